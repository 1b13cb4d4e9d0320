"""Tessellated shapes have the right area, volume and outside."""

from __future__ import annotations

import coal
import numpy as np
import pinocchio as pin
import pytest

from equipoise.analysis.rendering.tessellation import Mesh, tessellate

RADIUS, HALF = 0.07, 0.15
SHAPES = {
    "box": coal.Box(0.2, 0.3, 0.5),
    "sphere": coal.Sphere(RADIUS),
    "ellipsoid": coal.Ellipsoid(0.1, 0.2, 0.3),
    "capsule": coal.Capsule(RADIUS, 2.0 * HALF),
    "cylinder": coal.Cylinder(RADIUS, 2.0 * HALF),
    "cone": coal.Cone(RADIUS, 2.0 * HALF),
}


def face_vectors(mesh: Mesh) -> np.ndarray:
    a, b, c = (mesh.vertices[mesh.triangles[:, i]] for i in range(3))
    return 0.5 * np.cross(b - a, c - a)


def area(mesh: Mesh) -> float:
    return float(np.linalg.norm(face_vectors(mesh), axis=1).sum())


def volume(mesh: Mesh) -> float:
    """Return the volume by the divergence theorem; it counts only for a closed surface."""
    centres = mesh.vertices[mesh.triangles].mean(axis=1)
    return float(np.einsum("ij,ij->", centres, face_vectors(mesh)) / 3.0)


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
def test_surfaces_are_closed_and_face_outwards(shape):
    mesh = tessellate(shape)
    faces = face_vectors(mesh)
    assert np.linalg.norm(faces, axis=1).min() > 0.0
    np.testing.assert_allclose(faces.sum(axis=0), 0.0, atol=1e-15)
    outward = np.einsum("ij,ij->i", faces, mesh.vertices[mesh.triangles].mean(axis=1))
    assert (outward > 0.0).all()  # the origin lies inside of every one of these shapes
    along = np.einsum("ikj,ij->ik", mesh.normals[mesh.triangles], faces)
    assert (along > 0.0).all()
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, rtol=1e-12)


@pytest.mark.parametrize("name", ["box", "sphere", "ellipsoid", "capsule", "cylinder", "cone"])
def test_volume_is_that_of_coal(name):
    shape = SHAPES[name]
    coarse, fine = (
        abs(volume(tessellate(shape, segments)) - shape.computeVolume()) for segments in (24, 48)
    )
    if name == "box":
        assert fine < 1e-15
    else:  # the error of an inscribed polygon is of second order
        assert coarse / fine == pytest.approx(4.0, rel=0.05)


def test_capsule_area_converges_to_the_analytic_one():
    wanted = 4.0 * np.pi * RADIUS**2 + 2.0 * np.pi * RADIUS * 2.0 * HALF
    errors = [wanted - area(tessellate(SHAPES["capsule"], n)) for n in (24, 48)]
    assert 0.0 < errors[1] < errors[0] < 0.02 * wanted
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)


def test_cylinder_is_exactly_the_inscribed_prism():
    n = 12
    mesh = tessellate(SHAPES["cylinder"], n)
    base = 0.5 * n * np.sin(2.0 * np.pi / n) * RADIUS**2
    assert volume(mesh) == pytest.approx(base * 2.0 * HALF, rel=1e-12)


def test_mesh_and_its_hull_keep_their_volume():
    box = tessellate(SHAPES["box"])
    model = coal.BVHModelOBBRSS()
    model.beginModel(len(box.triangles), 3 * len(box.triangles))
    for corners in box.vertices[box.triangles]:
        model.addTriangle(*corners)
    model.endModel()
    model.buildConvexHull(True, "Qt")
    for shape in (model, model.convex):
        mesh = tessellate(shape)
        assert volume(mesh) == pytest.approx(0.2 * 0.3 * 0.5, rel=1e-9)
        assert area(mesh) == pytest.approx(2.0 * (0.06 + 0.1 + 0.15), rel=1e-9)


def test_moving_a_mesh_keeps_it_and_its_normals(rng):
    T = pin.SE3.Random()
    mesh = tessellate(SHAPES["capsule"])
    moved = mesh.moved(T)
    np.testing.assert_allclose(moved.vertices[7], T.act(mesh.vertices[7]), atol=1e-12)
    np.testing.assert_allclose(area(moved), area(mesh), rtol=1e-12)
    faces = face_vectors(moved)
    assert (np.einsum("ikj,ij->ik", moved.normals[moved.triangles], faces) > 0.0).all()


def test_what_has_no_surface_is_left_out():
    assert tessellate(coal.Halfspace(np.array([0.0, 0.0, 1.0]), 0.0)) is None
