"""The door for those who want only the motion."""

from __future__ import annotations

import numpy as np
import pytest

from equipoise import InverseKinematics
from equipoise.errors import InputError, NameNotFoundError, ShapeError
from equipoise.motion import MotionGenerator
from equipoise.spatial import pose
from equipoise.tasks import FramePoseTask
from helpers import kinematics


def test_a_hand_goes_where_it_is_sent_and_feet_stay(hrp2):
    kin = kinematics(hrp2, hrp2.q_half_sitting)
    T = kin.placement("right_palm")
    hand = FramePoseTask("hand", "right_palm", T)
    ik = InverseKinematics(hrp2, [hand])
    assert isinstance(ik.motion, MotionGenerator)
    hand.target = pose((0.03, 0.0, 0.08)) * T
    last = ik.step()
    for _ in range(300):
        step = ik.step()
        assert np.abs(step.v_ref - last.v_ref).max() < 0.3  # the target fades, nothing jumps
        last = step
    assert np.abs(hand.error(step.kin, step.t)).max() < 1e-3
    for sole in hrp2.soles:
        off = step.kin.placement(sole.frame).translation - kin.placement(sole.frame).translation
        assert np.abs(off).max() < 1e-8
    assert ik.t == pytest.approx(3.01)


def test_it_settles(hrp2):
    T = kinematics(hrp2, hrp2.q_half_sitting).placement("right_palm")
    ik = InverseKinematics(hrp2, [FramePoseTask("hand", "right_palm", pose((0.05, 0, 0.1)) * T)])
    step = ik.settle()
    assert np.abs(step.v_ref).max() < 1e-3
    with pytest.raises(InputError, match="still moves after 2 steps"):
        InverseKinematics(
            hrp2, [FramePoseTask("hand", "right_palm", pose((0.05, 0, 0.1)) * T)]
        ).settle(most=2)


def test_errors_say_what_was_given(hrp2):
    with pytest.raises(NameNotFoundError, match="hoof"):
        InverseKinematics(hrp2, feet=["hoof"])
    with pytest.raises(ShapeError, match="q_start"):
        InverseKinematics(hrp2, q_start=np.zeros(3))
    with pytest.raises(InputError, match="a level is a task"):
        InverseKinematics(hrp2, [1.0])
