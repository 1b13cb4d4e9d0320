"""Companion files and meshes: read when sound, refused with file, line and known keys when not."""

from __future__ import annotations

import re
import shutil
import struct
from pathlib import Path

import coal
import pytest

from equipoise.errors import InputError, NameNotFoundError, RobotFileError
from equipoise.robots import check_urdf, get_robot, load_robot, named_robots, robot_urdf_path

HRP2 = robot_urdf_path("hrp2")


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """Return the path of a copy of HRP-2 that a test may spoil."""
    for suffix in (".urdf", ".srdf", ".yaml"):
        shutil.copyfile(HRP2.with_suffix(suffix), tmp_path / f"hrp2{suffix}")
    return tmp_path / "hrp2.urdf"


def edit(path: Path, old: str, new: str) -> None:
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")


def test_registry_knows_hrp2_and_suggests() -> None:
    assert "hrp2" in named_robots()
    with pytest.raises(NameNotFoundError, match="Did you mean 'hrp2'"):
        get_robot("hrp-2")
    with pytest.raises(InputError):
        get_robot(3)
    assert get_robot(HRP2).joint_names == get_robot(str(HRP2)).joint_names


def test_companions_may_be_missing(copy: Path) -> None:
    copy.with_suffix(".srdf").unlink()
    copy.with_suffix(".yaml").unlink()
    robot = load_robot(copy)
    assert (robot.soles, robot.palms, robot.camera) == ((), (), None)
    assert (robot.q_half_sitting[7:] == 0.0).all()
    assert any("no soles" in str(finding) for finding in check_urdf(copy))


def test_companions_may_lie_elsewhere(copy: Path, tmp_path: Path) -> None:
    moved = [shutil.move(copy.with_suffix(s), tmp_path / f"other{s}") for s in (".srdf", ".yaml")]
    robot = load_robot(copy, srdf_path=moved[0], extras_path=moved[1])
    assert (robot.q_half_sitting == get_robot("hrp2").q_half_sitting).all()
    with pytest.raises(RobotFileError, match=r"no file .*\.srdf"):
        load_robot(copy, srdf_path=tmp_path / "none.srdf")


def test_cylinders_become_capsules_of_the_same_cylindrical_part_on_request(copy: Path) -> None:
    def limbs() -> list:
        shapes = load_robot(copy).collision_model.geometryObjects
        return [s.geometry for s in shapes if not isinstance(s.geometry, coal.Box)]

    capsules = limbs()
    edit(copy.with_suffix(".yaml"), "capsules: true", "capsules: false")
    cylinders = limbs()
    assert {type(shape) for shape in capsules} == {coal.Capsule}
    assert {type(shape) for shape in cylinders} == {coal.Cylinder}
    for capsule, cylinder in zip(capsules, cylinders, strict=True):
        assert (capsule.radius, capsule.halfLength) == (cylinder.radius, cylinder.halfLength)


EXTRAS = {
    "unknown key": ("camera:", "kamera:", "line 24, kamera: unknown key.*Known: name.*'camera'"),
    "unknown sole key": ("x_min: -0.1", "xmin: -0.1", "soles.0.*Known: name, frame, x_min"),
    "duplicate key": ("camera: camera", "name: again", "line 24: a key is given twice"),
    "word for number": ("x_min: -0.1", "x_min: wide", "line 7, soles.0.x_min.*'wide'"),
    "nan": ("x_min: -0.1", "x_min: .nan", "line 7, soles.0.x_min"),
    "bounds exchanged": ("x_min: -0.1", "x_min: 0.5", "x_min < x_max"),
    "same name": ("name: right_sole", "name: left_sole", "left_sole"),
    "not YAML": ("soles:", "soles: [", "not valid YAML"),
    "unknown frame": ("frame: left_sole", "frame: left_sol", "left_sole"),
    "unknown camera": ("camera: camera", "camera: eye", "'eye'"),
    "unknown palm": ("frame: left_palm", "frame: left_plam", "left_palm"),
}


