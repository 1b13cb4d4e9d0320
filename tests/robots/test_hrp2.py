"""HRP-2 is what the recorded facts say, computed a second way from those facts."""

from __future__ import annotations

import importlib.util
import json
import sys
from itertools import combinations
from pathlib import Path
from types import ModuleType

import numpy as np
import pinocchio as pin
import pytest

from equipoise.robots import Robot, get_robot, robot_urdf_path
from equipoise.robots.files.build import link_of

TOOLS = Path(__file__).resolve().parents[2] / "tools"
FACTS = json.loads((TOOLS / "hrp2_parameters.json").read_text(encoding="utf-8"))
LINKS = {link["name"]: link for link in FACTS["links"]}
JOINTS = {joint["name"]: joint for joint in FACTS["joints"]}
MIRROR = np.diag([1.0, -1.0, 1.0])
# Recorded as not mirrored in the source (see the facts' open_points).
NOT_MIRRORED_LINKS = {"LARM_LINK4"}
NOT_MIRRORED_PLACES = {"LARM_LINK6"}


@pytest.fixture(scope="module")
def robot() -> Robot:
    return get_robot("hrp2")


def author() -> ModuleType:
    spec = importlib.util.spec_from_file_location("author_hrp2", TOOLS / "author_hrp2.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their own module up
    spec.loader.exec_module(module)
    return module


def rotation(axis: list[int], angle: float) -> np.ndarray:
    """Rotate about an axis by Rodrigues' formula: nothing of Pinocchio's."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]], dtype=float)
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def placements(angles: dict[str, float]) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return link -> (R, p) in base axes by walking the recorded facts."""
    placed = {FACTS["base_link"]: (np.eye(3), np.zeros(3))}
    waiting = list(FACTS["joints"])
    while waiting:
        joint = waiting.pop(0)
        if joint["parent"] not in placed:
            waiting.append(joint)
            continue
        R, p = placed[joint["parent"]]
        placed[joint["child"]] = (
            R @ rotation(joint["axis"], angles[joint["name"]]),
            p + R @ np.array(joint["origin_xyz"]),
        )
    return placed


def inertia_matrix(link: dict) -> np.ndarray:
    i = link["inertia_about_com"]
    return np.array([[i["i" + "".join(sorted(r + c))] for c in "xyz"] for r in "xyz"])


def com_and_inertia(angles: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
    """Return CoM (3,) and rotational inertia about it (3, 3), base axes, from the facts."""
    placed = placements(angles)
    points = {n: placed[n][1] + placed[n][0] @ np.array(k["com"]) for n, k in LINKS.items()}
    masses = {n: k["mass"] for n, k in LINKS.items()}
    com = sum(masses[n] * points[n] for n in LINKS) / sum(masses.values())
    total = np.zeros((3, 3))
    for name, link in LINKS.items():
        R, d = placed[name][0], points[name] - com
        total += R @ inertia_matrix(link) @ R.T
        total += masses[name] * (d @ d * np.eye(3) - np.outer(d, d))
    return com, total


def random_q(robot: Robot, rng: np.random.Generator) -> np.ndarray:
    q = robot.q_half_sitting.copy()
    q[7:] = rng.uniform(robot.q_min, robot.q_max)
    return q


def angles_of(robot: Robot, q: np.ndarray) -> dict[str, float]:
    return dict(zip(robot.joint_names, q[7:], strict=True))


def mirrored_name(name: str) -> str:
    on_a_side = name[1:4] in ("LEG", "ARM")
    return {"L": "R", "R": "L"}[name[0]] + name[1:] if on_a_side else name


def test_the_committed_files_are_what_the_tool_writes() -> None:
    folder = robot_urdf_path("hrp2").parent
    files = author().author(FACTS)
    assert set(files) == {"hrp2.urdf", "hrp2.srdf", "hrp2.yaml"}
    for name, text in files.items():
        assert (folder / name).read_bytes() == text.encode()


def test_counts_and_names(robot: Robot) -> None:
    assert (robot.name, robot.nq, robot.nv, robot.na) == ("hrp2", 37, 36, 30)
    assert set(robot.joint_names) == set(JOINTS)
    assert set(LINKS) <= set(robot.frame_names)
    assert sum(1 for i in robot.model.inertias if i.mass > 0) == 31


def test_limits_are_the_recorded_ones(robot: Robot) -> None:
    for i, name in enumerate(robot.joint_names):
        fact = JOINTS[name]
        given = (robot.q_min[i], robot.q_max[i], robot.v_max[i], robot.tau_max[i])
        wanted = [fact[k] for k in ("lower_rad", "upper_rad", "velocity_rad_s", "effort_nm")]
        np.testing.assert_allclose(given, wanted, rtol=1e-15)


def test_mass_height_and_com_agree_with_the_record(robot: Robot) -> None:
    assert robot.mass == pytest.approx(FACTS["total_mass_kg"], abs=1e-9)
    assert robot.q_half_sitting[2] == pytest.approx(FACTS["base_height_half_sitting"], abs=1e-6)
    com = pin.centerOfMass(robot.model, robot.model.createData(), robot.q_half_sitting)
    recorded = np.array(FACTS["crosschecks"]["this_model_com_half_sitting"])
    np.testing.assert_allclose(com[1:], recorded[1:], atol=1e-6)
    # The record has the base at x = 0, we have the soles' middle there.
    foot_x = FACTS["crosschecks"]["jrl_walkgen_foot_x"]
    assert com[0] + foot_x == pytest.approx(recorded[0], abs=1e-6)
    assert robot.q_half_sitting[0] == pytest.approx(-foot_x, abs=1e-6)


def test_kinematics_com_and_inertia_agree_with_a_second_computation(robot: Robot) -> None:
    rng = np.random.default_rng(1)
    data = robot.model.createData()
    for _ in range(5):
        q = random_q(robot, rng)
        q[:7] = pin.neutral(robot.model)[:7]
        angles = angles_of(robot, q)
        pin.framesForwardKinematics(robot.model, data, q)
        for link, (R, p) in placements(angles).items():
            found = data.oMf[robot.frame_id(link)]
            np.testing.assert_allclose(found.rotation, R, atol=1e-12)
            np.testing.assert_allclose(found.translation, p, atol=1e-12)
        pin.ccrba(robot.model, data, q, np.zeros(robot.nv))
        com, inertia = com_and_inertia(angles)
        np.testing.assert_allclose(data.com[0], com, atol=1e-12)
        np.testing.assert_allclose(data.Ig.inertia, inertia, atol=1e-10)


def test_half_sitting_stands_flat_and_centred(robot: Robot) -> None:
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, robot.q_half_sitting)
    places = [data.oMf[robot.frame_id(sole.frame)] for sole in robot.soles]
    for place in places:
        np.testing.assert_allclose(place.rotation, np.eye(3), atol=1e-6)
    np.testing.assert_allclose(np.mean([p.translation for p in places], axis=0)[:2], 0, atol=1e-12)
    lowest = min(p.act(c)[2] for p, s in zip(places, robot.soles, strict=True) for c in s.corners)
    assert lowest == pytest.approx(0.0, abs=1e-12)
    assert places[0].translation[1] == pytest.approx(0.095, abs=1e-9)
    angles = angles_of(robot, robot.q_half_sitting)
    assert angles == pytest.approx(FACTS["half_sitting"], abs=1e-12)


def test_soles_lie_inside_the_foot_and_are_mirrored(robot: Robot) -> None:
    left, right = robot.sole("left_sole"), robot.sole("right_sole")
    assert (left.y_min, left.y_max) == (-right.y_max, -right.y_min)
    assert (left.x_min, left.x_max) == (right.x_min, right.x_max)
    for side, sole in (("left", left), ("right", right)):
        wide = FACTS["feet"]["sole_rect_mechanical"][side]
        assert wide["x_min"] <= sole.x_min < sole.x_max <= wide["x_max"]
        assert wide["y_min"] <= sole.y_min < sole.y_max <= wide["y_max"]


def test_palms_point_along_the_fingers_and_at_each_other(robot: Robot) -> None:
    data = robot.model.createData()
    q = robot.q_half_sitting.copy()
    q[7:] = 0.0  # arms hang
    pin.framesForwardKinematics(robot.model, data, q)
    left, right = (
        data.oMf[robot.frame_id(robot.palm(f"{s}_palm").frame)] for s in ("left", "right")
    )
    between = right.translation - left.translation
    for palm, inward in ((left, between), (right, -between)):
        np.testing.assert_allclose(palm.rotation[:, 0], [0, 0, -1], atol=1e-12)
        np.testing.assert_allclose(palm.rotation[:, 2], inward / np.linalg.norm(inward), atol=1e-12)
        assert np.linalg.det(palm.rotation) == pytest.approx(1.0)


def test_camera_looks_forward_from_inside_the_head(robot: Robot) -> None:
    frame = robot.model.frames[robot.frame_id(robot.camera)]
    low, high = (np.array(LINKS["HEAD_LINK1"][k]) for k in ("mesh_aabb_min", "mesh_aabb_max"))
    assert (frame.placement.translation > low).all()
    assert (frame.placement.translation < high).all()
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, robot.q_half_sitting)
    np.testing.assert_allclose(data.oMf[robot.frame_id("camera")].rotation, np.eye(3), atol=1e-6)


