"""The adapter to a user's own MuJoCo model: states, wrenches and torques, and what it refuses."""

from __future__ import annotations

import re

import numpy as np
import pinocchio as pin
import pytest

from equipoise import WholeBodyController
from equipoise.adapters import MujocoAdapter
from equipoise.contacts import ContactStack, GraspContact, PointContact, SoleContact, SurfaceContact
from equipoise.contacts.surfaces import Plane
from equipoise.errors import InputError, NameNotFoundError
from equipoise.robots import get_robot, load_robot, named_robots
from fixed_arm import arm_in_mujoco, small_arm
from helpers import kinematics, random_state

mujoco = pytest.importorskip("mujoco")


def spec_of(robot, *, gear: float = 1.0, motors: bool = True):
    """Return a model of somebody's: URDF, free joint, floor, boxes under the feet, motors."""
    text = re.sub(
        r"<(visual|collision|mujoco)>.*?</\1>", "", robot.urdf_path.read_text(), flags=re.S
    )
    spec = mujoco.MjSpec.from_string(text)
    base = spec.joint(robot.joint_names[0]).parent
    while base.parent.name != "world":
        base = base.parent
    base.add_freejoint()
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[3, 3, 0.1])
    for sole in robot.soles:
        frame = robot.model.frames[robot.frame_id(sole.frame)]
        joint = robot.model.names[frame.parentJoint]
        middle = np.array([sole.x_min + sole.x_max, sole.y_min + sole.y_max, 0.02]) / 2
        size = [(sole.x_max - sole.x_min) / 2, (sole.y_max - sole.y_min) / 2, 0.01]
        place = frame.placement.act(middle)
        quat = pin.Quaternion(frame.placement.rotation).coeffs()[[3, 0, 1, 2]]
        spec.joint(joint).parent.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX, size=size, pos=place, quat=quat
        )
    for name in robot.joint_names if motors else ():
        spec.joint(name).armature = 0.02
        spec.add_actuator(
            name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT, gear=[gear, 0, 0, 0, 0, 0]
        )
    return spec


@pytest.fixture(scope="module")
def g1():
    robots = named_robots()
    if robots["g1"].missing:
        pytest.skip(f"g1 is not installed: {robots['g1'].missing}")
    return get_robot("g1")


@pytest.fixture
def made(g1):
    model = spec_of(g1).compile()
    return g1, model, mujoco.MjData(model), MujocoAdapter(g1, model)


def test_states_go_there_and_back(made, rng):
    robot, _, data, world = made
    q, v = random_state(robot, rng)
    world.place(data, q, v)
    state = world.from_mujoco(data)
    assert np.allclose(pin.difference(robot.model, q, state.q), 0.0, atol=1e-12)
    assert np.allclose(state.v, v, atol=1e-12)
    assert state.wrenches == {}


def test_frames_move_as_mujoco_moves_them(made, rng):
    """Position and velocity of a body, of which the two conventions make different numbers."""
    robot, model, data, world = made
    q, v = random_state(robot, rng)
    world.place(data, q, v)
    kin = kinematics(robot, *world.from_mujoco(data)[:2])
    body = model.body("left_wrist_yaw_link").id
    assert np.allclose(kin.placement("left_wrist_yaw_link").translation, data.xpos[body], atol=1e-6)
    twist = np.zeros(6)
    mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, body, twist, 0)
    assert np.allclose(kin.twist("left_wrist_yaw_link"), twist[[3, 4, 5, 0, 1, 2]], atol=1e-5)


def settled(made):
    """Return the state of the robot a moment after it was put on the floor, a little into it."""
    robot, model, data, world = made
    q = robot.q_half_sitting.copy()
    q[2] -= 0.001
    world.place(data, q)
    mujoco.mj_step(model, data, 3)
    return kinematics(robot, world.from_mujoco(data).q)


def test_wrenches_of_soles_are_what_the_floor_does(made):
    """The generalised force of all contacts is that of the wrenches, in the rows of the soles."""
    robot, model, data, world = made
    kin = settled(made)
    mujoco.mj_forward(model, data)
    stack = ContactStack([SoleContact.standing(sole, kin) for sole in robot.soles])
    state = world.from_mujoco(data, stack)
    lam = np.concatenate([state.wrenches[sole.name] for sole in robot.soles])
    assert lam[2] > 50.0
    assert lam[8] > 50.0
    ours = stack.jacobian(kinematics(robot, state.q)).T @ lam
    theirs = data.qfrc_constraint.copy()
    R = kin.placement("pelvis").rotation
    base = np.concatenate((R.T @ theirs[:3], theirs[3:6]))
    joints = theirs[[model.joint(name).dofadr[0] for name in robot.joint_names]]
    free = np.array([abs(one) > 1e-12 for one in ours[6:]])  # joint limits act on the others
    assert np.allclose(ours[:6], base, rtol=1e-4, atol=1e-2)
    assert np.allclose(ours[6:][free], joints[free], rtol=1e-3, atol=1e-2)


def test_other_contacts_tell_the_same_wrench_in_their_rows(made):
    robot, _, data, world = made
    kin = settled(made)
    frame = robot.soles[0].frame
    T = kin.placement(frame)
    sole = SoleContact.standing(robot.soles[0], kin)
    turned = pin.SE3(pin.rpy.rpyToMatrix(0.0, 0.0, 0.3) @ T.rotation, T.translation)
    point = PointContact.standing(frame, kin, name="point")
    slide = SurfaceContact(name="slide", frame=frame, surface=Plane(), T_world_surface=turned)
    found = world.from_mujoco(data, [sole, point, slide]).wrenches
    world_force = T.rotation @ found[sole.name][:3]
    assert np.allclose(found["point"], world_force)
    assert np.allclose(found["slide"], world_force[2], atol=1e-3 * world_force[2])


