"""Stand and press in a loop of one's own: one object is the whole controller, one call a tick.

The right palm slides without friction on a vertical plane and is told to press 20 N. The simulated
robot weighs 20 % more than the nominal one; the law is not told and sees no mass anyway.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from equipoise import (
    ContactStack,
    ControlGains,
    ControlSettings,
    RigidContactEngine,
    SoleContact,
    WholeBodyController,
    advise_gains,
    get_robot,
)
from equipoise.contacts import Contact, SurfaceContact
from equipoise.contacts.surfaces import Plane
from equipoise.control import SignFunction
from equipoise.tasks import ContactTask, PostureTask, Task
from equipoise.trajectories import Profile

DT = 0.001


def main(seconds: float = 1.5) -> tuple[float, float]:
    """Run the loop; print and return the last force [N] and posture error [rad]."""
    robot = get_robot("hrp2")
    q = robot.q_half_sitting
    kin = robot.at(q)
    towards_robot = np.array([-1.0, 0.0, 0.0])  # the normal of the wall, world axes
    turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), towards_robot)
    wall = pin.SE3(turn.toRotationMatrix(), kin.placement("right_palm").translation)
    contacts: list[Contact] = [SoleContact.standing(sole, kin) for sole in robot.soles]
    contacts.append(
        SurfaceContact(
            name="wall",
            regulated=("fn",),
            frame="right_palm",
            surface=Plane(),
            T_world_surface=wall,
        )
    )
    stack = ContactStack(contacts)
    levels: list[list[Task]] = [
        [ContactTask("contacts", stack)],
        [PostureTask("posture", robot, q[robot.nq_base :])],
    ]
    advice = advise_gains(robot, stack, q, DT, alpha=20.0)
    smooth = SignFunction("saturation", 0.05), SignFunction("saturation", 0.5)
    gains = ControlGains(K_d=advice.K_d, alpha=20.0, sgn_p=smooth[0], sgn_F=smooth[1])
    controller = WholeBodyController(
        robot,
        levels,
        stack,
        ControlSettings(gains, period=DT),
        q,
        wanted_forces={"wall": [Profile.of([0.3, 0.8], [0.0, 20.0])]},
    )
    engine = RigidContactEngine(robot.scaled(1.2), stack, q, DT)

    state = engine.state
    for k in range(round(seconds / DT)):
        command = controller.step(k * DT, state.q, state.v, state.lam)
        state = engine.step(command.tau)
        if (k + 1) % 250 == 0:
            fn = state.lam[stack.rows["wall"]][0]
            dq = np.abs(pin.difference(robot.model, command.q_ref, state.q)).max()
            print(f"t = {state.t:.2f} s  force {fn:6.2f} N  posture {dq:.1e} rad  {command.status}")
    print(*advice.sentences(), sep="\n")
    return fn, dq


if __name__ == "__main__":
    main()
