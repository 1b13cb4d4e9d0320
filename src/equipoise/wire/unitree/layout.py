"""The bytes of `LowCmd_` and `LowState_` of `unitree_hg`, as views, and their checksum.

Source: IDL and CRC of Unitree's public Python SDK (unitree_sdk2py 1.0.1, BSD-3-Clause), whose messages
the benchmark `benchmarks/unitree_sdk.py` compares with these, byte for byte.
"""

from __future__ import annotations

import zlib

import numpy as np

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
LOW_CMD = np.dtype(
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
LOW_STATE = np.dtype(
    {
        "names": ["version", "mode_pr", "mode_machine", "tick", "imu_state", "motor_state",
                  "wireless_remote", "reserve", "crc"],
        "formats": [("<u4", 2), "u1", "u1", "<u4", IMU_STATE, (MOTOR_STATE, MOTORS), ("u1", 40),
                    ("<u4", 4), "<u4"],
        "offsets": [0, 8, 9, 12, 16, 72, 2032, 2072, 2088],
        "itemsize": 2092,
    }
)  # fmt: skip

_REVERSED = bytes(int(f"{byte:08b}"[::-1], 2) for byte in range(256))


def checksum(body: bytes | memoryview) -> int:
    """Return the CRC of a message, which counts all of it but its last word, the CRC itself.

    It is CRC-32/MPEG-2 over words of 32 bits, the highest byte of each first. That is the CRC-32 of
    zlib of the same bits the other way round, taken back the other way round.
    """
    words = np.frombuffer(body, "<u4")[:-1].astype(">u4").tobytes()
    mirrored = zlib.crc32(words.translate(_REVERSED)) ^ 0xFFFFFFFF
    return int.from_bytes(mirrored.to_bytes(4, "little").translate(_REVERSED), "big")


class Message:
    """A message in memory that is made once: `fields` is a view, `packet` its bytes for DDS."""

    def __init__(self, layout: np.dtype) -> None:
        self._memory = bytearray(len(HEADER) + layout.itemsize)
        self._memory[: len(HEADER)] = HEADER
        body = memoryview(self._memory)[len(HEADER) :]
        self.fields: np.void = np.frombuffer(body, layout)[0]
        self._body = body

    def packet(self) -> bytes:
        """Return the bytes with the right checksum."""
        self.fields["crc"] = checksum(self._body)
        return bytes(self._memory)


def fields_of(packet: bytes, layout: np.dtype) -> np.void | None:
    """Return the fields of a packet; None if it is of another size or encoding, or damaged."""
    size = len(HEADER) + layout.itemsize
    if len(packet) != size or packet[:2] != HEADER[:2]:
        return None
    body = memoryview(packet)[len(HEADER) :]
    fields: np.void = np.frombuffer(body, layout)[0]
    return fields if int(fields["crc"]) == checksum(body) else None