def test_left_and_right_are_mirror_images_where_the_record_is(robot: Robot) -> None:
    for name in LINKS:
        if name[0] != "L" or name in NOT_MIRRORED_LINKS:
            continue
        left, right = (robot.model.inertias[robot.model.getJointId(n.replace("LINK", "JOINT"))]
                       for n in (name, mirrored_name(name)))  # fmt: skip
        assert left.mass == right.mass
        np.testing.assert_allclose(left.lever, MIRROR @ right.lever, atol=1e-12)
        np.testing.assert_allclose(left.inertia, MIRROR @ right.inertia @ MIRROR, atol=1e-12)


def test_mirrored_angles_give_mirrored_links_and_limits(robot: Robot) -> None:
    # An angle about y is the same seen in a mirror that swaps y; about x and z its sign changes.
    sign = {n: 1.0 if JOINTS[n]["axis"] == [0, 1, 0] else -1.0 for n in JOINTS}
    for i, name in enumerate(robot.joint_names):
        j = robot.joint_index(mirrored_name(name))
        bounds = sorted((sign[name] * robot.q_min[j], sign[name] * robot.q_max[j]))
        np.testing.assert_allclose([robot.q_min[i], robot.q_max[i]], bounds, atol=1e-12)
    rng = np.random.default_rng(2)
    q = random_q(robot, rng)
    q[:7] = pin.neutral(robot.model)[:7]
    mirrored = q.copy()
    for i, name in enumerate(robot.joint_names):
        mirrored[7 + i] = sign[name] * q[7 + robot.joint_index(mirrored_name(name))]
    data, other = robot.model.createData(), robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, q)
    pin.framesForwardKinematics(robot.model, other, mirrored)
    for name in set(LINKS) - NOT_MIRRORED_PLACES - {mirrored_name(n) for n in NOT_MIRRORED_PLACES}:
        here = data.oMf[robot.frame_id(name)]
        there = other.oMf[robot.frame_id(mirrored_name(name))]
        np.testing.assert_allclose(there.translation, MIRROR @ here.translation, atol=1e-12)
        np.testing.assert_allclose(there.rotation, MIRROR @ here.rotation @ MIRROR, atol=1e-12)


