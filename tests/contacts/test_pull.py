"""A contact that can only push is never wanted to pull, wherever somebody says so."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from equipoise.contacts import ContactStack, GraspContact, SoleContact, SurfaceContact
from equipoise.contacts.pull import least_wanted
from equipoise.contacts.surfaces import Plane
from equipoise.control import ControlStatus, Measurement, Mode, Reference, Supervisor
from equipoise.errors import InputError, ScenarioError
from equipoise.robots import get_robot
from equipoise.scenarios import read_scenario
from equipoise.simulation.operator import OperatorPort, OperatorRequest
from equipoise.simulation.simulation import Simulation
from equipoise.trajectories import Profile, PushingForce, ScalarTrajectory, Travel
from equipoise.wbc import WholeBodyController

WANTED = {
    ("press", "contacts.press.force"): "{times: [0.0, 0.8], values: [2.0, %g]}",
    ("sphere", "contacts.press.force"): "{times: [0.0], values: [%g]}",
    ("cylinder", "contacts.press.force.values.2"): "%g",
    ("telephone", "contacts.push.force.values.0"): "%g",
    ("tray", "contacts.grasp.regulated"): "{fz: {times: [0.0, 0.3], values: [%g, 3.0]}}",
    ("tray_real", "contacts.grasp.regulated.fz.values.3"): "%g",
}


@pytest.mark.parametrize("wanted", WANTED)
@pytest.mark.parametrize("force", [-1e-6, -0.5, -300.0])
def test_a_file_or_an_override_that_pulls_is_refused(wanted: tuple[str, str], force: float) -> None:
    scenario, path = wanted
    with pytest.raises(ScenarioError, match="can only push") as told:
        read_scenario(scenario, [f"{path}={WANTED[wanted] % force}"])
    assert told.value.path.startswith("contacts.")
    assert f"{-force:g} N" in str(told.value)


@pytest.mark.parametrize("wanted", WANTED)
def test_nothing_and_more_can_be_wanted(wanted: tuple[str, str]) -> None:
    scenario, path = wanted
    for force in (0.0, 12.5):
        read_scenario(scenario, [f"{path}={WANTED[wanted] % force}"])


def test_other_rows_of_a_grasp_have_both_signs() -> None:
    read_scenario("tray", ["contacts.grasp.regulated={mx: {times: [0.0], values: [-1.0]}}"])


def facing(tilt: float) -> GraspContact:
    """Return a grasp whose second palm looks at the first but for a tilt [rad]."""
    T = pin.SE3(pin.rpy.rpyToMatrix(np.pi + tilt, 0.0, 0.0), np.array([0.0, 0.0, 0.4]))
    return GraspContact(name="grasp", frame_a="left_palm", frame_b="right_palm", T_a_b=T)


def test_which_rows_only_push() -> None:
    robot = get_robot("hrp2")
    kin = robot.at(robot.q_half_sitting)
    sole = SoleContact.standing(robot.soles[0], kin)
    assert sole.one_sided == {"fz"}
    plane = SurfaceContact(
        name="wall", regulated=("fn",), frame="left_palm", surface=Plane(),
        T_world_surface=pin.SE3.Identity(),
    )  # fmt: skip
    assert plane.one_sided == {"fn"}
    assert facing(0.0).one_sided == facing(1.0).one_sided == {"fz"}
    assert facing(np.pi).one_sided == facing(1.1).one_sided == frozenset()
    assert replace(facing(np.pi), regulated=("fz",)).one_sided == {"fz"}
    assert least_wanted([replace(facing(0.0), regulated=("fx", "fz"))]) == {
        "grasp/fx": -np.inf, "grasp/fz": 0.0,
    }  # fmt: skip


def test_the_least_of_a_pushing_force_is_never_undercut() -> None:
    profile = Profile.of([0.0, 1.0, 2.0], [3.0, 1.0, 4.0])
    t = np.linspace(-1.0, 4.0, 2000)
    for distance in (0.2, -0.2):
        force = PushingForce(profile, 60.0, Travel(0.5, 1.5, distance))
        values = np.array([force.at(x) for x in t])
        assert force.least <= values.min() + 1e-12
        assert PushingForce(profile, 0.0, Travel(0.5, 1.5, distance)).least == profile.least == 1.0


class Sinking(ScalarTrajectory):
    """A force of one's own that becomes a pull after 5 ms."""

    def at(self, t: float) -> float:
        return 5.0 - 1000.0 * t


