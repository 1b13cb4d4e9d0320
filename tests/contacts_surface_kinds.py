"""One surface of every kind, for tests that hold for all of them."""

from __future__ import annotations

import numpy as np

from equipoise.contacts.surfaces import (
    Cylinder,
    Ellipsoid,
    ImplicitSurface,
    Plane,
    Sphere,
    Surface,
    Torus,
)


def wavy() -> ImplicitSurface:
    """Return a user's own surface: a floor of waves, written with a steep phi."""
    return ImplicitSurface(
        "waves",
        lambda x: 3.0 * (x[2] - 0.05 * np.sin(4 * x[0]) * np.cos(3 * x[1])),
        lambda x: (
            3.0
            * np.array(
                [
                    -0.2 * np.cos(4 * x[0]) * np.cos(3 * x[1]),
                    0.15 * np.sin(4 * x[0]) * np.sin(3 * x[1]),
                    1.0,
                ]
            )
        ),
        lambda x: (
            3.0
            * np.array(
                [
                    [
                        0.8 * np.sin(4 * x[0]) * np.cos(3 * x[1]),
                        0.6 * np.cos(4 * x[0]) * np.sin(3 * x[1]),
                        0.0,
                    ],
                    [
                        0.6 * np.cos(4 * x[0]) * np.sin(3 * x[1]),
                        0.45 * np.sin(4 * x[0]) * np.cos(3 * x[1]),
                        0.0,
                    ],
                    [0.0, 0.0, 0.0],
                ]
            )
        ),
        near=(0.1, 0.2, 0.0),
    )


KINDS: dict[str, Surface] = {
    "plane": Plane(),
    "sphere": Sphere(0.2),
    "cylinder": Cylinder(0.15),
    "ellipsoid": Ellipsoid((0.1, 0.2, 0.35)),
    "torus": Torus(0.3, 0.08),
    "waves": wavy(),
}
