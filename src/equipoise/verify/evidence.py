"""What checks share: robot, contacts, states and recorded runs, each made once when first asked."""

from __future__ import annotations

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from equipoise.contacts import Contact, ContactStack, PointContact, SurfaceContact
from equipoise.contacts.moving import MotionSample, MovingSurfaceContact, SurfaceMotion
from equipoise.contacts.surfaces import Cylinder, Ellipsoid, Plane, Sphere, Surface, Torus
from equipoise.control import Projector, SignFunction
from equipoise.hqp import Solution, make_solver
from equipoise.hqp.hierarchy import Hierarchy
from equipoise.kinematics import Kinematics, KinematicsEvaluator
from equipoise.motion import MotionGenerator
from equipoise.robots import Robot, get_robot
from equipoise.spatial import Array
from equipoise.verify.short_runs import (
    Plan,
    RecordedRun,
    moving_reference,
    record,
    standing_contacts,
    still_reference,
)

SURFACES: tuple[Surface, ...] = (
    Plane(),
    Sphere(0.2),
    Cylinder(0.15),
    Ellipsoid((0.1, 0.2, 0.35)),
    Torus(0.3, 0.08),
)
STEPS = (2e-3, 1e-3, 5e-4)  # [s] of the runs along which identities are checked
RUN_TIME = 0.5  # [s]
KAPPA = 150.0  # [1/s] where K_d = kappa M is the same at every step
BLOW = 0.3  # [rad/s] that a joint of each arm is struck by
KICK_KAPPA = 300.0  # [1/s] there: the region that gravity opens shrinks with it
DAMPING = 1.0  # [N m s/rad] at the joints, so that D is not zero


class Tumbling(SurfaceMotion):
    """A surface that flies on a parabola and turns at a constant rate."""

    def __init__(self, T_world_start: pin.SE3) -> None:
        self.start = T_world_start
        self.omega = np.array([0.4, -0.3, 0.7])
        self.velocity = np.array([0.1, -0.2, 0.15])
        self.acceleration = np.array([0.3, 0.1, -0.4])

    def at(self, t: float) -> MotionSample:
        """Return the motion at time `t` [s]."""
        p_world = self.start.translation + self.velocity * t + 0.5 * self.acceleration * t * t
        T = pin.SE3(pin.exp3(self.omega * t) @ self.start.rotation, p_world)
        return MotionSample(
            T,
            np.concatenate((self.velocity + self.acceleration * t, self.omega)),
            np.concatenate((self.acceleration, np.zeros(3))),
        )


class TrayStep(NamedTuple):
    """A step of the tray's motion, and what its contacts want: `J_phi v = contact_speed`."""

    hierarchy: Hierarchy
    solution: Solution
    J_phi: Array
    contact_speed: Array


