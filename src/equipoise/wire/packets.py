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
from equipoise.wire.interface import (
    COMMAND_MODES,
    PARTS,
    ROBOT_MODES,
    CommandMode,
    RobotCommand,
    RobotMode,
    RobotState,
)
from equipoise.wire.model import WireModel

MAGIC, VERSION = b"EQPW", 1
HEADER = struct.Struct("<4sBBHQQQd16s4H")
CRC = struct.Struct("<I")
TURNED = 100.0  # [rad, m] of a joint that is told where to go; the robot keeps its own limits
LARGEST = 1e6  # of any number in a state, SI units: what is beyond was not measured


class Kind(IntEnum):
    """What a packet is."""

    HELLO = 0
    STATE = 1
    COMMAND = 2
    REFUSAL = 3


class Refusal(IntEnum):
    """Why a robot does not listen to somebody; told as the mode of a refusal."""

    OTHER_MODEL = 0
    TAKEN = 1


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
    FOREIGN = "of or for somebody else"
    OLD = "a copy, out of order, or too late"
    JUMP = "sequence too far ahead"


KINDS, REFUSALS = frozenset(Kind), frozenset(Refusal)


@dataclass(frozen=True)
class Header:
    """Who sent a packet to whom, and its place in the order: see docs/wire.md."""

    kind: Kind
    mode: int
    sender: int
    receiver: int
    sequence: int
    t: float


@dataclass(frozen=True)
class Parties:
    """The session numbers of who sends and who is meant, 0 for whoever it is."""

    sender: int
    receiver: int


class Codec:
    """Packs and unpacks the packets of one model; what is unpacked was checked whole."""

    def __init__(self, model: WireModel) -> None:
        self.model = model
        m = model
        self._sizes = (m.nq, m.nv, m.na, m.rows)
        numbers = {
            Kind.HELLO: 0,
            Kind.STATE: len(PARTS) + m.nq + m.nv + m.rows + m.na,
            Kind.COMMAND: m.na,
            Kind.REFUSAL: 0,
        }
        self.lengths = {kind: HEADER.size + 8 * n + CRC.size for kind, n in numbers.items()}
        self.longest = max(self.lengths.values())
        self._ends = np.cumsum([len(PARTS), m.nq, m.nv, m.rows]).tolist()

    def hello(self, whose: Parties, sequence: int) -> bytes:
        """Return a packet that only says who is there."""
        return self._packed(Kind.HELLO, 0, whose, (sequence, 0.0), b"")

    def refusal(self, whose: Parties, why: Refusal) -> bytes:
        """Return a packet that says why nobody listens; no longer than any that it answers."""
        return self._packed(Kind.REFUSAL, why, whose, (0, 0.0), b"")

    def state(self, whose: Parties, state: RobotState) -> bytes:
        """Return the packet of a state."""
        numbers = np.concatenate((state.stamps, state.q, state.v, state.lam, state.tau))
        place = state.sequence, state.t
        return self._packed(Kind.STATE, state.mode, whose, place, _bytes(numbers))

    def command(self, whose: Parties, sequence: int, command: RobotCommand) -> bytes:
        """Return the packet of a command. Raises: `InputError`, see `RobotInterface.write`."""
        if command.mode is CommandMode.POSTURE:
            numbers = real_vector("posture", command.posture, self.model.na)
        else:
            numbers = checked_torque(self.model, command.tau)
        place = sequence, command.t
        return self._packed(Kind.COMMAND, command.mode, whose, place, _bytes(numbers))

    def _packed(
        self, kind: Kind, mode: int, whose: Parties, place: tuple[int, float], payload: bytes
    ) -> bytes:
        ends = whose.sender, whose.receiver
        head = HEADER.pack(
            MAGIC, VERSION, kind, mode, *ends, *place, self.model.digest, *self._sizes
        )
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
        if kind not in KINDS:
            return Fault.KIND
        if not 0.0 <= t <= LARGEST:  # false for NaN
            return Fault.VALUES
        header = Header(Kind(kind), mode, sender, receiver, sequence, t)
        if header.kind is Kind.REFUSAL:  # may come from a robot of another model
            return header if len(packet) == self.lengths[Kind.REFUSAL] else Fault.SIZE
        if digest != self.model.digest:
            return Fault.MODEL
        if tuple(sizes) != self._sizes:
            return Fault.SHAPE
        return header if len(packet) == self.lengths[header.kind] else Fault.SIZE

    def state_in(self, packet: bytes, header: Header) -> RobotState | Fault:
        """Return the state in a packet whose header was found good."""
        if header.mode not in ROBOT_MODES:
            return Fault.VALUES
        numbers = _numbers(packet)
        a, b, c, d = self._ends
        stamps, measured = numbers[:a], numbers[a:]
        if not (np.isnan(measured) | (np.abs(measured) <= LARGEST)).all():
            return Fault.VALUES
        if not (stamps <= header.t).all():  # false for NaN; -inf was never measured
            return Fault.VALUES
        parts = stamps, numbers[a:b], numbers[b:c], numbers[c:d], numbers[d:]
        return RobotState(header.sequence, header.t, RobotMode(header.mode), *parts)

    def command_in(self, packet: bytes, header: Header) -> RobotCommand | Fault:
        """Return the command in a packet whose header was found good."""
        if header.mode not in COMMAND_MODES:
            return Fault.VALUES
        numbers, mode = _numbers(packet), CommandMode(header.mode)
        posture = mode is CommandMode.POSTURE
        limit = np.full(self.model.na, TURNED) if posture else self.model.tau_max
        if not (np.abs(numbers) <= limit).all():  # false for NaN
            return Fault.VALUES
        if posture:
            return RobotCommand(header.t, mode, np.zeros(self.model.na), numbers)
        return RobotCommand(header.t, mode, numbers)


def checked_torque(model: WireModel, given: Array) -> Array:
    """Return a torque (na,) [N m] that may be given. Raises: `InputError`."""
    tau = real_vector("tau", given, model.na)
    if not (np.abs(tau) <= model.tau_max).all():
        raise InputError("a commanded torque is beyond the limits of its joint", given=tau)
    return tau


def _numbers(packet: bytes) -> Array:
    inside = len(packet) - HEADER.size - CRC.size
    return np.frombuffer(packet, "<f8", inside // 8, HEADER.size).astype(np.float64)


def _bytes(numbers: Array) -> bytes:
    return numbers.astype("<f8", copy=False).tobytes()
