"""A scenario made ready to run: motion generator, controller and engine wired, tick by tick."""

from __future__ import annotations

from collections.abc import Iterator
from time import perf_counter_ns

import numpy as np

from equipoise.compiled.compilation import announce
from equipoise.contacts import ContactStack
from equipoise.control import (
    Command,
    GainAdvice,
    PassivityController,
    ReactionBounds,
    Target,
    advise_gains,
)
from equipoise.hqp import make_solver
from equipoise.kinematics import Kinematics, KinematicsEvaluator
from equipoise.motion import MotionStep, solve_posture
from equipoise.physics import PhysicsState
from equipoise.runlog import Channel
from equipoise.scenarios import schema
from equipoise.simulation.build.checks import check_contacts, check_waypoints
from equipoise.simulation.build.engines import make_engine
from equipoise.simulation.build.fades import make_generator
from equipoise.simulation.build.forces import wanted_forces
from equipoise.simulation.build.gains import gains_of, to_control_gains
from equipoise.simulation.build.levels import APPROACH_TIME, build_levels, build_start_levels
from equipoise.simulation.build.setup import build_setup
from equipoise.simulation.object_log import ObjectLog
from equipoise.simulation.operator import Operator, OperatorPort
from equipoise.simulation.recorder import Recorder
from equipoise.simulation.robot_interface import SimulatedRobot
from equipoise.spatial import Array
from equipoise.tasks import FramePoseTask


class Simulation:
    """Everything of one run; `ticks` runs it and yields what is logged.

    Building it finds the starting posture, so it takes a moment.
    Raises: `ScenarioError`, `PostureNotFoundError`.
    """

    def __init__(self, scenario: schema.Scenario) -> None:
        announce()
        self.scenario = scenario
        self.setup = build_setup(scenario)
        self.robot = self.setup.robot
        check_waypoints(scenario, self.setup)
        self.levels = build_levels(scenario, self.setup)
        self.q_start = self._starting_posture()
        check_contacts(self.setup, self.q_start, self.setup.reference_schedule.at(0.0))
        self.gains = gains_of(scenario)
        self.advice = self._advice()
        self.wanted_forces = wanted_forces(scenario, self.setup)
        self.dt = scenario.control.period
        self.steps = round(scenario.duration / self.dt)
        self.motion = make_generator(scenario, self.setup, self.levels, self.q_start)
        self.controller = PassivityController(
            self.robot,
            self.setup.schedule.at(0.0),
            to_control_gains(self.gains, self.advice),
            self.dt,
            bounds=ReactionBounds() if scenario.control.distribution == "bounded" else None,
        )
        self.engine = make_engine(scenario, self.setup, self.q_start)
        self.robot_interface = SimulatedRobot(
            scenario, self.robot, self.setup.contacts, self.controller
        )
        self.objects = ObjectLog(self.engine)
        if scenario.control.start == "standing":
            self.controller.take_over(self.engine.stand())
        self.tick_ns = np.zeros((self.steps, 2), dtype=np.int64)
        self.operator_port: OperatorPort | None = None
        self.recorder = Recorder(
            scenario, self.setup, self.levels, self.wanted_forces, self.engine.sliders
        )

    def _starting_posture(self) -> Array:
        solver = make_solver(self.scenario.control.solver)
        q, t_from = self.robot.q_half_sitting, -APPROACH_TIME
        for with_avoidance in (False, True):
            levels = build_start_levels(self.scenario, self.setup, with_avoidance=with_avoidance)
            must_hold = [t for level in levels for t in level if isinstance(t, FramePoseTask)]
            q = solve_posture(
                self.robot,
                levels,
                solver,
                q,
                t_from=t_from,
                must_hold=must_hold if with_avoidance else (),
                tolerance=1e-5 if with_avoidance else 1e-2,
            )
            t_from = 0.0
        return q

    def _advice(self) -> GainAdvice:
        gains, physics = self.gains, self.scenario.physics
        return advise_gains(
            self.robot,
            self.setup.contacts,
            self.q_start,
            self.scenario.control.period,
            alpha=gains.alpha,
            kappa=gains.kappa,
            rotor_inertia=physics.mujoco.armature if physics.engine == "mujoco" else 0.0,
        )

    @property
    def channels(self) -> list[Channel]:
        """What every tick logs."""
        steered = self.operator_port.channels if self.operator_port is not None else []
        return (
            self.recorder.channels + self.robot_interface.channels + self.objects.channels + steered
        )

    @property
    def story(self) -> tuple[str, ...]:
        """What a person changed and what the supervisor did, in sentences."""
        changes = self.operator_port.changes if self.operator_port is not None else []
        return (*changes, *self.robot_interface.story)

    def steer(self, operator: Operator) -> None:
        """Let someone change pushes, gains and wanted forces while it runs."""
        self.operator_port = OperatorPort(self, operator)

    def ticks(self) -> Iterator[tuple[float, dict[str, Array]]]:
        """Run; yield time and logged values of each tick. `lam` acts during the tick.

        Raises: `DivergedError`, `StopRequested`.
        """
        state = self.engine.state
        for k in range(self.steps):
            t = k * self.dt
            if self.operator_port is not None:
                self.operator_port.before_tick(t, state)
            began = perf_counter_ns()
            motion = self.motion.step(t)
            command = self._control(t, state, motion)
            controlled = perf_counter_ns()
            after = self._advance(t, state, command)
            self.tick_ns[k] = controlled - began, perf_counter_ns() - controlled
            values = (
                self.recorder.values(t, state, motion, command, after)
                | self.robot_interface.values()
            )
            values |= self.objects.values()
            if self.operator_port is not None:
                self.operator_port.after_tick(t, values)
            yield t, values
            state = after

    def _control(self, t: float, state: PhysicsState, motion: MotionStep) -> Command:
        contacts = self.setup.schedule.at(t)
        if contacts is not self.controller.contacts:
            self.controller.switch(contacts)
        target = Target(motion.q_ref, motion.v_ref, self._lam_ref(t, contacts))
        return self.robot_interface.control(t, state, target)

    def _advance(self, t: float, state: PhysicsState, command: Command) -> PhysicsState:
        wished = self.operator_port.push(state) if self.operator_port is not None else 0.0
        self.engine.external = wished + self.robot_interface.faults.external(t, state.q, state.v)
        return self.engine.step(self.robot_interface.applied(command))

    def _lam_ref(self, t: float, contacts: ContactStack) -> Array:
        return np.array(
            [wanted(t) for name in contacts.rows for wanted in self.wanted_forces[name]]
        )

    def kinematics(self, q: Array) -> Kinematics:
        """Return the kinematics of the nominal robot at `q` (nq,), at rest."""
        return KinematicsEvaluator(self.robot).at(q, np.zeros(self.robot.nv))
