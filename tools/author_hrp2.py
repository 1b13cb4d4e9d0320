"""Writes the HRP-2 description (URDF, SRDF, YAML) from the recorded facts in hrp2_parameters.json.

Usage: python tools/author_hrp2.py            rewrite src/equipoise/robots/hrp2/hrp2.*
       python tools/author_hrp2.py --check    say whether the committed files are what this writes

The facts are numbers from public sources (see the JSON's `provenance`); the shapes, the extra
frames and the disabled collision pairs are ours and are explained in docs/robots/hrp2.md.
"""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from itertools import combinations
from math import pi
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
PARAMETERS = ROOT / "tools" / "hrp2_parameters.json"
TARGET = ROOT / "src" / "equipoise" / "robots" / "hrp2"

LIGHT, WHITE, DARK = "light", "white", "dark"
COLOURS = {LIGHT: "0.72 0.74 0.77 1", WHITE: "0.92 0.93 0.94 1", DARK: "0.22 0.23 0.26 1"}
SIDES = "LR"
Facts = dict[str, Any]  # what hrp2_parameters.json says, or of one link or joint
# Link numbers: 2 upper arm, 3 and 4 forearm, 5 hand. The elbow stops at 137 degrees, the wrist at
# 92; an upper arm moves inward by 10 degrees only, so it reaches no part of the other arm but the
# hand and, for the forearm's far half, the other forearm.
SAME_ARM = [(2, 4), (2, 5), (3, 5)]
ACROSS_ARMS = [(2, 2), (2, 3), (3, 3), (2, 4)]
HEAD_PAIRS = {
    frozenset(("BODY", "HEAD_LINK1")),
    frozenset(("LLEG_LINK2", "HEAD_LINK1")),
    frozenset(("RLEG_LINK2", "HEAD_LINK1")),
}
SUMMARY = "HRP-2, 30 joints, 56 kg: the paper's robot, put together from public numbers"
PALM_SKIN = 0.04  # [m] from the hand's middle line to its surface
PARTS = {  # links by the names that all robots share
    "pelvis": "BODY",
    "torso": "CHEST_LINK1",
    "head": "HEAD_LINK1",
    **{
        f"{side}_{part}": f"{side[0].upper()}{link}"
        for part, link in (
            ("upper_arm", "ARM_LINK2"),
            ("hand", "ARM_LINK5"),
            ("thigh", "LEG_LINK2"),
            ("shin", "LEG_LINK3"),
            ("foot", "LEG_LINK5"),
        )
        for side in ("left", "right")
    },
    "left_forearm": "[LARM_LINK3, LARM_LINK4]",
    "right_forearm": "[RARM_LINK3, RARM_LINK4]",
}
AXIS_RPY = {"x": (0.0, pi / 2, 0.0), "y": (-pi / 2, 0.0, 0.0), "z": (0.0, 0.0, 0.0)}


@dataclass(frozen=True)
class Shape:
    """What a link is drawn as, and whether it also collides."""

    kind: str  # "box" or "capsule"
    colour: str
    collides: bool


CENTRAL_SHAPES = {
    "BODY": Shape("box", LIGHT, True),
    "CHEST_LINK0": Shape("box", DARK, False),
    "CHEST_LINK1": Shape("box", WHITE, True),
    "HEAD_LINK0": Shape("box", DARK, False),
    "HEAD_LINK1": Shape("box", WHITE, True),
}
SIDE_SHAPES = {
    "LEG_LINK0": Shape("capsule", DARK, False),
    "LEG_LINK1": Shape("capsule", DARK, False),
    "LEG_LINK2": Shape("capsule", WHITE, True),
    "LEG_LINK3": Shape("capsule", LIGHT, True),
    "LEG_LINK4": Shape("capsule", DARK, False),
    "LEG_LINK5": Shape("box", DARK, True),
    "ARM_LINK0": Shape("capsule", DARK, False),
    "ARM_LINK1": Shape("capsule", DARK, False),
    "ARM_LINK2": Shape("capsule", WHITE, True),
    "ARM_LINK3": Shape("capsule", LIGHT, True),
    "ARM_LINK4": Shape("capsule", WHITE, True),
    "ARM_LINK5": Shape("capsule", DARK, True),
    "ARM_LINK6": Shape("capsule", LIGHT, False),
}


def shape_of(link: str) -> Shape:
    """Return the shape of a link; the table for the sides leaves out the leading L or R."""
    return CENTRAL_SHAPES.get(link) or SIDE_SHAPES[link[1:]]


def number(value: float) -> str:
    """Write a number as short as it can be read back exactly."""
    value = float(value)
    return str(int(value)) if value == int(value) and abs(value) < 1e6 else repr(value)


def numbers(values: tuple[float, ...] | list[float]) -> str:
    """Write numbers with spaces between them."""
    return " ".join(number(value) for value in values)


