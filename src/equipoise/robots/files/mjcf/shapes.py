"""Turns the geoms of a compiled MJCF into shapes that collide and shapes that are seen."""

from __future__ import annotations

from typing import Any

import coal
import numpy as np
import pinocchio as pin

from equipoise.optional import require_package
from equipoise.robots.files.finding import WARNING, Finding
from equipoise.robots.files.mjcf.compiled import body_name, pose_of
from equipoise.robots.files.mjcf.tree import Tree

PLANE, SPHERE, CAPSULE, ELLIPSOID, CYLINDER, BOX, MESH = 0, 2, 3, 4, 5, 6, 7  # mjtGeom
COLLISION_GROUP = 3  # by habit, what is not to be seen


def build_shapes(compiled: Any, tree: Tree) -> tuple[pin.GeometryModel, pin.GeometryModel]:
    """Return the collision and the visual shapes; meshes as they are, of MuJoCo's corners.

    A geom that touches something collides. What is of the group 3 is not seen, unless its body
    has nothing else. The geoms of the world are scenery, and left out.
    """
    collision, visual = pin.GeometryModel(), pin.GeometryModel()
    seen: dict[int, list[pin.GeometryObject]] = {}
    hidden: dict[int, list[pin.GeometryObject]] = {}
    for geom in range(compiled.ngeom):
        body = int(compiled.geom_bodyid[geom])
        shape = _shape(compiled, geom) if body else None
        if shape is None:
            if body:
                where, problem = f"link {body_name(compiled, body)!r}", "a plane is not a body"
                tree.findings.append(Finding(WARNING, where, f"{problem}: it is left out"))
            continue
        one = _placed(compiled, tree, geom, shape)
        touches = compiled.geom_contype[geom] or compiled.geom_conaffinity[geom]
        if touches:
            collision.addGeometryObject(one.copy())
        drawn = compiled.geom_group[geom] != COLLISION_GROUP or not touches
        (seen if drawn else hidden).setdefault(body, []).append(one)
    for body in sorted({*seen, *hidden}):
        for one in seen.get(body) or hidden[body]:
            visual.addGeometryObject(one)
    return collision, visual


def excluded(compiled: Any) -> set[tuple[str, str]]:
    """Return the pairs of bodies that the file lets pass through one another."""
    pairs = [divmod(int(pair), 1 << 16) for pair in compiled.exclude_signature]
    return {(body_name(compiled, a), body_name(compiled, b)) for a, b in pairs}


def _placed(compiled: Any, tree: Tree, geom: int, shape: Any) -> pin.GeometryObject:
    body = int(compiled.geom_bodyid[geom])
    place = pose_of(compiled.geom_pos[geom], compiled.geom_quat[geom])
    name = str(compiled.geom(geom).name) or f"{body_name(compiled, body)}_{geom}"
    path = ""
    if compiled.geom_type[geom] == MESH:
        path = str(compiled.mesh(int(compiled.geom_dataid[geom])).name)
    one = pin.GeometryObject(
        name, tree.carrier[body], tree.frame[body], tree.T_carrier_body[body] * place, shape, path
    )
    material = int(compiled.geom_matid[geom])
    rgba = compiled.geom_rgba[geom] if material < 0 else compiled.mat_rgba[material]
    one.meshColor = np.clip(np.array(rgba, dtype=float), 0.0, 1.0)
    return one


def _shape(compiled: Any, geom: int) -> Any | None:
    """Return the shape of a geom, None for a plane and for other endless things."""
    kind, (x, y, z) = int(compiled.geom_type[geom]), map(float, compiled.geom_size[geom])
    if kind == SPHERE:
        return coal.Sphere(x)
    if kind == CAPSULE:
        return coal.Capsule(x, 2.0 * y)
    if kind == CYLINDER:
        return coal.Cylinder(x, 2.0 * y)
    if kind == BOX:
        return coal.Box(2.0 * x, 2.0 * y, 2.0 * z)
    if kind == ELLIPSOID:
        return _mesh(*_ellipsoid(np.array([x, y, z])))
    if kind != MESH:
        return None
    mesh = int(compiled.geom_dataid[geom])
    first, count = int(compiled.mesh_vertadr[mesh]), int(compiled.mesh_vertnum[mesh])
    face, faces = int(compiled.mesh_faceadr[mesh]), int(compiled.mesh_facenum[mesh])
    points = np.array(compiled.mesh_vert[first : first + count], dtype=float)
    return _mesh(points, np.array(compiled.mesh_face[face : face + faces]))


def _mesh(points: np.ndarray, faces: np.ndarray) -> Any:
    mesh = coal.BVHModelOBBRSS()
    mesh.beginModel(len(faces), len(points))
    mesh.addVertices(points)
    mesh.addTriangles(faces.astype(np.int64))
    mesh.endModel()
    return mesh


def _ellipsoid(half: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return corners (k, 3) and triangles of an ellipsoid: a sphere's, stretched."""
    require_package("scipy", "scipy", "the hull of a mesh")
    from scipy.spatial import ConvexHull

    rings, around = 12, 24
    polar = np.linspace(0.0, np.pi, rings + 1)[1:-1]
    turn = np.linspace(0.0, 2.0 * np.pi, around, endpoint=False)
    p, t = np.meshgrid(polar, turn, indexing="ij")
    ball = np.stack([np.sin(p) * np.cos(t), np.sin(p) * np.sin(t), np.cos(p)], axis=-1)
    points = np.vstack([ball.reshape(-1, 3), [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
    hull = ConvexHull(points)
    faces = hull.simplices.copy()
    outward = np.einsum("ij,ij->i", hull.equations[:, :3], np.cross(
        points[faces[:, 1]] - points[faces[:, 0]], points[faces[:, 2]] - points[faces[:, 0]]
    ))  # fmt: skip
    faces[outward < 0.0] = faces[outward < 0.0][:, [0, 2, 1]]
    return points * half, faces
