"""Each kind of bad description is refused by name, with the value and a remedy."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from equipoise.errors import RobotFileError
from equipoise.robots import check_urdf, load_robot, robot_urdf_path
from equipoise.robots.files.check_tree import MAX_DEPTH, MAX_JOINTS
from equipoise.robots.files.description import MAX_BYTES
from equipoise.robots.files.finding import ERROR, WARNING

INERTIAL = (
    '<inertial><origin xyz="0.1 0 0"/><mass value="2.0"/>'
    '<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial>'
)
GOOD = f"""<robot name="two">
<link name="base">{INERTIAL}<collision><geometry><box size="1 1 1"/></geometry></collision></link>
<link name="arm">{INERTIAL}<visual><geometry><cylinder radius="0.1" length="1"/></geometry></visual>
</link>
<link name="tip"/>
<joint name="elbow" type="revolute"><parent link="base"/><child link="arm"/>
<origin xyz="0 0 1" rpy="0 0 0"/><axis xyz="0 1 0"/>
<limit lower="-1.5" upper="1.25" effort="30" velocity="4"/></joint>
<joint name="tip_fixed" type="fixed"><parent link="arm"/><child link="tip"/></joint>
</robot>"""


def write(folder: Path, text: str, name: str = "two.urdf") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def refusal(folder: Path, text: str) -> str:
    """Return the message of the refusal, after checking that check_urdf says it too."""
    path = write(folder, text)
    with pytest.raises(RobotFileError) as caught:
        load_robot(path)
    assert any(finding.severity == ERROR for finding in check_urdf(path))
    return str(caught.value)


def test_the_good_one_loads_without_errors(tmp_path: Path) -> None:
    path = write(tmp_path, GOOD)
    robot = load_robot(path)
    assert (robot.name, robot.na, robot.mass) == ("two", 1, 4.0)
    findings = check_urdf(path)
    assert [finding.severity for finding in findings] == [WARNING]
    assert "two.yaml" in str(findings[0])


def test_hrp2_has_no_findings() -> None:
    assert check_urdf(robot_urdf_path("hrp2")) == []


ARM = GOOD.index('<link name="arm">')
REFUSED = {
    "mass nan": ('value="2.0"', 'value="nan"', "link 'base'.*mass.*finite.*'nan'"),
    "mass zero": ('value="2.0"', 'value="0"', "link 'base'.*mass must be positive.*'0'"),
    "mass negative": ('value="2.0"', 'value="-3"', "mass must be positive.*'-3'"),
    "mass word": ('value="2.0"', 'value="heavy"', "not a finite number.*'heavy'"),
    "mass absent": ('<mass value="2.0"/>', "", "link 'base'.*<mass> is missing"),
    "mass huge": ('value="2.0"', 'value="1e300"', "too large"),
    "inertia negative": ('ixx="0.02"', 'ixx="-0.02"', "not positive definite.*-0.02"),
    "inertia indefinite": ('ixy="0"', 'ixy="0.03"', "link 'base'.*not positive definite"),
    "inertia of no body": ('izz="0.02"', 'izz="0.05"', "no body has this inertia.*0.05"),
    "inertia twice": ("<inertial>", INERTIAL + "<inertial>", "<inertial> is given 2 times"),
    "inertia zero": ('ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"',
                     'ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"', "not positive definite"),
    "no inertial": (INERTIAL, "", "link 'base'.*moving link without mass"),
    "limits exchanged": ('lower="-1.5"', 'lower="2"', "joint 'elbow'.*lower must be below upper"),
    "limits equal": ('lower="-1.5"', 'lower="1.25"', "lower must be below upper.*1.25"),
    "limit absent": ('lower="-1.5" ', "", "elbow.*lower.*missing"),
    "no limits": (re.search("<limit.*?/>", GOOD)[0], "", "elbow.*<limit> is missing"),
    "effort zero": ('effort="30"', 'effort="0"', "elbow.*effort.*must be positive.*'0'"),
    "velocity negative": ('velocity="4"', 'velocity="-4"', "elbow.*velocity.*positive.*'-4'"),
    "velocity inf": ('velocity="4"', 'velocity="inf"', "elbow.*velocity.*finite"),
    "axis zero": ('axis xyz="0 1 0"', 'axis xyz="0 0 0"', "elbow.*axis is zero"),
    "axis short": ('axis xyz="0 1 0"', 'axis xyz="0 1"', "elbow.*wanted 3 numbers, got 2"),
    "origin nan": ('xyz="0 0 1"', 'xyz="0 nan 1"', "elbow.*origin xyz.*finite"),
    "floating": ("revolute", "floating", "elbow.*'floating'.*free base"),
    "unknown type": ("revolute", "hinge", "elbow.*'hinge'.*revolute, prismatic, continuous, fixed"),
    "link twice": ('<link name="arm">', '<link name="base">', "'base'.*given twice"),
    "joint twice": ('name="tip_fixed"', 'name="elbow"', "'elbow'.*given twice"),
    "reserved": ('<link name="tip"', '<link name="universe"', "'universe'.*reserved"),
    "no name": ('<link name="tip"', "<link", "printable name"),
    "no parent": ('<parent link="base"/>', "", "elbow.*<parent> is missing"),
    "unknown child": ('<child link="tip"/>', '<child link="top"/>', "tip_fixed.*'top'"),
    "two roots": ('<parent link="arm"/><child link="tip"/>',
                  '<parent link="arm"/><child link="arm"/>', "parent joints"),
    "box flat": ('size="1 1 1"', 'size="1 0 1"', "'base', collision 0.*positive"),
    "radius negative": ('radius="0.1"', 'radius="-1"', "'arm', visual 0.*radius.*positive"),
    "unknown shape": ('<box size="1 1 1"/>', "<cone/>", "cone.*box, cylinder, sphere, mesh"),
    "not XML": ("</robot>", "", "line 10.*not well-formed XML"),
    "not a robot": (GOOD, "<sdf/>", "outermost element is <sdf>"),
    "entity": (GOOD, '<!DOCTYPE robot [<!ENTITY a "b">]>' + GOOD, "DOCTYPE"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_refused_with_name_value_and_remedy(case: str, tmp_path: Path) -> None:
    old, new, wanted = REFUSED[case]
    assert old in GOOD
    said = refusal(tmp_path, GOOD.replace(old, new, 1))
    assert re.search(wanted, said, re.DOTALL), said


def test_all_errors_are_said_at_once(tmp_path: Path) -> None:
    said = refusal(tmp_path, GOOD.replace('effort="30"', 'effort="0"').replace("2.0", "nan"))
    assert "3 errors" in said
    assert said.count("mass") == 2


def test_a_loop_is_refused(tmp_path: Path) -> None:
    ring = (
        '<link name="a"/><link name="b"/>'
        '<joint name="ab" type="fixed"><parent link="a"/><child link="b"/></joint>'
        '<joint name="ba" type="fixed"><parent link="b"/><child link="a"/></joint></robot>'
    )
    assert "hangs on a loop" in refusal(tmp_path, GOOD.replace("</robot>", ring))


def chain(length: int) -> str:
    links = "".join(f'<link name="l{i}">{INERTIAL}</link>' for i in range(length + 1))
    joints = "".join(
        f'<joint name="j{i}" type="revolute"><parent link="l{i}"/><child link="l{i + 1}"/>'
        '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        for i in range(length)
    )
    return f'<robot name="chain">{links}{joints}</robot>'


def test_long_chains_are_refused_before_pinocchio(tmp_path: Path) -> None:
    assert "5000 joints" in refusal(tmp_path, chain(5000))
    assert f"at most {MAX_JOINTS}" in refusal(tmp_path, chain(MAX_JOINTS + 1))
    assert f"a chain of {MAX_DEPTH + 1} joints" in refusal(tmp_path, chain(MAX_DEPTH + 1))
    assert load_robot(write(tmp_path, chain(20))).na == 20


def test_a_bomb_of_nested_elements_and_a_huge_file_are_refused(tmp_path: Path) -> None:
    assert "nested deeper" in refusal(tmp_path, "<robot>" + "<a>" * 100_000)
    path = tmp_path / "huge.urdf"
    with path.open("wb") as stream:
        stream.truncate(MAX_BYTES + 1)
    with pytest.raises(RobotFileError, match="larger than 20 MB"):
        load_robot(path)


def test_a_missing_file_a_folder_and_bad_bytes_are_refused(tmp_path: Path) -> None:
    for path in (tmp_path / "none.urdf", tmp_path):
        with pytest.raises(RobotFileError, match=r"There is no file|holds no robot"):
            load_robot(path)
    bad = tmp_path / "bad.urdf"
    bad.write_bytes(b'<?xml version="1.0" encoding="no-such"?><robot/>')
    with pytest.raises(RobotFileError, match=r"line 1|decoded"):
        load_robot(bad)


def test_a_fixed_massless_frame_may_carry_the_root_and_mass_may_hang_on_it(tmp_path: Path) -> None:
    moved = GOOD.replace(f'<link name="arm">{INERTIAL}', '<link name="arm">')
    moved = moved.replace('<link name="tip"/>', f'<link name="tip">{INERTIAL}</link>')
    assert load_robot(write(tmp_path, moved)).mass == 4.0


WARNED = {
    "slip of the pen": ("<origin xyz=", "<orgin xyz=", "'orgin'.*not read"),
    "long axis": ('axis xyz="0 1 0"', 'axis xyz="0 2 0"', "not of length 1"),
    "no axis": ('<axis xyz="0 1 0"/>', "", "x is taken"),
    "degrees": ('upper="1.25"', 'upper="90"', "degrees"),
    "mimic": ("<axis", '<mimic joint="x"/><axis', "mimic"),
}


@pytest.mark.parametrize("case", WARNED)
def test_warned_but_loaded(case: str, tmp_path: Path) -> None:
    old, new, wanted = WARNED[case]
    path = write(tmp_path, GOOD.replace(old, new))
    load_robot(path)
    warnings = [str(f) for f in check_urdf(path) if f.severity == WARNING]
    assert any(re.search(wanted, said) for said in warnings), warnings


def test_an_axis_of_another_length_turns_as_far(tmp_path: Path) -> None:
    long = load_robot(write(tmp_path, GOOD.replace('axis xyz="0 1 0"', 'axis xyz="0 2 2"')))
    unit = load_robot(write(tmp_path, GOOD.replace('axis xyz="0 1 0"', 'axis xyz="0 1 1"')))
    assert long.model.joints[2] == unit.model.joints[2]


XACRO = {
    "macro": ("</robot>", '<xacro:leg prefix="left"/></robot>', "xacro:leg"),
    "macro in a link": ('<link name="tip"/>', '<link name="tip"><xacro:shape/></link>', "shape"),
    "property": ("</robot>", '<xacro:property name="a" value="1"/></robot>', "property"),
    "other prefix": (
        '<robot name="two">',
        '<robot name="two" xmlns:x="http://www.ros.org/wiki/xacro"><x:leg/>',
        "x:leg",
    ),
    "name of a link": ('name="tip"/>', 'name="${prefix}tip"/>', "link name.*prefix"),
    "name of a joint": ('name="elbow"', 'name="$(arg side)_elbow"', "joint name.*side"),
    "number": ('effort="30"', 'effort="${strong}"', "limit effort.*strong"),
    "deep": ('xyz="0 0 1"', 'xyz="0 0 ${height}"', "origin xyz.*height"),
}


@pytest.mark.parametrize("case", XACRO)
def test_xacro_that_is_left_over_is_an_error_with_the_remedy(case: str, tmp_path: Path) -> None:
    old, new, wanted = XACRO[case]
    assert old in GOOD
    said = refusal(tmp_path, GOOD.replace(old, new, 1))
    assert re.search(wanted, said), said
    assert "xacro FILE.xacro > FILE.urdf" in said


def test_an_expanded_file_may_keep_its_namespace_and_what_others_read(tmp_path: Path) -> None:
    text = GOOD.replace(
        '<robot name="two">',
        '<robot name="two" xmlns:xacro="http://www.ros.org/wiki/xacro">'
        '<gazebo><plugin filename="$(find x)/y"/></gazebo><transmission name="t"/>'
        "<ros2_control/><mujoco><compiler/></mujoco>",
    )
    path = write(tmp_path, text)
    assert load_robot(path).na == 1
    assert [f for f in check_urdf(path) if "no soles" not in str(f)] == []


ARM_PART = (
    f'<link name="hand">{INERTIAL}</link><joint name="wrist" type="revolute"><parent link="tip"/>'
    '<child link="hand"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
)


def in_capitals(part: str) -> str:
    return part.replace("<l", "<L").replace("</l", "</L").replace("<j", "<J").replace("</j", "</J")


def feather(inertial: str) -> str:
    return inertial.replace('"2.0"', '"1e-7"').replace('"0.02"', '"1e-9"')


TOLD = {
    "capitals": ("</robot>", in_capitals(ARM_PART) + "</robot>", "small letters: <link>"),
    "group": ("</robot>", f"<group>{ARM_PART}</group></robot>", "'group'.*1 link, 1 joint"),
    "wrapped": ("</robot>", f"<parts><arm>{ARM_PART}</arm></parts></robot>", "1 link, 1 joint"),
    "include": ("</robot>", '<include filename="x"/></robot>', "includes nothing"),
    "unknown": ("</robot>", "<frobnicate/></robot>", "'frobnicate'"),
    "degrees": ('lower="-1.5"', 'lower="-90"', "two turns.*degrees"),
    "axis": ('axis xyz="0 1 0"', 'axis xyz="0 2 0"', "length 1"),
    "no axis": ('<axis xyz="0 1 0"/>', "", "x is taken"),
    "grams": ('mass value="2.0"', 'mass value="2000"', "'base'.*absurd mass: 2000 kg"),
    "feather": (INERTIAL, feather(INERTIAL), "absurd mass: 1e-07 kg"),
    "attribute": ('<link name="tip"', '<link name="tip" colour="red"', "colour.*not read"),
    "no soles": ("</robot>", "</robot>", "no soles"),
}  # fmt: skip


@pytest.mark.parametrize("case", TOLD)
def test_what_a_check_warns_of_loading_says_too(case: str, tmp_path: Path, caplog) -> None:
    old, new, wanted = TOLD[case]
    assert old in GOOD
    path = write(tmp_path, GOOD.replace(old, new, 1))
    found = [str(f) for f in check_urdf(path)]
    assert caplog.text == ""  # a check answers, it does not talk
    assert any(re.search(wanted, one) for one in found), found
    assert load_robot(path).na == 1
    for one in found:
        assert one in caplog.text


@pytest.mark.parametrize("count", [10, 2000])
def test_a_whole_robot_of_tonnes_is_told(tmp_path: Path, count: int) -> None:
    path = write(tmp_path, GOOD.replace('mass value="2.0"', f'mass value="{count}"'))
    assert any("absurd" in str(f) for f in check_urdf(path)) == (count > 500)


def test_names_of_any_length_are_quoted_in_a_line(tmp_path: Path) -> None:
    for name in ("x" * 5000, "a\x7fb"):
        said = refusal(tmp_path, GOOD.replace('<link name="tip"', f'<link name="{name}"'))
        assert len(said) < 1500
        said = refusal(tmp_path, GOOD.replace('<robot name="two"', f'<robot name="{name}"'))
        assert len(said) < 500