def fitted_geometry(link: Facts, kind: str) -> str:
    """Return the <origin> and <geometry> of a primitive inside a link's bounding box.

    A box is the bounding box. A capsule lies along the longest side; its radius is half the
    shortest, and its ends touch the box, so the cylinder written here is longest - shortest long.
    """
    low, high = link["mesh_aabb_min"], link["mesh_aabb_max"]
    centre = [round((a + b) / 2, 6) for a, b in zip(low, high, strict=True)]
    size = [round(b - a, 6) for a, b in zip(low, high, strict=True)]
    if kind == "box":
        return (
            f'<origin xyz="{numbers(centre)}" rpy="0 0 0"/>'
            f'<geometry><box size="{numbers(size)}"/></geometry>'
        )
    axis = "xyz"[size.index(max(size))]
    radius, length = round(min(size) / 2, 6), round(max(size) - min(size), 6)
    return (
        f'<origin xyz="{numbers(centre)}" rpy="{numbers(AXIS_RPY[axis])}"/>'
        f'<geometry><cylinder radius="{number(radius)}" length="{number(length)}"/></geometry>'
    )


def link_xml(link: Facts) -> str:
    """Return the <link> element of a link with mass."""
    inertia = " ".join(f'{k}="{number(v)}"' for k, v in link["inertia_about_com"].items())
    shape = shape_of(link["name"])
    geometry = fitted_geometry(link, shape.kind)
    rows = [
        f'  <link name="{link["name"]}">',
        f'    <inertial><origin xyz="{numbers(link["com"])}" rpy="0 0 0"/>'
        f'<mass value="{number(link["mass"])}"/>',
        f"      <inertia {inertia}/></inertial>",
        f'    <visual>{geometry}<material name="{shape.colour}"/></visual>',
    ]
    if shape.collides:
        rows.append(f"    <collision>{geometry}</collision>")
    return "\n".join([*rows, "  </link>"])


def joint_xml(joint: Facts) -> str:
    """Return the <joint> element of an actuated joint."""
    return "\n".join(
        [
            f'  <joint name="{joint["name"]}" type="revolute">',
            f'    <parent link="{joint["parent"]}"/><child link="{joint["child"]}"/>',
            f'    <origin xyz="{numbers(joint["origin_xyz"])}" rpy="0 0 0"/>'
            f'<axis xyz="{numbers(joint["axis"])}"/>',
            f'    <limit lower="{number(joint["lower_rad"])}" upper="{number(joint["upper_rad"])}"'
            f' velocity="{number(joint["velocity_rad_s"])}"'
            f' effort="{number(joint["effort_nm"])}"/>',
            "  </joint>",
        ]
    )


def frame_xml(name: str, parent: str, xyz: tuple[float, ...], rpy: tuple[float, ...]) -> str:
    """Return a massless link fixed to a parent link: a named frame."""
    return "\n".join(
        [
            f'  <link name="{name}"/>',
            f'  <joint name="{name}_fixed" type="fixed">',
            f'    <parent link="{parent}"/><child link="{name}"/>',
            f'    <origin xyz="{numbers(xyz)}" rpy="{numbers(rpy)}"/>',
            "  </joint>",
        ]
    )


def extra_frames(facts: Facts) -> list[str]:
    """Return the soles, palms and camera.

    Palm axes: x along the fingers (-z of the hand), z the palm's inward normal (-y of the left
    hand, +y of the right one), y completes the right-handed frame.
    """
    sole = tuple(facts["feet"]["sole_frame_in_foot_link"])
    palm = tuple(facts["hands"]["contact_offsets_seen_in_wrist_frame"]["hpp_rbprm_most_used"])
    foot, hand = facts["feet"]["foot_link"], facts["hands"]["hand_link"]
    return [
        frame_xml("left_sole", foot["left"], sole, (0, 0, 0)),
        frame_xml("right_sole", foot["right"], sole, (0, 0, 0)),
        frame_xml("left_palm", hand["left"], palm, (pi / 2, pi / 2, 0)),
        frame_xml("right_palm", hand["right"], palm, (-pi / 2, pi / 2, 0)),
        frame_xml("camera", "HEAD_LINK1", (0.10, 0, 0.12), (0, 0, 0)),
    ]


def urdf(facts: Facts) -> str:
    """Return the text of hrp2.urdf."""
    materials = [
        f'  <material name="{name}"><color rgba="{rgba}"/></material>'
        for name, rgba in COLOURS.items()
    ]
    return "\n".join(
        [
            '<?xml version="1.0" encoding="utf-8"?>',
            "<!-- Written by tools/author_hrp2.py from tools/hrp2_parameters.json: do not edit.",
            "     Units: m, kg, rad, N m. Every <cylinder> stands for a capsule: a half ball of",
            "     the same radius is added at each end (hrp2.yaml: cylinders_are_capsules). -->",
            '<robot name="hrp2">',
            *materials,
            *(link_xml(link) for link in facts["links"]),
            *(joint_xml(joint) for joint in facts["joints"]),
            *extra_frames(facts),
            "</robot>",
            "",
        ]
    )


