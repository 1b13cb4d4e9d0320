"""From a scenario to everything that runs: setup, levels, starting posture, controller, plant."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass

from equipoise.control import (
    GainAdvice,
    ReactionBounds,
    advise_for_postures,
    advise_gains,
    bear_postures,
)
from equipoise.control.kinds import controller_maker
from equipoise.control.rivals.kinds import RivalKind
from equipoise.errors import AdviceWarning, NameNotFoundError
from equipoise.hqp import make_solver
from equipoise.motion import Governor, solve_posture
from equipoise.physics import PhysicsEngine
from equipoise.robots import Robot
from equipoise.scenarios import schema
from equipoise.scenarios.lookup import at_path
from equipoise.simulation.build.checks import check_contacts, check_waypoints
from equipoise.simulation.build.engines import make_engine
from equipoise.simulation.build.fades import build_fades
from equipoise.simulation.build.forces import wanted_forces
from equipoise.simulation.build.gains import gains_of, to_control_gains
from equipoise.simulation.build.levels import (
    APPROACH_TIME,
    build_levels,
    build_start_levels,
    tell_slowed,
)
from equipoise.simulation.build.reach import (
    Miss,
    Outlook,
    calmed,
    look_ahead,
    missed_waypoints,
    ways_of,
)
from equipoise.simulation.build.rehearse import rehearse
from equipoise.simulation.build.rivals import known_robot, tuned_rival
from equipoise.simulation.build.setup import Setup, build_setup
from equipoise.simulation.build.walk import WalkSetup, build_walk
from equipoise.simulation.plant import Plant
from equipoise.spatial import Array
from equipoise.tasks import FramePoseTask, Task
from equipoise.wbc import ControlSettings, NewController, WholeBodyController


@dataclass(frozen=True, kw_only=True)
class Controls:
    """Everything of one run but the plant.

    `q_start` (nq,) is the starting posture, `advice` what the gain adviser said, `told` what was
    told before the run, `walk` how it walks, if it does, `outlook` what was found of its ways.
    """

    scenario: schema.Scenario
    setup: Setup
    levels: list[list[Task]]
    q_start: Array
    advice: GainAdvice
    controller: WholeBodyController
    told: tuple[str, ...] = ()
    walk: WalkSetup | None = None
    outlook: Outlook

    @property
    def misses(self) -> tuple[Miss, ...]:
        """Which waypoints are out of reach."""
        return self.outlook.misses


@dataclass(frozen=True, kw_only=True)
class Assembly(Controls):
    """Everything of one run, put together."""

    plant: Plant

    @property
    def engine(self) -> PhysicsEngine:
        """The engine of the plant."""
        return self.plant.engine


@dataclass(frozen=True)
class Prepared:
    """What runs that differ in nothing but controller, physics and faults share.

    The robot as it was loaded, the starting posture (nq,) that was found for it, and what was found
    of its ways; None: it has to be found.
    """

    robot: Robot
    q_start: Array
    outlook: Outlook | None = None


def assemble(scenario: schema.Scenario, prepared: Prepared | None = None) -> Assembly:
    """Put a scenario together; finding the starting posture takes a moment unless it is given.

    Raises: `ScenarioError`, `PostureNotFoundError`.
    """
    controls = assemble_controls(scenario, prepared)
    plant, tau = assemble_plant(controls.scenario, controls.setup, controls.q_start)
    if tau is not None:
        controls.controller.take_over(tau)
    return Assembly(**vars(controls), plant=plant)


def assemble_controls(scenario: schema.Scenario, prepared: Prepared | None = None) -> Controls:
    """Put together all but the plant, which may stand elsewhere.

    Raises: `ScenarioError`, `PostureNotFoundError`.
    """
    setup = build_setup(scenario, prepared.robot if prepared is not None else None)
    check_waypoints(scenario, setup)
    walk = build_walk(scenario, setup)
    levels = build_levels(scenario, setup, walk)
    q_start = prepared.q_start if prepared is not None else starting_posture(scenario, setup, walk)
    outlook = prepared.outlook if prepared is not None else None
    if outlook is None:
        outlook = _look_out(scenario, setup, walk, levels, q_start)
    if outlook.calm:
        scenario = calmed(scenario, outlook.calm)
        levels = build_levels(scenario, setup, walk)
    told = tell_slowed(scenario)
    if prepared is None:
        told = (*told, *_tell(rehearse(scenario, setup, q_start)))
    check_contacts(setup, q_start, setup.reference_schedule.at(0.0))
    advice = advise(scenario, setup, q_start, outlook.ahead)
    controller = WholeBodyController(
        setup.robot,
        levels,
        setup.schedule,
        control_settings(scenario, advice),
        q_start,
        wanted_forces=wanted_forces(scenario),
        fades=build_fades(scenario),
        controller=_controller(scenario, setup, advice),
    )
    return Controls(
        scenario=scenario,
        setup=setup,
        levels=levels,
        q_start=q_start,
        advice=advice,
        controller=controller,
        told=told,
        walk=walk,
        outlook=outlook,
    )


def _look_out(
    scenario: schema.Scenario,
    setup: Setup,
    walk: WalkSetup | None,
    levels: list[list[Task]],
    q_start: Array,
) -> Outlook:
    """Find which waypoints are missed, which ways have to be calm, and where those come by."""
    misses = missed_waypoints(scenario, setup, levels, q_start)
    calm, ways = [miss.task for miss in misses], ways_of(scenario, setup)
    if ways and not calm and look_ahead(scenario, setup, levels, q_start).room(setup) < 0.0:
        calm = ways
    if not calm or walk is not None:
        return Outlook(misses, tuple(calm))
    scenario = calmed(scenario, calm)
    ahead = look_ahead(scenario, setup, build_levels(scenario, setup), q_start).postures
    return Outlook(misses, tuple(calm), tuple(ahead))


def assemble_plant(
    scenario: schema.Scenario, setup: Setup, q_start: Array
) -> tuple[Plant, Array | None]:
    """Return the plant at rest at `q_start` (nq,), and the torque (na,) [N m] if it stands by one.

    Raises: `ScenarioError`, `InputError`.
    """
    engine = make_engine(scenario, setup, q_start)
    plant = Plant(scenario, setup.robot, setup.contacts, engine)
    return plant, engine.stand() if scenario.control.start == "standing" else None


def _tell(sentences: tuple[str, ...]) -> tuple[str, ...]:
    """Warn of what had better be otherwise, and return it."""
    for sentence in sentences:
        warnings.warn(sentence, AdviceWarning, stacklevel=4)
    return sentences


def _controller(
    scenario: schema.Scenario, setup: Setup, advice: GainAdvice
) -> NewController | None:
    """Return what makes the controller that the scenario names, None for the shipped law."""
    control = scenario.control
    try:
        make = controller_maker(control.kind)
    except NameNotFoundError as error:
        raise at_path(error, "control.kind") from None
    if make is None:
        return None
    if isinstance(make, RivalKind):
        make = tuned_rival(scenario, make)
    gains, period = to_control_gains(gains_of(scenario), advice), control.period
    known = known_robot(scenario, setup.robot)
    return lambda contacts: make(known, contacts, gains, period)


def starting_posture(
    scenario: schema.Scenario, setup: Setup, walk: WalkSetup | None = None
) -> Array:
    """Return the configuration (nq,) at time 0. Raises: `PostureNotFoundError`.

    Found by our own solver, whichever one then runs: what is compared begins at one place.
    """
    q, t_from = setup.robot.q_half_sitting, -APPROACH_TIME
    for with_avoidance in (False, True):
        levels = build_start_levels(scenario, setup, walk, with_avoidance=with_avoidance)
        must_hold = [t for level in levels for t in level if isinstance(t, FramePoseTask)]
        q = solve_posture(
            setup.robot,
            levels,
            make_solver("active_set"),
            q,
            t_from=t_from,
            must_hold=must_hold if with_avoidance else (),
            tolerance=1e-5 if with_avoidance else 1e-2,
        )
        t_from = 0.0
    return q


def advise(
    scenario: schema.Scenario, setup: Setup, q_start: Array, postures: Sequence[Array] = ()
) -> GainAdvice:
    """Return what the gain adviser says about the nominal robot at `q_start` (nq,).

    Where the run will come to other `postures`, in which that would not be stable, less.
    """
    gains, physics = gains_of(scenario), scenario.physics
    look = advise_for_postures if gains.shape == "postures" else advise_gains
    robot = setup.robot
    if gains.hand_load:
        for palm in robot.palms:
            robot = robot.with_payload(palm.frame, gains.hand_load)
    period = scenario.control.period
    rotors = physics.mujoco.armature if physics.engine == "mujoco" else 0.0
    advice = look(
        robot,
        setup.contacts,
        q_start,
        period,
        alpha=gains.alpha,
        kappa=gains.kappa,
        rotor_inertia=rotors,
    )
    return bear_postures(advice, robot, setup.contacts, postures, period, rotor_inertia=rotors)


def control_settings(scenario: schema.Scenario, advice: GainAdvice) -> ControlSettings:
    """Return how the scenario wants the robot controlled."""
    control = scenario.control
    lifts = scenario.physics.engine == "mujoco" or scenario.walk is not None
    lifts = lifts or any(getattr(task, "calm", None) for task in scenario.tasks.values())
    usual = "bounded" if lifts else "least"
    distribution = control.distribution or usual
    bounds = ReactionBounds(torque_share=control.torque_share)
    return ControlSettings(
        gains=to_control_gains(gains_of(scenario), advice),
        period=control.period,
        bounds=bounds if distribution == "bounded" else None,
        split="zmp" if scenario.walk is not None else "measured",
        filter_time=control.reaction_filter,
        solver=control.solver,
        governor=_governor(control.governor),
    )


def _governor(spec: schema.GovernorSpec | None) -> Governor | None:
    if spec is None:
        return None
    pairs = ((spec.way[0], spec.way[1]), (spec.turn[0], spec.turn[1]))
    return Governor(*pairs, (spec.posture[0], spec.posture[1]), spec.fall, spec.rise)
