"""One suite for every engine: the same robot falls, stands and is named the same in each."""

from __future__ import annotations

import random
import shutil
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import pytest

from equipoise.contacts import ContactStack
from equipoise.control.passivity.gain_advice import inertia_matrix
from equipoise.physics import DivergedError, RigidContactEngine, RigidOptions
from equipoise.robots import get_robot, load_robot, robot_urdf_path
from helpers import kinematics, random_state, sole_contacts

mujoco = pytest.importorskip("mujoco")

from equipoise.physics.mujoco import MujocoEngine, MujocoOptions, Surroundings  # noqa: E402
from equipoise.physics.mujoco.contact_pads import floor_height  # noqa: E402

LOSSLESS = MujocoOptions(substeps=1, joint_friction=0.0, joint_damping=0.0, armature=0.0)
DT = 1e-3


def rigid(robot, contacts, q, v=None):
    return RigidContactEngine(robot, ContactStack(contacts), q, DT, v_start=v)


def in_mujoco(robot, contacts, q, v=None, options=LOSSLESS):
    stack = ContactStack(contacts)
    around = Surroundings(floor_height=floor_height(stack))
    return MujocoEngine(robot, stack, q, DT, options=options, surroundings=around, v_start=v)


ENGINES = pytest.mark.parametrize("make", [rigid, in_mujoco], ids=["rigid", "mujoco"])


@ENGINES
def test_what_is_let_go_at_rest_falls_as_one_body(hrp2, make):
    """Semi-implicit Euler under gravity alone: z_n = z_0 - g h^2 n (n + 1) / 2, joints still."""
    q, n = hrp2.q_half_sitting, 100
    engine = make(hrp2, [], q)
    for _ in range(n):
        state = engine.step(np.zeros(hrp2.na))
    assert state.t == pytest.approx(n * DT)
    assert state.q[2] - q[2] == pytest.approx(-9.81 * DT**2 * n * (n + 1) / 2, abs=1e-9)
    assert np.abs(np.delete(state.q - q, 2)).max() < 1e-9


def test_a_tumbling_robot_moves_the_same_in_both(hrp2, rng):
    """Free motion with spin: the engines differ by their integration only."""
    q, v = random_state(hrp2, rng, spread=0.05)
    tau = np.zeros(hrp2.na)
    gaps = []
    for steps in (1, 4):
        reached = []
        for engine in (
            RigidContactEngine(
                hrp2, ContactStack([]), q, DT, options=RigidOptions(substeps=steps), v_start=v
            ),
            in_mujoco(hrp2, [], q, v, replace(LOSSLESS, substeps=steps)),
        ):
            for _ in range(20):
                state = engine.step(tau)
            reached.append(state.q)
        gaps.append(np.abs(pin.difference(hrp2.model, *reached)).max())
    assert gaps[0] < 5e-3
    assert gaps[1] < 0.5 * gaps[0]


@ENGINES
def test_a_held_posture_stands_on_its_weight(hrp2, make):
    """Springs and dampers around static equilibrium: the soles carry the weight."""
    q = hrp2.q_half_sitting
    engine = make(hrp2, sole_contacts(hrp2, q), q)
    tau = engine.stand()
    M = inertia_matrix(hrp2, q)[6:, 6:]
    for _ in range(600):
        state = engine.state
        dq = pin.difference(hrp2.model, q, state.q)
        state = engine.step(tau - M @ (2000.0 * dq[6:] + 80.0 * state.v[6:]))
    total = state.lam[:3] + state.lam[6:9]
    assert total[2] == pytest.approx(9.81 * hrp2.mass, rel=1e-3)
    assert np.abs(total[:2]).max() < 1e-3 * total[2]
    assert np.abs(state.v).max() < 1e-2
    assert state.violation < 2e-3
    # Moments about the world's origin balance the weight at the centre of mass.
    kin = kinematics(hrp2, state.q)
    moment = np.zeros(3)
    for k, contact in enumerate(sole_contacts(hrp2, q)):
        p, wrench = contact.T_world_anchor.translation, state.lam[6 * k : 6 * k + 6]
        moment += wrench[3:] + np.cross(p, wrench[:3])
    weight = np.cross(kin.p_world_com, [0.0, 0.0, -9.81 * hrp2.mass])
    assert np.abs((moment + weight)[:2]).max() < 2.0


