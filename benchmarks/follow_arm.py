"""A fixed arm of seven joints follows a circle at 0.3 m/s: ours, Pink and mink in one run.

The arm is a Panda. Each is told the target every 5 ms and steps its own model: joint limits, the
hand, the posture; ours are three strict levels, the others weigh. They know poses only; ours is
also told the target's velocity. Beside that the whole controller with its law runs the simulated
arm at 1 kHz. Lines are what stands between the marks "# -- lines" and "# --": all that is not the
user's model. Times are medians of the calls from setting the target to the next configuration, or
torque.

    python benchmarks/follow_arm.py
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

import numpy as np
import pinocchio as pin

from equipoise import InverseKinematics, LoopSettings, RigidContactEngine, WholeBodyController
from equipoise.robots import Robot, load_robot
from equipoise.tasks import FramePoseTask

PERIOD, SPEED, RADIUS, SECONDS, TIP = 0.005, 0.3, 0.1, 6.0, "panda_link8"
RATE = SPEED / RADIUS
PANDA = """
base: fixed
locked: {"panda_finger_joint*": 0.0}
urdf: {package: example-robot-data, file: robots/panda_description/urdf/panda.urdf, extra: robots}
half_sitting: {panda_joint2: -0.2, panda_joint4: -2.0, panda_joint6: 1.8, panda_joint7: 0.8}
"""
Told = Callable[[float], pin.SE3]
Measured = tuple[list[float], list[np.ndarray], list[float]]  # times [s], q, when it is due


def panda() -> Robot:
    """Return the arm."""
    with TemporaryDirectory() as folder:
        path = Path(folder, "panda.yaml")
        path.write_text(PANDA)
        return load_robot(path)


def off(t: float) -> np.ndarray:
    """Return how far the target is from its start (3,) [m]."""
    return RADIUS * np.array([0.0, np.cos(RATE * t) - 1.0, np.sin(RATE * t)])


def twist_at(t: float) -> np.ndarray:
    """Return how the target moves (6,)."""
    return SPEED * np.array([0.0, -np.sin(RATE * t), np.cos(RATE * t), 0.0, 0.0, 0.0])


def motion(robot: Robot, target_at: Told, known: bool) -> Measured:
    """Follow with the motion alone."""
    times, told, due = [], [], []
    # -- lines
    hand = FramePoseTask("hand", TIP, target_at(0.0))
    ik = InverseKinematics(robot, [hand], period=PERIOD)
    for t in np.arange(0.0, SECONDS, PERIOD):
        there, twist = target_at(t), twist_at(t)
        began = perf_counter()
        hand.target = (there, twist) if known else there
        q = ik.step().q_ref
        # --
        times.append(perf_counter() - began)
        told.append(q)
        due.append(t)
    return times, told, due


def robot_itself(robot: Robot, target_at: Told, known: bool) -> Measured:
    """Follow with the whole controller, the simulated arm at its end."""
    times, told, due = [], [], []
    # -- lines
    hand = FramePoseTask("hand", TIP, target_at(0.0))
    controller = WholeBodyController.fixed(robot, tasks=[hand], loop=LoopSettings(delay=0.0))
    engine = RigidContactEngine(robot, controller.contacts, robot.q_half_sitting, controller.dt)
    state = engine.state
    controller.take_over(engine.stand())
    for t in np.arange(0.0, SECONDS, controller.dt):
        there, twist = target_at(t), twist_at(t)
        began = perf_counter()
        hand.target = (there, twist) if known else there
        command = controller.step(t, state.q, state.v, state.lam)
        # --
        times.append(perf_counter() - began)
        # -- lines
        state = engine.step(command.tau)
        # --
        told.append(state.q.copy())
        due.append(t + controller.dt)
    return times, told, due


def pink_motion(robot: Robot, target_at: Told, known: bool) -> Measured:
    """Follow with Pink and DAQP."""
    import pink
    from pink.tasks import FrameTask, PostureTask

    times, told, due = [], [], []
    # -- lines
    model = robot.model.copy()
    state = pink.Configuration(model, model.createData(), robot.q_half_sitting.copy())
    hand = FrameTask(TIP, position_cost=1.0, orientation_cost=1.0)
    posture = PostureTask(cost=1e-3)
    posture.set_target(robot.q_half_sitting)
    for t in np.arange(0.0, SECONDS, PERIOD):
        there = target_at(t)
        began = perf_counter()
        hand.set_target(there)
        v = pink.solve_ik(state, [hand, posture], PERIOD, solver="daqp", safety_break=False)
        state.integrate_inplace(v, PERIOD)
        # --
        times.append(perf_counter() - began)
        told.append(state.q.copy())
        due.append(t + PERIOD)
    return times, told, due


def mink_motion(robot: Robot, target_at: Told, known: bool) -> Measured:
    """Follow with mink and DAQP, on a MuJoCo model of the same arm."""
    import mink

    model = mujoco_model(robot)
    times, told, due = [], [], []
    # -- lines
    state = mink.Configuration(model, q=robot.q_half_sitting)
    hand = mink.FrameTask(TIP, "site", position_cost=1.0, orientation_cost=1.0)
    posture, limits = mink.PostureTask(model, cost=1e-3), [mink.ConfigurationLimit(model)]
    posture.set_target(state.q)
    for t in np.arange(0.0, SECONDS, PERIOD):
        there = mink.SE3.from_matrix(target_at(t).homogeneous)
        began = perf_counter()
        hand.set_target(there)
        v = mink.solve_ik(state, [hand, posture], PERIOD, solver="daqp", limits=limits)
        state.integrate_inplace(v, PERIOD)
        # --
        times.append(perf_counter() - began)
        told.append(state.q.copy())
        due.append(t + PERIOD)
    return times, told, due


def mujoco_model(robot: Robot) -> Any:
    """Return the arm in MuJoCo: the engine's own model of it, with a site at its tip."""
    from equipoise.contacts import ContactStack
    from equipoise.physics.mujoco import MujocoEngine, Surroundings
    from equipoise.physics.mujoco.names import of_joint

    nowhere = Surroundings(floor_height=None)
    engine = MujocoEngine(
        robot, ContactStack([]), robot.q_half_sitting, PERIOD, surroundings=nowhere
    )
    spec, frame = engine.model.spec, robot.model.frames[robot.frame_id(TIP)]
    link = spec.body(of_joint(robot.model.names[frame.parentJoint]))
    R = pin.Quaternion(frame.placement.rotation)
    site = link.add_site(name=TIP, pos=frame.placement.translation)
    site.quat = [R.w, R.x, R.y, R.z]
    return spec.compile()


