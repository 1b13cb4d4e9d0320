"""Stand and press: the law holds a wanted force on a wall that it knows only as a plane.

The right palm slides without friction on a vertical plane 5 cm before it is told to press 20 N. The
simulated robot weighs 20 % more than the nominal one; the law is not told and sees no mass anyway.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from equipoise import get_robot
from equipoise.contacts import ContactStack, SoleContact, SurfaceContact
from equipoise.contacts.surfaces import Plane
from equipoise.control import (
    ControlGains,
    Measurement,
    PassivityController,
    Profile,
    SignFunction,
    Target,
    advise_gains,
)
from equipoise.kinematics import KinematicsEvaluator
from equipoise.physics import RigidContactEngine

DT = 0.001


def main(seconds: float = 1.5) -> tuple[float, float]:
    """Run the loop; print and return the last force [N] and posture error [rad]."""
    robot = get_robot("hrp2")
    q = robot.q_half_sitting
    kin = KinematicsEvaluator(robot).at(q, np.zeros(robot.nv))
    contacts = [SoleContact.standing(sole, kin) for sole in robot.soles]
    palm = robot.frame_id("right_palm")
    towards_robot = np.array([-1.0, 0.0, 0.0])  # the normal of the wall, world axes
    turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), towards_robot)
    wall = pin.SE3(turn.toRotationMatrix(), kin.placement(palm).translation)
    contacts.append(
        SurfaceContact(
            name="wall", regulated=("fn",), frame_id=palm, surface=Plane(), T_world_surface=wall
        )
    )
    stack = ContactStack(contacts)
    advice = advise_gains(robot, stack, q, DT, alpha=20.0)
    smooth = SignFunction("saturation", 0.05), SignFunction("saturation", 0.5)
    gains = ControlGains(K_d=advice.K_d, alpha=20.0, sgn_p=smooth[0], sgn_F=smooth[1])
    controller = PassivityController(robot, stack, gains, DT)
    engine = RigidContactEngine(robot.scaled(1.2), stack, q, DT)
    force = Profile.of([0.3, 0.8], [0.0, 20.0])

    state = engine.state
    for k in range(round(seconds / DT)):
        t = k * DT
        wanted = np.array([force.at(t)])
        target = Target(q, np.zeros(robot.nv), wanted)
        command = controller.step(t, Measurement(state.q, state.v, state.lam), target)
        state = engine.step(command.tau)
        if (k + 1) % 250 == 0:
            fn = state.lam[stack.rows["wall"]][0]
            dq = np.abs(pin.difference(robot.model, q, state.q)).max()
            print(
                f"t = {t:.2f} s  force {fn:6.2f} N (wanted {wanted[0]:5.2f})  posture {dq:.1e} rad"
            )
    print(*advice.sentences(), sep="\n")
    return fn, dq


if __name__ == "__main__":
    main()
