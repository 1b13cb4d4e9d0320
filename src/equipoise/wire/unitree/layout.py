"""The bytes of `LowCmd_` and `LowState_` of `unitree_hg`, as views.

In memory every motor begins at a word, and over these bytes the checksum goes. On the wire (plain
CDR) only numbers do: the first motor follows right behind what is before it, four bytes earlier.

Source: IDL of Unitree's public Python SDK (unitree_sdk2py 1.0.1, BSD-3-Clause), whose messages
the benchmark `benchmarks/unitree_sdk.py` compares with these, byte for byte.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from equipoise.wire.unitree.checksum import checksum

MOTORS = 35  # places for motors in every message
HEADER = bytes((0, 1, 0, 0))  # plain CDR, little-endian: what DDS puts before a message

MOTOR_CMD = np.dtype(
    {
        "names": ["mode", "q", "dq", "tau", "kp", "kd", "reserve"],
        "formats": ["u1", "<f4", "<f4", "<f4", "<f4", "<f4", "<u4"],
        "offsets": [0, 4, 8, 12, 16, 20, 24],
        "itemsize": 28,
    }
)
_LOW_CMD = np.dtype(
    {
        "names": ["mode_pr", "mode_machine", "motor_cmd", "reserve", "crc"],
        "formats": ["u1", "u1", (MOTOR_CMD, MOTORS), ("<u4", 4), "<u4"],
        "offsets": [0, 1, 4, 984, 1000],
        "itemsize": 1004,
    }
)
IMU_STATE = np.dtype(
    {
        "names": ["quat_wxyz", "gyroscope", "accelerometer", "rpy", "temperature"],
        "formats": [("<f4", 4), ("<f4", 3), ("<f4", 3), ("<f4", 3), "<i2"],
        "offsets": [0, 16, 28, 40, 52],
        "itemsize": 56,
    }
)
MOTOR_STATE = np.dtype(
    {
        "names": ["mode", "q", "dq", "ddq", "tau_est", "temperature", "vol", "sensor",
                  "motorstate", "reserve"],
        "formats": ["u1", "<f4", "<f4", "<f4", "<f4", ("<i2", 2), "<f4", ("<u4", 2), "<u4",
                    ("<u4", 4)],
        "offsets": [0, 4, 8, 12, 16, 20, 24, 28, 36, 40],
        "itemsize": 56,
    }
)  # fmt: skip
_LOW_STATE = np.dtype(
    {
        "names": ["version", "mode_pr", "mode_machine", "tick", "imu_state", "motor_state",
                  "wireless_remote", "reserve", "crc"],
        "formats": [("<u4", 2), "u1", "u1", "<u4", IMU_STATE, (MOTOR_STATE, MOTORS), ("u1", 40),
                    ("<u4", 4), "<u4"],
        "offsets": [0, 8, 9, 12, 16, 72, 2032, 2072, 2088],
        "itemsize": 2092,
    }
)  # fmt: skip


class Layout(NamedTuple):
    """A message: its fields in memory, where its first motor begins on the wire, its size there."""

    memory: np.dtype
    first_motor: int
    size: int


LOW_CMD = Layout(_LOW_CMD, 2, len(HEADER) + _LOW_CMD.itemsize - 4)
LOW_STATE = Layout(_LOW_STATE, 70, len(HEADER) + _LOW_STATE.itemsize - 4)


def to_wire(memory: bytes, layout: Layout) -> bytes:
    """Return a message in memory as it goes over the wire, header included."""
    at = layout.first_motor
    return HEADER + memory[:at] + memory[at + 2 : at + 3] + b"\0" + memory[at + 6 :]


def from_wire(packet: bytes, layout: Layout) -> bytes:
    """Return a message from the wire as it lies in memory."""
    at = layout.first_motor + len(HEADER)
    begin = packet[len(HEADER) : at]
    return begin + b"\0\0" + packet[at : at + 1] + b"\0\0\0" + packet[at + 2 :]


class Message:
    """A message in memory that is made once: `fields` is a view, `packet` its bytes for DDS."""

    def __init__(self, layout: Layout) -> None:
        self._layout, self._memory = layout, bytearray(layout.memory.itemsize)
        self.fields: np.void = np.frombuffer(self._memory, layout.memory)[0]

    def packet(self) -> bytes:
        """Return the bytes with the right checksum."""
        self.fields["crc"] = checksum(bytes(self._memory))
        return to_wire(bytes(self._memory), self._layout)


def fields_of(packet: bytes, layout: Layout) -> np.void | None:
    """Return the fields of a packet; None if it is of another size or encoding, or damaged."""
    if len(packet) != layout.size or packet[:2] != HEADER[:2]:
        return None
    memory = from_wire(packet, layout)
    if memory[-4:] != checksum(memory).to_bytes(4, "little"):
        return None
    fields: np.void = np.frombuffer(memory, layout.memory)[0]
    return fields