def test_a_grasp_sees_nothing_that_touches_nothing(made):
    _robot, _, data, world = made
    kin = settled(made)
    grasp = GraspContact.holding("grasp", kin, "left_palm", "right_palm", regulated=("fz",))
    assert np.array_equal(world.from_mujoco(data, [grasp]).wrenches["grasp"], np.zeros(6))


@pytest.mark.parametrize(("gear", "motors"), [(1.0, True), (40.0, True), (1.0, False)])
def test_torques_reach_the_joints(g1, rng, gear, motors):
    model = spec_of(g1, gear=gear, motors=motors).compile()
    data, tau = mujoco.MjData(model), rng.normal(size=g1.na)
    MujocoAdapter(g1, model).apply(data, tau)
    mujoco.mj_forward(model, data)
    dofs = [model.joint(name).dofadr[0] for name in g1.joint_names]
    assert np.allclose((data.qfrc_actuator + data.qfrc_applied)[dofs], tau)


def test_what_cannot_be_the_robot_is_refused(g1):
    spec = spec_of(g1)
    spec.body("left_elbow_link").pos = [0.5, 0.0, 0.0]
    with pytest.raises(InputError, match="joint 'left_elbow_joint' lies elsewhere"):
        MujocoAdapter(g1, spec.compile())
    spec = spec_of(g1, motors=False)
    spec.joint("left_elbow_joint").name = "elbow"
    with pytest.raises(NameNotFoundError, match="left_elbow_joint"):
        MujocoAdapter(g1, spec.compile())
    spec = spec_of(g1)
    spec.actuator("left_elbow_joint").set_to_position(kp=50.0)
    with pytest.raises(InputError, match="servos"):
        MujocoAdapter(g1, spec.compile())
    spec = spec_of(g1)
    spec.delete(spec.actuator("left_elbow_joint"))
    with pytest.raises(InputError, match="one motor each"):
        MujocoAdapter(g1, spec.compile())
    spec = spec_of(g1)
    spec.delete(next(joint for joint in spec.joints if joint.type == mujoco.mjtJoint.mjJNT_FREE))
    with pytest.raises(InputError, match="base of robot g1 is free"):
        MujocoAdapter(g1, spec.compile())


def test_a_fixed_base_may_stand_anywhere():
    """Contacts are told in the robot's own world, whose origin is its base."""
    arm = small_arm()
    spec = mujoco.MjSpec.from_string(arm_in_mujoco("1 2 0.3", "0.9 0.1 -0.2 0.3"))
    model = spec.compile()
    data, world = mujoco.MjData(model), MujocoAdapter(arm, model)
    q, v = arm.q_half_sitting, np.array([0.1, -0.2, 0.05])
    world.place(data, q, v)
    tip = data.geom_xpos[1].copy()
    base = data.body(1)
    T = pin.SE3(base.xmat.reshape(3, 3), base.xpos.copy())
    assert np.allclose(T.actInv(tip), arm.at(q).placement("tip").translation, atol=1e-9)
    spec.geom("table").pos = tip - np.array([0.0, 0.0, 0.069])  # its top 1 mm into the ball
    model = spec.compile()
    data, world = mujoco.MjData(model), MujocoAdapter(arm, model)
    world.place(data, q)
    mujoco.mj_step(model, data)
    point = PointContact(name="tip", frame="tip", p_world=np.zeros(3))
    state = world.from_mujoco(data, [point])
    force = T.rotation @ state.wrenches["tip"]
    assert force[2] > 1.0
    kin, own = arm.at(q), state.wrenches["tip"]
    lever = T.actInv(data.contact.pos[0].copy()) - kin.placement("tip").translation
    acting = kin.jacobian("tip").T @ np.concatenate((own, np.cross(lever, own)))
    assert np.allclose(acting, data.qfrc_constraint, atol=1e-3 * force[2])
    world.apply(data, np.array([1.0, 2.0, 3.0]))
    assert np.array_equal(data.qfrc_applied, [1.0, 2.0, 3.0])


def test_a_fixed_arm_stands_in_a_loop_of_mujoco():
    """The whole way: the door for a fixed base, the adapter, gravity that nobody told of."""
    arm = small_arm()
    model = mujoco.MjModel.from_xml_string(arm_in_mujoco("1 2 0.3"))
    data, world = mujoco.MjData(model), MujocoAdapter(arm, model)
    model.opt.timestep = 0.001
    world.place(data, arm.q_half_sitting)
    controller = WholeBodyController.fixed(arm)
    for _ in range(3000):
        q, v, wrenches = world.from_mujoco(data, controller.contacts)
        command = controller.step(data.time, q, v, wrenches)
        world.apply(data, command.tau)
        mujoco.mj_step(model, data)
    assert np.abs(q - arm.q_half_sitting).max() < 1e-4


def test_an_armature_that_the_robot_has_is_not_counted_twice(tmp_path):
    """One description for both: the inertia matrix holds the rotors already."""
    text = arm_in_mujoco().replace('axis="0 0 1"/>', 'axis="0 0 1" armature="0.02"/>', 1)
    path = tmp_path / "arm.xml"
    path.write_text(text)
    model = mujoco.MjModel.from_xml_string(text)
    assert MujocoAdapter(small_arm(), model).rotor_inertia == pytest.approx([0.02, 0.0, 0.0])
    assert MujocoAdapter(load_robot(path), model).rotor_inertia == pytest.approx([0.0] * 3)
