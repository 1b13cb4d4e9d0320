"""Our kinematics kernels against Pinocchio: every named robot, and random trees of every joint."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest

from equipoise.compiled import entrance
from equipoise.compiled.workspace import part_of
from equipoise.errors import InputError, NonFiniteError, ShapeError
from equipoise.kinematics import KinematicsEvaluator, StaleKinematicsError, kinematics_at
from equipoise.kinematics.manifold import difference, integrate, velocity_difference
from equipoise.robots import get_robot
from equipoise.robots.registry import named_robots

ROBOTS = [name for name, robot in named_robots().items() if not robot.missing]
AXES = [np.array(a, dtype=float) / np.linalg.norm(a) for a in ([1, 2, 3], [-1, 0.3, 0.5])]


def random_tree(seed: int) -> SimpleNamespace:
    """Return a robot of random joints of every kind, free, planar or fixed at the base."""
    random = np.random.default_rng(seed)
    model = pin.Model()
    bases = {0: pin.JointModelFreeFlyer(), 1: pin.JointModelPlanar()}
    parents = [0]
    if seed % 3 in bases:
        parents = [model.addJoint(0, bases[seed % 3], pin.SE3.Random(), "base")]
        model.appendBodyToJoint(parents[0], pin.Inertia.Random(), pin.SE3.Identity())
    kinds = [
        *(pin.JointModelRX, pin.JointModelRY, pin.JointModelRZ),
        *(pin.JointModelPX, pin.JointModelPY, pin.JointModelPZ),
        *(pin.JointModelRUBX, pin.JointModelRUBY, pin.JointModelRUBZ),
        *(lambda a=a: pin.JointModelRevoluteUnaligned(a) for a in AXES),
        *(lambda a=a: pin.JointModelPrismaticUnaligned(a) for a in AXES),
    ]
    for k in range(12):
        parent = int(random.choice(parents[-3:]))
        kind = kinds[int(random.integers(len(kinds)))]
        joint = model.addJoint(parent, kind(), pin.SE3.Random(), f"joint{k}")
        model.appendBodyToJoint(joint, pin.Inertia.Random(), pin.SE3.Random())
        frame = pin.Frame(f"frame{k}", joint, pin.SE3.Random(), pin.FrameType.OP_FRAME)
        model.addFrame(frame)
        parents.append(joint)
    return SimpleNamespace(model=model, nq=model.nq, nv=model.nv, frame_id=int)


def states(robot, seed: int, count: int = 5):
    random = np.random.default_rng(seed)
    for _ in range(count):
        q = pin.integrate(robot.model, pin.neutral(robot.model), random.normal(size=robot.nv))
        yield q, random.normal(size=robot.nv)


def everything(request) -> object:
    kind, which = request
    return get_robot(which) if kind == "robot" else random_tree(which)


MODELS = [*(("robot", name) for name in ROBOTS), *(("tree", seed) for seed in range(12))]


@pytest.fixture(params=MODELS, ids=lambda p: f"{p[0]}-{p[1]}")
def robot(request):
    return everything(request.param)


def test_placements_jacobians_and_drifts_are_pinocchios(robot):
    model, data = robot.model, robot.model.createData()
    evaluator = KinematicsEvaluator(robot)
    world = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    for q, v in states(robot, 1):
        kin = evaluator.at(q, v)
        pin.forwardKinematics(model, data, q, v, np.zeros(robot.nv))
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        assert np.allclose(kin._memory.state.columns.T, data.J, atol=1e-12)
        for f in range(0, model.nframes, 3):
            assert np.allclose(kin.placement(f).homogeneous, data.oMf[f].homogeneous, atol=1e-12)
            J = pin.getFrameJacobian(model, data, f, world)
            assert np.allclose(kin.jacobian(f), J, atol=1e-11)
            assert np.allclose(kin.twist(f), J @ v, atol=1e-11)
            bias = pin.getFrameClassicalAcceleration(model, data, f, world).vector
            assert np.allclose(kin.drift(f), bias, atol=1e-9 * (1.0 + np.abs(bias).max()))


def test_the_centre_of_mass_is_pinocchios(robot):
    model, data = robot.model, robot.model.createData()
    for q, v in states(robot, 2):
        kin = kinematics_at(robot, q, v)
        J = pin.jacobianCenterOfMass(model, data, q)
        assert np.allclose(kin.p_world_com, data.com[0], atol=1e-12)
        assert np.allclose(kin.J_com, J, atol=1e-11)


@entrance
def step(floats, whole, tables, q, v, dt):
    integrate(part_of(floats, whole, tables, 0), q, v, dt)


@entrance
def apart(floats, whole, tables, q_from, q, out):
    difference(part_of(floats, whole, tables, 0), q_from, q, out)


@entrance
def velocities_apart(floats, whole, tables, q, v, q_ref, v_ref, dv):
    velocity_difference(part_of(floats, whole, tables, 0), q, v, q_ref, v_ref, dv)


@pytest.mark.parametrize("scale", [1e-9, 1e-3, 1.0])
def test_steps_and_differences_are_pinocchios(robot, scale):
    model = robot.model
    workspace = KinematicsEvaluator(robot)._memory.workspace
    blocks = workspace.floats, workspace.integers, workspace.tables
    for q, v in states(robot, 3):
        moved, out = q.copy(), np.zeros(robot.nv)
        step(*blocks, moved, v, 0.7 * scale)
        assert np.allclose(moved, pin.integrate(model, q, 0.7 * scale * v), atol=1e-12)
        apart(*blocks, q, moved, out)
        wanted = pin.difference(model, q, moved) if scale == 1.0 else 0.7 * scale * v
        assert np.allclose(out, wanted, rtol=1e-9, atol=2e-15)


def test_a_velocity_is_seen_from_the_actual_base():
    """Both bases belong to one rigid body in motion: then no difference is left."""
    for seed in (0, 1):  # free, planar
        robot = random_tree(seed)
        workspace = KinematicsEvaluator(robot)._memory.workspace
        (q, v), (q_ref, _) = list(states(robot, 4, 2))
        base, nv = robot.model.joints[1], robot.model.joints[1].nv
        data = robot.model.createData()
        pin.forwardKinematics(robot.model, data, q)
        T = data.oMi[1].copy()
        pin.forwardKinematics(robot.model, data, q_ref)
        # the reference's place moved to where the joint's own frame stands
        T_ref_actual = data.oMi[1].actInv(T)
        keep = np.arange(6) if nv == 6 else np.array([0, 1, 5])
        twist = np.zeros(6)
        twist[keep] = v[base.idx_v : base.idx_v + nv]
        v_ref = v.copy()
        v_ref[base.idx_v : base.idx_v + nv] = T_ref_actual.act(pin.Motion(twist)).vector[keep]
        dv = np.ones(robot.nv)
        blocks = workspace.floats, workspace.integers, workspace.tables
        velocities_apart(*blocks, q, v, q_ref, v_ref, dv)
        assert np.allclose(dv, 0.0, atol=1e-12)


def test_an_older_state_is_not_answered_for(hrp2):
    evaluator = KinematicsEvaluator(hrp2)
    old = evaluator.at(hrp2.q_half_sitting)
    evaluator.at(hrp2.q_half_sitting)
    with pytest.raises(StaleKinematicsError):
        old.placement("left_palm")
    assert hrp2.at(hrp2.q_half_sitting).placement("left_palm").translation[1] > 0.1


@pytest.mark.parametrize(
    ("q", "v", "error"),
    [
        (np.full(37, np.nan), None, NonFiniteError),
        (np.zeros(36), None, ShapeError),
        (None, None, InputError),
        ("nothing", None, InputError),
        (np.zeros(37), np.full(36, np.inf), NonFiniteError),
        (np.zeros(37, dtype=object), np.array(["a"] * 36), InputError),
        (np.zeros(37, dtype=complex), None, InputError),
    ],
)
def test_a_state_that_is_none_is_refused(hrp2, q, v, error):
    with pytest.raises(error):
        hrp2.at(q, v)
