"""A robot of one's own: a small biped written as URDF here, checked, loaded, and run.

Each leg has six joints; the whole body weighs 14 kg. The YAML beside the URDF says what a URDF
cannot: where the soles are, and the half-sitting posture. Then a short scenario squats.
"""

from __future__ import annotations

import sys
from pathlib import Path

from equipoise import Run, get_robot, run_scenario
from equipoise.robots import check_urdf

LINK = """<link name="{name}"><inertial><origin xyz="0 0 {z}"/><mass value="{mass}"/>
  <inertia ixx="{i}" iyy="{i}" izz="{i}" ixy="0" ixz="0" iyz="0"/></inertial>{shape}</link>"""
BOX = '<collision><geometry><box size="0.1 0.1 0.05"/></geometry></collision>'
JOINT = """<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>
  <origin xyz="0 {y} {z}"/><axis xyz="{axis}"/>
  <limit lower="-1.8" upper="1.8" velocity="8" effort="120"/></joint>"""
LEG = (  # joint, axis, height of the joint above the one before [m], mass of its link [kg]
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
duration: 2.0
contacts:
  left: {{kind: sole, sole: left}}
  right: {{kind: sole, sole: right}}
tasks:
  com: {{kind: com_polygon, margin: 0.02, priority: 1}}
  limits: {{kind: joint_limits, priority: 1}}
  torso:
    {{kind: frame_way, frame: torso, priority: 2, waypoints: [{{t: 0.3, xyz: [0.0, 0.0, 0.5]}},
      {{t: 1.0, xyz: [0.0, 0.0, 0.42]}}, {{t: 1.8, xyz: [0.0, 0.0, 0.5]}}]}}
  posture: {{kind: posture, priority: 3}}
"""


def urdf() -> str:
    """Return the biped as URDF text."""
    parts = [LINK.format(name="torso", z=0.1, mass=6.0, i=0.05, shape=BOX)]
    for side, y in (("left", 0.08), ("right", -0.08)):
        parent = "torso"
        for name, axis, z, mass in LEG:
            child = f"{side}_{name}"
            at = y if parent == "torso" else 0.0
            shape = BOX if name == "ankle_roll" else ""
            joint = {"name": f"{child}_joint", "parent": parent, "child": child, "axis": axis}
            parts.append(JOINT.format(y=at, z=z, **joint))
            parts.append(LINK.format(name=child, z=-0.02, mass=mass, i=0.005, shape=shape))
            parent = child
    return '<robot name="biped">' + "\n".join(parts) + "</robot>"


def extras() -> str:
    """Return the YAML beside it: soles and the half-sitting posture."""
    size = "x_min: -0.08, x_max: 0.12, y_min: -0.05, y_max: 0.05"
    sides = ("left", "right")
    lines = ["soles:", *(f"  - {{name: {s}, frame: {s}_ankle_roll, {size}}}" for s in sides)]
    bend = {"hip_pitch": -0.4, "knee": 0.8, "ankle_pitch": -0.4}
    lines += ["half_sitting:", *(f"  {s}_{j}_joint: {a}" for s in sides for j, a in bend.items())]
    return "\n".join(lines) + "\n"


def main(folder: str = "runs/biped") -> Run:
    """Write, check, load and run the biped."""
    place = Path(folder)
    place.mkdir(parents=True, exist_ok=True)
    path = place / "biped.urdf"
    path.write_text(urdf(), encoding="utf-8")
    path.with_suffix(".yaml").write_text(extras(), encoding="utf-8")
    print("\n".join(map(str, check_urdf(path))) or "nothing to complain about")
    print(get_robot(path))
    scenario = place / "squat.yaml"
    scenario.write_text(SCENARIO.format(urdf=path), encoding="utf-8")
    run = run_scenario(str(scenario), out=place / "run", figures=False)
    for name in ("posture_error", "com_margin", "torque_share", "reaction_pressure"):
        row = run.summary["metrics"][name]
        print(f"{name:<18}{row['value']:.2e} {row['unit']}")
    return run


if __name__ == "__main__":
    main(*sys.argv[1:])
