"""The whole controller in one object: one call equals its parts, and its memory is one object."""

from __future__ import annotations

import pickle

import numpy as np
import pinocchio as pin
import pytest

from equipoise import ControlGains, ControlSettings, RigidContactEngine, WholeBodyController
from equipoise.collision.scene import Body, Scene, Shape
from equipoise.contacts import ContactSchedule, PointContact
from equipoise.control import (
    Command,
    ControlStatus,
    Measurement,
    Mode,
    PassivityController,
    ReactionBounds,
    Reference,
    SignFunction,
    advise_gains,
)
from equipoise.errors import InputError, NameNotFoundError, ShapeError
from equipoise.hqp import Rows, Status, make_solver
from equipoise.motion import MotionGenerator, StaleMotionError
from equipoise.spatial import pose
from equipoise.tasks import (
    AvoidanceTask,
    ContactTask,
    FramePoseTask,
    JointLimitsTask,
    PostureTask,
    Task,
)
from equipoise.trajectories import Fade, Profile, Waypoint, WaypointTrajectory
from helpers import sole_contacts

DT, LET_GO = 1e-3, 0.05
FORCE = Profile.of([0.0, 0.1], [0.0, 20.0])


class Lean(Task):
    """A task in plain Python: the base goes forward slowly; from `grown` on it has a second row."""

    labels, units = ("vx",), ("m",)

    def __init__(self, grown: float = np.inf) -> None:
        super().__init__("lean")
        self.grown = grown

    def rows(self, kin, t):
        count = 2 if t >= self.grown else 1
        A = np.zeros((count, kin.robot.nv))
        A[:, 0] = 1.0
        wanted = np.full(count, 0.02)
        return Rows(self.name, "m/s", ("vx", "again")[:count], A, wanted, wanted)

    def error(self, kin, t):
        return np.zeros(1)


class Made:
    """Robot, contacts, levels and gains of a run in which a hand presses, then is let go."""

    def __init__(self, robot, *, plain: Task | None = None, far: bool = False) -> None:
        q = robot.q_half_sitting
        kin = robot.at(q)
        left, right = (palm.frame for palm in robot.palms)
        hand = PointContact(
            "hand", regulated=("fx",), frame=right, p_world=kin.placement(right).translation
        )
        self.robot, self.q = robot, q
        self.schedule = ContactSchedule(
            [*sole_contacts(robot, q), hand], {"hand": (-np.inf, LET_GO)}
        )
        T = kin.placement(left)
        goal = pose((1.5 if far else 0.1, 0.0, 0.1)) * T  # far: no robot reaches it
        path = WaypointTrajectory([Waypoint(0.0, T), Waypoint(0.3, goal)])
        box = Shape("box", (0.05, 2.0, 3.0), pose((T.translation[0] + 0.2, 0.0, 0.0)))
        scene = Scene(robot, [Body("wall", (box,), pin.SE3.Identity())])
        link = robot.model.frames[robot.model.getFrameId(left)].parentJoint
        shapes = scene.geometry.geometryObjects
        name = next(
            name
            for name in scene.body_names
            if any(shapes[k].parentJoint == link for k in scene.shapes_of(name))
        )
        self.levels = [
            [ContactTask("contacts", self.schedule)],
            [
                JointLimitsTask("limits", robot),
                AvoidanceTask("near", scene, [scene.pair(name, "wall")]),
            ],
            [FramePoseTask("palm", left, path)],
            *([[plain]] if plain is not None else []),
            [PostureTask("posture", robot, q[robot.nq_base :])],
        ]
        self.fades = {"palm": Fade(0.01, 1.0, 0.02)}
        advice = advise_gains(robot, self.schedule.at(0.0), q, DT, alpha=10.0)
        smooth = SignFunction("saturation", 0.05)
        self.gains = ControlGains(K_d=advice.K_d, alpha=10.0, sgn_p=smooth, sgn_F=smooth)

    def controller(self, *, solver="active_set", bounds=None, **how) -> WholeBodyController:
        settings = ControlSettings(self.gains, DT, bounds=bounds, solver=solver)
        return WholeBodyController(
            self.robot, self.levels, self.schedule, settings, self.q,
            wanted_forces={"hand": [FORCE]}, fades=self.fades, **how,
        )  # fmt: skip


