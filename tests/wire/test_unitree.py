"""`unitree_hg`: bytes and checksum against the definition, both ends against each other."""

from __future__ import annotations

import struct
import sys
from collections import deque

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from equipoise import get_robot
from equipoise.errors import InputError
from equipoise.wire import CommandMode, Fault, RobotCommand, RobotMode, RobotState
from equipoise.wire.unitree.checksum import checksum
from equipoise.wire.unitree.dds import DdsEnd, DdsOptions
from equipoise.wire.unitree.layout import LOW_CMD, LOW_STATE, Message, fields_of
from equipoise.wire.unitree.motors import G1, Motors
from equipoise.wire.unitree.robot import UnitreeRobot
from equipoise.wire.unitree.server import UnitreeServer, require_ticks


def crc_by_bits(words) -> int:
    """CRC-32/MPEG-2, a bit at a time."""
    crc = 0xFFFFFFFF
    for word in words:
        for k in range(31, -1, -1):
            crc = ((crc << 1) ^ (0x04C11DB7 if (crc >> 31) ^ (word >> k & 1) else 0)) & 0xFFFFFFFF
    return crc


def test_the_checksum_of_a_known_text():
    """The check value of CRC-32/MPEG-2 in catalogues is of nine bytes; here of whole words."""
    text = b"12345678"
    words = struct.unpack(">2I", text)
    memory = struct.pack("<3I", *words, 0)
    assert checksum(memory) == crc_by_bits(words)
    assert crc_by_bits([0]) == 0xC704DD7B  # four zero bytes, as catalogues of CRCs have it


@settings(max_examples=20, deadline=None)
@given(st.lists(st.integers(0, 2**32 - 1), min_size=1, max_size=40))
def test_the_checksum_is_that_by_bits(words):
    memory = struct.pack(f"<{len(words)}I", *words)
    assert checksum(memory) == crc_by_bits(words[:-1])


def test_a_command_lies_on_the_wire_as_plain_cdr_has_it():
    """Written out by the rules of CDR: each number at a multiple of its size, nothing else."""
    message, numbers = Message(LOW_CMD), np.arange(35 * 5, dtype="f4").reshape(35, 5)
    motors = message.fields["motor_cmd"]
    for k, name in enumerate(("q", "dq", "tau", "kp", "kd")):
        motors[name] = numbers[:, k]
    motors["mode"], motors["reserve"] = np.arange(35) + 1, np.arange(35) + 7
    message.fields["mode_pr"], message.fields["mode_machine"] = 3, 5
    message.fields["reserve"] = 11, 12, 13, 14
    packet = message.packet()
    cdr = bytearray(b"\x03\x05")
    for k in range(35):
        cdr += bytes([k + 1])
        cdr += bytes(-len(cdr) % 4)
        cdr += struct.pack("<5fI", *numbers[k], k + 7)
    cdr += struct.pack("<4I", 11, 12, 13, 14)
    assert packet[:-4] == b"\0\x01\0\0" + cdr
    assert len(packet) == 1004


def test_a_state_comes_back_and_any_change_is_noticed():
    message, random = Message(LOW_STATE), np.random.default_rng(0)
    message.fields["motor_state"]["q"] = random.normal(size=35)
    message.fields["imu_state"]["temperature"], message.fields["tick"] = -5, 123
    packet = message.packet()
    fields = fields_of(packet, LOW_STATE)
    np.testing.assert_array_equal(fields["motor_state"]["q"], message.fields["motor_state"]["q"])
    assert (fields["imu_state"]["temperature"], fields["tick"]) == (-5, 123)
    for at in (6, 20, 70, 200, 2050, 2090):
        changed = bytearray(packet)
        changed[at] ^= 1
        assert fields_of(bytes(changed), LOW_STATE) is None
    assert fields_of(packet[:-1], LOW_STATE) is None
    assert fields_of(packet, LOW_CMD) is None


class Joined:
    """Two ends that hear each other, as `DdsEnd` without a network."""

    def __init__(self) -> None:
        self.box, self.other, self.time = deque(), self, 0.0

    def now(self) -> float:
        self.time += 1e-4
        return self.time

    def wait(self, until: float) -> None:
        self.time = max(self.time, until)

    def take(self):
        return self.box.popleft() if self.box else None

    def send(self, packet: bytes, writer: int = 1) -> None:
        self.other.box.append((packet, writer))

    def close(self) -> None:
        pass


