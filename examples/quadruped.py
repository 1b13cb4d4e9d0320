"""Solo stands on four points while its trunk follows a circle of 5 cm radius, in two engines.

The feet only push, within the cone of their friction. In MuJoCo they are small balls on a floor
that gives, and joints have friction and rotors. Needs the extras mujoco and robots.
"""

import sys
from pathlib import Path
from tempfile import mkdtemp

import numpy as np
import pinocchio as pin

from equipoise import LoopSettings, RigidContactEngine, WholeBodyController
from equipoise.physics import PhysicsEngine
from equipoise.physics.mujoco import MujocoEngine, MujocoOptions
from equipoise.robots import Robot, load_robot
from equipoise.tasks import FramePoseTask

FEET = ["FL_FOOT", "FR_FOOT", "HL_FOOT", "HR_FOOT"]
SOLO = """
urdf: {package: example-robot-data, file: robots/solo_description/robots/solo12.urdf, extra: robots}
feet: [{name: FL, frame: FL_FOOT}, {name: FR, frame: FR_FOOT},
  {name: HL, frame: HL_FOOT}, {name: HR, frame: HR_FOOT}]
half_sitting: {FL_HFE: 0.8, FL_KFE: -1.6, FR_HFE: 0.8, FR_KFE: -1.6,
  HL_HFE: 0.8, HL_KFE: -1.6, HR_HFE: 0.8, HR_KFE: -1.6}
"""
RADIUS, RATE = 0.05, 2.0  # m, rad/s
HARDWARE = MujocoOptions(joint_friction=0.05, joint_damping=0.05, armature=0.01)


def target_at(t: float, start: pin.SE3) -> pin.SE3:
    """Return where the trunk should be: at rest, then round and round after a soft start."""
    turn, soft = RATE * max(t, 0.0), min(max(t, 0.0), 1.0)
    size = RADIUS * soft**3 * (10.0 - 15.0 * soft + 6.0 * soft**2)
    out = np.array([np.cos(turn), np.sin(turn), 0.0])
    return pin.SE3(start.rotation, start.translation + size * out)


def follow(robot: Robot, mujoco: bool) -> float:
    """Return how far [mm] the trunk is from its target at most, once it is on the circle."""
    start = robot.at(robot.q_half_sitting).placement("base_link")
    # -- Equipoise
    trunk, loop = FramePoseTask("trunk", "base_link", start), LoopSettings(delay=0.0)
    if mujoco:
        loop = LoopSettings(rotor_inertia=HARDWARE.armature)
    controller = WholeBodyController.standing(robot, tasks=[trunk], feet=FEET, loop=loop)
    # --
    given = robot, controller.contacts, robot.q_half_sitting, controller.dt
    engine: PhysicsEngine = RigidContactEngine(*given)
    if mujoco:
        engine = MujocoEngine(*given, options=HARDWARE)
    controller.take_over(engine.stand())  # it was held, and is let go
    state, worst = engine.state, 0.0
    for t in np.arange(0.0, 8.0, controller.dt):
        trunk.target = target_at(t - 1.0, start)  # its velocity is estimated
        state = engine.step(controller.step(t, state.q, state.v, state.lam).tau)
        if t > 2.0:
            there = target_at(t - 1.0 + controller.dt, start).translation
            worst = max(worst, 1e3 * float(np.linalg.norm(state.q[:3] - there)))
    return worst


def main() -> bool:
    """Follow twice; print how far off, and return whether both are close enough."""
    path = Path(mkdtemp(), "solo12.yaml")
    path.write_text(SOLO)
    robot = load_robot(path)
    rigid, soft = follow(robot, mujoco=False), follow(robot, mujoco=True)
    print(f"from the circle at most {rigid:.3f} mm, in MuJoCo {soft:.3f} mm (both wanted <= 2)")
    return rigid <= 2.0 and soft <= 2.0


if __name__ == "__main__":
    sys.exit(0 if main() else 1)
