"""Cameras, depth buffer and pictures: what is nearer hides what is farther."""

from __future__ import annotations

import coal
import numpy as np
import pinocchio as pin
import pytest

from equipoise.analysis.rendering.camera import Camera
from equipoise.analysis.rendering.raster import rasterise, weights
from equipoise.analysis.rendering.render import render
from equipoise.analysis.rendering.scene_meshes import Picture
from equipoise.analysis.rendering.tessellation import Mesh, tessellate

RED, BLUE = np.array([0.9, 0.1, 0.1]), np.array([0.1, 0.1, 0.9])


def picture(*shapes: tuple[coal.CollisionGeometry, tuple, np.ndarray]) -> Picture:
    """Return a picture of shapes at positions [m], each with a colour."""
    meshes = [
        tessellate(shape).moved(pin.SE3(np.eye(3), np.array(position)))
        for shape, position, _ in shapes
    ]
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    mesh = Mesh(
        np.vstack([mesh.vertices for mesh in meshes]),
        np.vstack([mesh.normals for mesh in meshes]),
        np.vstack([m.triangles + s for m, s in zip(meshes, starts, strict=False)]),
    )
    part = np.repeat(np.arange(len(meshes)), [len(mesh.triangles) for mesh in meshes])
    return Picture(mesh, part, np.array([rgb for *_, rgb in shapes]))


def camera_along_x(perspective: bool, size: float = 0.5) -> Camera:
    eye, target = np.array([4.0, 0.0, 1.0]), np.array([0.0, 0.0, 1.0])
    return Camera(eye, target, (-size, size, -size, size), perspective)


@pytest.mark.parametrize("perspective", [True, False])
def test_projection_of_known_points(perspective):
    camera = camera_along_x(perspective)
    # Seen from +x, +y lies to the right; at half the distance things look twice as large.
    points = np.array([[0.0, 0.3, 1.2], [2.0, 0.3, 1.2]])
    seen = camera.project(points)
    np.testing.assert_allclose(seen[0, :2], [0.3, 0.2], atol=1e-12)
    scale = 2.0 if perspective else 1.0
    np.testing.assert_allclose(seen[1, :2], scale * seen[0, :2], atol=1e-12)
    assert seen[1, 2] > seen[0, 2]


@pytest.mark.parametrize("perspective", [True, False])
def test_unproject_undoes_project_and_rays_meet_the_points(perspective, rng):
    target = np.array([0.2, -0.1, 0.8])
    camera = Camera.around(target, 0.7, 0.3, 5.0, perspective=perspective)
    points = rng.normal(size=(50, 3))
    seen = camera.project(points)
    np.testing.assert_allclose(camera.unproject(seen), points, atol=1e-10)
    origin, direction = camera.rays(seen[:, 0], seen[:, 1])
    np.testing.assert_allclose(np.cross(points - origin, direction), 0.0, atol=1e-9)


def test_azimuth_and_elevation_say_where_the_eye_is():
    camera = Camera.around(np.zeros(3), np.pi / 2.0, 0.0, 2.0)
    np.testing.assert_allclose(camera.eye, [0.0, 2.0, 0.0], atol=1e-12)
    assert Camera.around(np.zeros(3), 0.0, 0.4, 2.0).eye[2] > 0.0


def test_what_is_behind_the_eye_is_not_seen():
    assert np.isnan(camera_along_x(True).project(np.array([[5.0, 0.0, 1.0]]))[0, 2])


def test_fitted_camera_holds_all_points_and_no_more(rng):
    points = rng.normal(size=(200, 3))
    camera = Camera.around(np.zeros(3), 0.4, 0.2, 12.0).fitted(points, margin=0.0)
    seen = camera.project(points)
    assert camera.window == pytest.approx(
        (seen[:, 0].min(), seen[:, 0].max(), seen[:, 1].min(), seen[:, 1].max())
    )


