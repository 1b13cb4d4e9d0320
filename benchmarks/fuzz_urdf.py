"""Mutated robot descriptions: each is refused kindly, or gives a sound robot; never worse.

`python benchmarks/fuzz_urdf.py --count 1500 [--seed 0] [--limit 60]`

HRP-2 and small robots with meshes, each with its YAML (and SRDF), are changed in one to four
places: numbers, attributes, tags, elements, types, names, words, characters, pieces of xacro,
wrappers, meshes and paths. Mutations fall on the URDF, seldom on its companions. Ends with 1 if a
case raised anything but an error of ours, took too long, killed its process, was said in more
than a line, or gave a robot that is not sound.
"""

from __future__ import annotations

import random
import re
import shutil
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin
from fuzzing import main

from equipoise.errors import InputError
from equipoise.robots import check_urdf, load_robot, robot_urdf_path
from equipoise.robots.files.finding import ERROR
from equipoise.robots.robot import Robot

LONGEST_LINE = 1000  # characters of a line of a message
BAD_NUMBERS = (
    "nan", "inf", "-inf", "1e400", "-1e400", "1e308", "1e13", "1e11", "-1", "0", "-0.0", "1e-320",
    "1e-30", "", "abc", "0x10", "1,5", "1_0", "١", "1 2", "NaN(1)", "+", "1e", "--1", "9" * 400,
    "${x}", "$(arg x)",
)  # fmt: skip
PATHS = (
    "part.obj", "../folder/part.obj", "flat.obj", "nan.obj", "../../../etc/passwd", "/etc/passwd",
    "link.obj", "file:///etc/passwd", "package://x/part.obj", "package://folder/part.obj",
    "none.stl", "part.urdf", "\x7f", "a" * 300, "..", "", "http://example.org/a.stl", "empty.stl",
    "part.dae",
)  # fmt: skip
NUMBER = re.compile(r"-?\d+\.?\d*(?:e[+-]?\d+)?(?=[ \"])")
ATTRIBUTE = re.compile(r' (\w+)="([^"]*)"')
TAG = re.compile(r"<(/?)(\w+)[^>]*>")
ELEMENT = re.compile(r"<(\w+)[^>]*/>|<(inertial|link|joint)\b.*?</\2>", re.S)
XACRO = (
    '<xacro:leg prefix="left"/>', '<xacro:property name="a" value="1"/>', "<xacro:if/>",
    '<include filename="x"/>', "<Link name='a'/>", "<group><link name='a'/></group>",
    '<gazebo reference="a"><x>${y}</x></gazebo>', "<![CDATA[${x}]]>", "<a:b xmlns:a='u'/>",
    "<!-- ${x} -->", "<?pi x?>", "<transmission/>", "<mimic joint='x'/>",
)  # fmt: skip
INERTIAL = (
    '<inertial><origin xyz="0.1 0 0" rpy="0 0.1 0"/><mass value="2.0"/>'
    '<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial>'
)
SMALL = f"""<?xml version="1.0"?>
<robot name="two"><material name="red"><color rgba="1 0 0 1"/></material>
<link name="base">{INERTIAL}<collision><geometry><box size="1 1 1"/></geometry></collision></link>
<link name="arm">{INERTIAL}<visual><origin xyz="0 0 1" rpy="0 0 0"/><geometry>
<cylinder radius="0.1" length="1"/></geometry><material name="red"/></visual><collision><geometry>
<mesh filename="part.obj" scale="1 1 1"/></geometry></collision></link>
<link name="tip"/><link name="finger">{INERTIAL}<collision><geometry><sphere radius="0.1"/>
</geometry></collision></link>
<joint name="elbow" type="revolute"><parent link="base"/><child link="arm"/>
<origin xyz="0 0 1" rpy="0 0 0"/><axis xyz="0 1 0"/><dynamics damping="0.1" friction="0"/>
<limit lower="-1.5" upper="1.25" effort="30" velocity="4"/></joint>
<joint name="tip_fixed" type="fixed"><parent link="arm"/><child link="tip"/></joint>
<joint name="slide" type="prismatic"><parent link="tip"/><child link="finger"/><axis xyz="1 0 0"/>
<limit lower="0" upper="0.2" effort="30" velocity="4"/><mimic joint="elbow"/></joint>
</robot>"""
SMALL_YAML = """name: two
camera: tip
soles:
  - {name: foot, frame: base, x_min: -0.1, x_max: 0.1, y_min: -0.1, y_max: 0.1}
palms:
  - {name: hand, frame: finger, skin: 0.01}
half_sitting: {elbow: 0.3}
frames:
  - {name: extra, on: arm, xyz: [0.1, 0.0, 0.0], rpy: [0.0, 0.0, 1.0]}
locked: {slide: 0.1}
limits: {elbow: {velocity: 3.0}}
inertials: {arm: {mass: 1.5}}
parts: {left_arm: arm}
"""
PART = (
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 1 1 1\n"
    "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 5\nf 3 4 5\nf 2 5 4\n"
)