class Plant:
    """The rigid engine, whose contacts go with the schedule."""

    def __init__(self, made: Made) -> None:
        self.made, self.engine, self.stack = made, None, None

    def state(self, t: float):
        stack = self.made.schedule.at(t)
        if stack is not self.stack:
            q, v = self.made.q, None
            if self.engine is not None:
                q, v = self.engine.state.q, self.engine.state.v
            self.engine = RigidContactEngine(self.made.robot, stack, q, DT, v_start=v)
            self.stack = stack
        return self.engine.state


def follow(made: Made, step, ticks: int = 80) -> list[np.ndarray]:
    """Run the loop; `step(t, state)` returns what is kept of a tick, the torque first."""
    plant, kept = Plant(made), []
    for k in range(ticks):
        state = plant.state(k * DT)
        told = step(k * DT, state)
        plant.engine.step(told[0])
        kept.append(np.concatenate(told))
    return kept


def of_one_call(controller: WholeBodyController):
    def step(t, state):
        command = controller.step(t, state.q, state.v, state.lam)
        return command.tau, command.q_ref, command.v_ref, command.u, command.s

    return step


def of_parts(made: Made, solver: str, bounds=None):
    """Return the same by a motion generator and a law of their own, the reference a step behind."""
    motion = MotionGenerator(
        made.robot, made.levels, lambda: make_solver(solver), DT, made.q, fades=made.fades
    )
    law = PassivityController(made.robot, made.schedule.at(0.0), made.gains, DT, bounds=bounds)

    def step(t, state):
        if made.schedule.at(t) is not law.contacts:
            law.switch(made.schedule.at(t))
        moved = motion.step(t)
        wanted = [FORCE.at(t)] if t < LET_GO else []
        reference = Reference(moved.q_ref, moved.v_ref, np.array(wanted))
        command = law.step(t, Measurement(state.q, state.v, state.lam), reference)
        return command.tau, moved.q_ref, moved.v_ref, command.u, command.s

    return step


@pytest.fixture(scope="module")
def made(hrp2) -> Made:
    return Made(hrp2)


@pytest.mark.parametrize("bounds", [None, ReactionBounds()], ids=["least", "bounded"])
def test_one_call_is_motion_and_law(made, bounds):
    """Through a fade and a change of contacts with its hand-over."""
    fused = follow(made, of_one_call(made.controller(bounds=bounds)))
    parts = follow(made, of_parts(made, "active_set", bounds))
    for one, other in zip(fused, parts, strict=True):
        assert np.allclose(one, other, rtol=1e-9, atol=1e-9)


def test_the_exact_cascade_gives_the_same_motion(made):
    """Another solver: its ticks run in parts, their references agree to its accuracy."""
    fused = follow(made, of_one_call(made.controller()), ticks=40)
    cascade = follow(made, of_one_call(made.controller(solver="cascade")), ticks=40)
    nq, nv = made.robot.nq, made.robot.nv
    for one, other in zip(fused, cascade, strict=True):
        moved = slice(made.robot.na, made.robot.na + nq + nv)
        assert np.allclose(one[moved], other[moved], atol=1e-6)


@pytest.mark.parametrize("bounds", [None, ReactionBounds()], ids=["least", "bounded"])
@pytest.mark.parametrize("at", [15, 49, 55], ids=["in the fade", "before", "after the switch"])
def test_a_restored_controller_goes_on_with_the_same_bits(made, bounds, at):
    """Also one that never ran, and one that is elsewhere; the state passes through a file."""
    first, plant = made.controller(bounds=bounds), Plant(made)
    inputs, told = [], []
    for k in range(80):
        if k == at:
            kept = pickle.loads(pickle.dumps(first.state()))
        state = plant.state(k * DT)
        command = first.step(k * DT, state.q, state.v, state.lam)
        inputs.append(state)
        told.append([command.tau, command.q_ref, command.v_ref, command.u, command.s])
        plant.engine.step(command.tau)
    for second in (made.controller(bounds=bounds), first):
        second.restore(kept)
        for k in range(at, 80):
            state = inputs[k]
            command = second.step(k * DT, state.q, state.v, state.lam)
            again = [command.tau, command.q_ref, command.v_ref, command.u, command.s]
            for one, other in zip(again, told[k], strict=True):
                assert np.array_equal(one, other)