@pytest.mark.parametrize("case", EXTRAS)
def test_bad_extras_are_refused(case: str, copy: Path) -> None:
    old, new, wanted = EXTRAS[case]
    edit(copy.with_suffix(".yaml"), old, new)
    with pytest.raises(InputError) as caught:
        load_robot(copy)
    assert re.search(wanted, str(caught.value)), caught.value
    assert any(re.search(wanted, str(finding)) for finding in check_urdf(copy))


SRDF = {
    "unknown joint": ('"LLEG_JOINT0" value', '"LLEG_JOINTO" value', "JOINTO.*Did you mean"),
    "outside limits": ('"LARM_JOINT3" value="-0.52', '"LARM_JOINT3" value="0.52', "outside.*0.52"),
    "not a number": ('value="-0.523599"', 'value="bent"', "ARM_JOINT3.*'bent'"),
    "no value": ('value="-0.523599"', "", "needs a value"),
    "no link": ('link1="BODY"', "", "needs a link1"),
}  # fmt: skip


@pytest.mark.parametrize("case", SRDF)
def test_bad_srdf_is_refused(case: str, copy: Path) -> None:
    old, new, wanted = SRDF[case]
    edit(copy.with_suffix(".srdf"), old, new)
    with pytest.raises(InputError) as caught:
        load_robot(copy)
    assert re.search(wanted, str(caught.value)), caught.value


def test_a_disabled_pair_of_an_unknown_link_is_warned_of(copy: Path) -> None:
    edit(copy.with_suffix(".srdf"), 'link1="BODY"', 'link1="BODI"')
    findings = check_urdf(copy)
    assert [finding.severity for finding in findings] == ["warning"]
    assert "BODI" in str(findings[0])
    pairs = len(get_robot("hrp2").collision_model.collisionPairs)
    assert len(load_robot(copy).collision_model.collisionPairs) == pairs + 1


def test_half_sitting_of_the_extras_goes_before_the_srdf(copy: Path) -> None:
    with copy.with_suffix(".yaml").open("a", encoding="utf-8") as stream:
        stream.write("half_sitting: {LLEG_JOINT3: 0.5, RLEG_JOINT3: 0.5}\n")
    robot = load_robot(copy)
    assert robot.q_half_sitting[7 + robot.joint_index("LLEG_JOINT3")] == 0.5
    assert robot.q_half_sitting[7 + robot.joint_index("LARM_JOINT3")] == 0.0