class Evidence:
    """Robot, contacts and runs under a projector of the law; `seed` fixes every random state."""

    def __init__(self, seed: int = 0, projector: Projector = "euclidean") -> None:
        self.seed, self.projector = seed, projector
        self._runs: dict[float, RecordedRun] = {}

    @cached_property
    def in_metric(self) -> Evidence:
        """The same under the projector that is orthogonal in K_d."""
        return Evidence(self.seed, "damping")

    @cached_property
    def robot(self) -> Robot:
        """The shipped HRP-2."""
        return get_robot("hrp2")

    @cached_property
    def states(self) -> list[tuple[Array, Array]]:
        """Random configurations (nq,) near half-sitting and velocities (nv,)."""
        generator, robot = np.random.default_rng(self.seed), self.robot
        return [
            (
                pin.integrate(
                    robot.model, robot.q_half_sitting, 0.2 * generator.normal(size=robot.nv)
                ),
                0.5 * generator.normal(size=robot.nv),
            )
            for _ in range(3)
        ]

    def generator(self) -> np.random.Generator:
        """Return a fresh generator of the seed."""
        return np.random.default_rng(self.seed + 1)

    def at(self, q: Array, v: Array, t: float = 0.0) -> Kinematics:
        """Return the kinematics of a state, from an evaluator of its own."""
        return KinematicsEvaluator(self.robot).at(q, v, t)

    def contact_kinds(self, q: Array) -> list[Contact]:
        """Return one contact of every kind and surface, touching at `q` (nq,)."""
        palm, offset = self.robot.palms[0].frame, (0.03, -0.02, 0.05)
        T_palm = self.robot.at(q).placement(palm)
        p_world = T_palm.act(np.array(offset))
        common: dict[str, Any] = {"frame": palm, "offset": offset}
        kinds: list[Contact] = [PointContact(name="point", p_world=p_world, **common)]
        for surface in SURFACES:
            R = pin.rpy.rpyToMatrix(0.3, -0.5, 1.1)
            foot = surface.project(np.array([0.07, 0.12, 0.09]))
            T = pin.SE3(R, p_world - R @ foot)
            kinds.append(
                SurfaceContact(name=surface.name, surface=surface, T_world_surface=T, **common)
            )
            kinds.append(
                MovingSurfaceContact(
                    name=f"moving {surface.name}", surface=surface, motion=Tumbling(T), **common
                )
            )
        return [*self._standing_at(q), *kinds]

    def _standing_at(self, q: Array) -> list[Contact]:
        return list(standing_contacts(self.robot, grasp=True, q=q).contacts)

    @cached_property
    def contacts(self) -> ContactStack:
        """Both soles, and the palms on an object between them with a regulated squeeze."""
        return standing_contacts(self.robot, grasp=True)

    @cached_property
    def soles(self) -> ContactStack:
        """Both soles alone."""
        return standing_contacts(self.robot, grasp=False)

    def moving_run(self, dt: float) -> RecordedRun:
        """Return the run in which both hands carry an object up and forward, squeezing it."""
        if dt not in self._runs:
            self._runs[dt] = record(
                self.robot,
                self.contacts,
                moving_reference(self.robot, self.contacts, dt, RUN_TIME),
                Plan(
                    dt=dt,
                    duration=RUN_TIME,
                    gains={
                        "projector": self.projector,
                        "k_ip": 20.0,
                        "sgn_p": SignFunction("saturation", 0.1),
                        "sgn_F": SignFunction("saturation", 0.5),
                    },
                    kappa=KAPPA,
                    joint_damping=DAMPING,
                ),
            )
        return self._runs[dt]

    @cached_property
    def _kicked(self) -> RecordedRun:
        robot, dt = self.robot, 5e-4
        at_rest = self.soles.at(self.at(robot.q_half_sitting, np.zeros(robot.nv)))
        blow = np.zeros(robot.nv)
        blow[robot.nv_base + robot.joint_index("LARM_JOINT3")] = BLOW
        blow[robot.nv_base + robot.joint_index("RARM_JOINT1")] = -BLOW
        begin = round(0.4 / dt)
        return record(
            robot,
            self.soles,
            still_reference(robot),
            Plan(
                dt=dt,
                duration=0.5,
                gains={
                    "projector": self.projector,
                    "k_ip": 50.0,
                    "sgn_p": SignFunction("saturation", 0.1),
                },
                kappa=KICK_KAPPA,
                kicks={begin: at_rest.project(blow)},
                keep_from=begin,
            ),
        )

    def kicked_run(self) -> RecordedRun:
        """Return a run at rest, from a blow on that throws both arms off the sliding mode."""
        return self._kicked

    def spread_samples(self, dt: float, count: int) -> list[int]:
        """Return `count` ticks spread over the moving run."""
        samples = self.moving_run(dt).samples
        return [int(i) for i in np.linspace(0, len(samples) - 1, count)]

    @cached_property
    def tray(self) -> list[TrayStep]:
        """Return the tray scenario's hierarchies, solved along its motion in steps of 20 ms."""
        from equipoise.scenarios import read_scenario
        from equipoise.simulation.simulation import Simulation

        simulation = Simulation(read_scenario("tray"))
        dt, rate = 0.02, simulation.scenario.control.contact_rate
        contacts = simulation.setup.contacts
        motion = MotionGenerator(
            simulation.robot,
            simulation.levels,
            make_solver("active_set"),
            dt,
            simulation.assembly.q_start,
        )
        steps = []
        for k in range(round(simulation.scenario.duration / dt)):
            step = motion.step(k * dt)
            wanted = contacts.rate(step.kin) - rate * contacts.residual(step.kin)
            J = contacts.jacobian(step.kin)
            steps.append(TrayStep(step.hierarchy, step.solution, J, wanted))
        return steps
