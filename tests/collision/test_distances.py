"""Distances of our kernels against Coal's, and their rates against finite differences."""

from __future__ import annotations

import coal
import numpy as np
import pinocchio as pin
import pytest

from equipoise.collision import Body, DistanceEvaluator, Scene, Shape
from equipoise.collision.pairs import (
    ASK,
    FIND,
    KNOWN,
    PairProgram,
    bound_of,
    find_distances_there,
)
from equipoise.collision.shapes import BOX, CYLINDER, HULL, SEGMENT, core_of
from equipoise.compiled import entrance
from equipoise.compiled.workspace import Workspace, part_of
from equipoise.errors import InputError
from equipoise.robots import get_robot
from helpers import random_state

GENERATOR = np.random.default_rng(0)


def mesh(points: np.ndarray) -> coal.ConvexBase:
    """Return the convex hull of points (k, 3), as a mesh file would give it."""
    vertices = coal.StdVec_Vec3s()
    for point in points:
        vertices.append(point)
    return coal.Convex.convexHull(vertices, False, "")


SHAPES = {
    "sphere": lambda: coal.Sphere(0.1),
    "capsule": lambda: coal.Capsule(0.05, 0.4),
    "box": lambda: coal.Box(0.2, 0.3, 0.1),
    "cylinder": lambda: coal.Cylinder(0.08, 0.3),
    "hull": lambda: mesh(GENERATOR.normal(size=(20, 3)) * 0.1),
}
PAIRS = [(a, b) for i, a in enumerate(SHAPES) for b in list(SHAPES)[i:]]


def floating_shapes(first: coal.CollisionGeometry, second: coal.CollisionGeometry):
    """Return a robot-like object of two free bodies with a shape each, and its pair."""
    model = pin.Model()
    geometry = pin.GeometryModel()
    for name, shape in (("first", first), ("second", second)):
        joint = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), name)
        model.appendBodyToJoint(joint, pin.Inertia.Random(), pin.SE3.Identity())
        geometry.addGeometryObject(pin.GeometryObject(name, joint, 0, pin.SE3.Identity(), shape))

    class Two:
        geometry_model = geometry

        def shapes_of(self, body):
            return [0] if body == "first" else [1]

    two = Two()
    two.geometry = geometry
    return two


class Beside:
    """Two shapes at any poses, in a workspace of their own."""

    def __init__(self, first: coal.CollisionGeometry, second: coal.CollisionGeometry) -> None:
        from equipoise.collision.scene import Pair
        from equipoise.kinematics.kernels import state_shapes

        scene = floating_shapes(first, second)
        self.program = PairProgram(scene, [Pair("first", "second")])
        self.workspace = Workspace(
            {"state": state_shapes(14, 12, 3, 1, 12), "pairs": self.program.array_shapes()},
            stages=[FIND],
        )
        self.shapes = first, second
        self.program.fill(self.workspace.pairs)

    def ask(self, T_first: pin.SE3, T_second: pin.SE3) -> int:
        """Find the distance; return how many were left to Coal."""
        for joint, T in ((1, T_first), (2, T_second)):
            self.workspace.state.joints[joint] = np.r_[T.rotation.T.ravel(), T.translation]
        blocks = self.workspace.floats, self.workspace.integers, self.workspace.tables
        return find_two(*blocks)

    @property
    def row(self) -> np.ndarray:
        return self.workspace.pairs.found[0]

    def by_coal(self, T_first: pin.SE3, T_second: pin.SE3) -> coal.DistanceResult:
        result = coal.DistanceResult()
        transforms = [coal.Transform3s(T.rotation, T.translation) for T in (T_first, T_second)]
        request = coal.DistanceRequest()
        request.gjk_tolerance = 1e-10
        first, second = self.shapes
        coal.distance(first, transforms[0], second, transforms[1], request, result)
        return result


@entrance
def find_two(floats, whole, tables):
    return find_distances_there(
        part_of(floats, whole, tables, 0), part_of(floats, whole, tables, 1), 0
    )


@entrance
def bound_alone(floats, whole, tables):
    return bound_of(part_of(floats, whole, tables, 1), 0)


def random_pose(rng: np.random.Generator, far: float) -> pin.SE3:
    direction = rng.normal(size=3)
    return pin.SE3(pin.exp3(rng.normal(size=3)), far * direction / np.linalg.norm(direction))


