"""Two ends of a wire: whom they believe, in which order, and what they let go."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from wire_models import LOOP, OTHER, ROBOT, acquainted, model, state, torque, two_ends

from equipoise.errors import InputError
from equipoise.wire import CommandMode, Fault, RobotLostError, UdpRobot, UdpServer, UdpSocket
from equipoise.wire.end import FARTHEST
from equipoise.wire.packets import Codec, Parties, Refusal
from equipoise.wire.virtual import NetworkFaults, VirtualNetwork

CODEC = Codec(model())


def test_states_go_to_who_listens_and_commands_come_back():
    _, server, robot = acquainted()
    robot.write(torque(1.0))
    robot.read(0.001)
    taken = server.receive(1.001)
    assert taken is not None
    np.testing.assert_array_equal(taken.tau, torque(1.0).tau)
    assert not server.dropped
    assert not robot.dropped


def test_nothing_is_commanded_before_a_robot_is_heard():
    _, _, robot = two_ends()
    with pytest.raises(InputError, match="Read a state first"):
        robot.write(torque(0.0))


def test_the_newest_of_several_states_is_read():
    network, server, robot = acquainted()
    for t in (1.001, 1.002, 1.003):
        server.send(state(t))
    network.run(network.now + 1e-3, lambda: False)
    assert robot.read(0.0).t == 1.003
    assert robot.read(0.0) is None


def commands_of(network, server, robot, *packets, sender=LOOP):
    """Return what the robot's end takes of packets that come from somewhere."""
    for packet in packets:
        network.carry(packet, sender, ROBOT)
    network.run(network.now + 1e-3, lambda: False)
    return server.receive(1.0)


def packet_of(robot, server, sequence, t=1.0, mode=CommandMode.TORQUE):
    command = torque(t)._replace(mode=mode)
    return CODEC.command(Parties(robot.session, server.session), sequence, command)


def test_copies_and_older_packets_are_dropped():
    network, server, robot = acquainted()
    first, second = (packet_of(robot, server, n) for n in (10, 11))
    assert commands_of(network, server, robot, first, second) is not None
    assert commands_of(network, server, robot, first, second, second) is None
    assert server.dropped == {Fault.OLD: 3}


def test_a_sequence_far_ahead_is_dropped_and_does_not_deafen():
    network, server, robot = acquainted()
    assert commands_of(network, server, robot, packet_of(robot, server, 10)) is not None
    far = packet_of(robot, server, 10 + FARTHEST + 1)
    assert commands_of(network, server, robot, far) is None
    assert server.dropped == {Fault.JUMP: 1}
    assert commands_of(network, server, robot, packet_of(robot, server, 11)) is not None


@pytest.mark.parametrize("t", [0.9, 1.001])
def test_an_answer_to_an_old_state_or_to_none_is_dropped(t):
    network, server, robot = acquainted()
    assert commands_of(network, server, robot, packet_of(robot, server, 10, t)) is None
    assert server.dropped == {Fault.OLD: 1}


def test_holding_is_taken_however_late_and_not_overtaken():
    network, server, robot = acquainted()
    hold = packet_of(robot, server, 10, 0.5, CommandMode.HOLD)
    taken = commands_of(network, server, robot, hold, packet_of(robot, server, 11))
    assert taken.mode is CommandMode.HOLD


def test_a_second_commander_is_noticed_told_and_gets_nothing():
    network, server, robot = acquainted()
    assert commands_of(network, server, robot, packet_of(robot, server, 10)) is not None
    second = UdpRobot(model(), network.place(OTHER), ROBOT)
    assert second.read(0.001) is None  # its hello is on the way
    server.receive(1.0)
    with pytest.raises(RobotLostError, match="somebody else is already connected"):
        second.read(0.001)
    assert server.dropped[Fault.FOREIGN] == 1
    server.send(state(1.001))
    assert robot.read(0.001) is not None
    assert not network.box(OTHER)


def test_a_commander_is_pinned_by_session_and_by_address():
    network, server, robot = acquainted()
    assert commands_of(network, server, robot, packet_of(robot, server, 10)) is not None
    network.place(OTHER)
    stolen = packet_of(robot, server, 11)  # the right session from another address
    assert commands_of(network, server, robot, stolen, sender=OTHER) is None
    forged = CODEC.command(Parties(5, server.session), 12, torque(1.0))  # the right address
    assert commands_of(network, server, robot, forged) is None
    recorded = CODEC.command(Parties(robot.session, 5), 13, torque(1.0))  # of another run
    assert commands_of(network, server, robot, recorded) is None
    assert server.dropped == {Fault.FOREIGN: 3}
    server.send(state(1.001))
    assert robot.read(0.001) is not None


def test_who_only_listens_loses_its_place_by_silence():
    network, server, robot = acquainted()
    second = UdpRobot(model(), network.place(OTHER), ROBOT)
    network.run(network.now + 1.1, lambda: False)
    second.read(0.001)
    server.receive(1.0)
    server.send(state(1.001))
    assert second.read(0.001) is not None
    assert robot.read(0.0) is None


