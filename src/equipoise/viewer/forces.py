"""The arrows: forces of the contacts on the robot, wanted ones beside them, and pushes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import viser

from equipoise.analysis.rendering.sole_arrows import outer_sides, sole_arrow
from equipoise.contacts import (
    Contact,
    GraspContact,
    MovingSurfaceContact,
    PointContact,
    SoleContact,
    SurfaceContact,
)
from equipoise.scenarios import schema
from equipoise.simulation.build.setup import Setup
from equipoise.spatial import Array
from equipoise.viewer.layer import Layer, Moment

MEASURED, WANTED, PUSH = (214, 40, 40), (255, 170, 0), (200, 0, 160)
HAND_SCALE, PUSH_SCALE = 1e-2, 1e-2  # [m/N]
BESIDE = 0.025  # [m] between an arrow and its wanted one


class ForceLayer(Layer):
    """Contact forces on the robot as arrows to scale, wanted ones beside them where they exist.

    At a hand an arrow ends where the force acts. At a sole it stands on the floor beside the
    foot, level with the centre of pressure, and points where the floor pushes: up.
    """

    title = "Contact forces"

    def __init__(self, scene: viser.SceneApi, setup: Setup) -> None:
        self._setup = setup
        self._sides = outer_sides(setup)
        self._measured = _arrows(scene, "/forces/measured", MEASURED)
        self._wanted = _arrows(scene, "/forces/wanted", WANTED)

    def set_visible(self, visible: bool) -> None:
        self._measured.visible = self._wanted.visible = visible

    def show(self, moment: Moment) -> None:
        measured, wanted = [], []
        for contact in self._setup.contacts.contacts:
            lam = moment.values.get(f"lam/{contact.name}")
            if lam is None:
                continue
            measured += self._arrows(contact, moment, lam, 0.0)
            target = _wanted_rows(contact, moment)
            if target is not None:
                wanted += self._arrows(contact, moment, target, BESIDE)
        _draw(self._measured, measured)
        _draw(self._wanted, wanted)

    def _arrows(self, contact: Contact, moment: Moment, lam: Array, beside: float) -> list[Array]:
        if isinstance(contact, SoleContact):
            arrow = sole_arrow(contact, lam, self._sides[contact.name], beside)
            return [] if arrow is None else [arrow]
        return force_arrows(contact, moment, lam, beside)


class PushLayer(Layer):
    """Pushes of a person and of the scenario as arrows that end where they act."""

    title = "Pushes"

    def __init__(self, scene: viser.SceneApi, scenario: schema.Scenario, setup: Setup) -> None:
        self._planned = [
            (setup.robot.frame_id(push.frame), push) for push in scenario.faults.pushes
        ]
        self._handle = _arrows(scene, "/pushes", PUSH)

    def set_visible(self, visible: bool) -> None:
        self._handle.visible = visible

    def show(self, moment: Moment) -> None:
        pushes = [
            (moment.kin.placement(frame).translation, np.array(push.force))
            for frame, push in self._planned
            if push.start <= moment.t < push.start + push.duration
        ]
        force, point = moment.values.get("push"), moment.values.get("push_point")
        if force is not None and point is not None and np.isfinite(point).all():
            pushes.append((point, force))
        _draw(self._handle, [_ending(p, PUSH_SCALE * f) for p, f in pushes if f.any()])


def force_arrows(contact: Contact, moment: Moment, lam: Array, beside: float) -> list[Array]:
    """Return arrows (2, 3) [m] from tail to tip, world axes, for the rows `lam` at a hand.

    They are the forces on the robot, moved by `beside` [m] for the sake of another arrow.
    """
    if not np.isfinite(lam).all() or not lam.any():
        return []
    for kind, arrows in _KINDS.items():
        if isinstance(contact, kind):
            return arrows(contact, moment, lam, beside)
    return []


def _grasp(contact: GraspContact, moment: Moment, lam: Array, beside: float) -> list[Array]:
    T_a, T_b = moment.kin.placement(contact.frame_a), moment.kin.placement(contact.frame_b)
    force, shift = HAND_SCALE * (T_a.rotation @ lam[:3]), _up(beside)
    return [_ending(T_b.translation + shift, force), _ending(T_a.translation + shift, -force)]


def _surface(
    contact: SurfaceContact | MovingSurfaceContact, moment: Moment, lam: Array, beside: float
) -> list[Array]:
    point = contact.position(moment.kin) + _up(beside)
    return [_ending(point, HAND_SCALE * lam[0] * contact.normal(moment.kin))]


def _point(contact: PointContact, moment: Moment, lam: Array, beside: float) -> list[Array]:
    return [_ending(contact.p_world + _up(beside), HAND_SCALE * lam[:3])]


_KINDS: dict[type | tuple[type, ...], Callable[..., list[Array]]] = {
    GraspContact: _grasp,
    (SurfaceContact, MovingSurfaceContact): _surface,
    PointContact: _point,
}


def _ending(point: Array, arrow: Array) -> Array:
    return np.array([point - arrow, point])


def _up(height: float) -> Array:
    return np.array([0.0, 0.0, height])


def _wanted_rows(contact: Contact, moment: Moment) -> Array | None:
    """Return the rows of a contact with the wanted values, zero where none is wanted."""
    target = moment.values.get(f"lam_ref/{contact.name}")
    if target is None:
        return None
    rows = np.zeros(contact.size)
    for label, value in zip(contact.regulated, target, strict=True):
        rows[contact.labels.index(label)] = value
    return rows


def _arrows(scene: viser.SceneApi, name: str, colour: tuple[int, int, int]) -> viser.ArrowsHandle:
    return scene.add_arrows(
        name,
        np.zeros((1, 2, 3)),
        colour,
        shaft_radius=0.008,
        head_radius=0.02,
        head_length=0.045,
    )


def _draw(handle: viser.ArrowsHandle, arrows: list[Array]) -> None:
    handle.points = np.array(arrows or np.zeros((0, 2, 3)), dtype=np.float32)
