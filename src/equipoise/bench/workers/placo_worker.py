"""PlaCo's kinematics solver on the task that `bench.apart` wrote; runs in PlaCo's own Python.

Imports nothing of Equipoise.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import version
from time import perf_counter_ns

import numpy as np
import placo
from protocol import Asked, serve


class Tick:
    """Frame tasks of hands and feet (feet hard), a light posture, joint and velocity limits."""

    def __init__(self, task: Asked, targets: dict[str, np.ndarray]) -> None:
        self.targets = targets
        self.robot = placo.RobotWrapper(task["urdf"], placo.Flags.ignore_collisions)
        for joint, limit in zip(task["joints"], task["velocity_max"], strict=True):
            self.robot.set_velocity_limit(joint, limit)
        for joint, value in zip(task["joints"], task["q_start"][7:], strict=True):
            self.robot.set_joint(joint, value)
        self.robot.set_T_world_fbase(_pose(task["q_start"]))
        self.robot.update_kinematics()
        self.solver = placo.KinematicsSolver(self.robot)
        self.solver.dt = task["dt"]
        self.solver.enable_joint_limits(True)
        self.solver.enable_velocity_limits(True)
        self.follow = {}
        for name, link in task["links"].items():
            frame_task = self.solver.add_frame_task(link, self.targets[name][0])
            kind = "hard" if name in task["feet"] else "soft"
            frame_task.configure(name, kind, 1.0, 1.0)
            self.follow[name] = frame_task
        posture = self.solver.add_joints_task()
        posture.set_joints(dict(zip(task["joints"], task["q_posture"][7:], strict=True)))
        posture.configure("posture", "soft", 1e-6)

    def run(self, k: int) -> tuple[int, int]:
        """Return the time [ns] of tick k, and 1 if it failed."""
        for name, frame_task in self.follow.items():
            frame_task.T_world_frame = self.targets[name][k]
        began = perf_counter_ns()
        try:
            self.robot.update_kinematics()
            self.solver.solve(True)
            failed = 0
        except RuntimeError:
            failed = 1
        return perf_counter_ns() - began, failed

    def error(self, k: int) -> float:
        """Return the largest distance [m] of a link from its target of tick k."""
        self.robot.update_kinematics()
        return max(float(np.abs(task.position().error()).max()) for task in self.follow.values())


def _pose(q: Sequence[float]) -> np.ndarray:
    x, y, z, w = q[3:7]
    T = np.eye(4)
    T[:3, 3] = q[:3]
    T[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return T


if __name__ == "__main__":
    serve(Tick, f"placo {version('placo')}, feet hard")
