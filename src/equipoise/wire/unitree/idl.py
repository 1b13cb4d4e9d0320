"""The types of `unitree_hg` for DDS, so that others on the topic know them; samples are bytes.

Imports Cyclone DDS: only `dds` imports this file. Source: IDL of Unitree's public Python SDK.
"""

# mypy: ignore-errors
# no `from __future__ import annotations`: Cyclone DDS reads the types of the fields
from dataclasses import dataclass
from typing import Any

import cyclonedds.idl as idl
import cyclonedds.idl.annotations as annotate
import cyclonedds.idl.types as types

from equipoise.wire.unitree.layout import MOTORS


def as_bytes(kind: Any) -> Any:
    """Return the type with samples that are their own bytes: nothing is unpacked unasked."""

    def of(packet: bytes) -> Any:
        sample = kind.__new__(kind)
        sample.packet = packet
        return sample

    kind.of = staticmethod(of)
    kind.serialize = lambda sample, *_, **__: sample.packet
    kind.deserialize = staticmethod(lambda packet, **_: of(bytes(packet)))
    return kind


@dataclass
@annotate.final
@annotate.autoid("sequential")
class IMUState_(idl.IdlStruct, typename="unitree_hg.msg.dds_.IMUState_"):
    """Inertial unit."""

    quaternion: types.array[types.float32, 4]
    gyroscope: types.array[types.float32, 3]
    accelerometer: types.array[types.float32, 3]
    rpy: types.array[types.float32, 3]
    temperature: types.int16


@dataclass
@annotate.final
@annotate.autoid("sequential")
class MotorState_(idl.IdlStruct, typename="unitree_hg.msg.dds_.MotorState_"):
    """What a motor says."""

    mode: types.uint8
    q: types.float32
    dq: types.float32
    ddq: types.float32
    tau_est: types.float32
    temperature: types.array[types.int16, 2]
    vol: types.float32
    sensor: types.array[types.uint32, 2]
    motorstate: types.uint32
    reserve: types.array[types.uint32, 4]


@dataclass
@annotate.final
@annotate.autoid("sequential")
class MotorCmd_(idl.IdlStruct, typename="unitree_hg.msg.dds_.MotorCmd_"):
    """What a motor is told."""

    mode: types.uint8
    q: types.float32
    dq: types.float32
    tau: types.float32
    kp: types.float32
    kd: types.float32
    reserve: types.uint32


@as_bytes
@dataclass
@annotate.final
@annotate.autoid("sequential")
class LowState_(idl.IdlStruct, typename="unitree_hg.msg.dds_.LowState_"):
    """State of the robot."""

    version: types.array[types.uint32, 2]
    mode_pr: types.uint8
    mode_machine: types.uint8
    tick: types.uint32
    imu_state: IMUState_
    motor_state: types.array[MotorState_, MOTORS]
    wireless_remote: types.array[types.uint8, 40]
    reserve: types.array[types.uint32, 4]
    crc: types.uint32


@as_bytes
@dataclass
@annotate.final
@annotate.autoid("sequential")
class LowCmd_(idl.IdlStruct, typename="unitree_hg.msg.dds_.LowCmd_"):
    """Command to the robot."""

    mode_pr: types.uint8
    mode_machine: types.uint8
    motor_cmd: types.array[MotorCmd_, MOTORS]
    reserve: types.array[types.uint32, 4]
    crc: types.uint32