def colliding_links(facts: Facts) -> list[str]:
    """Return the names of the links with a collision shape, in file order."""
    return [link["name"] for link in facts["links"] if shape_of(link["name"]).collides]


def neighbours(facts: Facts) -> set[frozenset[str]]:
    """Return the pairs of colliding links with no colliding link between them in the tree."""
    parent = {joint["child"]: joint["parent"] for joint in facts["joints"]}
    colliding = set(colliding_links(facts))
    pairs = set()
    for link in colliding:
        above = parent.get(link)
        while above is not None and above not in colliding:
            above = parent.get(above)
        if above is not None:
            pairs.add(frozenset((link, above)))
    return pairs


def never_touch(first: str, second: str) -> bool:
    """Say whether two links are out of each other's reach at any joint angles within limits.

    tests/robots/test_hrp2.py searches for counter-examples.
    """
    pair = frozenset((first, second))
    same_arm = {frozenset((a, b)) for s in SIDES for a, b in _on_arm(s, s, SAME_ARM)}
    across = {
        frozenset((a, b))
        for s, t in (("L", "R"), ("R", "L"))
        for a, b in _on_arm(s, t, ACROSS_ARMS)
    }
    return pair in same_arm | across | HEAD_PAIRS


def _on_arm(first: str, second: str, link_numbers: list[tuple[int, int]]) -> list[tuple[str, str]]:
    return [(f"{first}ARM_LINK{i}", f"{second}ARM_LINK{j}") for i, j in link_numbers]


def disabled_pairs(facts: Facts) -> list[tuple[str, str, str]]:
    """Return (link, link, reason) of the collision pairs to leave out."""
    adjacent = neighbours(facts)
    rows = []
    for first, second in combinations(colliding_links(facts), 2):
        if frozenset((first, second)) in adjacent:
            rows.append((first, second, "Adjacent"))
        elif never_touch(first, second):
            rows.append((first, second, "Never"))
    return rows


def srdf(facts: Facts) -> str:
    """Return the text of hrp2.srdf."""
    angles = facts["half_sitting"]
    joints = [joint["name"] for joint in facts["joints"]]
    return "\n".join(
        [
            '<?xml version="1.0" encoding="utf-8"?>',
            "<!-- Written by tools/author_hrp2.py: do not edit. -->",
            '<robot name="hrp2">',
            '  <group name="whole_body">',
            *(f'    <joint name="{name}"/>' for name in joints),
            "  </group>",
            '  <group_state name="half_sitting" group="whole_body">',
            *(f'    <joint name="{n}" value="{number(angles[n])}"/>' for n in joints),
            "  </group_state>",
            *(
                f'  <disable_collisions link1="{a}" link2="{b}" reason="{reason}"/>'
                for a, b, reason in disabled_pairs(facts)
            ),
            "</robot>",
            "",
        ]
    )


def extras(facts: Facts) -> str:
    """Return the text of hrp2.yaml."""
    rows = [
        "# Written by tools/author_hrp2.py: do not edit. Units: m.",
        "name: hrp2",
        "cylinders_are_capsules: true",
        "soles:",
    ]
    for side, rectangle in facts["feet"]["sole_rect_laas_controller"].items():
        rows += [f"  - name: {side}_sole", f"    frame: {side}_sole"]
        rows += [f"    {key}: {number(value)}" for key, value in rectangle.items()]
    rows.append("palms:")
    for side in ("left", "right"):
        rows += [f"  - name: {side}_palm", f"    frame: {side}_palm", f"    skin: {PALM_SKIN}"]
    rows += ["camera: camera", f'summary: "{SUMMARY}"', "parts:"]
    rows += [f"  {part}: {links}" for part, links in PARTS.items()]
    return "\n".join([*rows, ""])


def author(facts: Facts) -> dict[str, str]:
    """Return file name -> text of the three files."""
    return {"hrp2.urdf": urdf(facts), "hrp2.srdf": srdf(facts), "hrp2.yaml": extras(facts)}


def main(arguments: list[str]) -> int:
    """Write the files, or with --check compare them with what is there."""
    files = author(json.loads(PARAMETERS.read_text(encoding="utf-8")))
    if arguments == ["--check"]:
        stale = [n for n, t in files.items() if (TARGET / n).read_bytes() != t.encode()]
        print(f"Stale: {', '.join(stale)}" if stale else "Up to date.")
        return 1 if stale else 0
    TARGET.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (TARGET / name).write_bytes(text.encode())
        print(f"Wrote {(TARGET / name).relative_to(ROOT)}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
