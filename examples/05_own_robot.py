"""A robot of one's own: a small biped written as URDF here, checked, loaded, and run.

The YAML beside the URDF says what a URDF cannot: soles and half-sitting. Then a scenario squats.
"""

from __future__ import annotations

import sys
from pathlib import Path

from equipoise import Run, get_robot, run_scenario
from equipoise.robots import check_urdf

LINK = """<link name="{name}"><inertial><origin xyz="0 0 {z}"/><mass value="{mass}"/>
  <inertia ixx="{i}" iyy="{i}" izz="{i}" ixy="0" ixz="0" iyz="0"/></inertial>{shape}</link>"""
BOX = '<collision><geometry><box size="0.1 0.1 0.05"/></geometry></collision>'
JOINT = """<joint name="{child}_joint" type="revolute"><parent link="{parent}"/>
  <child link="{child}"/><origin xyz="0 {y} {z}"/><axis xyz="{axis}"/>
  <limit lower="-1.8" upper="1.8" velocity="8" effort="120"/></joint>"""
LEG = (  # joint, axis, height above the joint before [m], mass of the link [kg]
    ("hip_yaw", "0 0 1", -0.05, 0.3),
    ("hip_roll", "1 0 0", 0.0, 0.3),
    ("hip_pitch", "0 1 0", 0.0, 1.5),
    ("knee", "0 1 0", -0.25, 1.2),
    ("ankle_pitch", "0 1 0", -0.25, 0.2),
    ("ankle_roll", "1 0 0", 0.0, 0.5),
)
SCENARIO = """
name: squat
robot: {urdf}
duration: 1.2
contacts: {{left: {{kind: sole, sole: left}}, right: {{kind: sole, sole: right}}}}
tasks:
  com: {{kind: com_polygon, margin: 0.02, priority: 1}}
  limits: {{kind: joint_limits, priority: 1}}
  torso:
    {{kind: frame_path, frame: torso, priority: 2, waypoints: [{{t: 0.1, xyz: [0.0, 0.0, 0.5]}},
      {{t: 0.6, xyz: [0.0, 0.0, 0.42]}}, {{t: 1.1, xyz: [0.0, 0.0, 0.5]}}]}}
  posture: {{kind: posture, priority: 3}}
"""


def urdf() -> str:
    parts = [LINK.format(name="torso", z=0.1, mass=6.0, i=0.05, shape=BOX)]
    for side, y in (("left", 0.08), ("right", -0.08)):
        parent = "torso"
        for name, axis, z, mass in LEG:
            child = f"{side}_{name}"
            parts.append(JOINT.format(parent=parent, child=child, axis=axis, y=y, z=z))
            shape = BOX if name == "ankle_roll" else ""
            parts.append(LINK.format(name=child, z=-0.02, mass=mass, i=0.005, shape=shape))
            parent, y = child, 0.0
    return '<robot name="biped">' + "\n".join(parts) + "</robot>"


def extras() -> str:
    size = "x_min: -0.08, x_max: 0.12, y_min: -0.05, y_max: 0.05"
    bend = {"hip_pitch": -0.4, "knee": 0.8, "ankle_pitch": -0.4}
    sides = ("left", "right")
    soles = [f"  - {{name: {s}, frame: {s}_ankle_roll, {size}}}" for s in sides]
    posture = [f"  {s}_{joint}_joint: {angle}" for s in sides for joint, angle in bend.items()]
    return "\n".join(["soles:", *soles, "half_sitting:", *posture])


def main(folder: str = "runs/biped") -> Run:
    """Write, check, load and run the biped."""
    path = Path(folder) / "biped.urdf"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(urdf(), encoding="utf-8")
    path.with_suffix(".yaml").write_text(extras(), encoding="utf-8")
    print(get_robot(path), "findings:", *check_urdf(path))
    scenario = path.with_name("squat.yaml")
    scenario.write_text(SCENARIO.format(urdf=path), encoding="utf-8")
    run = run_scenario(str(scenario), out=path.with_name("run"), figures=False)
    print({name: row["value"] for name, row in run.metrics.items()})
    return run


if __name__ == "__main__":
    main(*sys.argv[1:])