def test_another_model_is_refused_with_the_reason():
    network, server, _ = two_ends()
    other = UdpRobot(model(tau_max=11.0), network.place(OTHER), ROBOT)
    other.read(0.001)
    server.receive(0.0)
    with pytest.raises(RobotLostError, match="are other ones"):
        other.read(0.001)
    assert server.dropped == {Fault.MODEL: 1}


def test_a_forged_refusal_does_not_part_two_who_speak():
    network, server, robot = acquainted()
    refusal = CODEC.refusal(Parties(server.session, robot.session), Refusal.TAKEN)
    network.carry(refusal, ROBOT, LOOP)
    server.send(state(1.001))
    assert robot.read(0.001).t == 1.001
    assert robot.dropped == {Fault.FOREIGN: 1}


def test_a_robot_that_is_started_anew_is_another_one():
    network, _, robot = acquainted()
    anew = UdpServer(model(), network.place(ROBOT), 0.02)
    packet = CODEC.state(Parties(anew.session, robot.session), state(2.0)._replace(sequence=9))
    network.carry(packet, ROBOT, LOOP)
    assert robot.read(0.001) is None
    assert robot.dropped == {Fault.FOREIGN: 1}


def test_time_does_not_go_back():
    _, server, robot = acquainted()
    server.send(state(0.9))
    assert robot.read(0.001) is None
    assert robot.dropped == {Fault.OLD: 1}


def test_lost_states_are_counted():
    _network, server, robot = acquainted()
    for _ in range(3):
        server.next_sequence()
    server.send(state(1.1))
    robot.read(0.001)
    assert robot.missing == 3


def test_closing_lets_a_driven_robot_hold_and_leaves_another_alone():
    network, server, robot = acquainted()
    robot.close()
    network.run(network.now + 1e-3, lambda: False)
    assert server.receive(1.0) is None
    network, server, robot = acquainted()
    robot.write(torque(1.0))
    robot.close()
    robot.close()
    network.run(network.now + 1e-3, lambda: False)
    assert server.receive(1.0).mode is CommandMode.HOLD
    assert server.receive(1.0) is None


def test_no_answer_is_longer_than_the_question():
    """A robot cannot be used to flood somebody else."""
    network, server, _ = two_ends()
    network.place(OTHER)
    hello = Codec(model(11.0)).hello(Parties(5, 0), 1)
    network.carry(hello, OTHER, ROBOT)
    network.run(0.001, lambda: False)
    server.receive(0.0)
    network.run(0.002, lambda: False)
    [(answer, _)] = network.box(OTHER)
    assert len(answer) <= len(hello)


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 2**31))
def test_whatever_the_network_does_commands_come_in_order_and_within_limits(seed):
    faults = NetworkFaults(0.2, 0.2, 0.2, 0.3, (0.0, 0.01))
    _network, server, robot = two_ends(faults, seed)
    last, heard = -1.0, 0
    for k in range(2000):  # time for twenty greetings, most of which are lost
        t = 0.001 * k
        taken = server.receive(t)
        if taken is not None:
            assert taken.t >= last
            assert t - taken.t <= 0.02
            assert (np.abs(taken.tau) <= 10.0).all()
            last = taken.t
        server.send(state(t))
        read = robot.read(0.001)
        if read is not None:
            heard += 1
            robot.write(torque(read.t))
    assert heard > 20
    assert last > 0.0


def test_the_virtual_network_is_the_same_twice():
    def session(seed):
        _network, server, robot = two_ends(NetworkFaults(0.3, 0.1, 0.1, 0.1, (0.0, 0.005)), seed)
        server.session, robot.session = 1, 2
        times = []
        for k in range(100):
            server.receive(0.001 * k)
            server.send(state(0.001 * k))
            read = robot.read(0.001)
            times.append(None if read is None else read.t)
        return times

    assert session(3) == session(3)
    assert session(3) != session(4)


def test_sockets_speak_on_loopback_and_refuse_a_taken_port():
    with pytest.raises(InputError, match="delay must be"):
        NetworkFaults(delay=(1.0, 0.0))
    place = UdpSocket(("127.0.0.1", 0), CODEC.longest)
    with pytest.raises(InputError, match="cannot listen"):
        UdpSocket(place.address, CODEC.longest)
    server = UdpServer(model(), place, 0.02)
    robot = UdpRobot(model(), UdpSocket(("127.0.0.1", 0), CODEC.longest), place.address)
    assert robot.read(0.0) is None
    place.wait(place.now() + 5.0)
    server.receive(1.0)
    server.send(state(1.0))
    assert robot.read(5.0).t == 1.0
    robot.write(torque(1.0))
    place.wait(place.now() + 5.0)
    assert server.receive(1.0) is not None
    robot.close()
    server.close()


def test_sending_to_nobody_harms_nobody():
    network = VirtualNetwork(NetworkFaults(), 0)
    network.place(LOOP).send(b"x", ("nobody", 9))
    place = UdpSocket(("127.0.0.1", 0), 100)
    place.send(b"x", ("127.0.0.1", 9))
    place.send(b"x" * 70000, ("127.0.0.1", 9))
    place.wait(place.now() + 0.01)
    assert place.take() is None
    place.close()
