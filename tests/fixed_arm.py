"""A robot whose base is fixed to the world, small enough to see through."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

from equipoise.robots import Robot, load_robot


def small_arm() -> Robot:
    """Return a robot with a fixed base: two links that swing and one that slides."""
    links = "".join(
        f'<link name="link{k}"><inertial><origin xyz="0.15 0 0.02"/><mass value="2"/>'
        '<inertia ixx="0.02" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        for k in range(3)
    )
    kinds = ("revolute", "0 0 1", "0 0 0.5", 2.0), ("revolute", "0 1 0", "0.3 0 0", 1.5)
    kinds = (*kinds, ("prismatic", "0 0 1", "0.3 0 0", 0.3))
    parents = "mount", "link0", "link1"
    joints = "".join(
        f'<joint name="joint{k}" type="{kind}"><parent link="{parent}"/><child link="link{k}"/>'
        f'<origin xyz="{place}"/><axis xyz="{axis}"/>'
        f'<limit lower="{-end}" upper="{end}" velocity="3" effort="80"/></joint>'
        for k, (parent, (kind, axis, place, end)) in enumerate(zip(parents, kinds, strict=True))
    )
    tip = (
        '<link name="tip"/><joint name="tip_mount" type="fixed"><parent link="link2"/>'
        '<child link="tip"/><origin xyz="0.1 0 0"/></joint>'
    )
    with TemporaryDirectory() as folder:
        urdf = Path(folder) / "arm.urdf"
        urdf.write_text(f'<robot name="arm"><link name="mount"/>{links}{joints}{tip}</robot>')
        urdf.with_suffix(".yaml").write_text(
            "name: arm\nbase: fixed\nhalf_sitting: {joint0: 0.3, joint1: 0.4, joint2: 0.05}\n"
        )
        return load_robot(urdf)


def arm_in_mujoco(at: str = "0 0 0", turned: str = "1 0 0 0") -> str:
    """Return the same arm as an MJCF, its base at a place, with a ball as tip, and a table."""
    inertial = '<inertial pos="0.15 0 0.02" mass="2" diaginertia="0.02 0.02 0.02"/>'
    return f"""
<mujoco>
  <worldbody>
    <geom name="table" type="box" size="0.2 0.2 0.05" pos="0 0 -10"/>
    <body pos="{at}" quat="{turned}">
      <body pos="0 0 0.5">
        <joint name="joint0" axis="0 0 1"/>{inertial}
        <body pos="0.3 0 0">
          <joint name="joint1" axis="0 1 0"/>{inertial}
          <body pos="0.3 0 0">
            <joint name="joint2" type="slide" axis="0 0 1"/>{inertial}
            <geom type="sphere" size="0.02" pos="0.1 0 0"/>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>"""
