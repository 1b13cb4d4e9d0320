"""Bytes of the wire: what goes in comes out, and nothing else does."""

from __future__ import annotations

import struct
import zlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from wire_models import model, state, torque

from equipoise import SoleContact, get_robot
from equipoise.contacts import ContactStack
from equipoise.errors import InputError
from equipoise.wire import Codec, CommandMode, Fault, Kind, WireModel
from equipoise.wire.packets import CRC, Header, Parties

BOTH = Parties(7, 9)
CODEC = Codec(model())


def good(packet: bytes) -> Header:
    header = CODEC.header(packet)
    assert isinstance(header, Header), header
    return header


def sealed(body: bytes) -> bytes:
    """Return a body behind which its CRC is right."""
    return body + struct.pack("<I", zlib.crc32(body))


def changed(packet: bytes, at: int, new: bytes) -> bytes:
    """Return a packet in which some bytes are others, and its CRC right all the same."""
    body = packet[: -CRC.size]
    return sealed(body[:at] + new + body[at + len(new) :])


def test_a_state_comes_back_bit_for_bit():
    sent = state(1.25)
    packet = CODEC.state(BOTH, sent)
    header = good(packet)
    assert (header.kind, header.sender, header.receiver) == (Kind.STATE, 7, 9)
    back = CODEC.state_in(packet, header)
    for given_, got in zip(sent[:-1], back[:-1], strict=True):  # health is not on this wire
        np.testing.assert_array_equal(given_, got)
    assert back.ages["base"] == np.inf
    assert back.ages["forces"] == pytest.approx(1e-3)


def test_a_posture_comes_back_bit_for_bit_and_has_limits_of_its_own():
    sent = torque(0.5)
    posture = 3.0 * np.arange(1.0, 1.0 + sent.tau.size)
    led = sent._replace(mode=CommandMode.POSTURE, posture=posture)
    packet = CODEC.command(BOTH, 4, led)
    back = CODEC.command_in(packet, good(packet))
    assert back.mode is CommandMode.POSTURE
    np.testing.assert_array_equal(back.posture, posture)
    assert not back.tau.any()
    far = CODEC.command(BOTH, 4, led._replace(posture=1e3 * posture))
    assert CODEC.command_in(far, good(far)) is Fault.VALUES
    with pytest.raises(InputError):
        CODEC.command(BOTH, 4, led._replace(posture=posture[:-1]))


def test_a_command_comes_back_bit_for_bit():
    sent = torque(0.5)
    packet = CODEC.command(BOTH, 4, sent)
    back = CODEC.command_in(packet, good(packet))
    assert (back.t, back.mode) == (sent.t, sent.mode)
    np.testing.assert_array_equal(back.tau, sent.tau)


def test_bytes_are_where_the_page_says():
    """docs/wire.md, written out once more by hand."""
    packet = CODEC.command(BOTH, 4, torque(0.5))
    assert len(packet) == 64 + 8 * 3 + 4
    assert packet[:4] == b"EQPW"
    assert packet[4:8] == bytes([1, 2, 0, 0])  # version, kind, mode
    assert struct.unpack("<QQQ", packet[8:32]) == (7, 9, 4)
    assert struct.unpack("<d", packet[32:40]) == (0.5,)
    assert packet[40:56] == model().digest
    assert struct.unpack("<4H", packet[56:64]) == (10, 9, 3, 5)
    assert struct.unpack("<3d", packet[64:88]) == (1.0, -2.0, 3.0)
    assert struct.unpack("<I", packet[88:]) == (zlib.crc32(packet[:88]),)
    assert len(CODEC.state(BOTH, state(0.5))) == 64 + 8 * (4 + 10 + 9 + 5 + 3) + 4


@pytest.mark.parametrize(
    ("at", "new", "fault"),
    [
        (0, b"X", Fault.MAGIC),
        (4, b"\x02", Fault.VERSION),
        (5, b"\x09", Fault.KIND),
        (32, struct.pack("<d", -1.0), Fault.VALUES),
        (32, struct.pack("<d", np.nan), Fault.VALUES),
        (40, b"other digest....", Fault.MODEL),
        (56, b"\x0b", Fault.SHAPE),
        (5, b"\x00", Fault.SIZE),
    ],
)
def test_each_wrong_field_has_its_name(at, new, fault):
    packet = CODEC.command(BOTH, 4, torque(0.5))
    assert CODEC.header(changed(packet, at, new)) is fault


@settings(max_examples=200, deadline=None)
@given(st.binary(max_size=400))
def test_garbage_is_no_packet(noise):
    assert isinstance(CODEC.header(noise), Fault)


@settings(max_examples=200, deadline=None)
@given(st.integers(0, 91), st.integers(1, 255))
def test_any_changed_byte_is_noticed(at, bits):
    packet = bytearray(CODEC.command(BOTH, 4, torque(0.5)))
    packet[at] ^= bits
    assert isinstance(CODEC.header(bytes(packet)), Fault)


@pytest.mark.parametrize("size", [0, 1, 67, 91, 93])
def test_a_cut_or_longer_packet_is_noticed(size):
    packet = CODEC.command(BOTH, 4, torque(0.5)) + b"\0"
    assert CODEC.header(packet[:size]) in (Fault.SIZE, Fault.CRC)


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf, 10.001, -10.001, 1e300])
def test_a_torque_beyond_the_limits_is_neither_sent_nor_taken(wrong):
    with pytest.raises(InputError):
        CODEC.command(BOTH, 4, torque(0.5, 0.0, wrong, 0.0))
    packet = changed(CODEC.command(BOTH, 4, torque(0.5)), 72, struct.pack("<d", wrong))
    assert CODEC.command_in(packet, good(packet)) is Fault.VALUES


@pytest.mark.parametrize(("at", "wrong"), [(96 + 8, np.inf), (96, -2e6), (64, 0.6), (64, np.nan)])
def test_a_state_that_nobody_measured_is_not_taken(at, wrong):
    """Infinite, beyond all measure, or measured in the future."""
    packet = changed(CODEC.state(BOTH, state(0.5)), at, struct.pack("<d", wrong))
    assert CODEC.state_in(packet, good(packet)) is Fault.VALUES


def test_a_mode_that_does_not_exist_is_not_taken():
    packet = changed(CODEC.state(BOTH, state(0.5)), 6, b"\x63\x00")
    assert CODEC.state_in(packet, good(packet)) is Fault.VALUES
    packet = changed(CODEC.command(BOTH, 1, torque(0.5)), 6, b"\x63\x00")
    assert CODEC.command_in(packet, good(packet)) is Fault.VALUES


def test_models_that_differ_in_anything_have_other_digests():
    robot = get_robot("hrp2")
    kin = robot.at(robot.q_half_sitting)
    soles = [
        SoleContact(s.frame, sole=s, T_world_anchor=kin.placement(s.frame)) for s in robot.soles
    ]
    both, one = ContactStack(soles), ContactStack(soles[:1])
    digests = {
        WireModel.of(robot, both, 1e-3, lockstep=True).digest,
        WireModel.of(robot, one, 1e-3, lockstep=True).digest,
        WireModel.of(robot, both, 2e-3, lockstep=True).digest,
        WireModel.of(robot, both, 1e-3, lockstep=False).digest,
    }
    assert len(digests) == 4
    assert WireModel.of(robot, both, 1e-3, lockstep=True).digest in digests


def test_sizes_have_a_bound():
    with pytest.raises(InputError, match="nv must be from 0 to 256"):
        WireModel(10, 300, 3, 5, np.ones(3), bytes(16))
