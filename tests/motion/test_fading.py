"""Tasks that come and go do not make the velocity jump, and priorities stay strict meanwhile."""

from __future__ import annotations

from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest

from equipoise.contacts import ContactStack
from equipoise.errors import NameNotFoundError
from equipoise.hqp import Hierarchy, Rows, Status, make_solver
from equipoise.hqp.solution import describe
from equipoise.kinematics import kinematics_at
from equipoise.motion import MotionGenerator, MotionStep
from equipoise.spatial import pose
from equipoise.tasks import ContactTask, FramePoseTask, JointLimitsTask, PostureTask, Task
from equipoise.trajectories import Fade, FixedPose
from helpers import sole_contacts
from hqp.hqp_problems import random_hierarchy


class StillTask(Task):
    """Rows that never change."""

    labels = units = ()

    def __init__(self, rows: Rows) -> None:
        super().__init__(rows.name)
        self._rows = rows

    def rows(self, kin, t):
        return self._rows

    def error(self, kin, t):
        return np.zeros(0)


def cascade():
    return make_solver("cascade")


def active_set():
    return make_solver("active_set")


def still_levels(h: Hierarchy) -> list[list[StillTask]]:
    """Return a task a block of a hierarchy, level by level."""
    levels: list[list[StillTask]] = [[] for _ in h.ends]
    for b in h.blocks:
        rows = Rows(b.name, b.unit, b.labels, h.A[b.rows], h.lower[b.rows], h.upper[b.rows])
        levels[b.level].append(StillTask(rows))
    return levels


def sliders(n: int) -> SimpleNamespace:
    """Return a robot of n joints that nothing depends on."""
    model = pin.Model()
    for k in range(n):
        joint = model.addJoint(0, pin.JointModelPX(), pin.SE3.Identity(), f"joint{k}")
        model.appendBodyToJoint(joint, pin.Inertia.Random(), pin.SE3.Identity())
    robot = SimpleNamespace(model=model, nq=n, nv=n, nv_base=0, frame_id=int)
    robot.at = lambda q, v=None, t=0.0: kinematics_at(robot, q, v, t)
    return robot


FADES = {"l1": Fade(0.0, 1.0, 0.4), "l2": Fade(0.1, 0.8, 0.3), "l0": Fade(0.3, 2.0, 0.2)}


def blended(h: Hierarchy, fades=FADES, solver=cascade) -> MotionGenerator:
    named = {name: fade for name, fade in fades.items() if name in {b.name for b in h.blocks}}
    return MotionGenerator(sliders(h.n), still_levels(h), solver, 1e-3, np.zeros(h.n), fades=named)


def solved(motion: MotionGenerator, t: float) -> MotionStep:
    """Return a step whose parts are put together."""
    step = motion.step(t)
    _, _, step.listed = step.hierarchy, step.solution, step.parts
    return step


@pytest.mark.parametrize("solver", [cascade, active_set])
@pytest.mark.parametrize("kind", ["infeasible", "redundant", "boxes", "degenerate"])
def test_the_velocity_moves_no_faster_than_the_weights(kind, solver) -> None:
    """|dv| <= sum |dw| times the distance of two optima, however the ramps overlap."""
    for seed in range(2):
        h = random_hierarchy(kind, 400 + seed, n=7)
        motion = blended(h, solver=solver)
        times = np.linspace(-0.1, 2.1, 67)
        steps = [solved(motion, t) for t in times]
        optima = np.array([p.solution.v for step in steps for p in step.listed])
        far = np.linalg.norm(optima[:, None] - optima[None], axis=2).max()
        v = [step.v_ref for step in steps]
        weights = [np.array([f.weight(t) for f in motion.fades.values()]) for t in times]
        for (w0, v0), (w1, v1) in pairwise(zip(weights, v, strict=True)):
            assert np.linalg.norm(v1 - v0) <= np.abs(w1 - w0).sum() * far + 1e-9


def test_the_blend_is_what_is_answered() -> None:
    h = random_hierarchy("infeasible", 400, n=7)
    steps = [solved(blended(h, solver=solver), 0.2) for solver in (cascade, active_set)]
    for step in steps:
        assert len(step.listed) == 3
        v = sum(p.share * p.solution.v for p in step.listed)
        assert np.allclose(step.v_ref, v, rtol=1e-12)
        assert np.allclose(step.solution.v, v, rtol=1e-12)
    assert np.allclose(steps[0].v_ref, steps[1].v_ref, atol=1e-7)


@pytest.mark.parametrize("kind", ["infeasible", "redundant", "boxes"])
def test_priorities_stay_strict_while_fading(kind) -> None:
    """Levels above every fading task keep their optimum; no level is worse than the blend."""
    for seed in range(4):
        h = random_hierarchy(kind, 500 + seed, n=7)
        motion = blended(h, {"l1": FADES["l1"], "l2": FADES["l2"]})
        for t in np.linspace(0.0, 1.0, 9):
            step = solved(motion, t)
            parts = step.listed
            hierarchy = parts[0].hierarchy  # with all of them
            solution = describe(hierarchy, step.v_ref, Status.SOLVED, "", 0)
            assert sum(p.share for p in parts) == pytest.approx(1.0)
            size = 1.0 + np.abs(hierarchy.A).max()
            violated = [
                [*describe(hierarchy, p.solution.v, Status.SOLVED, "", 0).slack] for p in parts
            ]
            mixed = np.array([p.share for p in parts]) @ np.array(violated)
            assert (np.array(solution.slack) <= mixed + 1e-9 * size).all()
            assert solution.slack[0] <= min(v[0] for v in violated) + 1e-9 * size


