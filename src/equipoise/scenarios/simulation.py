"""A scenario made ready to run: motion generator, controller and engine wired, tick by tick."""

from __future__ import annotations

from collections.abc import Iterator
from time import perf_counter_ns

import numpy as np

from equipoise.contacts import ContactStack
from equipoise.control import (
    Command,
    ControlGains,
    GainAdvice,
    Measurement,
    PassivityController,
    SignFunction,
    Target,
    advise_gains,
)
from equipoise.hqp import make_solver
from equipoise.kinematics import Kinematics, KinematicsEvaluator
from equipoise.motion import MotionGenerator, MotionStep, solve_posture
from equipoise.physics import PhysicsState, RigidContactEngine
from equipoise.runlog import Channel
from equipoise.scenarios import schema
from equipoise.scenarios.forces import wanted_forces
from equipoise.scenarios.levels import APPROACH_TIME, build_levels, build_start_levels
from equipoise.scenarios.places import build_places
from equipoise.scenarios.record import Recorder
from equipoise.scenarios.sanity import check_contacts, check_waypoints
from equipoise.scenarios.steering import Helm, Steering
from equipoise.scenarios.truth import true_robot, true_sliders
from equipoise.spatial import Array
from equipoise.tasks import FramePoseTask


class Simulation:
    """Everything of one run; `ticks` runs it and yields what is logged.

    Building it finds the starting posture, so it takes a moment.
    Raises: `ScenarioError`, `PostureNotFoundError`.
    """

    def __init__(self, scenario: schema.Scenario) -> None:
        self.scenario = scenario
        self.places = build_places(scenario)
        self.robot = self.places.robot
        check_waypoints(scenario, self.places)
        self.levels = build_levels(scenario, self.places)
        self.q_start = self._starting_posture()
        check_contacts(self.places, self.q_start, self.places.reference_schedule.at(0.0))
        self.advice = self._advice()
        self.wanted_forces = wanted_forces(scenario, self.places)
        self.dt = scenario.control.period
        self.steps = round(scenario.duration / self.dt)
        self.motion = MotionGenerator(
            self.robot, self.levels, make_solver(scenario.control.solver), self.dt, self.q_start
        )
        self.controller = PassivityController(
            self.robot,
            self.places.schedule.at(0.0),
            _gains(scenario.control.gains, self.advice),
            self.dt,
        )
        self.engine = self._engine()
        if scenario.control.start == "standing":
            self.controller.take_over(self.engine.stand())
        self.tick_ns = np.zeros((self.steps, 2), dtype=np.int64)
        self.helm: Helm | None = None
        self._rows: dict[ContactStack, Array] = {}
        self.recorder = Recorder(
            scenario, self.places, self.levels, self.wanted_forces, self.engine.sliders
        )

    def _starting_posture(self) -> Array:
        solver = make_solver(self.scenario.control.solver)
        q, t_from = self.robot.q_half_sitting, -APPROACH_TIME
        for with_avoidance in (False, True):
            levels = build_start_levels(self.scenario, self.places, with_avoidance=with_avoidance)
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
        gains = self.scenario.control.gains
        return advise_gains(
            self.robot,
            self.places.contacts,
            self.q_start,
            self.scenario.control.period,
            alpha=gains.alpha,
            kappa=gains.kappa,
        )

    def _engine(self) -> RigidContactEngine:
        physics = self.scenario.physics
        return RigidContactEngine(
            true_robot(self.scenario, self.places),
            self.places.contacts,
            self.q_start,
            self.dt,
            substeps=physics.substeps,
            position_gain=physics.position_gain,
            velocity_gain=physics.velocity_gain,
            joint_damping=physics.joint_damping,
            sliders=true_sliders(self.scenario),
        )

    @property
    def channels(self) -> list[Channel]:
        """What every tick logs."""
        return self.recorder.channels + (self.helm.channels if self.helm is not None else [])

    def steer(self, steering: Steering) -> None:
        """Let someone change pushes, gains and wanted forces while it runs."""
        self.helm = Helm(self, steering)

    def ticks(self) -> Iterator[tuple[float, dict[str, Array]]]:
        """Run; yield time and logged values of each tick. `lam` acts during the tick.

        Raises: `DivergedError`, `StopRequested`.
        """
        state = self.engine.state
        for k in range(self.steps):
            t = k * self.dt
            if self.helm is not None:
                self.helm.before_tick(t, state)
            began = perf_counter_ns()
            motion = self.motion.step(t)
            command = self._control(t, state, motion)
            controlled = perf_counter_ns()
            after = self.engine.step(command.tau)
            self.tick_ns[k] = controlled - began, perf_counter_ns() - controlled
            values = self.recorder.values(t, state, motion, command, after)
            if self.helm is not None:
                self.helm.after_tick(t, values)
            yield t, values
            state = after

    def _control(self, t: float, state: PhysicsState, motion: MotionStep) -> Command:
        contacts = self.places.schedule.at(t)
        if contacts is not self.controller.contacts:
            self.controller.switch(contacts)
        measured = Measurement(state.q, state.v, state.lam[self._rows_in_whole(contacts)])
        return self.controller.step(
            t, measured, Target(motion.q_ref, motion.v_ref, self._lam_ref(t, contacts))
        )

    def _rows_in_whole(self, contacts: ContactStack) -> Array:
        """Return where the rows of a stack are among those of all contacts (r,)."""
        rows = self._rows.get(contacts)
        if rows is None:
            whole = self.places.contacts.rows
            parts = [np.r_[whole[contact.name]] for contact in contacts.contacts]
            rows = self._rows[contacts] = np.concatenate([np.zeros(0, dtype=int), *parts])
        return rows

    def _lam_ref(self, t: float, contacts: ContactStack) -> Array:
        return np.array(
            [wanted(t) for name in contacts.rows for wanted in self.wanted_forces[name]]
        )

    def kinematics(self, q: Array) -> Kinematics:
        """Return the kinematics of the nominal robot at `q` (nq,), at rest."""
        return KinematicsEvaluator(self.robot).at(q, np.zeros(self.robot.nv))


def _gains(spec: schema.GainsSpec, advice: GainAdvice) -> ControlGains:
    values = spec.model_dump(exclude={"kappa", "sgn_p", "sgn_F"})
    return ControlGains(
        K_d=advice.K_d,
        sgn_p=SignFunction(spec.sgn_p.kind, spec.sgn_p.layer),
        sgn_F=SignFunction(spec.sgn_F.kind, spec.sgn_F.layer),
        **values,
    )
