"""A robot leans into what it presses, and a force waits until the soles bear it."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from equipoise import LoopSettings, RigidContactEngine, WholeBodyController, get_robot
from equipoise.contacts import ContactStack, SupportPolygon, SurfaceContact
from equipoise.control import Command, ControlStatus, Measurement, Reference
from equipoise.motion.levels import feet_of, polygon_of
from equipoise.robots import Robot
from equipoise.spatial import pose
from equipoise.tasks import ComPolygonTask, FloorSupportTask, JointLimitsTask
from equipoise.trajectories import LiveScalar, Profile
from fixed_arm import small_arm
from helpers import kinematics

MARGIN = 0.03  # [m]
G = 9.81


def start_of(robot: Robot, yaw: float) -> np.ndarray:
    """Return half-sitting, turned about the vertical and 0.3 m aside."""
    q = robot.q_half_sitting.copy()
    q[:7] = pin.SE3ToXYZQUAT(pose((0.3, 0.0, 0.0), (0.0, 0.0, yaw)) * pin.XYZQUATToSE3(q[:7]))
    return q


def pressing(
    robot: Robot, dt: float, force: float | Profile, yaw: float = 0.0, **more: object
) -> WholeBodyController:
    """Return a controller whose right palm presses forward, and a bit down."""
    q = start_of(robot, yaw)
    normal = pose((0.0, 0.0, 0.0), (0.0, 0.0, yaw)).rotation @ np.array([-1.0, 0.2, 0.3])
    wall = SurfaceContact.on_plane("wall", "right_palm", kinematics(robot, q), normal)
    loop = LoopSettings(period=dt, margin=MARGIN)
    return WholeBodyController.standing(
        robot, q, contacts=[wall], forces={"wall": force}, loop=loop, **more
    )


def zero_moment_point(robot: Robot, controller: WholeBodyController, q: np.ndarray) -> np.ndarray:
    """Return where the soles' force acts at rest (2,): moments of weight and palm, by hand."""
    kin = kinematics(robot, q)
    wall = controller.contacts["wall"]
    F = controller.asked[0] * (wall.T_world_surface.rotation @ np.array([0.0, 0.0, 1.0]))
    at = kin.placement("right_palm").translation
    weight = np.array([0.0, 0.0, -robot.mass * G])
    force = F + weight
    moment = np.cross(at, F) + np.cross(kin.p_world_com, weight)
    return np.array([-moment[1], moment[0]]) / force[2]


def follow_exactly(controller: WholeBodyController, seconds: float, each) -> None:
    """Run on a robot that is where its reference is."""
    robot, q = controller.robot, controller.motion.q_ref
    v, lam = np.zeros(robot.nv), np.zeros(controller.contacts.size)
    rows = controller.contacts.rows["wall"]
    for k in range(round(seconds / controller.dt)):
        command = controller.step(k * controller.dt, q, v, lam)
        q, v = command.q_ref, command.v_ref
        lam[rows] = controller.asked
        each(k * controller.dt, command)


@pytest.mark.parametrize(
    ("name", "force", "dt", "yaw"),
    [("hrp2", 200.0, 0.005, 2.0), ("g1", 85.0, 0.005, 0.0), ("g1", 85.0, 0.002, -0.7)],
)
def test_the_soles_bear_it_on_the_whole_way(name, force, dt, yaw):
    """On the way there, there, and on the way back; without leaning they would not."""
    robot = get_robot(name)
    controller, q = pressing(robot, dt, force, yaw), start_of(robot, yaw)
    polygon = polygon_of(feet_of(robot, q, None, 0.7))
    start = robot.at(q).p_world_com[:2].copy()
    room, asked, waited = [], [], []

    def each(t, command):
        if abs(t - 8.0) < dt / 2:
            controller.want("wall", 0.0)
        if round(t / dt) % 10 == 0:
            room.append(polygon.margin(zero_moment_point(robot, controller, command.q_ref)))
        asked.append(controller.asked[0])
        waited.append(abs(controller.asked[0] - controller.wanted[0]))

    follow_exactly(controller, 15.0, each)
    asked, at = np.array(asked), lambda t: round(t / dt)
    assert min(room) > 0.85 * MARGIN
    assert asked[at(7.9)] == pytest.approx(force, rel=1e-3)
    assert max(waited[: at(8.0)]) > 0.1 * force
    assert max(waited[at(8.0) :]) > 1.0
    assert abs(asked[-1]) < 0.01 * force
    # statics: with the centre of mass where it was, the full force would tip the robot over
    height = robot.at(q).placement("right_palm").translation[2]
    behind = force * height / (robot.mass * G) * np.array([np.cos(yaw), np.sin(yaw)])
    assert polygon.margin(start - behind) < 0.0
    assert np.abs(np.diff(asked)).max() < 2.0 * force / 0.5 * dt


def test_what_is_borne_is_asked_at_once(hrp2):
    controller = pressing(hrp2, 0.002, 10.0)
    follow_exactly(controller, 1.0, lambda t, command: None)
    assert controller.asked[0] == controller.wanted[0] == 10.0
    assert np.abs(controller.motion.q_ref - start_of(hrp2, 0.0)).max() < 1e-3


def test_more_than_can_be_borne_is_never_asked():
    """A wall that is pressed with the robot's weight: it leans as far as it gets, and stands."""
    g1 = get_robot("g1")
    controller = pressing(g1, 0.01, g1.mass * G)
    polygon = polygon_of(feet_of(g1, start_of(g1, 0.0), None, 0.7))
    room = []
    follow_exactly(
        controller,
        6.0,
        lambda t, command: room.append(
            polygon.margin(zero_moment_point(g1, controller, command.q_ref))
        ),
    )
    assert controller.asked[0] < controller.wanted[0]
    assert min(room) > 0.5 * MARGIN


