"""Models for MuJoCo as they come in wheels: nothing is downloaded; they stand or reach."""

from __future__ import annotations

import json
from importlib import metadata
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from equipoise import WholeBodyController, run_scenario
from equipoise.robots import load_robot
from equipoise.robots.dynamics import JointDynamics
from equipoise.spatial import pose
from equipoise.tasks import FramePoseTask, PostureTask

mujoco = pytest.importorskip("mujoco")

from equipoise.adapters.mujoco import MujocoAdapter  # noqa: E402
from equipoise.physics.mujoco.library import load_mujoco  # noqa: E402


def models_of(package: str, ending: str) -> dict[str, Path]:
    """Return by name the files of a package that end so; none if it is not installed."""
    try:
        files = metadata.files(package) or []
    except metadata.PackageNotFoundError:
        return {}
    found = [Path(str(file.locate())) for file in files if str(file).endswith(ending)]
    return {path.stem: path.resolve() for path in found}


GYM = {n: p for n, p in models_of("gymnasium", ".xml").items() if p.parent.name == "assets"}
OPENARM = models_of("openarm-mujoco", "openarm_bimanual.xml")
ALL = {**GYM, **OPENARM}


def folded(robot, model, q):
    """Return where MuJoCo has the robot at q, and how its velocities are ours: `qvel = B v`."""
    data, B = mujoco.MjData(model), np.zeros((model.nv, robot.nv))
    laws = {name: (name, 1.0, 0.0) for name in robot.joint_names} | dict(robot.followers)
    if robot.nv_base:
        data.qpos[:7] = q[[0, 1, 2, 6, 3, 4, 5]]
        B[:3, :3], B[3:6, 3:6] = pin.Quaternion(q[3:7]).toRotationMatrix(), np.eye(3)
    for name, (leader, ratio, offset) in laws.items():
        k = robot.joint_index(leader)
        data.joint(name).qpos[0] = ratio * q[robot.nq_base + k] + offset
        B[int(model.joint(name).dofadr[0]), robot.nv_base + k] = ratio
    return data, B


@pytest.mark.parametrize("name", sorted(ALL))
def test_inertia_and_bias_are_mujocos(name):
    """At 100 random states, of the robot as it is loaded: what follows is folded by its law."""
    path = ALL[name]
    robot, model = load_robot(path), mujoco.MjModel.from_xml_path(str(path))
    if (
        robot.nv_base
    ):  # no rotor turns in a free joint: loading takes that armature out, and says so
        model.dof_armature[:6] = 0.0
    model.opt.gravity[:] = 0.0, 0.0, -9.81
    dynamics, rng = JointDynamics(robot.model), np.random.default_rng(7)
    assert robot.nv + len(robot.followers) == model.nv
    names = [model.joint(j).name for j in range(model.njnt)]
    if "" in names:
        pytest.skip("its joints have no names to find them by")
    for _ in range(100):
        q = pin.integrate(robot.model, pin.neutral(robot.model), rng.normal(size=robot.nv))
        v = rng.normal(size=robot.nv)
        data, B = folded(robot, model, q)
        data.qvel[:], data.eq_active[:] = B @ v, 0
        mujoco.mj_forward(model, data)
        M_theirs = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, M_theirs)
        drift = np.zeros(model.nv)
        if robot.nv_base:
            drift[:3] = B[:3, :3] @ np.cross(v[3:6], v[:3])
        M, h = B.T @ M_theirs @ B, B.T @ (data.qfrc_bias + M_theirs @ drift)
        assert np.abs(dynamics.inertia(q) - M).max() <= 1e-9 * max(np.abs(M).max(), 1e-6)
        assert np.abs(dynamics.bias(q, v) - h).max() <= 1e-9 * max(np.abs(h).max(), 1e-3)