@pytest.mark.parametrize("kind", ["collision_model", "visual_model"])
def test_shapes_stay_inside_the_recorded_bounding_boxes(robot: Robot, kind: str) -> None:
    shapes = getattr(robot, kind).geometryObjects
    assert len(shapes) == {"collision_model": 17, "visual_model": 31}[kind]
    for shape in shapes:
        fact = LINKS[link_of(robot.model, shape)]
        place = robot.model.frames[shape.parentFrame].placement.actInv(shape.placement)
        shape.geometry.computeLocalAABB()
        box = shape.geometry.aabb_local
        reach = np.abs(place.rotation) @ ((box.max_ - box.min_) / 2)
        assert (place.translation - reach >= np.array(fact["mesh_aabb_min"]) - 2e-6).all()
        assert (place.translation + reach <= np.array(fact["mesh_aabb_max"]) + 2e-6).all()


def distances(robot: Robot, q: np.ndarray) -> dict[frozenset[str], float]:
    data, geometry = robot.model.createData(), robot.collision_model
    results = geometry.createData()
    pin.updateGeometryPlacements(robot.model, data, geometry, results, q)
    pin.computeDistances(geometry, results)
    names = [link_of(robot.model, shape) for shape in geometry.geometryObjects]
    return {
        frozenset((names[p.first], names[p.second])): r.min_distance
        for p, r in zip(geometry.collisionPairs, results.distanceResults, strict=True)
    }


