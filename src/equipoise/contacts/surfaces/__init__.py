"""Smooth surfaces `phi(x) = 0` that a contact point may slide on. One file a kind."""

from equipoise.contacts.surfaces.base import Surface, VanishingGradientError
from equipoise.contacts.surfaces.cylinder import Cylinder
from equipoise.contacts.surfaces.ellipsoid import Ellipsoid
from equipoise.contacts.surfaces.implicit import ImplicitSurface, WrongDerivativeError
from equipoise.contacts.surfaces.plane import Plane
from equipoise.contacts.surfaces.sphere import Sphere
from equipoise.contacts.surfaces.torus import Torus

__all__ = [
    "Cylinder",
    "Ellipsoid",
    "ImplicitSurface",
    "Plane",
    "Sphere",
    "Surface",
    "Torus",
    "VanishingGradientError",
    "WrongDerivativeError",
]