def test_inertia_and_bias_are_pinocchios(hrp2, rng):
    for _ in range(3):
        q, v = random_state(hrp2, rng)
        engine = in_mujoco(hrp2, [], q, v)
        M, bias = _inertia_and_bias(engine, q, v)
        context = hrp2.model.createData()
        upper = np.triu(pin.crba(hrp2.model, context, q))
        assert np.abs(M - (upper + np.triu(upper, 1).T)).max() < 1e-9
        assert np.abs(bias - pin.nonLinearEffects(hrp2.model, context, q, v)).max() < 1e-9


def test_payload_and_scaled_masses_arrive(hrp2, rng):
    robot = hrp2.scaled(1.3).with_payload("right_palm", 2.5, (0.0, 0.0, 0.05))
    q, v = random_state(robot, rng)
    M, _ = _inertia_and_bias(in_mujoco(robot, [], q, v), q, v)
    upper = np.triu(pin.crba(robot.model, robot.model.createData(), q))
    assert np.abs(np.triu(M) - upper).max() < 1e-9


def test_names_and_places_survive_any_order_of_the_file(tmp_path, rng):
    """A URDF whose links and joints are shuffled is the same robot, joint by joint name."""
    shuffled = load_robot(_shuffled_urdf(tmp_path))
    original = get_robot("hrp2")
    q = {name: float(rng.uniform(-0.3, 0.3)) for name in original.joint_names}
    heights = []
    for robot in (original, shuffled):
        configuration = robot.q_half_sitting.copy()
        configuration[7:] = [q[name] for name in robot.joint_names]
        engine = in_mujoco(robot, [], configuration)
        assert engine.model.joint_names == robot.joint_names
        state = engine.step(np.array([q[name] for name in robot.joint_names]))
        heights.append(dict(zip(robot.joint_names, state.q[7:], strict=True)))
    assert heights[0].keys() == heights[1].keys()
    assert max(abs(heights[0][n] - heights[1][n]) for n in q) < 1e-9


def test_joint_names_are_those_of_the_robot(hrp2):
    assert in_mujoco(hrp2, [], hrp2.q_half_sitting).model.joint_names == hrp2.joint_names


@ENGINES
def test_a_push_does_the_work_of_its_generalised_force(hrp2, rng, make):
    """`external` in base axes: the first step's velocity is M^-1 (force - bias) h."""
    q, v = random_state(hrp2, rng)
    v *= 0.0
    engine = make(hrp2, [], q, v)
    engine.external = rng.normal(size=hrp2.nv) * 5.0
    state = engine.step(np.zeros(hrp2.na))
    a = pin.aba(hrp2.model, hrp2.model.createData(), q, v, engine.external)
    assert np.allclose(state.v, a * DT, atol=1e-2 * np.abs(a * DT).max())


@ENGINES
def test_a_lost_number_is_an_error_with_a_time(hrp2, make):
    engine = make(hrp2, [], hrp2.q_half_sitting)
    engine.step(np.zeros(hrp2.na))
    with pytest.raises(DivergedError, match=r"at t = 0\.00"):
        engine.step(np.full(hrp2.na, 1e308))


def _inertia_and_bias(engine, q, v):
    """Return MuJoCo's M (nv, nv) and bias (nv,) in our coordinates, of which v is T^-1 qvel."""
    model, simulated, nv = engine.model.compiled, engine.simulated, len(v)
    M = np.zeros((nv, nv))
    for i, unit in enumerate(np.eye(nv)):
        column = np.zeros(nv)
        mujoco.mj_mulM(model, simulated, column, unit)
        M[:, i] = column
    R = pin.Quaternion(q[3:7]).toRotationMatrix()
    T = np.zeros((nv, nv))
    T[:3, :3], T[3:6, 3:6] = R, np.eye(3)
    T[engine.model.conversion.dof_joints, np.arange(6, nv)] = 1.0
    T_rate_v = np.zeros(nv)
    T_rate_v[:3] = R @ np.cross(v[3:6], v[:3])
    return T.T @ M @ T, T.T @ (simulated.qfrc_bias + M @ T_rate_v)


def _shuffled_urdf(folder: Path) -> Path:
    source = Path(robot_urdf_path("hrp2"))
    root = ElementTree.parse(source).getroot()
    parts = list(root)
    random.Random(3).shuffle(parts)
    root[:] = parts
    for neighbour in source.parent.iterdir():
        if neighbour.suffix in (".srdf", ".yaml"):
            shutil.copy(neighbour, folder / neighbour.name)
    path = folder / "hrp2.urdf"
    ElementTree.ElementTree(root).write(path)
    return path
