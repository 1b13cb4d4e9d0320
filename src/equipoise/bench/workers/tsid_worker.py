"""TSID's inverse dynamics on the task that `bench.apart` wrote; runs in TSID's own Python.

Imports nothing of Equipoise.
"""

from __future__ import annotations

from importlib.metadata import version
from time import perf_counter_ns
from typing import Literal

import numpy as np
import pinocchio as pin
import tsid
from protocol import Asked, serve

FRICTION, FORCE_MIN, FORCE_MAX = 0.8, 0.0, 2000.0
GAIN = 100.0  # [1/s^2] of hands, feet and posture; damping is critical


class Tick:
    """Rigid feet, hands, centre of mass, a light posture, velocity bounds; torques come out."""

    def __init__(self, task: Asked, targets: dict[str, np.ndarray]) -> None:
        self.targets = targets
        self.dt = task["dt"]
        self.robot = tsid.RobotWrapper(task["urdf"], [], pin.JointModelFreeFlyer(), False)
        self.q, self.v = self._order(task, "q_start"), np.zeros(self.robot.nv)
        self.form = tsid.InverseDynamicsFormulationAccForce("tick", self.robot, False)
        self.form.computeProblemData(0.0, self.q, self.v)
        self.kept = [self._contact(task, foot) for foot in task["feet"]]
        self.hands = {hand: self._hand(task["links"][hand], hand) for hand in task["hands"]}
        self._balance()
        self._posture(task)
        self.solver = tsid.SolverHQuadProgFast("solver")
        self.solver.resize(self.form.nVar, self.form.nEq, self.form.nIn)

    def _order(self, task: Asked, key: Literal["q_start", "q_posture"]) -> np.ndarray:
        q = np.array(task[key])
        ours = dict(zip(task["joints"], q[7:], strict=True))
        names = list(self.robot.model().names)[2:]
        return np.concatenate((q[:7], [ours[name] for name in names]))

    def _contact(self, task: Asked, foot: str) -> tsid.Contact6d:
        corners = np.array(task["soles"][foot]).T
        contact = tsid.Contact6d(
            foot,
            self.robot,
            task["links"][foot],
            corners,
            np.array([0.0, 0.0, 1.0]),
            FRICTION,
            FORCE_MIN,
            FORCE_MAX,
        )
        contact.setKp(GAIN * np.ones(6))
        contact.setKd(2.0 * np.sqrt(GAIN) * np.ones(6))
        contact.setReference(pin.SE3(self.targets[foot][0]))
        self.form.addRigidContact(contact, 1e-5)
        return contact

    def _hand(self, link: str, hand: str) -> tuple[tsid.TaskSE3Equality, tsid.TrajectorySample]:
        follow = tsid.TaskSE3Equality(hand, self.robot, link)
        follow.setKp(GAIN * np.ones(6))
        follow.setKd(2.0 * np.sqrt(GAIN) * np.ones(6))
        self.form.addMotionTask(follow, 1.0, 1, 0.0)
        return follow, tsid.TrajectorySample(12, 6)

    def _balance(self) -> None:
        balance = tsid.TaskComEquality("balance", self.robot)
        balance.setKp(GAIN * np.ones(3))
        balance.setKd(2.0 * np.sqrt(GAIN) * np.ones(3))
        p_com = self.robot.com(self.form.data())
        balance.setReference(tsid.TrajectoryEuclidianConstant("com", p_com).computeNext())
        self.form.addMotionTask(balance, 1.0, 1, 0.0)
        self.kept.append(balance)

    def _posture(self, task: Asked) -> None:
        posture = tsid.TaskJointPosture("posture", self.robot)
        posture.setKp(GAIN * np.ones(self.robot.nv - 6))
        posture.setKd(2.0 * np.sqrt(GAIN) * np.ones(self.robot.nv - 6))
        posture.setReference(
            tsid.TrajectoryEuclidianConstant(
                "rest", self._order(task, "q_posture")[7:]
            ).computeNext()
        )
        self.form.addMotionTask(posture, 1e-3, 1, 0.0)
        bounds = tsid.TaskJointBounds("bounds", self.robot, self.dt)
        ours = dict(zip(task["joints"], task["velocity_max"], strict=True))
        limit = np.array([ours[name] for name in list(self.robot.model().names)[2:]])
        bounds.setVelocityBounds(-limit, limit)
        self.form.addMotionTask(bounds, 1.0, 0, 0.0)
        self.kept += [posture, bounds]

    def run(self, k: int) -> tuple[int, int]:
        """Return the time [ns] of tick k, and 1 if it failed."""
        for hand, (follow, sample) in self.hands.items():
            T = self.targets[hand][k]
            sample.value(np.concatenate((T[:3, 3], T[:3, :3].T.ravel())))
            before = self.targets[hand][max(k - 1, 0)]  # the tray does not turn
            velocity = (T[:3, 3] - before[:3, 3]) / self.dt
            sample.derivative(np.concatenate((velocity, np.zeros(3))))
            follow.setReference(sample)
        began = perf_counter_ns()
        problem = self.form.computeProblemData(k * self.dt, self.q, self.v)
        answer = self.solver.solve(problem)
        failed = int(answer.status != 0)
        if not failed:
            self.form.getActuatorForces(answer)
            dv = self.form.getAccelerations(answer)
            self.v = self.v + self.dt * dv
            self.q = pin.integrate(self.robot.model(), self.q, self.dt * self.v)
        return perf_counter_ns() - began, failed

    def error(self, k: int) -> float:
        """Return the largest distance [m] of a hand from its target of tick k."""
        return max(
            float(np.linalg.norm(follow.position_error[:3])) for follow, _ in self.hands.values()
        )


if __name__ == "__main__":
    serve(Tick, f"tsid {version('tsid')}, one level of motion")
