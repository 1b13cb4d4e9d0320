"""A hand of G1 follows a circle at 0.3 m/s: ours, Pink and mink in one run, time and lag.

Each is told the target every 5 ms and steps its own model: feet, hand and posture, joint limits.
Ours keeps feet and limits strictly, and the centre of mass inside the feet; the others weigh.
They know poses only, ours is also timed with the target's velocity. Times are medians of the calls
from setting the target to the next configuration.

    python benchmarks/follow_target.py
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from time import perf_counter

import numpy as np
import pinocchio as pin

from equipoise import InverseKinematics, MujocoAdapter, get_robot
from equipoise.tasks import FramePoseTask

PERIOD, SPEED, RADIUS, TICKS = 0.005, 0.3, 0.1, 1500
RATE = SPEED / RADIUS
Step = Callable[[float], np.ndarray]  # sets the target of a time; returns the next configuration
Place = Callable[[np.ndarray], np.ndarray]  # where the hand is (3,) at a configuration
Follower = tuple[Step, Place, int]  # and how many ticks after it was told the target that is


def off(t: float) -> np.ndarray:
    """Return how far the target is from its start (3,) [m]."""
    return RADIUS * np.array([np.cos(RATE * t) - 1.0, 0.0, np.sin(RATE * t)])


def ours(known: bool) -> Follower:
    """Return ours, told the velocity of the target or not."""
    robot = get_robot("g1")
    start = robot.at(robot.q_half_sitting).placement("right_palm")
    hand = FramePoseTask("hand", "right_palm", start)
    ik = InverseKinematics(robot, [hand], period=PERIOD)

    def step(t: float) -> np.ndarray:
        T = pin.SE3(start.rotation, start.translation + off(t))
        twist = SPEED * np.array([-np.sin(RATE * t), 0.0, np.cos(RATE * t), 0.0, 0.0, 0.0])
        hand.target = (T, twist) if known else T
        return ik.step().q_ref

    def place(q: np.ndarray) -> np.ndarray:
        return robot.at(q).placement("right_palm").translation

    return step, place, 0


def pink_step() -> Follower:
    """Return the same of Pink, with DAQP."""
    import pink
    from pink.tasks import FrameTask, PostureTask

    robot = get_robot("g1")
    model = robot.model.copy()
    state = pink.Configuration(model, model.createData(), robot.q_half_sitting.copy())
    tasks = [FrameTask(s.frame, position_cost=100.0, orientation_cost=100.0) for s in robot.soles]
    tasks.append(FrameTask("right_palm", position_cost=10.0, orientation_cost=10.0))
    for task in tasks:
        task.set_target(state.get_transform_frame_to_world(task.frame))
    start, posture = tasks[-1].transform_target_to_world.copy(), PostureTask(cost=1e-3)
    posture.set_target(robot.q_half_sitting)

    def step(t: float) -> np.ndarray:
        tasks[-1].set_target(pin.SE3(start.rotation, start.translation + off(t)))
        every = [*tasks, posture]
        v = pink.solve_ik(state, every, PERIOD, solver="daqp", safety_break=False)
        state.integrate_inplace(v, PERIOD)
        return state.q.copy()

    def place(q: np.ndarray) -> np.ndarray:
        return robot.at(q).placement("right_palm").translation

    return step, place, 1


def mink_step() -> Follower:
    """Return the same of mink, with DAQP, on the MuJoCo model of the example."""
    import mink
    import mujoco

    sys.path.insert(0, str(Path(__file__).parents[1] / "examples"))
    from own_mujoco_loop import own_model

    robot, model = get_robot("g1"), own_model()
    data, state = mujoco.MjData(model), mink.Configuration(model)
    MujocoAdapter(robot, model).place(data, robot.q_half_sitting)
    state.update(data.qpos.copy())
    bodies = ["left_ankle_roll_link", "right_ankle_roll_link", "right_wrist_yaw_link"]
    costs = [100.0, 100.0, 10.0]
    tasks = [
        mink.FrameTask(body, "body", position_cost=cost, orientation_cost=cost)
        for body, cost in zip(bodies, costs, strict=True)
    ]
    for task in tasks:
        task.set_target_from_configuration(state)
    posture, limits = mink.PostureTask(model, cost=1e-3), [mink.ConfigurationLimit(model)]
    posture.set_target(state.q)
    start = state.get_transform_frame_to_world(bodies[-1], "body")

    def step(t: float) -> np.ndarray:
        place = start.translation() + off(t)
        tasks[-1].set_target(mink.SE3.from_rotation_and_translation(start.rotation(), place))
        v = mink.solve_ik(state, [*tasks, posture], PERIOD, solver="daqp", limits=limits)
        state.integrate_inplace(v, PERIOD)
        return state.q.copy()

    def place(q: np.ndarray) -> np.ndarray:
        state.update(q)
        return state.get_transform_frame_to_world(bodies[-1], "body").translation()

    return step, place, 1


def main() -> None:
    """Print a line for each that is installed."""
    for name, make in (
        ("ours, velocity known", lambda: ours(True)),
        ("ours, estimated", lambda: ours(False)),
        ("Pink", pink_step),
        ("mink", mink_step),
    ):
        try:
            step, place, late = make()
        except ImportError as error:
            print(f"{name:22s} not installed: {error}")
            continue
        times, told = np.empty(TICKS), []
        for k in range(TICKS):
            began = perf_counter()
            told.append(step(k * PERIOD))
            times[k] = perf_counter() - began
        places = np.array([place(q) for q in told])
        start = places[0]  # the first target is where the hand is
        wanted = start + np.array([off((k + late) * PERIOD) for k in range(TICKS)])
        lag = np.linalg.norm(places - wanted, axis=1)[TICKS // 3 :].max()
        print(f"{name:22s} {1e6 * np.median(times):6.1f} us   lag {1e3 * lag:.3f} mm")


if __name__ == "__main__":
    main()
