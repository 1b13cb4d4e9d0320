"""The one place that calls the kernels of surfaces. A new surface is its file and a line here."""

from __future__ import annotations

import numpy as np

from equipoise.compiled import compiled
from equipoise.contacts.surfaces.cylinder import cylinder_sample
from equipoise.contacts.surfaces.ellipsoid import ellipsoid_sample
from equipoise.contacts.surfaces.plane import plane_sample
from equipoise.contacts.surfaces.sample import CYLINDER, ELLIPSOID, PLANE, SPHERE, TORUS
from equipoise.contacts.surfaces.sphere import sphere_sample
from equipoise.contacts.surfaces.torus import torus_sample


@compiled
def sample_surface(
    kind: int, numbers: np.ndarray, x: float, y: float, z: float, out: np.ndarray
) -> None:
    """Write value, gradient and Hessian [13] at (x, y, z); nothing for a surface of one's own."""
    if kind == PLANE:
        plane_sample(numbers, x, y, z, out)
    elif kind == SPHERE:
        sphere_sample(numbers, x, y, z, out)
    elif kind == CYLINDER:
        cylinder_sample(numbers, x, y, z, out)
    elif kind == ELLIPSOID:
        ellipsoid_sample(numbers, x, y, z, out)
    elif kind == TORUS:
        torus_sample(numbers, x, y, z, out)