@pytest.fixture(scope="module")
def made() -> Simulation:
    return Simulation(read_scenario("press", ["duration=0.1"]))


Wanted = Callable[[float], float] | ScalarTrajectory


def controller(made: Simulation, force: Wanted) -> WholeBodyController:
    assembly = made.assembly
    return WholeBodyController(
        assembly.setup.robot, assembly.levels, assembly.setup.schedule,
        assembly.controller.settings, assembly.q_start, wanted_forces={"press": [force]},
    )  # fmt: skip


@pytest.mark.parametrize(
    "force",
    [
        Profile.of([0.0, 1.0], [5.0, -1.0]),
        PushingForce(Profile.of([0.0], [1.0]), 60.0, Travel(0.0, 1.0, -0.5)),
        lambda t: -3.0,
    ],
    ids=["profile", "pushing", "function"],
)
def test_a_controller_refuses_a_force_that_pulls(made: Simulation, force: Wanted) -> None:
    with pytest.raises(InputError, match="press/fn can only push"):
        controller(made, force)


def test_a_force_of_ones_own_that_becomes_a_pull_gets_nothing_and_is_told(made: Simulation) -> None:
    whole = controller(made, Sinking())
    state = made.engine.state
    lam = made.plant.multipliers(made.plant.read(state), made.setup.schedule.at(0.0))
    wanted = []
    for k in range(12):
        whole.step(0.001 * k, state.q, state.v, lam)
        wanted.append(float(whole.wanted[0]))
        assert whole.workspace.parts["law"].lam_ref[0] == wanted[-1]
    assert wanted[:5] == pytest.approx([5.0, 4.0, 3.0, 2.0, 1.0])
    assert wanted[6:] == [0.0] * 6
    assert [line for line in whole.story if "press/fn was wanted to pull" in line]


class Nobody:
    """Looks at the run and does nothing."""

    paused_s = 0.0

    def before_tick(self, t: float) -> OperatorRequest | None:
        return self.request if t >= 0.005 else None

    def after_tick(self, t: float, values: object) -> None:
        pass

    def __init__(self, request: OperatorRequest) -> None:
        self.request = request


def test_the_live_page_cannot_make_a_contact_pull() -> None:
    """The press begins with 2 N: taking 1.5 N away is done, taking 30 N away is refused."""
    for added, refused in ((-1.5, False), (-30.0, True)):
        run = Simulation(read_scenario("press", ["duration=0.02"]))
        run.operate(Nobody(OperatorRequest(forces={"press/fn": added})))
        assert isinstance(run.operator_port, OperatorPort)
        wanted = [float(record["lam_ref/press"][0]) for _, record in run.ticks()]
        told = [line for line in run.story if "press/fn" in line]
        assert any("refused: press/fn can only push" in line for line in told) is refused
        assert min(wanted) >= 0.0
        assert (wanted[-1] > 1.9) is refused


def test_the_law_alone_refuses_a_pull_and_its_supervisor_wants_none(made: Simulation) -> None:
    law, state = controller(made, lambda t: 2.0).law, made.engine.state
    assert law is not None
    lam = made.plant.multipliers(made.plant.read(state), made.setup.schedule.at(0.0))
    measured = Measurement(state.q, state.v, lam)
    pulling = Reference(state.q, state.v, np.array([-3.0]))
    with pytest.raises(InputError, match="press/fn can only push"):
        law.step(0.0, measured, pulling)
    supervisor = Supervisor(law)
    command = supervisor.step(0.0, measured, pulling)
    assert command.status is not ControlStatus.HELD
    assert supervisor.mode is Mode.RUN


def test_a_stack_without_regulated_rows_wants_nothing() -> None:
    robot = get_robot("hrp2")
    kin = robot.at(robot.q_half_sitting)
    stack = ContactStack([SoleContact.standing(sole, kin) for sole in robot.soles])
    assert least_wanted(stack.contacts) == {}
