"""Live targets and forces: no lag where the velocity is known, no jump, no running away."""

from __future__ import annotations

import threading

import numpy as np
import pinocchio as pin
import pytest

from equipoise.errors import InputError, NonFiniteError, ShapeError
from equipoise.hqp import make_solver
from equipoise.motion import MotionGenerator
from equipoise.spatial import pose
from equipoise.tasks import FramePoseTask, GazeTask
from equipoise.trajectories import FixedPose, LiveScalar, LiveTarget
from equipoise.trajectories.live import live_alone
from equipoise.trajectories.live_scalar import live_scalar_alone
from helpers import kinematics

DT, SPEED, RADIUS = 1e-3, 0.3, 0.1
OMEGA = SPEED / RADIUS


def circle(t):
    """Return pose and twist of what goes round and turns with it."""
    c, s = np.cos(OMEGA * t), np.sin(OMEGA * t)
    T = pin.SE3(pin.rpy.rpyToMatrix(0.2 * s, 0.0, 0.0), RADIUS * np.array([c, s, 0.0]))
    twist = np.array([-SPEED * s, SPEED * c, 0.0, 0.2 * OMEGA * c, 0.0, 0.0])
    return T, twist


class Ticks:
    """The kernel of one target, tick by tick."""

    def __init__(self, target):
        self.target, self.numbers = target, target.numbers
        target.work_in(self.numbers)

    def __call__(self, t):
        self.target.post()
        row = np.empty(18)
        live_alone(self.numbers, t, row)
        return row


EVERY = [(True, 1, 1e-6), (False, 1, 1e-4), (True, 33, 1e-3), (False, 33, 3e-3)]


@pytest.mark.parametrize(("known", "every", "most"), EVERY)
def test_a_circle_is_followed(known, every, most):
    """What is shown is where the target is, however often it is told; its twist is the rate."""
    T, twist = circle(0.0)
    ticks = Ticks(LiveTarget(T))
    worst, last = 0.0, None
    for k in range(3000):
        T, twist = circle(k * DT)
        if k % every == 0:
            ticks.target.set(T, twist if known else None)
        row = ticks(k * DT)
        if k > 1000:
            worst = max(worst, np.abs(row[9:12] - T.translation).max())
            assert np.abs(row[9:12] - last[9:12]).max() < 1.1 * SPEED * DT + 1e-3
        last = row
    assert worst < most


def test_the_twist_shown_is_the_rate_of_the_pose_while_it_fades(rng):
    """Finite differences, across a jump of place and rotation, a second jump on the way."""
    ticks = Ticks(LiveTarget(pose((0, 0, 0), (0.3, 0.1, -0.2))))
    rows = []
    h = 1e-4
    for k in range(8000):
        if k == 1000:
            ticks.target.set(
                pose((0.2, -0.1, 0.3), (1.0, -0.8, 1.2)), np.array([0.1, 0, 0, 0, 0.3, 0])
            )
        if k == 2200:
            ticks.target.set(pose((-0.2, 0.1, 0.1), (-1.0, 0.4, 0.2)))
        rows.append(ticks(k * h))
    for a, b, c in zip(rows, rows[1:], rows[2:], strict=False):
        assert np.allclose((c[9:12] - a[9:12]) / (2 * h), b[12:15], atol=2e-4)
        R, S = (row[:9].reshape(3, 3).T for row in (a, c))
        assert np.allclose(pin.log3(S @ R.T) / (2 * h), b[15:18], atol=2e-3)
        assert np.abs(c[12:] - b[12:]).max() < 0.05  # no jump of the speed in 0.1 ms
    assert np.allclose(rows[-1][9:12], [-0.2, 0.1, 0.1])
    assert np.allclose(rows[-1][12:], 0.0)


@pytest.mark.parametrize("way", [0.02, 0.3, 2.0])
def test_a_jump_keeps_speed_and_acceleration(way):
    """A short one takes the fade, a long one as long as one of the bounds asks for."""
    ticks = Ticks(LiveTarget(pin.SE3.Identity(), speed=0.5, acceleration=2.0, fade=0.3))
    ticks(0.0)
    ticks.target.set(pose((way, 0, 0)))
    rows = np.array([ticks(k * DT) for k in range(9000)])
    speed, change = rows[:, 12].max(), np.abs(np.diff(rows[:, 12])).max() / DT
    assert rows[-1, 9] == pytest.approx(way)
    assert speed < 0.5 * 1.001
    assert change < 2.0 * 1.001
    if way < 0.03:
        assert rows[round(0.3 / DT), 9] == pytest.approx(way)
    else:
        assert max(speed / 0.5, change / 2.0) > 0.98


def test_a_jump_back_on_the_way_brakes_first():
    """What goes at full speed goes on by its braking distance, no further."""
    ticks = Ticks(LiveTarget(pin.SE3.Identity(), speed=0.5, acceleration=2.0))
    ticks.target.set(pose((2.0, 0, 0)))
    there = [ticks(k * DT) for k in range(3750)][-1]
    ticks.target.set(pin.SE3.Identity())
    rows = np.array([ticks((3750 + k) * DT) for k in range(9000)])
    assert there[12] == pytest.approx(0.5, rel=0.01)
    assert rows[:, 9].max() - there[9] < 0.1
    assert np.abs(np.diff(rows[:, 12])).max() / DT < 4.01
    assert rows[-1, 9] == pytest.approx(0.0, abs=1e-9)