def test_raster_agrees_with_testing_every_pixel(rng):
    width, height = 40, 30
    corners = rng.uniform(-10.0, 50.0, size=(25, 3, 3))
    raster = rasterise(corners, width, height)
    column, row = (a.ravel() for a in np.meshgrid(np.arange(width), np.arange(height)))
    best, owner = np.full(column.size, -np.inf), np.full(column.size, -1)
    for k, triangle in enumerate(corners):
        share = weights(np.broadcast_to(triangle, (column.size, 3, 3)), column, row)
        value = np.where((share >= 0.0).all(axis=1), share @ triangle[:, 2], -np.inf)
        owner[value > best] = k
        best = np.maximum(best, value)
    np.testing.assert_array_equal(raster.triangle.ravel(), owner)
    np.testing.assert_allclose(raster.nearness.ravel(), best, rtol=1e-9, atol=1e-9)


def test_raster_leaves_out_what_is_not_finite_or_flat():
    triangle = np.array([[0.0, 0.0, 1.0], [9.0, 0.0, 1.0], [0.0, 9.0, 1.0]])
    broken = triangle.copy()
    broken[1, 2] = np.nan
    flat = np.zeros((3, 3))
    raster = rasterise(np.array([broken, flat, triangle]), 10, 10)
    assert set(np.unique(raster.triangle)) == {-1, 2}
    assert (rasterise(np.empty((0, 3, 3)), 4, 3).triangle == -1).all()


def is_red(rgb: np.ndarray) -> bool:
    return rgb[0] > 2.0 * rgb[2]


@pytest.mark.parametrize("perspective", [True, False])
@pytest.mark.parametrize("red_first", [True, False])
def test_near_box_hides_a_far_one_in_any_order(perspective, red_first):
    near = (coal.Box(0.1, 0.3, 0.3), (0.6, 0.0, 1.0), RED)
    far = (coal.Box(0.1, 0.6, 0.6), (-0.6, 0.0, 1.0), BLUE)
    shapes = (near, far) if red_first else (far, near)
    image = render(picture(*shapes), camera_along_x(perspective), 60, 60)
    assert is_red(image[30, 30])
    assert image[30, 17, 2] > 2.0 * image[30, 17, 0]  # the far one looks out at the side
    np.testing.assert_allclose(image[3, 3], 1.0)  # and beside both there is nothing


def test_boxes_that_reach_into_each_other_meet_in_the_right_place():
    # Turned by 45 degrees, two flat boxes cross in the middle: each hides half of the other.
    centre = np.array([0.0, 0.0, 1.0])
    turned = [pin.SE3(pin.utils.rotate("z", s * np.pi / 4), centre) for s in (1, -1)]
    plate = tessellate(coal.Box(0.002, 0.8, 0.4))
    meshes = [plate.moved(T) for T in turned]
    n = len(plate.vertices)
    crossed = Picture(
        Mesh(
            np.vstack([m.vertices for m in meshes]),
            np.vstack([m.normals for m in meshes]),
            np.vstack([plate.triangles, plate.triangles + n]),
        ),
        np.repeat([0, 1], len(plate.triangles)),
        np.array([RED, BLUE]),
    )
    row = render(crossed, camera_along_x(False), 80, 80)[40]
    left, right = row[20:38], row[42:60]
    assert is_red(right[5]) != is_red(left[5])
    assert all(is_red(rgb) == is_red(left[5]) for rgb in left)
    assert all(is_red(rgb) == is_red(right[5]) for rgb in right)


def test_a_sphere_covers_the_area_of_its_disc():
    ball = picture((coal.Sphere(0.3), (0.0, 0.0, 1.0), RED))
    image = render(ball, camera_along_x(False), 160, 160, smooth=1)
    covered = (image.min(axis=2) < 0.9).mean()  # of a window of one square metre
    assert covered == pytest.approx(np.pi * 0.3**2, rel=0.02)


def test_floor_lies_in_the_shadow_of_what_stands_on_it():
    box = picture((coal.Box(0.3, 0.3, 0.3), (0.0, 0.0, 0.5), RED))
    camera = Camera.around(np.array([0.0, 0.0, 0.3]), 0.0, 0.6, 4.0)
    camera = camera.fitted(np.array([[-1.0, -1.0, 0.0], [1.0, 1.0, 1.0], [1.0, -1.0, 0.0]]))
    bare = render(picture((coal.Box(0.3, 0.3, 0.3), (0.0, 0.0, -5.0), RED)), camera, 90, 80)
    image = render(box, camera, 90, 80)
    darker = (bare - image > 0.1).all(axis=2)
    grey = np.ptp(image, axis=2) < 1e-9
    assert (darker & grey).sum() > 100
