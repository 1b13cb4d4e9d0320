"""Rows with an ease: promises of second order in closed loop, the tray without kinks, refusals."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from equipoise.analysis.metrics.smoothness import acceleration_steps
from equipoise.errors import InputError
from equipoise.hqp import explain, make_solver
from equipoise.motion import MotionGenerator
from equipoise.scenarios import read_scenario
from equipoise.simulation.build.levels import build_levels
from equipoise.simulation.build.setup import build_setup
from equipoise.simulation.simulation import Simulation
from equipoise.tasks import (
    ComPolygonTask,
    ContactTask,
    JointAccelerationsTask,
    JointLimitsTask,
    PostureTask,
    Task,
    describe_rows,
)

# what the tray was before: bounds of first order, and twice as fast a posture
BEFORE = [
    *(f"tasks.{name}.ease=null" for name in ("com", "limits", "obstacles", "posture")),
    "tasks.posture.rate=2.0",
]
EXACT = 1e-9


def motion_of(robot, levels, dt, q=None, solver="active_set") -> MotionGenerator:
    q = robot.q_half_sitting if q is None else q
    return MotionGenerator(robot, levels, lambda: make_solver(solver), dt, q, advise=False)


@pytest.mark.parametrize(
    ("rate", "ease", "dt"), [(5.0, 10.0, 0.001), (10.0, 40.0, 0.01), (50.0, 20.0, 0.02)]
)
def test_what_is_left_of_a_bound_is_used_up_at_its_ease(hrp2, rate, ease, dt):
    """Joints thrown at their stops: the slack keeps the share 1 - e dt a tick, exactly on the row.

    So no stop is passed, and nothing brakes harder than the two rates of the row together.
    """
    limits = JointLimitsTask("limits", hrp2, rate=rate).easing(ease)
    wild = PostureTask("wild", hrp2, hrp2.q_max + 1.0, rate=0.8 / dt)
    motion = motion_of(hrp2, [[limits], [wild]], dt)
    slack, below, before = np.zeros(0), np.zeros(0, dtype=bool), np.zeros(0)
    held, worst = 0, -np.inf
    for k in range(round(8.0 / (min(rate, ease) * dt))):
        step = motion.step(k * dt)
        v, q = step.v_ref[6:], step.q_ref[7:]
        assert (q <= limits.q_high + EXACT).all()
        high = rate * (limits.q_high - q)
        free = high < limits.v_share  # below the speed limit the bound falls with the distance
        left = np.minimum(high, limits.v_share) - v
        assert (left >= -EXACT).all()
        if len(slack):
            both = free & below & (v > 0.0) & (before > 0.0)
            share = (1.0 - ease * dt) * slack[both]
            assert (left[both] >= share - EXACT).all()
            on = np.abs(left[both] - share) <= EXACT
            held += int(on.sum())
            brake = (before - v)[both] / dt
            worst = max(worst, float((brake - (rate + ease) * before[both]).max(initial=-np.inf)))
        slack, below, before = left, free, v
    assert held > 100  # it is the row that held, not the posture
    assert worst <= EXACT


def test_eased_bounds_are_no_wider_and_standing_still_is_allowed(hrp2, rng):
    """At random states: inside the bounds of first order; rest and a slower going on are inside."""
    dt, ease, rate = 0.005, 12.0, 5.0
    square = build_setup(read_scenario("tray")).polygon
    tasks = JointLimitsTask("limits", hrp2, rate=rate), ComPolygonTask("com", square, rate=rate)
    eased_tasks = (
        JointLimitsTask("limits", hrp2, rate=rate).easing(ease),
        ComPolygonTask("com", square, rate=rate).easing(ease),
    )
    for _ in range(20):
        q = hrp2.q_half_sitting.copy()
        q[7:] = rng.uniform(hrp2.q_min + 0.02, hrp2.q_max - 0.02)
        q[:2] -= hrp2.at(q).p_world_com[:2] - square.vertices.mean(axis=0)
        plain = _hierarchy(motion_of(hrp2, [tasks], dt, q), q, np.zeros(hrp2.nv))
        v = rng.normal(size=hrp2.nv)
        value = plain.A @ v
        with np.errstate(divide="ignore"):
            room = np.where(value > 0.0, plain.upper / value, plain.lower / value)
        v *= rng.uniform(0.5, 1.0) * room.min()  # the bounds of first order hold
        eased = _hierarchy(motion_of(hrp2, [eased_tasks], dt, q), q, v)
        assert (eased.lower >= plain.lower).all()
        assert (eased.upper <= plain.upper).all()
        assert (eased.lower <= eased.upper).all()
        assert (eased.upper < plain.upper).any()
        slower = (1.0 - ease * dt) * (1.0 - rate * dt)
        for share in (0.0, 0.5 * slower, slower):
            value = eased.A @ (share * v)
            assert (value <= eased.upper + EXACT).all()
            assert (value >= eased.lower - EXACT).all()


def _hierarchy(motion, q, v):
    motion.reset(q, v)
    return motion.step(0.0).hierarchy


def test_what_it_comes_to_rest_at_is_what_it_was(hrp2):
    """A posture beyond stops and the edge of the polygon, at two periods, with and without ease."""
    found = []
    for dt, ease in ((0.02, None), (0.02, 6.0), (0.005, 6.0)):
        scenario = read_scenario("tray")
        setup = build_setup(scenario)
        goal = hrp2.q_half_sitting[7:].copy()
        goal[hrp2.joint_index("CHEST_JOINT1")] = 2.0
        tasks: list[Task] = [
            ComPolygonTask("com", setup.polygon, margin=0.08),
            JointLimitsTask("limits", hrp2, rate=5.0),
            PostureTask("posture", hrp2, goal, rate=1.5),
        ]
        if ease is not None:
            tasks = [task.easing(ease) for task in tasks]
        contacts = ContactTask("contacts", setup.soles)
        motion = motion_of(hrp2, [[contacts], tasks[:2], tasks[2:]], dt)
        for k in range(round(14.0 / dt)):
            step = motion.step(k * dt)
        assert np.abs(step.v_ref).max() < 1e-5
        assert np.count_nonzero(step.solution.active) > 12  # stops or edges hold it
        found.append(step.q_ref)
    assert np.abs(found[1] - found[0]).max() < 1e-4
    assert np.abs(found[2] - found[0]).max() < 1e-4


@cache
def reference_of(eased: bool, period: float):
    """Return the tray's velocities (N, nv) and how short each level was (N, levels)."""
    scenario = read_scenario("tray", [] if eased else BEFORE)
    simulation = Simulation(scenario)
    levels = build_levels(scenario, simulation.setup)
    motion = motion_of(simulation.robot, levels, period, simulation.assembly.q_start)
    count = round(scenario.duration / period)
    v, slack = np.empty((count, simulation.robot.nv)), np.empty((count, len(motion.levels)))
    for k in range(count):
        v[k] = motion.step(k * period).v_ref
        motion.measure_levels(slack[k])
    return v, slack