def write_tetrahedron(path: Path) -> None:
    """Write a binary STL of a tetrahedron with edges along the axes."""
    points = [(0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.0, 0.1, 0.0), (0.0, 0.0, 0.1)]
    faces = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    body = b"".join(
        struct.pack("<12fH", 0, 0, 0, *(x for i in face for x in points[i]), 0) for face in faces
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(bytes(80) + struct.pack("<I", len(faces)) + body)


def with_mesh(urdf: Path, filename: str) -> None:
    edit(urdf, '<box size="0.2972 0.3282 0.2653"/>', f'<mesh filename="{filename}"/>')


@pytest.fixture
def package(copy: Path) -> Path:
    """Return the URDF of a package arm/ with urdf/, meshes/ and a secret beside it."""
    root = copy.parent / "arm"
    write_tetrahedron(root / "meshes" / "body.stl")
    write_tetrahedron(root.parent / "secret.stl")
    (root / "urdf").mkdir()
    (root / "meshes" / "link.stl").symlink_to(root.parent / "secret.stl")
    return Path(shutil.copy(copy, root / "urdf" / "arm.urdf"))


def test_meshes_inside_the_package_are_read(package: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir("/")  # a path must not depend on where the program was started
    with_mesh(package, "package://arm/meshes/body.stl")
    mesh = load_robot(package).visual_model.geometryObjects[0].geometry
    assert mesh.num_vertices in (4, 12)
    write_tetrahedron(package.parent / "near.stl")
    edit(package, "package://arm/meshes/body.stl", "near.stl")
    load_robot(package)


@pytest.mark.parametrize(
    ("filename", "wanted"),
    [
        ("package://arm/../secret.stl", "outside its folder"),
        ("package://arm/meshes/link.stl", "outside its folder"),
        ("package://../secret.stl", "must be package"),
        ("package://other/body.stl", "package folder was not found.*package_dirs"),
        ("package://arm/meshes/none.stl", "no mesh file"),
        ("../meshes/link.stl", "outside its folder"),
        ("../../secret.stl", "outside its folder"),
        ("../urdf/../../secret.stl", "outside its folder"),
        ("/etc/hostname", "must be package"),
        ("file:///etc/hostname", "must be package"),
        ("https://example.org/body.stl", "must be package"),
        ("arm.urdf", "unknown mesh format"),
        ("", "must be package"),
    ],
)
def test_other_meshes_are_refused(package: Path, filename: str, wanted: str) -> None:
    with_mesh(package, filename)
    with pytest.raises(RobotFileError) as caught:
        load_robot(package)
    assert re.search(wanted, str(caught.value)), caught.value
    assert "link 'BODY', visual 0" in str(caught.value)


def test_a_broken_mesh_is_refused(package: Path) -> None:
    (package.parent / "broken.stl").write_bytes(b"solid nothing")
    with_mesh(package, "broken.stl")
    with pytest.raises(RobotFileError):
        load_robot(package)


def test_package_dirs_hold_packages(package: Path, tmp_path: Path) -> None:
    elsewhere = tmp_path / "elsewhere"
    write_tetrahedron(elsewhere / "skins" / "body.stl")
    with_mesh(package, "package://skins/body.stl")
    load_robot(package, package_dirs=[elsewhere])


@pytest.mark.parametrize("deep", [False, True])
def test_meshes_beside_the_urdf_s_folder_and_in_its_package_are_found(
    package: Path, deep: bool
) -> None:
    """`../meshes/x.stl` is the most common layout; in a package it may lead further up."""
    with_mesh(package, "../meshes/body.stl")
    if deep:
        (package.parent.parent / "package.xml").write_text("<package/>")
        inner = package.parent / "v1" / "arm.urdf"
        inner.parent.mkdir()
        for suffix in (".urdf", ".srdf", ".yaml"):
            if package.with_suffix(suffix).exists():
                shutil.move(package.with_suffix(suffix), inner.with_suffix(suffix))
        edit(inner, "../meshes", "../../meshes")
        package = inner
    robot = load_robot(package)
    assert len(robot.visual_model.geometryObjects) > 0
    assert not [f for f in check_urdf(package) if f.severity == "error"]


def test_a_package_s_file_does_not_open_what_is_outside(package: Path) -> None:
    (package.parent.parent / "package.xml").write_text("<package/>")
    outside = package.parent.parent.parent
    write_tetrahedron(outside / "other.stl")
    (package.parent / "near").symlink_to(outside)
    for name in (
        "../../other.stl",
        "near/other.stl",
        "../urdf/../../other.stl",
        "./near/../../../x",
    ):
        text = package.read_text(encoding="utf-8")
        with_mesh(package, name)
        with pytest.raises(RobotFileError, match="outside its folder"):
            load_robot(package)
        package.write_text(text, encoding="utf-8")


def test_old_homes_of_scenes_and_distances_say_where_they_are_now() -> None:
    import equipoise.distances
    import equipoise.world
    from equipoise.collision.scene import Scene

    with pytest.warns(DeprecationWarning, match="equipoise.collision.scene.Scene"):
        assert equipoise.world.Scene is Scene
    with pytest.warns(DeprecationWarning, match="collision.distances"):
        assert equipoise.distances.DistanceEvaluator is not None
    with pytest.raises(AttributeError):
        equipoise.world.Nothing  # noqa: B018