def test_where_nothing_fades_it_is_the_optimum_itself() -> None:
    h = random_hierarchy("infeasible", 8, n=7)
    motion = blended(h, {"l1": Fade(1.0, 2.0, 0.2)})
    step = solved(motion, 1.5)
    assert step.hierarchy.ends == h.ends
    assert np.array_equal(step.solution.v, cascade().solve(h).v)
    step = solved(motion, 0.5)
    assert len(step.hierarchy.ends) == len(h.ends)
    assert "l1" not in [b.name for b in step.hierarchy.blocks]
    assert step.solution.certificate(step.hierarchy).holds()
    step = solved(motion, 1.1)
    assert len(step.listed) == 2
    assert "l1" not in [b.name for b in step.hierarchy.blocks]  # it does not count fully yet


def test_a_fade_of_no_task_is_refused() -> None:
    with pytest.raises(NameNotFoundError, match="l0"):
        MotionGenerator(
            sliders(7), still_levels(random_hierarchy("boxes", 1, n=7)), cascade, 1e-3,
            np.zeros(7), fades={"L0": Fade()},
        )  # fmt: skip


def test_a_solver_that_fails_is_not_blended_away() -> None:
    class Failing:
        name = "failing"

        def solve(self, h):
            return describe(h, np.full(h.n, np.nan), Status.FAILED, self.name, 0)

    h = random_hierarchy("infeasible", 8, n=7)
    step = solved(blended(h, {"l1": Fade(0.0, 1.0, 0.4)}, Failing), 0.2)
    assert not step.v_ref.any()
    solution = step.solution
    assert solution.status is Status.FAILED
    assert not solution.v.any()
    assert solution.slack[0] == np.inf


def generator(robot, ramp, dt, *, shift=(0.05, 0.03, 0.05), share=0.95, first=False, end=0.25):
    """Return a standing robot whose hand has a task from 0.05 s to `end`, with `first` at level 0.

    `shift` [m]: how far off the task finds the hand; `share` of the speed limits may be used.
    """
    q = robot.q_half_sitting
    moved = pose(shift) * robot.at(q).placement("left_palm")
    hand = FramePoseTask("hand", "left_palm", FixedPose(moved))
    soles = ContactStack(sole_contacts(robot, q))
    levels = [
        [ContactTask("contacts", soles)],
        [JointLimitsTask("limits", robot, velocity_share=share)],
        [hand],
        [PostureTask("posture", robot, q[7:] + 0.05)],
    ]
    if first:
        levels[0].append(levels[2].pop())
    return MotionGenerator(robot, levels, active_set, dt, q, fades={"hand": Fade(0.05, end, ramp)})


def largest_steps(robot, ramp, dt, **how) -> tuple[float, float]:
    """Return the largest change of v_ref in a tick around the start, and around the end."""
    motion = generator(robot, ramp, dt, **how)
    ticks = [(k * dt, motion.step(k * dt)) for k in range(round(0.27 / dt))]
    v = np.array([step.v_ref for _, step in ticks])
    change = np.abs(np.diff(v, axis=0)).max(axis=1)
    t = np.array([t for t, _ in ticks[1:]])
    return change[(t > 0.04) & (t < 0.15)].max(), change[t >= 0.15].max()


FINE = (0.001, 0.00025)  # [s] the first resolves how fast bounds become active
COARSE = (0.004, 0.001)

CASES = {
    "reachable": {},
    "too fast for the limits above": {"share": 0.03},
    "among the contacts": {"first": True},
}


@pytest.mark.parametrize("case", CASES)
def test_a_fading_task_makes_no_jump_and_a_switched_one_does(hrp2, case) -> None:
    """A jump stays as it is when the time step shrinks; a smooth change shrinks with it."""
    coarse, fine = (largest_steps(hrp2, 0.1, dt, **CASES[case]) for dt in FINE)
    switched = [largest_steps(hrp2, 0.0, dt, **CASES[case]) for dt in COARSE]
    for edge in (0, 1):
        assert fine[edge] < 0.4 * coarse[edge]
        assert switched[1][edge] > 0.6 * switched[0][edge]
        assert coarse[edge] < 0.15 * switched[1][edge]  # at the same step


def test_levels_above_hold_while_a_task_below_fades(hrp2) -> None:
    motion = generator(hrp2, 0.1, 0.004, share=0.03, end=0.35)
    short = 0.0
    for k in range(100):
        step = motion.step(k * 0.004)
        assert max(step.solution.slack[:2]) < 1e-9  # contacts and limits
        short = max(short, step.solution.slack[2])
    assert short > 0.1  # the limits did hold the hand up