def replaced(text: str, match: re.Match[str], new: str) -> str:
    """Return the text with what matched written anew."""
    return text[: match.start()] + new + text[match.end() :]


def one_of(pattern: re.Pattern[str], text: str, rng: random.Random) -> re.Match[str] | None:
    """Return one of the places that match."""
    found = list(pattern.finditer(text))
    return rng.choice(found) if found else None


def change_number(text: str, rng: random.Random) -> str:
    """Write a wrong number, or one that is far too large or small."""
    match = one_of(NUMBER, text, rng)
    if match is None:
        return text
    scaled = repr(float(match[0]) * rng.choice((-1, 10, 1e3, 1e6, 1e9, 1e-3, 1e-9)))
    return replaced(text, match, rng.choice((*BAD_NUMBERS, scaled, scaled, scaled)))


def change_gently(text: str, rng: random.Random) -> str:
    """Write a number that is a little different."""
    match = one_of(NUMBER, text, rng)
    if match is None:
        return text
    return replaced(text, match, repr(float(match[0]) * rng.uniform(0.7, 1.5)))


def remove_attribute(text: str, rng: random.Random) -> str:
    """Leave an attribute out."""
    match = one_of(ATTRIBUTE, text, rng)
    return text if match is None else replaced(text, match, "")


def swap_attributes(text: str, rng: random.Random) -> str:
    """Exchange the values of two attributes."""
    found = list(ATTRIBUTE.finditer(text))
    if len(found) < 2:
        return text
    first, second = sorted(rng.sample(found, 2), key=lambda m: m.start())
    text = replaced(text, second, f' {second[1]}="{first[2]}"')
    return replaced(text, first, f' {first[1]}="{second[2]}"')


def remove_tag(text: str, rng: random.Random) -> str:
    """Leave a tag out, which leaves XML that is not well-formed, or an empty element."""
    match = one_of(TAG, text, rng)
    return text if match is None else replaced(text, match, "")


def rename_tag(text: str, rng: random.Random) -> str:
    """Write another name for a tag."""
    match = one_of(TAG, text, rng)
    if match is None:
        return text
    new = rng.choice(("x", "link", "joint", "Link", "xacro:link", match[2].upper()))
    return replaced(text, match, match[0].replace(match[2], new, 1))


def remove_element(text: str, rng: random.Random) -> str:
    """Leave an element out."""
    match = one_of(ELEMENT, text, rng)
    return text if match is None else replaced(text, match, "")


def double_element(text: str, rng: random.Random) -> str:
    """Write an element twice."""
    match = one_of(ELEMENT, text, rng)
    return text if match is None else replaced(text, match, match[0] * 2)


def wrap_element(text: str, rng: random.Random) -> str:
    """Put an element inside another, or a piece of xacro before it."""
    match = one_of(ELEMENT, text, rng)
    if match is None:
        return text
    tag = rng.choice(("group", "link", "joint", "gazebo", "xacro:if"))
    wrapped = (f"<{tag}>{match[0]}</{tag}>", rng.choice(XACRO) + match[0])
    return replaced(text, match, rng.choice(wrapped))


def change_type(text: str, rng: random.Random) -> str:
    """Write another type of joint."""
    match = one_of(re.compile(r'type="\w+"'), text, rng)
    kinds = ("fixed", "continuous", "floating", "planar", "prismatic", "spherical", "")
    return text if match is None else replaced(text, match, f'type="{rng.choice(kinds)}"')


def change_name(text: str, rng: random.Random) -> str:
    """Write another name, of something else or of a kind that is awkward."""
    names = [m for m in ATTRIBUTE.finditer(text) if m[1] in ("name", "link", "joint")]
    if not names:
        return text
    match = rng.choice(names)
    awkward = ("", "universe", "root_joint", "a b", "é", "x" * 300, "base", "floor", "world", "a/b",
               "${x}", "a&#10;b", "&lt;b&gt;")  # fmt: skip
    return replaced(text, match, f' {match[1]}="{rng.choice((rng.choice(names)[2], *awkward))}"')


