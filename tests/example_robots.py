"""Robots of the package example-robot-data as tests complete them: a YAML each, by name."""

from __future__ import annotations

from pathlib import Path

from equipoise.robots import Robot, load_robot

SOURCE = "urdf: {{package: example-robot-data, file: {file}}}\n"
LEGS = ("FL", "FR", "HL", "HR")


def quadruped(feet: dict[str, str], bend: dict[str, float], radius: float) -> str:
    """Return the YAML of a robot on four points."""
    rows = [f"  - {{name: {n}, frame: {f}, radius: {radius}}}" for n, f in feet.items()]
    posture = [f"  {joint}: {angle}" for joint, angle in bend.items()]
    return "\n".join(["feet:", *rows, "half_sitting:", *posture, ""])


FILES = {
    "panda": "robots/panda_description/urdf/panda.urdf",
    "ur5": "robots/ur_description/urdf/ur5_robot.urdf",
    "baxter": "robots/baxter_description/urdf/baxter.urdf",
    "tiago_pro": "robots/tiago_pro_description/robots/tiago_pro.urdf",
    "talos": "robots/talos_data/robots/talos_full_v2.urdf",
    "icub": "robots/icub_description/robots/icub.urdf",
    "anymal": "robots/anymal_b_simple_description/robots/anymal.urdf",
    "solo12": "robots/solo_description/robots/solo12.urdf",
    "go2": "robots/go2_description/urdf/go2.urdf",
    "g1_hands": "robots/g1_description/urdf/g1_29dof_with_hand_rev_1_0.urdf",
}
BALL = "{ixx: 1.0e-3, iyy: 1.0e-3, izz: 1.0e-3, ixy: 0.0, ixz: 0.0, iyz: 0.0}"
POINT_MASSES = ("head", "l_ankle_1", "l_ankle_2", "r_ankle_1", "r_ankle_2", "r_hip_2",
                "r_lower_leg", "r_upper_leg", "l_wrist_1", "r_wrist_1", "neck_1", "neck_2",
                "r_hip_1")  # fmt: skip


def soles(frames: dict[str, str], length: float, width: float) -> str:
    """Return the soles of a biped, each about its frame."""
    size = f"x_min: {-length / 2}, x_max: {length / 2}, y_min: {-width / 2}, y_max: {width / 2}"
    rows = [f"  - {{name: {name}, frame: {frame}, {size}}}" for name, frame in frames.items()]
    return "\n".join(["soles:", *rows, ""])


MORE = {
    "panda": "base: fixed\nhalf_sitting: {panda_joint2: -0.4, panda_joint4: -2.0, "
    "panda_joint6: 1.6, panda_joint7: 0.8}\n",
    "ur5": "half_sitting: {shoulder_lift_joint: -1.2, elbow_joint: 1.6, wrist_1_joint: -1.9, "
    "wrist_2_joint: -1.57}\n",
    "baxter": "base: fixed\nhalf_sitting: {left_s1: -0.5, left_e1: 1.2, left_w1: 0.7, "
    "right_s1: -0.5, right_e1: 1.2, right_w1: 0.7}\n",
    "tiago_pro": 'base: fixed\nlocked: {"wheel_*": 0.0}\n'
    "half_sitting: {arm_left_2_joint: -0.8, arm_left_4_joint: -1.4, arm_right_2_joint: -0.8, "
    "arm_right_4_joint: -1.4}\n",
    "anymal": quadruped(
        {f"{a}{b}": f"{a}{b}_FOOT" for a in "LR" for b in "FH"},
        {
            f"{a}{b}_{joint}": sign * angle
            for a in "LR"
            for b, sign in (("F", 1.0), ("H", -1.0))
            for joint, angle in (("HFE", 0.7), ("KFE", -1.4))
        },
        0.03,
    ),
    "solo12": quadruped(
        {leg: f"{leg}_FOOT" for leg in LEGS},
        {f"{leg}_{joint}": angle for leg in LEGS for joint, angle in (("HFE", 0.8), ("KFE", -1.6))},
        0.0,
    ),
    "go2": quadruped(
        {leg: f"{leg}_foot" for leg in ("FL", "FR", "RL", "RR")},
        {
            f"{leg}_{joint}_joint": angle
            for leg in ("FL", "FR", "RL", "RR")
            for joint, angle in (("thigh", 0.8), ("calf", -1.5))
        },
        0.022,
    ),
    "talos": soles({"left": "left_sole_link", "right": "right_sole_link"}, 0.2, 0.12)
    + "half_sitting: {leg_left_3_joint: -0.4, leg_left_4_joint: 0.8, leg_left_5_joint: -0.4, "
    "leg_right_3_joint: -0.4, leg_right_4_joint: 0.8, leg_right_5_joint: -0.4, "
    "arm_left_2_joint: 0.3, arm_right_2_joint: -0.3, arm_left_4_joint: -0.8, "
    "arm_right_4_joint: -0.8}\n",
    "g1_hands": 'locked: {"*_hand_*": 0.0}\n'
    "frames:\n  - {name: left, on: left_ankle_roll_link, xyz: [0.035, 0.0, -0.035]}\n"
    "  - {name: right, on: right_ankle_roll_link, xyz: [0.035, 0.0, -0.035]}\n"
    + soles({"left": "left", "right": "right"}, 0.17, 0.05)
    + "half_sitting: {left_hip_pitch_joint: -0.35, left_knee_joint: 0.7, "
    "left_ankle_pitch_joint: -0.35, right_hip_pitch_joint: -0.35, right_knee_joint: 0.7, "
    "right_ankle_pitch_joint: -0.35}\n",
    "icub": soles({"left": "l_sole", "right": "r_sole"}, 0.14, 0.06)
    + "inertials:\n"
    + "".join(f"  {link}: {BALL}\n" for link in POINT_MASSES)
    + "half_sitting: {l_hip_pitch: 0.3, l_knee: -0.6, l_ankle_pitch: -0.3, r_hip_pitch: 0.3, "
    "r_knee: -0.6, r_ankle_pitch: -0.3}\n",
}
DEGREES_OF_FREEDOM = {
    "panda": 8, "ur5": 6, "baxter": 17, "tiago_pro": 19, "talos": 32 + 6, "anymal": 18,
    "solo12": 18, "go2": 18, "g1_hands": 29 + 6,
    "icub": 38,
}  # fmt: skip


def write_example(folder: Path, name: str) -> Path:
    """Write the YAML of a robot; return its path."""
    path = folder / f"{name}.yaml"
    path.write_text(f"name: {name}\n" + SOURCE.format(file=FILES[name]) + MORE.get(name, ""))
    return path


def load_example(folder: Path, name: str) -> Robot:
    """Load a robot of the package."""
    return load_robot(write_example(folder, name))