@pytest.fixture
def ends():
    near, far = Joined(), Joined()
    near.other, far.other = far, near
    robot = get_robot("g1")
    return UnitreeRobot(robot, 13, near), UnitreeServer(robot, far, 0.02), near, far


def state_of(robot, t: float) -> RobotState:
    random = np.random.default_rng(round(1e3 * t))
    q = np.concatenate(([0.1, 0.2, 0.8], [0.0, 0.0, 0.6, 0.8], random.normal(size=robot.na)))
    imu = np.concatenate((q[3:7], random.normal(size=6)))
    v, lam = random.normal(size=robot.nv), random.normal(size=13)
    return RobotState(
        0, t, RobotMode.DRIVEN, np.full(4, t), q, v, lam, random.normal(size=robot.na), imu
    )


def test_a_state_has_what_the_messages_have_and_nothing_else(ends):
    robot, server, _, _ = ends
    sent = state_of(robot.robot, 0.004)
    server.send(state_of(robot.robot, 0.0))
    assert robot.read(0.1).t == 0.0
    server.send(sent)
    got = robot.read(0.1)
    assert got.t == pytest.approx(0.004)
    np.testing.assert_allclose(got.q[7:], sent.q[7:], atol=1e-6)
    np.testing.assert_allclose(got.v[6:], sent.v[6:], atol=1e-6)
    np.testing.assert_allclose(got.tau, sent.tau, atol=1e-6)
    np.testing.assert_allclose(got.imu, sent.imu, atol=1e-6)
    assert np.isnan(got.q[:7]).all()
    assert np.isnan(got.v[:6]).all()
    assert np.isnan(got.lam).all()
    assert got.ages["base"] == got.ages["forces"] == np.inf


def test_a_torque_arrives_and_holding_asks_for_servos(ends):
    robot, server, _, _ = ends
    server.send(state_of(robot.robot, 0.0))
    robot.read(0.1)
    tau = 0.5 * robot.robot.tau_max
    robot.write(RobotCommand(0.0, CommandMode.TORQUE, tau))
    taken = server.receive(0.0)
    assert taken.mode is CommandMode.TORQUE
    np.testing.assert_allclose(taken.tau, tau, rtol=1e-6)
    robot.close()
    taken = server.receive(0.0)
    assert taken.mode is CommandMode.HOLD


def test_holding_takes_over_without_a_jump(ends):
    """Evaluated as a robot does: on the state that it sent, at rest, it is the last torque."""
    robot, server, _, _ = ends
    state = state_of(robot.robot, 0.0)
    state = state._replace(v=np.zeros_like(state.v))
    server.send(state)
    robot.read(0.1)
    tau = 0.4 * robot.robot.tau_max
    robot.write(RobotCommand(0.0, CommandMode.TORQUE, tau))
    server.receive(0.0)
    robot.close()
    np.testing.assert_allclose(server.receive(0.0).tau, tau, rtol=1e-5)


def test_a_posture_is_led_to_around_the_torque_that_carries(ends):
    robot, server, _, _ = ends
    state = state_of(robot.robot, 0.0)
    server.send(state)
    assert robot.read(0.1).mode is RobotMode.DRIVEN  # as the simulated robot says of itself
    posture = state.q[7:] + 0.01
    robot.write(RobotCommand(0.0, CommandMode.POSTURE, np.zeros(29), posture))
    taken = server.receive(0.0)
    assert taken.mode is CommandMode.POSTURE
    np.testing.assert_allclose(taken.posture, posture, rtol=1e-6, atol=1e-6)
    motors = Motors.of(robot.robot)
    limit = robot.robot.tau_max
    wanted = np.clip(
        np.clip(state.tau, -limit, limit) + 0.01 * motors.kp - motors.kd * state.v[6:],
        -limit,
        limit,
    )
    np.testing.assert_allclose(taken.tau, wanted, atol=1e-3)


def test_a_robot_that_let_go_is_known_by_its_word(ends):
    robot, server, _, far = ends
    server.send(state_of(robot.robot, 0.0)._replace(mode=RobotMode.HELD))
    assert robot.read(0.1).mode is RobotMode.HELD
    message = Message(LOW_STATE)  # a robot of Unitree leaves the word at zero
    message.fields["imu_state"]["quat_wxyz"] = 1.0, 0.0, 0.0, 0.0
    far.send(message.packet())
    assert robot.read(0.1).mode is RobotMode.WAITING
    message.fields["reserve"][0] = 77
    far.send(message.packet())
    assert robot.read(0.1) is None
    assert robot.dropped == {Fault.VALUES: 1}