@pytest.mark.parametrize("grown", [np.inf, 0.02], ids=["steady", "growing"])
def test_a_plain_task_has_its_say_beside_the_kernel(hrp2, grown):
    """Rows that are asked from Python, and a layout made again while running, change nothing."""
    made = Made(hrp2, plain=Lean(grown))
    controller = made.controller()
    fused = follow(made, of_one_call(controller), ticks=60)
    parts = follow(made, of_parts(made, "active_set"), ticks=60)
    for one, other in zip(fused, parts, strict=True):
        assert np.allclose(one, other, rtol=1e-9, atol=1e-9)
    assert abs(fused[-1][hrp2.na + hrp2.nq] - 0.02) < 1e-6  # the base does lean


def test_levels_that_cannot_be_met_are_solved_all_the_same(hrp2):
    made = Made(hrp2, far=True)
    controller, plant = made.controller(), Plant(made)
    for k in range(400):
        state = plant.state(k * DT)
        command = controller.step(k * DT, state.q, state.v, state.lam)
        assert command.motion_status is Status.SOLVED
        if k % 20 == 0 and k > 30:  # faded in: no blend of optima any more
            assert command.solution.certificate(command.hierarchy).holds()
        plant.engine.step(command.tau)
    assert command.solution.slack[2] > 0.1  # out of reach
    assert max(command.solution.slack[:2]) < 1e-8


def test_a_held_tick_keeps_the_torque_and_moves_the_reference(made):
    controller, free = made.controller(), made.controller()
    plant = Plant(made)
    for k in range(30):
        state = plant.state(k * DT)
        command = controller.step(k * DT, state.q, state.v, state.lam)
        undisturbed = free.step(k * DT, state.q, state.v, state.lam)
        plant.engine.step(command.tau)
    held = controller.hold(30 * DT, command)
    state = plant.state(30 * DT)
    undisturbed = free.step(30 * DT, state.q, state.v, state.lam)
    assert np.array_equal(held.tau, command.tau)
    assert np.allclose(held.q_ref, undisturbed.q_ref, atol=1e-12)
    assert not np.array_equal(held.q_ref, command.q_ref)
    assert controller.wanted == pytest.approx([FORCE.at(30 * DT)])


def test_wrenches_may_come_by_the_name_of_the_contact(made):
    first, second = made.controller(), made.controller()
    state = Plant(made).state(0.0)
    lam = np.arange(state.lam.size, dtype=float)
    by_name = made.schedule.at(0.0).split(lam)
    one = first.step(0.0, state.q, state.v, lam)
    other = second.step(0.0, state.q, state.v, by_name)
    assert np.array_equal(one.tau, other.tau)
    with pytest.raises(NameNotFoundError, match="right_sole"):
        second.step(DT, state.q, state.v, {"left_sole": lam[:6], "hand": lam[12:]})


def test_what_is_no_measurement_is_refused_and_what_is_not_finite_is_supervised(made):
    controller, state = made.controller(), Plant(made).state(0.0)
    with pytest.raises(ShapeError):
        controller.step(0.0, state.q[:-1], state.v, state.lam)
    with pytest.raises(InputError):
        controller.step(0.0, ["a"] * state.q.size, state.v, state.lam)
    controller.step(0.0, state.q, state.v, state.lam)
    deaf = np.full_like(state.lam, np.nan)
    command = controller.step(DT, state.q, state.v, deaf)
    assert command.mode is Mode.DEGRADED
    assert np.isfinite(command.tau).all()
    command = controller.step(2 * DT, state.q, state.v, state.lam)
    assert command.mode is Mode.RUN
    fallen = state.q.copy()
    fallen[3:7] = [np.sin(0.6), 0.0, 0.0, np.cos(0.6)]
    command = controller.step(3 * DT, fallen, state.v, state.lam)
    assert command.mode is Mode.SAFE
    assert "base_roll" in " ".join(controller.story)