def lines_of(follow: Callable[..., Measured]) -> int:
    """Return how many lines are not the user's model, without those that only measure."""
    counting, count = False, 0
    for line in inspect.getsource(follow).splitlines():
        if line.strip().startswith("# --"):
            counting = "lines" in line
        elif counting and line.strip() and "perf_counter" not in line:
            count += 1
    return count


def main() -> None:
    """Print a line for each that is installed."""
    robot = panda()
    start = robot.at(robot.q_half_sitting).placement(TIP).copy()

    def target_at(t: float) -> pin.SE3:
        return pin.SE3(start.rotation, start.translation + off(t))

    for name, follow, known in (
        ("ours, motion, velocity known", motion, True),
        ("ours, motion, estimated", motion, False),
        ("ours, the robot, velocity known", robot_itself, True),
        ("ours, the robot, estimated", robot_itself, False),
        ("Pink, motion", pink_motion, False),
        ("mink, motion", mink_motion, False),
    ):
        try:
            times, told, due = follow(robot, target_at, known)
        except ImportError as error:
            print(f"{name:32s} not installed: {error}")
            continue
        settled = len(due) // 3
        wanted = start.translation + np.array([off(t) for t in due])
        places = np.array([robot.at(q).placement(TIP).translation for q in told])
        lag = np.linalg.norm(places - wanted, axis=1)[settled:].max()
        took = 1e6 * np.median(times)
        print(f"{name:32s} {took:6.1f} us   {lines_of(follow):2d} lines   lag {1e3 * lag:.3f} mm")


if __name__ == "__main__":
    main()