def test_a_target_that_nobody_sets_any_more_comes_to_rest():
    ticks = Ticks(LiveTarget(pin.SE3.Identity(), hold=0.1))
    ticks.target.set(pin.SE3.Identity(), np.array([0.04, 0, 0, 0, 0, 0]))
    way = [ticks(k * DT)[9] for k in range(400)]
    assert way[100] == pytest.approx(0.004)
    assert way[-1] == way[250] == pytest.approx(0.006)


def test_one_jump_makes_no_speed():
    """A target moved once by hand is not taken for one that flies."""
    ticks = Ticks(LiveTarget(pin.SE3.Identity()))
    for k in range(1500):
        if k in (100, 150):
            ticks.target.set(pose((0.2 if k == 150 else 0.0, 0, 0)))
        far = ticks(k * DT)[9]
        assert far < 0.2 + 0.02
    assert far == pytest.approx(0.2, abs=0.02)


def test_noise_is_smoothed(rng):
    """Measured targets, 1 kHz with 0.1 mm of noise: the speed fed forward stays near the true."""
    T, _ = circle(0.0)
    ticks, off = Ticks(LiveTarget(T, smoothing=0.02)), []
    for k in range(2000):
        T, twist = circle(k * DT)
        noisy = pin.SE3(T.rotation, T.translation + rng.normal(size=3) * 1e-4)
        ticks.target.set(noisy)
        off.append(ticks(k * DT)[12:15] - twist[:3])
    assert np.std(off[500:]) < 0.05


def test_any_thread_may_set_it_and_no_half_is_seen():
    target = LiveTarget(pin.SE3.Identity(), fade=1e-3)
    ticks, stop = Ticks(target), threading.Event()

    def send():
        k = 0
        while not stop.is_set():
            k += 1
            x = 0.001 * (k % 10)
            target.set(pose((x, x, x)), np.zeros(6))

    threads = [threading.Thread(target=send) for _ in range(3)]
    for thread in threads:
        thread.start()
    rows = [ticks(k * DT) for k in range(3000)]
    stop.set()
    for thread in threads:
        thread.join()
    assert all(row[9] == pytest.approx(row[10]) == pytest.approx(row[11]) for row in rows)


@pytest.mark.parametrize(("known", "most"), [(True, 1e-4), (False, 2e-3)])
def test_a_hand_lags_by_no_more_than_wanted(hrp2, known, most):
    """0.3 m/s on a circle, one generator at 1 kHz: what the issue of moving targets asks."""
    T0 = kinematics(hrp2, hrp2.q_half_sitting).placement("right_palm")
    centre = T0.translation + np.array([0.1 - RADIUS, 0.0, 0.15])
    task = FramePoseTask("hand", "right_palm", T0)
    motion = MotionGenerator(hrp2, [[task]], make_solver("active_set"), DT, hrp2.q_half_sitting)
    lag = []
    for k in range(2500):
        T, twist = circle(k * DT)
        there = pin.SE3(T0.rotation, centre + T.translation)
        task.target = (there, np.r_[twist[:3], 0, 0, 0]) if known else there
        step = motion.step(k * DT)
        lag.append(np.linalg.norm(step.kin.placement("right_palm").translation - there.translation))
    assert max(lag[1500:]) < most
    assert motion.one_call


def test_a_gaze_can_be_set_too(hrp2):
    task = GazeTask("look", hrp2.camera, pose((1.0, 0.0, 1.0)))
    task.target = pose((1.0, 0.3, 1.0))
    assert task.error(kinematics(hrp2, hrp2.q_half_sitting), 0.0).shape == (2,)


def test_what_is_no_target_is_refused():
    target = LiveTarget(pin.SE3.Identity())
    task = FramePoseTask("hand", "palm", target)
    with pytest.raises(InputError, match=r"pinocchio\.SE3"):
        task.target = np.eye(4)
    with pytest.raises(NonFiniteError):
        task.target = pin.SE3(np.eye(3), np.array([np.nan, 0, 0]))
    with pytest.raises(ShapeError, match="twist"):
        task.target = pin.SE3.Identity(), np.zeros(3)
    with pytest.raises(InputError, match="is a FixedPose"):
        FramePoseTask("hand", "palm", FixedPose(pin.SE3.Identity())).target = pin.SE3.Identity()
    for how in ({"fade": 0.0}, {"hold": -1.0}, {"smoothing": -1.0}, {"speed": 0.0}):
        with pytest.raises(InputError):
            LiveTarget(pin.SE3.Identity(), **how)


def test_a_live_number_fades_and_small_steps_are_taken_at_once():
    force = LiveScalar(20.0, start=0.0, fade=0.5)
    assert force.least == 0.0
    assert force.value == 20.0
    numbers = force.numbers
    force.work_in(numbers)
    values = []
    for k in range(3000):
        if k == 500:
            force.value = 40.0
        if k == 700:
            force.value = 10.0
        if k >= 2000:
            force.value = 10.0 + 5.0 * np.sin(0.01 * (k - 2000))
        force.post()
        values.append(live_scalar_alone(numbers, k * DT))
    assert values[0] == 0.0
    assert values[499] == pytest.approx(20.0, abs=1e-3)
    assert np.abs(np.diff(values)).max() < 0.3
    assert values[1999] == 10.0
    assert values[2999] == force.at(3.0) == force.value
    with pytest.raises(InputError):
        force.value = "much"
