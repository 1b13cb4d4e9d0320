"""Robots that must not be driven: what their messages say, and who may begin or go on."""

from __future__ import annotations

import numpy as np
import pytest

from equipoise import get_robot
from equipoise.wire.health import HOTTEST, HOTTEST_AT_START, Health, told_of_health, trouble
from equipoise.wire.unitree.layout import LOW_STATE, Message
from equipoise.wire.unitree.motors import G1
from equipoise.wire.unitree.robot import UnitreeRobot

NAMES = ("knee", "elbow")


class OneMessage:
    """`DdsEnd` without a network: one message."""

    def __init__(self, packet: bytes) -> None:
        self.packets = [(packet, 1)]

    def now(self) -> float:
        return 0.0

    def wait(self, until: float) -> None:
        pass

    def take(self):
        return self.packets.pop() if self.packets else None


def health_of(message: Message) -> Health:
    message.fields["imu_state"]["quat_wxyz"] = 1.0, 0.0, 0.0, 0.0
    return UnitreeRobot(get_robot("g1"), 13, OneMessage(message.packet())).read(0.0).health


def test_a_motor_is_as_hot_as_the_hotter_of_its_sensors():
    message = Message(LOW_STATE)
    motors = message.fields["motor_state"]
    motors["temperature"][:29, 0], motors["temperature"][:29, 1] = 30, 28
    motors["temperature"][G1.index("left_knee_joint")] = 41, 95
    motors["vol"], motors["motorstate"][2] = 48.5, 0x20
    health, names = health_of(message), get_robot("g1").joint_names
    assert health.temperature[names.index("left_knee_joint")] == 95.0
    assert "left_knee_joint has 95 deg C" in trouble(health, names)
    said = " ".join(told_of_health(health, names))
    assert "48.5 V" in said
    assert "left_hip_yaw_joint 0x20" in said
    assert "battery is not looked at" in said


def test_what_is_not_told_is_said():
    said = " ".join(told_of_health(health_of(Message(LOW_STATE)), get_robot("g1").joint_names))
    assert "no temperature" in said
    assert "no voltage" in said
    assert "battery is not looked at" in said


@pytest.mark.parametrize(
    ("pressed", "stops"),
    [((0, 0), False), ((0x08, 0), True), ((0x20, 0x02), True), ((0x20, 0), False), ((0, 2), False)],
)
def test_select_or_l2_with_b_is_a_stop(pressed, stops):
    message = Message(LOW_STATE)
    message.fields["wireless_remote"][2:4] = pressed
    assert health_of(message).stop is stops


def test_who_is_too_warm_to_begin_may_still_go_on():
    between = Health(np.array([20.0, 0.5 * (HOTTEST + HOTTEST_AT_START)]))
    assert "elbow" in trouble(between, NAMES, HOTTEST_AT_START)
    assert trouble(between, NAMES) == ""
    assert trouble(Health(np.array([np.nan, 20.0])), NAMES) != ""
    assert trouble(Health(), NAMES) == ""
    assert told_of_health(Health(), NAMES) == []
