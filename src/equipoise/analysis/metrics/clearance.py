"""The least distance of pairs of bodies along a run: robot, world, held and pushed objects, itself.

A link whose contact presses a surface touches the body that has this surface; such pairs are looked
at by themselves, as they are at zero distance when all is well.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import coal
import numpy as np

from equipoise.collision.distances import DistanceEvaluator
from equipoise.collision.scene import Body, Pair
from equipoise.contacts import SurfaceContact
from equipoise.kinematics import Kinematics, KinematicsEvaluator
from equipoise.runlog import Run
from equipoise.simulation.build.setup import Setup
from equipoise.spatial import Array

TOUCHED = 0.005  # [m] from the surface of a body up to which a contact point is on it
STRIDE = 10  # ticks from one look at the distances to the next


@dataclass(frozen=True, eq=False)
class Clearance:
    """The least distance [m], of which pair, and at which time [s].

    `distances` (K,) of the nearest of `pairs` (K,) at the `ticks` (K,) that were looked at.
    """

    distance: float
    pair: str
    t: float
    distances: Array
    pairs: tuple[str, ...]
    ticks: Array


def all_pairs(setup: Setup, start: Kinematics) -> list[Pair]:
    """Return every pair that must not touch.

    The robot's own pairs are those its SRDF leaves enabled. A world body is paired with every
    other body, except a held object with the links that hold it, two fixed bodies, what a contact
    at the state of `start` touches, and sliders, which have pairs of their own.
    """
    robot, scene = setup.robot, setup.scene
    objects = robot.collision_model.geometryObjects
    frames = robot.model.frames
    link = [frames[g.parentFrame].name for g in objects]
    own = {(link[p.first], link[p.second]) for p in robot.collision_model.collisionPairs}
    pairs = [scene.pair(a, b) for a, b in sorted(own)]
    links = sorted(set(link))
    fixed = [b.name for b in scene.bodies if b.frame is None and b.name not in setup.sliders]
    held = [b.name for b in scene.bodies if b.frame is not None]
    touching = {(pair.first, pair.second) for pair in touching_pairs(setup, start)}
    for body in fixed:
        others = [(other, body) for other in (*links, *held) if (other, body) not in touching]
        pairs += [scene.pair(*names) for names in others]
    for body in held:
        holding = links_at(setup, [hand for name, hand in setup.handles if name == body])
        pairs += [scene.pair(body, other) for other in links if other not in holding]
    return pairs


def touching_pairs(setup: Setup, start: Kinematics) -> list[Pair]:
    """Return the links whose surface contact lies on a fixed body, with this body."""
    pairs = {}
    fixed = [b for b in setup.scene.bodies if b.frame is None and b.name not in setup.sliders]
    for contact in setup.contacts.contacts:
        if not isinstance(contact, SurfaceContact):
            continue
        for body in fixed:
            if abs(_distance_to(body, contact.position(start))) <= TOUCHED:
                for link in sorted(links_at(setup, [contact.frame])):
                    pairs[link, body.name] = setup.scene.pair(link, body.name)
    return list(pairs.values())


def least_clearance(
    run: Run,
    setup: Setup,
    pairs_of: Callable[[Setup, Kinematics], list[Pair]] = all_pairs,
    stride: int = STRIDE,
) -> Clearance | None:
    """Return the least distance over every `stride`-th tick and the last; None without pairs.

    Of `all_pairs`, those of the links with pushed objects where these are then take part too.
    """
    evaluator = KinematicsEvaluator(setup.robot)
    still = np.zeros(setup.robot.nv)
    pairs = pairs_of(setup, setup.robot.at(run["q"][0]))
    pushed = pushed_pairs(setup, run) if pairs_of is all_pairs else {}
    if not pairs and not pushed:
        return None
    ticks = np.array(sorted({*range(0, len(run.t), stride), len(run.t) - 1}))
    looks: list[tuple[DistanceEvaluator, Array]] = []
    if pairs:
        looks.append((DistanceEvaluator(setup.scene, pairs), run["q"]))
    for name, own in pushed.items():
        looks.append((DistanceEvaluator(setup.scene, own), seen_by(setup, run, name)))
    least, names = np.full(len(ticks), np.inf), [""] * len(ticks)
    for distances, q in looks:
        for i, k in enumerate(ticks):
            values = distances.at(evaluator.at(q[k], still))
            nearest = int(np.argmin(values))
            if not values[nearest] >= least[i]:
                least[i], names[i] = values[nearest], distances.pairs[nearest].name
    worst = int(np.argmin(least))
    t = float(run.t[ticks[worst]])
    return Clearance(float(least[worst]), names[worst], t, least, tuple(names), ticks)


def links_at(setup: Setup, frames: Iterable[str | int]) -> set[str]:
    """Return the links with a shape that carry one of these frames, or hang on one (fingers)."""
    model = setup.robot.model
    joints = {model.frames[setup.robot.frame_id(frame)].parentJoint for frame in frames}
    joints |= {j for j in range(1, model.njoints) if model.parents[j] in joints}
    objects = setup.robot.collision_model.geometryObjects
    return {model.frames[g.parentFrame].name for g in objects if g.parentJoint in joints}


def seen_by(setup: Setup, run: Run, slider: str) -> Array:
    """Return the configurations (N, nq) of the robot as a pushed object sees them, at its start."""
    q = run["q"].copy()
    q[:, :3] -= run[f"slider/{slider}"][:, :1] * setup.sliders[slider]
    return q


def pushed_pairs(setup: Setup, run: Run) -> dict[str, list[Pair]]:
    """Return for each slider its pairs with the links that do not push it."""
    if setup.robot.nq_base != 7:
        return {}
    objects = setup.robot.collision_model.geometryObjects
    links = sorted({setup.robot.model.frames[g.parentFrame].name for g in objects})
    found = {}
    for name in setup.sliders:
        if f"slider/{name}" in run:
            pushing = links_at(setup, setup.pushing.get(name, ()))
            found[name] = [setup.scene.pair(x, name) for x in links if x not in pushing]
    return found


def _distance_to(body: Body, p_world: Array) -> float:
    """Return how far [m] a point is from the surface of a fixed body, negative inside."""
    point, least = coal.Sphere(1e-6), np.inf
    at = coal.Transform3s(np.eye(3), p_world)
    for shape in body.shapes:
        T = body.T_parent_body * shape.T_body_shape
        place = coal.Transform3s(T.rotation, T.translation)
        result = coal.DistanceResult()
        found = coal.distance(shape.geometry(), place, point, at, coal.DistanceRequest(), result)
        least = min(least, float(found))
    return least