def test_the_tray_has_half_of_the_variation_and_its_levels_hold():
    """Total variation of dv_ref/dt, of joints and of all; the levels that may never be short."""
    (v, _), (v_eased, slack) = (reference_of(eased, 0.001) for eased in (False, True))
    for part in (slice(6, None), slice(None)):
        before, now = (acceleration_steps(one[:, part], 0.001).sum() for one in (v, v_eased))
        assert now <= 0.5 * before
    assert slack[:, :3].max() <= EXACT  # contacts; feet and balance; hands and limits


def test_accelerations_do_not_jump_at_any_period():
    """A kink is a jump of the acceleration however short the ticks; eased it is 2 % of that.

    What is left comes from rows that turn: where they use up the last of a slack, the bound of
    first order takes over, and the acceleration jumps by `dA/dt v`.
    """
    jumps, sums = {}, {}
    for period in (0.002, 0.001):
        for eased in (False, True):
            steps = acceleration_steps(reference_of(eased, period)[0][:, 6:], period)
            jumps[eased, period], sums[eased, period] = steps.max(), steps.sum()
        assert jumps[True, period] <= 0.02 * jumps[False, period]
    assert jumps[False, 0.001] >= 0.7 * jumps[False, 0.002]
    assert sums[True, 0.001] == pytest.approx(sums[True, 0.002], rel=0.03)


class Plain(Task):
    """The rows of another task in plain Python."""

    labels = units = ()

    def __init__(self, like: Task) -> None:
        super().__init__(like.name)
        self.like, self.rate = like, like.rate

    @property
    def row_caps(self):
        return self.like.row_caps

    def rows(self, kin, t):
        return self.like.rows(kin, t)

    def error(self, kin, t):
        return self.like.error(kin, t)


def test_tasks_in_python_and_other_solvers_are_eased_alike(hrp2):
    """The same ticks from a kernel, from plain Python rows, and from the cascade."""
    ticks = []
    for plain, solver in ((False, "active_set"), (True, "active_set"), (False, "cascade")):
        tasks = [
            JointLimitsTask("limits", hrp2, velocity_share=1.0, rate=5.0),
            PostureTask("posture", hrp2, hrp2.q_max, rate=6.0),
        ]
        tasks = [(Plain(task) if plain else task).easing(8.0) for task in tasks]
        motion = motion_of(hrp2, [tasks[:1], tasks[1:]], 0.01, solver=solver)
        ticks.append([motion.step(0.01 * k).v_ref for k in range(60)])
    assert np.abs(np.subtract(ticks[1], ticks[0])).max() < 1e-7
    assert np.abs(np.subtract(ticks[2], ticks[0])).max() < 1e-6


def test_an_eased_posture_is_left_over_by_what_it_lacks(hrp2):
    """From rest the words say how far it is, as without an ease."""
    dt, goal = 0.004, hrp2.q_half_sitting[7:].copy()
    goal[5] += 0.2
    frozen = JointLimitsTask("limits", hrp2, frozen=[hrp2.joint_names[5]])
    posture = PostureTask("posture", hrp2, goal, rate=2.0).easing(5.0)
    step = motion_of(hrp2, [[frozen], [posture]], dt).step(0.0)
    words = describe_rows([frozen, posture], step.hierarchy, step.kin, dt)
    amount, unit = explain(step.hierarchy, step.v_ref, words).of("posture").amounts[0]
    assert (amount, unit) == (pytest.approx(0.2), "rad")


def test_what_cannot_be_eased_is_refused(hrp2):
    limits = JointLimitsTask("limits", hrp2)
    for ease in (0.0, -1.0, float("nan"), float("inf")):
        with pytest.raises(InputError, match="ease of task 'limits'"):
            limits.easing(ease)
    brake = JointAccelerationsTask("brake", hrp2, np.ones(hrp2.na), 0.001)
    with pytest.raises(InputError, match="has no ease"):
        brake.easing(3.0)
    setup = build_setup(read_scenario("tray"))
    with pytest.raises(InputError, match="contacts hold or do not"):
        ContactTask("contacts", setup.soles).easing(3.0)
    scenario = read_scenario(
        "tray", ["tasks.brake={kind: joint_accelerations, priority: 1, ease: 3.0}"]
    )
    with pytest.raises(InputError, match="has no ease") as told:
        build_levels(scenario, setup)
    assert "tasks.brake.ease" in str(told.value)