@pytest.mark.parametrize(("first", "second"), PAIRS)
def test_distances_normals_and_points_are_coals(first, second, rng):
    """Whether apart or passing into one another: then Coal is asked, and so is the test's."""
    two = Beside(SHAPES[first](), SHAPES[second]())
    apart = asked = 0
    for _ in range(200):
        T_first, T_second = random_pose(rng, 0.0), random_pose(rng, rng.uniform(0.0, 0.7))
        count = two.ask(T_first, T_second)
        if count:
            two.program.ask_coal(two.workspace.pairs)
            asked += 1
        row, wanted = two.row, two.by_coal(T_first, T_second)
        assert row[0] == pytest.approx(wanted.min_distance, abs=2e-6 if row[0] > 0 else 1e-4)
        if row[0] < 1e-3:
            continue
        apart += 1
        # between its points lies the distance, along the normal: a claim that needs no oracle
        assert np.linalg.norm(row[1:4]) == pytest.approx(1.0)
        assert np.allclose(row[7:10] - row[4:7], row[0] * row[1:4], atol=1e-9)
        bound = bound_alone(two.workspace.floats, two.workspace.integers, two.workspace.tables)
        assert bound <= row[0] + 1e-9
    assert apart > 50
    if {first, second} - {"sphere", "capsule"}:  # two lines in space hardly ever meet
        assert asked > 0


@pytest.mark.parametrize("kind", SHAPES)
def test_the_ball_around_a_shape_holds_it(kind):
    shape = SHAPES[kind]()
    core = core_of(pin.GeometryObject("one", 0, 0, pin.SE3.Identity(), shape))
    assert core.kind == {"box": BOX, "cylinder": CYLINDER, "hull": HULL}.get(kind, SEGMENT)
    ball = coal.Sphere(1e-9)
    rng = np.random.default_rng(3)
    for direction in rng.normal(size=(50, 3)):
        direction /= np.linalg.norm(direction)
        p = core.centre + (core.reach + 1e-6) * direction
        result = coal.DistanceResult()
        coal.distance(
            shape, coal.Transform3s.Identity(), ball, coal.Transform3s(np.eye(3), p),
            coal.DistanceRequest(), result,
        )  # fmt: skip
        assert result.min_distance > -1e-6


def test_a_shape_of_no_known_kind_is_refused_by_name():
    plane = pin.GeometryObject("floor", 0, 0, pin.SE3.Identity(), coal.Halfspace(0, 0, 1, 0))
    with pytest.raises(InputError, match="floor"):
        core_of(plane)


def test_parallel_capsules_and_touching_boxes_have_a_finite_answer():
    """Where there is no one nearest point, any will do; where cores touch, Coal is asked."""
    capsules = Beside(coal.Capsule(0.05, 0.4), coal.Capsule(0.05, 0.4))
    here = pin.SE3.Identity()
    beside = pin.SE3(np.eye(3), np.array([0.3, 0.0, 0.0]))
    assert capsules.ask(here, beside) == 0
    assert capsules.row[0] == pytest.approx(0.2)
    assert np.allclose(capsules.row[1:4], [1.0, 0.0, 0.0])
    assert capsules.ask(here, here) == 1
    assert capsules.workspace.pairs.state[0] == ASK
    capsules.program.ask_coal(capsules.workspace.pairs)
    assert capsules.workspace.pairs.state[0] == KNOWN
    assert capsules.row[0] < 0.0
    boxes = Beside(coal.Box(0.2, 0.2, 0.2), coal.Box(0.2, 0.2, 0.2))
    boxes.ask(here, pin.SE3(np.eye(3), np.array([0.2, 0.0, 0.0])))
    boxes.program.ask_coal(boxes.workspace.pairs)
    assert boxes.row[0] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("name", ["hrp2", "talos", "g1", "romeo"])
def test_distances_of_a_robot_are_coals(name, rng):
    """Every pair of limbs of every named robot, against Pinocchio's own computation."""
    try:
        robot = get_robot(name)
    except InputError as error:
        pytest.skip(str(error))
    box = Shape("box", (0.4, 1.0, 0.05), pin.SE3(np.eye(3), np.array([0.6, 0.0, 0.7])))
    scene = Scene(robot, [Body("desk", (box,), pin.SE3.Identity())])
    links = [name for name in scene.body_names if name != "desk"]
    pairs = [scene.pair(link, "desk") for link in links]
    pairs += [scene.pair(a, b) for a, b in zip(links[:-2], links[2:], strict=True) if a != b]
    evaluator = DistanceEvaluator(scene, pairs)
    geometry = scene.geometry
    for _ in range(3):
        q, _ = random_state(robot, rng, 0.3)
        distances = evaluator.at(robot.at(q))
        data = geometry.createData()
        pin.updateGeometryPlacements(robot.model, robot.model.createData(), geometry, data, q)
        for k, pair in enumerate(pairs):
            least = np.inf
            for i in scene.shapes_of(pair.first):
                for j in scene.shapes_of(pair.second):
                    result = coal.DistanceResult()
                    one, other = (geometry.geometryObjects[n].geometry for n in (i, j))
                    T = [coal.Transform3s(data.oMg[n].rotation, data.oMg[n].translation)
                         for n in (i, j)]  # fmt: skip
                    coal.distance(one, T[0], other, T[1], coal.DistanceRequest(), result)
                    least = min(least, result.min_distance)
            assert distances[k] == pytest.approx(least, abs=1e-4 if least < 0.0 else 2e-6)
            seen = evaluator.witness(k)
            assert seen.distance == pytest.approx(distances[k])
    assert DistanceEvaluator(scene, []).at(robot.at(q)).size == 0