def test_nothing_touches_at_half_sitting_nor_with_straight_limbs(robot: Robot) -> None:
    straight = robot.q_half_sitting.copy()
    straight[7:] = 0.0
    for q in (robot.q_half_sitting, straight):
        assert min(distances(robot, q).values()) > 0.0


def closest(robot: Robot, first: str, second: str, rng: np.random.Generator) -> float:
    """Search the joint limits for the smallest distance of two links: random, then refined."""
    geometry = robot.collision_model
    index = {link_of(robot.model, s): i for i, s in enumerate(geometry.geometryObjects)}
    data, geometry = robot.model.createData(), geometry.copy()
    geometry.addCollisionPair(pin.CollisionPair(index[first], index[second]))
    results = geometry.createData()
    pair = len(geometry.collisionPairs) - 1
    q = robot.q_half_sitting.copy()

    def distance(joints: np.ndarray) -> float:
        q[7:] = joints
        pin.updateGeometryPlacements(robot.model, data, geometry, results, q)
        return pin.computeDistance(geometry, results, pair).min_distance

    span = robot.q_max - robot.q_min
    best, best_at = np.inf, robot.q_half_sitting[7:]
    for trial in range(1500):
        width = 1.0 if trial < 600 else 0.3 * 0.995 ** (trial - 600)
        centre = best_at if trial >= 600 else (robot.q_min + robot.q_max) / 2
        joints = np.clip(
            centre + width * span * rng.uniform(-0.5, 0.5, robot.na), robot.q_min, robot.q_max
        )
        found = distance(joints)
        if found < best:
            best, best_at = found, joints
    return best


def test_pairs_said_never_to_touch_do_not_and_the_search_can_tell(robot: Robot) -> None:
    rng = np.random.default_rng(3)
    tool = author()
    never = [(a, b) for a, b, reason in tool.disabled_pairs(FACTS) if reason == "Never"]
    assert len(never) == 15
    for first, second in never:
        assert closest(robot, first, second, rng) > 0.005, (first, second)
    for first, second in (("RARM_LINK5", "CHEST_LINK1"), ("LLEG_LINK5", "RLEG_LINK3")):
        assert closest(robot, first, second, rng) < 0.0, "the search finds no contact at all"


def test_watched_and_disabled_pairs_make_up_all_pairs(robot: Robot) -> None:
    tool = author()
    disabled = {frozenset(pair[:2]) for pair in tool.disabled_pairs(FACTS)}
    watched = set(distances(robot, robot.q_half_sitting))
    every = {frozenset(pair) for pair in combinations(tool.colliding_links(FACTS), 2)}
    assert watched == every - disabled