def test_an_offset_is_added_to_what_is_wanted(made):
    first, second = made.controller(), made.controller()
    second.offsets[second.rows["hand/fx"]] = 7.0
    state = Plant(made).state(0.0)
    for one in (first, second):
        one.step(0.02, state.q, state.v, state.lam)
    assert second.wanted - first.wanted == pytest.approx(7.0)


def test_what_is_asked_for_too_late_is_refused(made):
    controller, state = made.controller(), Plant(made).state(0.0)
    command = controller.step(0.0, state.q, state.v, state.lam)
    controller.step(DT, state.q, state.v, state.lam)
    with pytest.raises(StaleMotionError):
        _ = command.solution
    assert command.tau.shape == (made.robot.na,)  # what it returned is its own


class Springs:
    """A controller of somebody else: springs to the reference."""

    def __init__(self, robot, contacts) -> None:
        self.robot, self.contacts, self.dt = robot, contacts, DT
        self.switched = 0

    def reset(self) -> None: ...

    def step(self, t, measured, reference) -> Command:
        away = pin.difference(self.robot.model, reference.q_ref, measured.q)
        tau = -100.0 * away[6:] - 10.0 * measured.v[6:]
        limit = self.robot.tau_max
        return Command(np.clip(tau, -limit, limit), ControlStatus.RUN)

    def switch(self, contacts) -> None:
        self.contacts, self.switched = contacts, self.switched + 1

    def take_over(self, tau) -> None: ...

    def state(self):
        return {"switched": self.switched}

    def restore(self, state) -> None:
        self.switched = state["switched"]


def test_another_controller_stands_behind_the_same_motion_and_supervisor(made):
    controller = made.controller(controller=lambda stack: Springs(made.robot, stack))
    law = made.controller()
    state = Plant(made).state(0.0)
    for k in range(60):
        lam = state.lam[: made.schedule.at(k * DT).size]
        command = controller.step(k * DT, state.q, state.v, lam)
        other = law.step(k * DT, state.q, state.v, lam)
        assert np.allclose(command.q_ref, other.q_ref, atol=1e-12)
        assert np.allclose(command.tau, Springs(made.robot, None).step(
            0.0, Measurement(state.q, state.v, lam), command).tau)  # fmt: skip
        assert not command.u.any()
    assert controller.controller.switched == 1
    nan = np.full_like(state.q, np.nan)
    assert controller.step(0.06, nan, state.v, lam).mode is Mode.DEGRADED
    kept = controller.state()
    controller.controller.switched = 7
    controller.restore(kept)
    assert controller.controller.switched == 1


def test_wrong_settings_are_refused_in_words(made):
    with pytest.raises(NameNotFoundError, match="foot"):
        WholeBodyController(
            made.robot, made.levels, made.schedule, ControlSettings(made.gains), made.q,
            wanted_forces={"foot": []},
        )  # fmt: skip
    with pytest.raises(InputError, match="1 regulated rows"):
        WholeBodyController(
            made.robot, made.levels, made.schedule, ControlSettings(made.gains), made.q
        )
    with pytest.raises(InputError, match="period"):
        WholeBodyController(
            made.robot, made.levels, made.schedule, ControlSettings(made.gains, period=0.0), made.q
        )


@pytest.mark.parametrize("name", ["hrp2", "talos", "g1", "romeo"])
def test_it_runs_on_every_named_robot(name):
    robot = pytest.importorskip("equipoise.robots").get_robot
    try:
        made = Made(robot(name))
    except InputError as error:
        pytest.skip(str(error))
    fused = follow(made, of_one_call(made.controller()), ticks=60)
    parts = follow(made, of_parts(made, "active_set"), ticks=60)
    for one, other in zip(fused, parts, strict=True):
        assert np.allclose(one, other, rtol=1e-8, atol=1e-8)