def change_path(text: str, rng: random.Random) -> str:
    """Name another mesh file."""
    match = one_of(re.compile(r'filename="[^"]*"'), text, rng)
    return text if match is None else replaced(text, match, f'filename="{rng.choice(PATHS)}"')


def cut(text: str, rng: random.Random) -> str:
    """Leave the end out."""
    return text[: rng.randrange(len(text) + 1)]


def change_character(text: str, rng: random.Random) -> str:
    """Write another character."""
    place = rng.randrange(len(text) + 1)
    return text[:place] + rng.choice("<>&\"'/=\x00\x01 9-\n\té\U0001f916") + text[place + 1 :]


def change_word(text: str, rng: random.Random) -> str:
    """Write another word."""
    words = list(re.finditer(r"[\w.-]+", text))
    if not words:
        return text
    return replaced(text, rng.choice(words), rng.choice((*BAD_NUMBERS, rng.choice(words)[0])))


Mutation = Callable[[str, random.Random], str]
MUTATIONS: tuple[Mutation, ...] = (
    change_gently, change_gently, change_gently, change_gently, change_gently, change_number,
    change_number, change_number, change_number, remove_attribute, swap_attributes,
    remove_tag, rename_tag, remove_element, double_element, wrap_element, change_type, change_name,
    change_name, change_path, change_word, cut, change_character,
)  # fmt: skip
OF_COMPANIONS: tuple[Mutation, ...] = (
    change_word,
    change_word,
    change_number,
    change_character,
    cut,
)


def write_case(seed: int, folder: Path) -> Path:
    """Write a robot with mutations into a folder; return the path of its URDF."""
    rng = random.Random(seed)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    source = robot_urdf_path("hrp2")
    texts = {".urdf": SMALL, ".yaml": SMALL_YAML}
    if rng.random() < 0.5:
        texts = {
            end: source.with_suffix(end).read_text("utf-8") for end in (".urdf", ".yaml", ".srdf")
        }
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        end = ".urdf" if rng.random() < 0.8 else rng.choice(list(texts))
        kinds = MUTATIONS if end == ".urdf" else OF_COMPANIONS
        texts[end] = rng.choice(kinds)(texts[end], rng)
    for end, text in texts.items():
        (folder / f"robot{end}").write_bytes(text.encode("utf-8", "surrogatepass"))
    (folder / "part.obj").write_text(PART)
    (folder / "flat.obj").write_text(
        PART.replace("v 0 0 1", "v 0 0 0").replace("v 1 1 1", "v 1 1 0")
    )
    (folder / "nan.obj").write_text(PART.replace("v 1 1 1", "v nan 1 1e39"))
    (folder / "empty.stl").write_bytes(b"")
    (folder / "part.dae").write_text("<COLLADA/>")
    (folder / "link.obj").symlink_to("/etc/passwd")
    return folder / "robot.urdf"


def outcome(seed: int, folder: Path) -> str:
    """Return "refused" or "loaded". Raises: what is not an error of ours; `AssertionError`."""
    path = write_case(seed, folder / "folder")
    findings = check_urdf(path)
    errors = [finding for finding in findings if finding.severity == ERROR]
    for finding in findings:
        assert_readable(str(finding))
    try:
        robot = load_robot(path)
    except InputError as error:
        assert_readable(str(error))
        assert errors, "loading refuses what the check finds sound"
        return "refused"
    assert not errors, "loading takes what the check refuses"
    assert_sound(robot)
    return "loaded"


def assert_readable(message: str) -> None:
    """Raise unless a message is a sentence or some, none of them endless."""
    assert len(message) > 20, message
    assert max(len(line) for line in message.splitlines()) < LONGEST_LINE, message[:2000]


def assert_sound(robot: Robot) -> None:
    """Raise unless a robot's matrices and limits can be worked with."""
    matrix = pin.crba(robot.model, robot.model.createData(), robot.q_half_sitting)
    matrix = np.triu(matrix) + np.triu(matrix, 1).T
    assert np.isfinite(matrix).all()
    scale = np.sqrt(np.diag(matrix))
    np.linalg.cholesky(matrix / np.outer(scale, scale))
    assert np.isfinite([robot.q_min, robot.q_max, robot.v_max, robot.tau_max]).all()
    assert (robot.q_min < robot.q_max).all()
    assert min(*robot.v_max, *robot.tau_max) > 0.0
    for shape in robot.collision_model.geometryObjects:
        assert np.isfinite(shape.placement.homogeneous).all()


if __name__ == "__main__":
    sys.exit(main(outcome, "mutated descriptions"))
