"""Arms that tests write: a chain of links with one palm, as URDF."""

from __future__ import annotations

from pathlib import Path

AXES = ("0 0 1", "0 1 0", "0 1 0", "0 0 1", "0 1 0", "1 0 0")
LINK = """<link name="{name}"><inertial><origin xyz="0.01 0 {z}"/><mass value="{mass}"/>
  <inertia ixx="{i}" iyy="{i}" izz="{small}" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
JOINT = """<joint name="joint{k}" type="revolute"><parent link="link{k0}"/><child link="link{k}"/>
  <origin xyz="0 0 {z}"/><axis xyz="{axis}"/>
  <limit lower="-2.8" upper="2.8" velocity="5" effort="150"/></joint>"""


def arm_urdf(name: str = "arm") -> str:
    """Return a six-joint arm of 0.25 m links, whose heavy first link is `link0`."""
    parts = [LINK.format(name="link0", z=0.05, mass=8.0, i=0.06, small=0.05)]
    for k, axis in enumerate(AXES, start=1):
        mass = 3.0 - 0.4 * k
        parts.append(JOINT.format(k=k, k0=k - 1, z=0.1 if k == 1 else 0.22, axis=axis))
        parts.append(LINK.format(name=f"link{k}", z=0.1, mass=mass, i=0.02 * mass, small=0.008))
    return f'<robot name="{name}">' + "\n".join(parts) + "</robot>"


ARM_YAML = """
base: {base}
frames: [{{name: hand, on: link6, xyz: [0.0, 0.0, 0.1]}}]
half_sitting: {{joint2: 0.6, joint3: 0.9, joint5: 0.7}}
"""


def write_arm(folder: Path, base: str) -> Path:
    """Write the arm and its YAML; return the path of the URDF."""
    path = folder / f"arm_{base}.urdf"
    path.write_text(arm_urdf(), encoding="utf-8")
    path.with_suffix(".yaml").write_text(ARM_YAML.format(base=base), encoding="utf-8")
    return path
