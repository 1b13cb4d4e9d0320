"""Rounded bodies from cross sections: shells, limbs and covers that a designer would draw."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from equipoise.analysis.rendering.looks.normals import with_normals
from equipoise.analysis.rendering.tessellation import Mesh
from equipoise.spatial import Array

AROUND = 20  # corners of a cross section
BETWEEN = 2  # cross sections drawn from one given to the next
ROUND_STEPS = 3  # cross sections of a rounded end

Section = tuple[float, float, float, float, float]


def loft(
    axis: str,
    sections: Sequence[Section],
    *,
    exponent: float = 2.6,
    rounding: float | tuple[float, float] = 0.01,
    arc: tuple[float, float] | None = None,
) -> Mesh:
    """Return a body through cross sections along an axis ("x", "y" or "z").

    A section is (place along the axis, half a, half b, centre a, centre b) [m], where a and b are
    the axes that follow in the order x, y, z. Its outline is a superellipse: 2 is an ellipse, large
    exponents a box with rounded corners. `rounding` [m] is that of both ends, or of each; `arc`
    [rad] takes only a part of the outline, from a towards b, as for a visor.
    """
    ends = rounding if isinstance(rounding, tuple) else (rounding, rounding)
    rows = _rounded(_smooth(np.array(sections, dtype=float)), ends)
    start, stop = arc or (0.0, 2.0 * np.pi)
    angle = np.linspace(start, stop, AROUND + 1)
    cosine, sine = np.cos(angle), np.sin(angle)
    power = 2.0 / exponent
    unit = np.column_stack(
        [np.sign(cosine) * np.abs(cosine) ** power, np.sign(sine) * np.abs(sine) ** power]
    )
    if arc is None:
        unit = unit[:-1]
    points = np.empty((len(rows), len(unit), 3))
    points[:, :, 0] = rows[:, 0, None]
    points[:, :, 1] = rows[:, 3, None] + rows[:, 1, None] * unit[:, 0]
    points[:, :, 2] = rows[:, 4, None] + rows[:, 2, None] * unit[:, 1]
    first = "xyz".index(axis)
    order = [(k - first) % 3 for k in range(3)]
    triangles = _between_rings(len(rows), len(unit), closed=arc is None)
    return with_normals(points.reshape(-1, 3)[:, order], triangles)


def mirrored(mesh: Mesh) -> Mesh:
    """Return the mesh on the other side of the plane y = 0."""
    flip = np.array([1.0, -1.0, 1.0])
    return Mesh(mesh.vertices * flip, mesh.normals * flip, mesh.triangles[:, ::-1])


def _smooth(sections: Array) -> Array:
    """Return the sections with some between them, on cubics that do not overshoot."""
    if len(sections) < 3:
        return sections
    place, values = sections[:, 0], sections[:, 1:]
    step = np.diff(place)[:, None]
    slope = np.diff(values, axis=0) / step
    tangent = np.vstack([slope[:1], 0.5 * (slope[:-1] + slope[1:]), slope[-1:]])
    turns = slope[:-1] * slope[1:] <= 0.0
    tangent[1:-1][turns] = 0.0
    rows = []
    for k in range(len(step)):
        for u in np.arange(BETWEEN) / BETWEEN:
            a, b = (1.0 + 2.0 * u) * (1.0 - u) ** 2, u * (1.0 - u) ** 2
            c, d = u * u * (3.0 - 2.0 * u), u * u * (u - 1.0)
            value = a * values[k] + c * values[k + 1]
            value = value + step[k] * (b * tangent[k] + d * tangent[k + 1])
            rows.append([place[k] + u * step[k, 0], *value])
    return np.array([*rows, sections[-1]])


def _rounded(rows: Array, rounding: tuple[float, float]) -> Array:
    """Return the rows with both ends closed by a quarter of a circle."""
    quarter = np.linspace(0.0, np.pi / 2.0, ROUND_STEPS + 1)[:-1]
    ends = []
    for end, outward, wanted in ((rows[0], -1.0, rounding[0]), (rows[-1], 1.0, rounding[1])):
        r = min(wanted, *(0.9 * end[1:3]))
        cap = np.repeat(end[None, :], ROUND_STEPS + 1, axis=0)
        cap[:-1, 0] += outward * r * (np.sin(quarter) - 1.0) + outward * r
        cap[:-1, 1:3] -= r * (1.0 - np.cos(quarter))[:, None]
        cap[-1, 0] += outward * r
        cap[-1, 1:3] = 1e-5
        ends.append(cap)
    return np.vstack([ends[0][::-1], rows[1:-1], ends[1]])


def _between_rings(rings: int, around: int, *, closed: bool) -> np.ndarray:
    k = np.arange(around if closed else around - 1)
    after = (k + 1) % around
    found = []
    for ring in range(rings - 1):
        low, high = ring * around, (ring + 1) * around
        found.append(np.column_stack([low + k, low + after, high + after]))
        found.append(np.column_stack([low + k, high + after, high + k]))
    return np.vstack(found)