@pytest.mark.slow
@pytest.mark.skipif(not OPENARM, reason="openarm-mujoco is not installed")
def test_openarm_reaches_and_opens_a_gripper_in_its_own_model():
    """Its fingers are two joints that an equality ties: one coordinate, one torque."""
    (path,) = OPENARM.values()
    spec = mujoco.MjSpec.from_file(str(path))
    for actuator in list(spec.actuators):  # servos ask for positions
        spec.delete(actuator)
    model, robot = spec.compile(), load_robot(path)
    model.opt.timestep = 1e-3
    q = robot.q_half_sitting.copy()
    for name in robot.joint_names:
        if name.endswith("joint4"):
            q[robot.joint_index(name)] = 1.0
    finger = robot.joint_index("openarm_left_finger_joint1")
    wanted = q.copy()
    wanted[finger] = np.clip(q[finger] - 0.3, robot.q_min[finger], robot.q_max[finger])
    if abs(wanted[finger] - q[finger]) < 0.1:
        wanted[finger] = np.clip(q[finger] + 0.3, robot.q_min[finger], robot.q_max[finger])
    start = robot.at(q).placement("left_ee_control_point")
    T = pose((0.03, 0.05, 0.06)) * start
    data, world = mujoco.MjData(model), MujocoAdapter(robot, model)
    world.place(data, q)
    controller = WholeBodyController.fixed(
        robot, q,
        tasks=[FramePoseTask("hand", "left_ee_control_point", T, rate=4.0),
               PostureTask("fingers", robot, wanted, rate=3.0)],
    )  # fmt: skip
    for k in range(2000):
        state = world.from_mujoco(data)
        world.apply(data, controller.step(k * 1e-3, *state).tau)
        mujoco.mj_step(model, data)
    there = robot.at(world.from_mujoco(data).q).placement("left_ee_control_point")
    assert np.linalg.norm(there.translation - T.translation) < 2e-3
    one, other = (data.joint(f"openarm_left_finger_joint{i}").qpos[0] for i in (1, 2))
    assert one == pytest.approx(wanted[finger], abs=0.01)
    assert abs(one - other) < 0.01


ANT = """
mjcf: {path}
name: ant
frames:
{frames}
feet:
{feet}
half_sitting: {{ankle_1: 1.0, ankle_2: -1.0, ankle_3: -1.0, ankle_4: 1.0}}
limits: {limits}
"""
LEGS = {
    "body_4": (0.4, 0.4),
    "body_7": (-0.4, 0.4),
    "body_10": (-0.4, -0.4),
    "body_13": (0.4, -0.4),
}


@pytest.mark.slow
@pytest.mark.skipif("ant" not in GYM, reason="gymnasium has no ant")
@pytest.mark.parametrize("engine", ["rigid", "mujoco"])
def test_the_ant_of_gymnasium_stands_on_four_points(tmp_path, engine):
    """Each of its feet goes in a plane of its own, so that standing is all that it can do."""
    load_mujoco()
    frames = "\n".join(
        f"  - {{name: foot_{b}, on: {b}, xyz: [{x}, {y}, 0.0]}}" for b, (x, y) in LEGS.items()
    )
    feet = "\n".join(f"  - {{name: {b}, frame: foot_{b}, radius: 0.08}}" for b in LEGS)
    (tmp_path / "ant.xml").write_text(GYM["ant"].read_text())
    yaml = tmp_path / "ant.yaml"
    yaml.write_text(ANT.format(path="ant.xml", frames=frames, feet=feet, limits="{}"))
    robot = load_robot(yaml)
    scenario = {
        "name": "try", "robot": str(yaml), "duration": 1.5, "physics": {"engine": engine},
        "contacts": {foot.name: {"kind": "foot", "foot": foot.name} for foot in robot.feet},
        "control": {"start": "standing"},
        "tasks": {
            "limits": {"kind": "joint_limits", "priority": 1},
            "posture": {"kind": "posture", "priority": 3},
        },
    }  # fmt: skip
    (tmp_path / "try.yaml").write_text(json.dumps(scenario))
    finished = run_scenario(str(tmp_path / "try.yaml"), out=tmp_path / "run", figures=False)
    values = {key: row["value"] for key, row in finished.metrics.items()}
    assert values["completed"] == 1.0, values
    assert values["mode_worst"] == 0.0, values
    T = robot.at(robot.q_half_sitting).placement("torso").translation
    height = np.array([robot.at(q).placement("torso").translation[2] for q in finished["q"][::50]])
    assert np.abs(height - T[2]).max() < 1e-3, values
    assert values["posture_error"] < 2e-3, values
    assert values["reaction_normal"] > 0.0, values