def test_a_servo_of_the_sdk_is_evaluated_on_the_state(ends):
    """What Unitree's own programs send: a posture with gains, no tick that it answers."""
    robot, server, near, _ = ends
    state = state_of(robot.robot, 0.0)
    server.send(state)
    message = Message(LOW_CMD)
    motors = message.fields["motor_cmd"]
    motors["q"][:29], motors["kp"][:29], motors["kd"][:29] = 0.1, 10.0, 0.5
    near.send(message.packet())
    wanted = 10.0 * (0.1 - state.q[7:]) - 0.5 * state.v[6:]
    limit = robot.robot.tau_max
    np.testing.assert_allclose(
        server.receive(0.0).tau, np.clip(wanted, -limit, limit), rtol=1e-5, atol=1e-5
    )


@pytest.mark.parametrize(
    ("name", "value"), [("tau", 1e4), ("tau", np.nan), ("q", np.inf), ("kp", -1.0), ("kd", 1e9)]
)
def test_a_command_beyond_all_limits_is_dropped(ends, name, value):
    robot, server, near, _ = ends
    server.send(state_of(robot.robot, 0.0))
    message = Message(LOW_CMD)
    message.fields["motor_cmd"][name][3] = value
    near.send(message.packet())
    assert server.receive(0.0) is None
    assert server.dropped == {Fault.VALUES: 1}


def test_a_second_writer_is_noticed_on_both_sides(ends):
    robot, server, near, far = ends
    server.send(state_of(robot.robot, 0.0))
    robot.read(0.1)
    robot.write(RobotCommand(0.0, CommandMode.TORQUE, np.zeros(29)))
    server.receive(0.0)
    near.send(Message(LOW_CMD).packet(), writer=2)
    assert server.receive(0.0) is None
    assert server.dropped == {Fault.FOREIGN: 1}
    far.send(Message(LOW_STATE).packet(), writer=2)
    assert robot.read(0.1) is None
    assert robot.dropped == {Fault.FOREIGN: 1}


def test_an_old_answer_is_dropped(ends):
    robot, server, _, _ = ends
    server.send(state_of(robot.robot, 0.0))
    robot.read(0.1)
    robot.write(RobotCommand(0.0, CommandMode.TORQUE, np.zeros(29)))
    assert server.receive(0.03) is None
    assert server.dropped == {Fault.OLD: 1}


def test_a_torque_beyond_a_limit_is_not_sent(ends):
    robot, server, _, _ = ends
    server.send(state_of(robot.robot, 0.0))
    robot.read(0.1)
    with pytest.raises(InputError, match="beyond the limits"):
        robot.write(RobotCommand(0.0, CommandMode.TORQUE, 1.01 * robot.robot.tau_max))


def test_motors_are_those_of_the_g1_and_of_nothing_else():
    motors = Motors.of(get_robot("g1"))
    assert [G1[k] for k in motors.places] == list(get_robot("g1").joint_names)
    with pytest.raises(InputError, match="order of the motors of hrp2 is not known"):
        Motors.of(get_robot("hrp2"))
    with pytest.raises(InputError, match="counts milliseconds"):
        require_ticks(0.0015)


def test_without_cyclone_the_extra_is_named(monkeypatch):
    for name in [
        one for one in sys.modules if one.startswith(("cyclonedds", "equipoise.wire.unitree.idl"))
    ]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "cyclonedds", None)
    with pytest.raises(InputError, match=r"pip install 'equipoise\[wire\]'"):
        DdsEnd("rt/lowstate", "rt/lowcmd", DdsOptions())


def test_messages_go_over_dds_on_this_machine():
    pytest.importorskip("cyclonedds")
    options = DdsOptions(domain=71)
    near, far = (
        DdsEnd("rt/lowstate", "rt/lowcmd", options),
        DdsEnd("rt/lowcmd", "rt/lowstate", options),
    )
    message, taken = Message(LOW_STATE), None
    message.fields["tick"] = 7
    for _ in range(200):  # until they have found each other
        far.send(message.packet())
        near.wait(near.now() + 0.05)
        taken = near.take()
        if taken is not None:
            break
    assert taken is not None
    assert taken[0] == message.packet()
    near.close()
    far.close()
