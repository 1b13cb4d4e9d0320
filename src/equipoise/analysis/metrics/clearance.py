"""The least distance of any pair of bodies along a run: robot, world, held objects, itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from equipoise.collision.distances import DistanceEvaluator
from equipoise.collision.scene import Pair
from equipoise.kinematics import KinematicsEvaluator
from equipoise.runlog import Run
from equipoise.simulation.build.setup import Setup


@dataclass(frozen=True)
class Clearance:
    """The least distance [m], of which pair, and at which time [s]."""

    distance: float
    pair: str
    t: float


def all_pairs(setup: Setup) -> list[Pair]:
    """Return every pair whose touching would matter.

    The robot's own pairs are those its SRDF leaves enabled. A world body is paired with every
    other body, except a held object with the links that hold it, two fixed bodies, and sliders,
    which are there to be touched.
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
    for body in fixed:
        pairs += [scene.pair(other, body) for other in (*links, *held)]
    for body in held:
        holding = _holding_links(setup, body)
        pairs += [scene.pair(body, other) for other in links if other not in holding]
    return pairs


def least_clearance(run: Run, setup: Setup, stride: int = 10) -> Clearance | None:
    """Return the least distance over every `stride`-th tick and the last; None without pairs."""
    pairs = all_pairs(setup)
    if not pairs:
        return None
    distances = DistanceEvaluator(setup.scene, pairs)
    evaluator = KinematicsEvaluator(setup.robot)
    best = Clearance(np.inf, "", 0.0)
    still = np.zeros(setup.robot.nv)
    for k in sorted({*range(0, len(run.t), stride), len(run.t) - 1}):
        values = distances.at(evaluator.at(run["q"][k], still))
        least = int(np.argmin(values))
        if values[least] < best.distance:
            best = Clearance(float(values[least]), pairs[least].name, float(run.t[k]))
    return best


def _holding_links(setup: Setup, body: str) -> set[str]:
    """Return the links that carry a handle of the object, and what is hinged to them (fingers)."""
    model = setup.robot.model
    joints = {
        model.frames[setup.robot.frame_id(hand)].parentJoint
        for name, hand in setup.handles
        if name == body
    }
    joints |= {j for j in range(1, model.njoints) if model.parents[j] in joints}
    objects = setup.robot.collision_model.geometryObjects
    return {model.frames[g.parentFrame].name for g in objects if g.parentJoint in joints}
