"""G1 stands and presses in a loop that is plain MuJoCo: 14 lines of it are Equipoise.

The model is the user's own: the robot's URDF, boxes as feet, a ball as hand, motors, a floor, a
wall. The hand presses the wall with 15 N, and after 2 s the robot is pushed with 30 N for 0.2 s.
"""

from __future__ import annotations

import re
import sys

import mujoco
import numpy as np
import pinocchio as pin

from equipoise import LoopSettings, MujocoAdapter, WholeBodyController, get_robot
from equipoise.contacts import SurfaceContact

GRIP, FIRM = [0.8, 0.005, 0.0001], [0.01, 1.0]  # softer soles sink, and the knees bend for it
PLANE, BALL, BOX = (getattr(mujoco.mjtGeom, f"mjGEOM_{k}") for k in ("PLANE", "SPHERE", "BOX"))


def own_model() -> mujoco.MjModel:
    """Return a model such as anybody has: here from the URDF that comes with the robot."""
    robot, strip = get_robot("g1"), r"<(visual|collision|mujoco)>.*?</\1>"
    text = re.sub(strip, "", robot.urdf_path.read_text(), flags=re.S)
    spec = mujoco.MjSpec.from_string(text)
    spec.option.timestep, spec.option.noslip_iterations = 0.0005, 5  # or standing feet creep
    spec.body("pelvis").add_freejoint()
    spec.worldbody.add_geom(type=PLANE, size=[3, 3, 0.1], friction=GRIP)
    for side in ("left", "right"):
        foot, size = spec.body(f"{side}_ankle_roll_link"), [0.085, 0.025, 0.01]
        foot.add_geom(type=BOX, size=size, pos=[0.035, 0, -0.025], friction=GRIP, solref=FIRM)
    spec.body("right_wrist_yaw_link").add_geom(type=BALL, size=[0.03, 0, 0], pos=[0.1, 0, 0])
    wall = robot.at(robot.q_half_sitting).placement("right_palm").translation
    spec.worldbody.add_geom(type=BOX, size=[0.05, 0.2, 0.2], pos=wall + np.array([0.08, 0, 0]))
    for name in robot.joint_names:
        spec.joint(name).armature = 0.02
        spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    return spec.compile()


def main(seconds: float = 4.0) -> bool:
    """Run the loop; print what was achieved, and return whether it was enough."""
    model = own_model()
    data = mujoco.MjData(model)
    heights, forces, postures = [], [], []
    # -- Equipoise
    robot = get_robot("g1")
    world = MujocoAdapter(robot, model)
    world.place(data, robot.q_half_sitting)
    start = world.from_mujoco(data).q
    press = SurfaceContact.on_plane("wall", "right_palm", robot.at(start), (-1.0, 0.0, 0.0))
    loop = LoopSettings(rotor_inertia=world.rotor_inertia)
    controller = WholeBodyController.standing(
        robot, start, contacts=[press], forces={"wall": 15.0}, loop=loop
    )
    # --
    for _ in range(round(seconds / loop.period)):
        data.body("torso_link").xfrc_applied[0] = 30.0 if 2.0 <= data.time < 2.2 else 0.0
        # -- Equipoise
        q, v, wrenches = world.from_mujoco(data, controller.contacts)
        command = controller.step(data.time, q, v, wrenches)
        world.apply(data, command.tau)
        # --
        mujoco.mj_step(model, data, nstep=2)
        heights.append(data.qpos[2])
        forces.append(wrenches["wall"][0])
        postures.append(np.abs(pin.difference(robot.model, command.q_ref, q)).max())
    sag, at_2s = 1e3 * (start[2] - min(heights)), 1e3 * postures[1990]
    print(f"sag {sag:.1f} mm (wanted <= 15), posture after 2 s {at_2s:.2f} mrad (<= 2)")
    lower = 1e3 * (start[2] - heights[-1])
    print(f"pressed with {forces[1990]:.2f} N, after the push with {forces[-1]:.2f} N (15 +- 0.75)")
    print(f"after the push {lower:.1f} mm lower than at first (<= 5)")
    presses = abs(forces[1990] - 15.0) <= 0.75 and abs(forces[-1] - 15.0) <= 0.75
    return bool(sag <= 15.0 and at_2s <= 2.0 and lower <= 5.0 and presses)


if __name__ == "__main__":
    sys.exit(0 if main() else 1)