def test_a_reference_in_the_rigid_engine_and_a_memory(hrp2):
    """Two that go on from one state, while a force waits, give the same bits."""
    controller = pressing(hrp2, 0.002, 90.0)
    engine = RigidContactEngine(hrp2, controller.contacts, start_of(hrp2, 0.0), controller.dt)
    state, torques = engine.state, []
    for k in range(600):
        if k == 400:
            memory, begin = controller.state(), engine.state
        command = controller.step(k * controller.dt, state.q, state.v, state.lam)
        state = engine.step(command.tau)
        if k >= 400:
            torques.append((command.tau.copy(), state))
    assert controller.asked[0] < controller.wanted[0]
    rows = controller.contacts.rows["wall"]
    assert state.lam[rows][0] == pytest.approx(controller.asked[0], rel=0.05)
    controller.restore(memory)
    states = [begin, *(state for _, state in torques)]
    for k in range(400, 600):
        now = states[k - 400]
        tau = controller.step(k * controller.dt, now.q, now.v, now.lam).tau
        np.testing.assert_array_equal(tau, torques[k - 400][0])


def test_floor_support_knows_what_is_pressed(hrp2):
    """Where it does not, it calls the centre of mass back from where the palm holds it."""
    polygon = polygon_of(feet_of(hrp2, start_of(hrp2, 0.0), None, 0.7))
    fastest = {}
    for leans in (True, False):
        limits = JointLimitsTask("limits", hrp2)
        support = FloorSupportTask("support", hrp2, polygon, 0.01, leans=leans)
        balance = ComPolygonTask("balance", polygon, margin=MARGIN, leans=True)
        controller = pressing(hrp2, 0.01, 200.0, tasks=[[limits, support], balance])
        speeds = []
        follow_exactly(controller, 7.0, lambda t, c, s=speeds: s.append(abs(c.v_ref).max()))
        fastest[leans] = max(speeds)
        assert controller.asked[0] == pytest.approx(200.0)
    assert fastest[True] < 0.3 < 1.0 < fastest[False]


@pytest.mark.parametrize("force", [40.0, 200.0])
def test_a_force_that_is_wanted_from_the_beginning_waits_too(hrp2, force):
    """At the first tick it is what the soles bear without a lean, all of it or a part."""
    controller = pressing(hrp2, 0.01, Profile.of([0.0], [force]))
    polygon = polygon_of(feet_of(hrp2, start_of(hrp2, 0.0), None, 0.7))
    first, room = [], []

    def each(t, command):
        first.append(controller.asked[0])
        room.append(polygon.margin(zero_moment_point(hrp2, controller, command.q_ref)))

    follow_exactly(controller, 0.3, each)
    assert min(room) > 0.85 * MARGIN
    if force < 50.0:
        assert first[0] == force
    else:
        assert 0.2 * force < first[0] < 0.5 * force


def test_a_robot_that_cannot_tip_over_does_not_lean():
    """A bolted one has no columns of a base: a polygon that leans is one that does not."""
    arm = small_arm()
    polygon = SupportPolygon.of_points(np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]))
    kin = kinematics(arm, arm.q_half_sitting)
    tip = arm.frame_names[-1]
    wall = SurfaceContact.on_plane("wall", tip, kin, (-1.0, 0.0, 0.0))
    balance = ComPolygonTask("balance", polygon, leans=True)
    controller = WholeBodyController.fixed(
        arm, tasks=[balance], contacts=[wall], forces={"wall": Profile.of([0.0], [5.0])}
    )
    assert not controller.motion.program.leans
    controller.step(0.0, arm.q_half_sitting, np.zeros(arm.nv), np.zeros(controller.contacts.size))
    assert controller.asked[0] == 5.0


class Listener:
    """A controller of somebody else that does nothing but note which forces it is told."""

    def __init__(self, robot: Robot, stack: ContactStack, dt: float) -> None:
        self.robot, self.contacts, self.dt = robot, stack, dt
        self.told: list[float] = []

    def step(self, t: float, measured: Measurement, reference: Reference) -> Command:
        self.told.append(float(reference.lam_ref[0]))
        return Command(np.zeros(self.robot.na), ControlStatus.RUN)

    def reset(self) -> None: ...

    def switch(self, contacts: ContactStack) -> None: ...

    def take_over(self, tau: np.ndarray) -> None: ...

    def state(self) -> dict[str, object]:
        return {}

    def restore(self, state: dict[str, object]) -> None: ...


def test_a_controller_of_somebody_else_is_told_the_same(hrp2):
    """What is borne comes from the reference, not from the law."""
    law = pressing(hrp2, 0.01, 120.0)
    forces = {"wall": [LiveScalar(120.0, start=0.0)]}
    other = WholeBodyController(
        hrp2, law.motion.levels, law.contacts, law.settings, start_of(hrp2, 0.0),
        wanted_forces=forces, controller=lambda stack: Listener(hrp2, stack, 0.01),
    )  # fmt: skip
    told = []
    follow_exactly(law, 3.0, lambda t, command: told.append(law.asked[0]))
    follow_exactly(other, 3.0, lambda t, command: None)
    assert 0.3 * 120.0 < told[60] < 0.7 * 120.0
    np.testing.assert_allclose(other.controller.told, told, atol=1e-9)
