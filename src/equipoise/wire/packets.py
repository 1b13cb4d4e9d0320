"""The bytes of the wire, out and in; docs/wire.md describes each of them."""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass
from enum import Enum, IntEnum

import numpy as np

from equipoise.errors import InputError
from equipoise.spatial import Array
from equipoise.spatial.numbers import real_vector
from equipoise.wire.interface import PARTS, CommandMode, RobotCommand, RobotMode, RobotState
from equipoise.wire.model import WireModel

MAGIC, VERSION = b"EQPW", 1
HEADER = struct.Struct("<4sBBHQQQd16s4H")
CRC = struct.Struct("<I")
LARGEST = 1e6  # of any number in a state, SI units: what is beyond was not measured


class Kind(IntEnum):
    """What a packet is."""

    HELLO = 0
    STATE = 1
    COMMAND = 2


class Fault(Enum):
    """Why a packet was dropped; the value is a word for it."""

    SIZE = "wrong size"
    MAGIC = "not of this protocol"
    VERSION = "other version"
    CRC = "damaged"
    MODEL = "other model"
    SHAPE = "other sizes"
    KIND = "unexpected kind"
    VALUES = "values not finite or out of range"
    FOREIGN = "of somebody else"
    OLD = "replayed or out of order"


@dataclass(frozen=True)
class Header:
    """Who sent a packet to whom, and its place in the order: see docs/wire.md."""

    kind: Kind
    mode: int
    sender: int
    receiver: int
    sequence: int
    t: float
    digest: bytes


class Codec:
    """Packs and unpacks the packets of one model; what is unpacked was checked whole."""

    def __init__(self, model: WireModel) -> None:
        self.model = model
        m = model
        self._sizes = (m.nq, m.nv, m.na, m.rows)
        numbers = {
            Kind.HELLO: 0,
            Kind.STATE: len(PARTS) + m.nq + m.nv + m.rows + m.na,
            Kind.COMMAND: 2 * m.na,
        }
        self.lengths = {kind: HEADER.size + 8 * n + CRC.size for kind, n in numbers.items()}
        self.longest = max(self.lengths.values())
        self._cuts = np.cumsum([len(PARTS), m.nq, m.nv, m.rows]).tolist()

    def hello(self, sender: int, receiver: int, sequence: int) -> bytes:
        """Return a packet that only says who is there."""
        return self._packed(Kind.HELLO, 0, (sender, receiver, sequence, 0.0), b"")

    def state(self, sender: int, receiver: int, state: RobotState) -> bytes:
        """Return the packet of a state."""
        parts = (state.stamps, state.q, state.v, state.lam, state.tau)
        whose = (sender, receiver, state.sequence, state.t)
        return self._packed(Kind.STATE, state.mode, whose, _bytes(*parts))

    def command(self, sender: int, receiver: int, sequence: int, command: RobotCommand) -> bytes:
        """Return the packet of a command. Raises: `InputError`, see `RobotInterface.write`."""
        tau, damping = checked_command(self.model, command)
        whose = (sender, receiver, sequence, command.t)
        return self._packed(Kind.COMMAND, command.mode, whose, _bytes(tau, damping))

    def _packed(
        self, kind: Kind, mode: int, whose: tuple[int, int, int, float], payload: bytes
    ) -> bytes:
        head = HEADER.pack(MAGIC, VERSION, kind, mode, *whose, self.model.digest, *self._sizes)
        body = head + payload
        return body + CRC.pack(zlib.crc32(body))

    def header(self, packet: bytes) -> Header | Fault:
        """Return the header of a packet that is whole and of this model, or what is wrong."""
        if len(packet) < HEADER.size + CRC.size:
            return Fault.SIZE
        magic, version, kind, mode, sender, receiver, sequence, t, digest, *sizes = (
            HEADER.unpack_from(packet)
        )
        if magic != MAGIC:
            return Fault.MAGIC
        if version != VERSION:
            return Fault.VERSION
        if CRC.unpack_from(packet, len(packet) - CRC.size)[0] != zlib.crc32(packet[: -CRC.size]):
            return Fault.CRC
        if digest != self.model.digest:
            return Fault.MODEL
        if tuple(sizes) != self._sizes:
            return Fault.SHAPE
        if kind not in set(Kind):
            return Fault.KIND
        if len(packet) != self.lengths[Kind(kind)]:
            return Fault.SIZE
        if not 0.0 <= t <= LARGEST:  # false for NaN
            return Fault.VALUES
        return Header(Kind(kind), mode, sender, receiver, sequence, t, digest)

    def state_in(self, packet: bytes, header: Header) -> RobotState | Fault:
        """Return the state in a packet whose header was found good."""
        if header.mode not in set(RobotMode):
            return Fault.VALUES
        numbers = _numbers(packet)
        stamps, q, v, lam, tau = np.split(numbers, self._cuts)
        measured = numbers[len(PARTS) :]
        if not (np.isnan(measured) | (np.abs(measured) <= LARGEST)).all():
            return Fault.VALUES
        if not (stamps <= header.t).all():  # false for NaN; -inf was never measured
            return Fault.VALUES
        return RobotState(
            header.sequence, header.t, RobotMode(header.mode), stamps, q, v, lam, tau
        )

    def command_in(self, packet: bytes, header: Header) -> RobotCommand | Fault:
        """Return the command in a packet whose header was found good."""
        if header.mode not in set(CommandMode):
            return Fault.VALUES
        tau, damping = np.split(_numbers(packet), 2)
        command = RobotCommand(header.t, CommandMode(header.mode), tau, damping)
        return command if _within(self.model, tau, damping) else Fault.VALUES


def checked_command(model: WireModel, command: RobotCommand) -> tuple[Array, Array]:
    """Return torque and damping (na,) of a command that may be given. Raises: `InputError`."""
    tau = real_vector("tau", command.tau, model.na)
    damping = real_vector("damping", command.damping, model.na)
    if not _within(model, tau, damping):
        raise InputError(
            "a command must keep the torque limits, with a damping that is not negative",
            given=(tau, damping),
        )
    return tau, damping


def _within(model: WireModel, tau: Array, damping: Array) -> bool:
    return bool(
        (np.abs(tau) <= model.tau_max).all() and (damping >= 0).all() and (damping <= LARGEST).all()
    )  # false for NaN


def _numbers(packet: bytes) -> Array:
    inside = len(packet) - HEADER.size - CRC.size
    return np.frombuffer(packet, "<f8", inside // 8, HEADER.size).astype(np.float64)


def _bytes(*arrays: Array) -> bytes:
    return np.concatenate(arrays).astype("<f8").tobytes()
