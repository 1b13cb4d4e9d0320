"""A Panda that is bolted down slides along a table with 10 N, in a loop that is plain MuJoCo.

The tool draws a line of 10 cm there and back. Masses and friction are told to nobody.
"""

import re
import sys
from pathlib import Path
from tempfile import mkdtemp

import mujoco
import numpy as np

from equipoise import LoopSettings, MujocoAdapter, WholeBodyController
from equipoise.contacts import SurfaceContact
from equipoise.robots import Robot, load_robot
from equipoise.tasks import FramePoseTask
from equipoise.trajectories import Waypoint, WaypointTrajectory

PANDA = """
base: fixed
locked: {"panda_finger_joint*": 0.0}
urdf: {package: example-robot-data, file: robots/panda_description/urdf/panda.urdf, extra: robots}
frames: [{name: tip, on: panda_link8, xyz: [0.0, 0.0, 0.1]}]
half_sitting: {panda_joint2: 0.2, panda_joint4: -2.0, panda_joint6: 2.2, panda_joint7: 0.8}
"""
BOX, BALL, GREASE = mujoco.mjtGeom.mjGEOM_BOX, mujoco.mjtGeom.mjGEOM_SPHERE, [0.02, 0, 0]


def own_model(robot: Robot) -> mujoco.MjModel:
    """Return a model such as anybody has: the arm, a soft ball as tool, a table, motors."""
    strip = r"<(visual|collision|mujoco)>.*?</\1>|<mimic.*?/>"
    text = re.sub(strip, "", robot.urdf_path.read_text(), flags=re.S)
    spec = mujoco.MjSpec.from_string(text.replace("prismatic", "fixed"))  # its fingers stay
    spec.option.timestep, spec.option.cone = 0.0005, mujoco.mjtCone.mjCONE_ELLIPTIC
    top = robot.at(robot.q_half_sitting).placement("tip").translation - np.array([0, 0, 0.05])
    spec.worldbody.add_geom(type=BOX, size=[0.4, 0.4, 0.05], pos=top, friction=GREASE)
    ball = spec.body("panda_link7").add_geom(type=BALL, size=[0.02, 0, 0], pos=[0, 0, 0.187])
    ball.friction, ball.solref = GREASE, [0.1, 0.3]  # a soft one: tool tips are
    for name in robot.joint_names:
        spec.joint(name).armature, spec.joint(name).frictionloss = 0.1, 0.2
        spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    return spec.compile()


def main(seconds: float = 6.0) -> bool:
    """Run the loop; print what was achieved, and return whether it was enough."""
    (path := Path(mkdtemp(), "panda.yaml")).write_text(PANDA)
    robot = load_robot(path)
    model = own_model(robot)
    data, forces, off = mujoco.MjData(model), [], []
    # -- Equipoise
    world, kin = MujocoAdapter(robot, model), robot.at(robot.q_half_sitting)
    world.place(data, robot.q_half_sitting)
    here, there = kin.placement("tip"), kin.placement("tip")
    there.translation += np.array([0.0, 0.1, 0.0])
    line = WaypointTrajectory([Waypoint(1.0, here), Waypoint(3.0, there), Waypoint(5.0, here)])
    table = SurfaceContact.on_plane("table", "tip", kin, normal=(0.0, 0.0, 1.0))
    loop = LoopSettings(delay=0.003, rotor_inertia=world.rotor_inertia)  # a contact that gives
    slide, ten = FramePoseTask("slide", "tip", line), {"table": 10.0}
    controller = WholeBodyController.fixed(
        robot, tasks=[slide], contacts=[table], forces=ten, loop=loop
    )
    controller.take_over(data.qfrc_bias)  # the torques that held it until now
    # --
    while data.time < seconds:
        # -- Equipoise
        q, v, wrenches = world.from_mujoco(data, controller.contacts)
        world.apply(data, controller.step(data.time, q, v, wrenches).tau)
        # --
        forces.append(wrenches["table"][0])
        off.append(1e3 * np.linalg.norm(slide.error(robot.at(q), data.time)[:2]))
        mujoco.mj_step(model, data, nstep=2)
    rms, far = float(np.sqrt(np.mean((np.array(forces[1000:]) - 10.0) ** 2))), max(off[1000:])
    print(f"10 N met to {rms:.3f} N RMS (wanted <= 0.2), line to {far:.2f} mm (wanted <= 2)")
    return bool(rms <= 0.2 and far <= 2.0)


if __name__ == "__main__":
    sys.exit(0 if main() else 1)
