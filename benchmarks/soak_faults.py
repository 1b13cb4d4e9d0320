"""A million ticks of sensors, faults and the whole controller on states that swing at random.

`python benchmarks/soak_faults.py 1e6 [seed]`: counts exceptions, torques that are not finite and
torques over a limit. Every 2,000 ticks robot motion, sensor errors, silences, delays, missed ticks
and weak motors are drawn anew. It is not closed over an engine, so that the states are wilder than
any that a run would survive.
"""

from __future__ import annotations

import sys
from collections import Counter
from time import perf_counter

import numpy as np
import pinocchio as pin

from equipoise.contacts import ContactStack, GraspContact, SoleContact
from equipoise.control import ControlGains, ReactionBounds, SignFunction, advise_gains
from equipoise.physics import PhysicsState
from equipoise.robots import Robot, get_robot
from equipoise.simulation.faults import FaultInjector, Faults
from equipoise.simulation.sensors import SensorModel, SensorModels, SensorSuite, Silence
from equipoise.tasks import ContactTask, PostureTask
from equipoise.trajectories import Profile
from equipoise.wbc import ControlSettings, WholeBodyController

DT, ROUND = 1e-3, 2000
SQUEEZE = Profile.of([0.0], [15.0])


def contacts_of(robot: Robot) -> ContactStack:
    """Return both soles where they stand and a grasp between the palms."""
    kin = robot.at(robot.q_half_sitting)
    soles = [SoleContact.standing(sole, kin) for sole in robot.soles]
    palms = (palm.frame for palm in robot.palms)
    return ContactStack([*soles, GraspContact.holding("grasp", kin, *palms, regulated=("fz",))])


class Ordeal:
    """One round: a controller, and everything that goes wrong, drawn from a seed."""

    def __init__(
        self, robot: Robot, stack: ContactStack, K_d: np.ndarray, rng: np.random.Generator
    ) -> None:
        self.robot, self.stack, self.rng = robot, stack, rng
        gains = ControlGains(
            K_d=K_d, alpha=10.0, sgn_p=SignFunction("saturation", 0.2), damp_violation=True
        )
        bounds = ReactionBounds() if rng.random() < 0.5 else None
        posture = PostureTask("posture", robot, robot.q_half_sitting[robot.nq_base :])
        self.controller = WholeBodyController(
            robot,
            [[ContactTask("contacts", stack)], [posture]],
            stack,
            ControlSettings(gains, DT, bounds=bounds, filter_time=0.02),
            robot.q_half_sitting,
            wanted_forces={"grasp": [SQUEEZE]},
        )
        seed = int(rng.integers(1 << 30))
        self.sensors = SensorSuite(robot, stack, self._models(), DT, seed)
        self.faults = FaultInjector(robot, self._faults(), DT, seed + 1)
        self.size = 10 ** rng.uniform(-4, 0.3)
        self.rates = rng.uniform(1, 30, size=robot.nv)
        self.phases = rng.uniform(0, 6, size=robot.nv)
        self.command = None

    def _models(self) -> SensorModels:
        rng, known = self.rng, ("joint_position", "joint_velocity", "base", *self.stack.rows)
        known = (*known, *self.robot.joint_names)

        def model(scale: float) -> SensorModel:
            return SensorModel(
                noise=scale * 10 ** rng.uniform(-6, 0),
                bias=scale * 10 ** rng.uniform(-6, -1),
                filter_time=rng.choice([0.0, 0.002, 0.01]),
                delay=rng.choice([0.0, 0.001, 0.003]),
            )

        silences = []
        for _ in range(rng.integers(0, 4)):
            start = float(rng.uniform(0, 2))
            end = start + float(10 ** rng.uniform(-3, 0))
            reading = str(rng.choice(["nan", "frozen"]))
            silences.append(Silence(str(rng.choice(known)), start, end, reading))
        return SensorModels(
            *(model(scale) for scale in (1, 10, 1, 1, 10, 10, 1000, 100)), tuple(silences)
        )

    def _faults(self) -> Faults:
        draw = self.rng.choice
        return Faults(
            measurement_delay=float(draw([0.0, 0.002, 0.01])),
            command_delay=float(draw([0.0, 0.003])),
            missed_ticks=float(draw([0.0, 0.1, 0.5])),
            torque_share=float(draw([1.0, 0.3])),
        )

    def tick(self, t: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the commanded and the applied torque (na,) of the tick at `t` [s]."""
        robot, angle = self.robot, self.rates * t + self.phases
        q = pin.integrate(robot.model, robot.q_half_sitting, self.size * np.sin(angle))
        v = self.size * self.rates * np.cos(angle)
        lam = 300.0 * self.rng.normal(size=self.stack.size)
        reading = self.faults.late_reading(self.sensors.read(PhysicsState(t, q, v, lam, 0.0)))
        if self.command is not None and self.faults.tick_is_missed():
            self.command = self.controller.hold(t, self.command)
        else:
            self.command = self.controller.step(t, reading.q, reading.v, reading.lam)
        return self.command.tau, self.faults.torque(self.command.tau)


def main(ticks: int, seed: int) -> int:
    """Run, print the counts, return 1 if any is not zero."""
    robot = get_robot("hrp2")
    stack, rng = contacts_of(robot), np.random.default_rng(seed)
    K_d = advise_gains(robot, stack, robot.q_half_sitting, DT, alpha=10.0, kappa=50.0).K_d
    counts, modes, began = Counter(), Counter(), perf_counter()
    for k in range(ticks):
        if k % ROUND == 0:
            ordeal = Ordeal(robot, stack, K_d, rng)
        try:
            for tau in ordeal.tick((k % ROUND) * DT):
                counts["not finite"] += not np.isfinite(tau).all()
                counts["over a limit"] += bool((np.abs(tau) > robot.tau_max).any())
        except Exception as error:  # what this looks for
            counts["exceptions"] += 1
            print(f"tick {k}: {error!r}")
        modes[ordeal.controller.supervisor.mode.name.lower()] += 1
        if k % 100_000 == 99_999:
            print(f"{k + 1} ticks, {perf_counter() - began:.0f} s", flush=True)
    told = [f"{counts[kind]} {kind}" for kind in ("exceptions", "not finite", "over a limit")]
    print(f"{ticks} ticks: {', '.join(told)}; modes {dict(modes)}")
    return int(any(counts.values()))


if __name__ == "__main__":
    arguments = [float(argument) for argument in sys.argv[1:]]
    sys.exit(main(int(arguments[0]) if arguments else 1_000_000, int([*arguments, 0, 0][1])))
