"""How well hands, frames, base and posture followed their references."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from equipoise.analysis.metrics.base import ANGLE, POSITION, Found, Metric, largest, lengths
from equipoise.analysis.run_context import RunContext
from equipoise.scenarios import schema
from equipoise.simulation.build.levels import slowed_way
from equipoise.trajectories import WaypointTrajectory

NEARLY = 0.1  # [s] around its time in which a waypoint counts as come to
LEVER = 0.2  # [m] that a radian counts beside a distance


def _palm(part: slice, ticks: str) -> Callable[[RunContext], float | None]:
    def compute(context: RunContext) -> float | None:
        count = len(context.run.t)
        keep = {
            "settled": context.settled,
            "all": np.ones(count, dtype=bool),
            "end": np.arange(count) == count - 1,
        }[ticks]
        return largest(lengths(context.errors_of(schema.HandOnObjectSpec), part), keep)

    return compute


def _posture(context: RunContext) -> float | None:
    return largest([context.run["dq"]], context.settled)


def _path(context: RunContext) -> float | None:
    errors = context.errors_of(schema.FramePathSpec)
    return largest(lengths(errors, POSITION), context.settled)


def _miss(context: RunContext) -> Found | None:
    """Return how near the frames of ways that are out of reach came to their waypoints at best."""
    run, worst = context.run, None
    for name, spec in context.scenario.tasks.items():
        if not (isinstance(spec, schema.FramePathSpec) and spec.calm and f"error/{name}" in run):
            continue
        error, way = run[f"error/{name}"], slowed_way(spec)[0]
        far = np.hypot(lengths([error], POSITION)[0], LEVER * lengths([error], ANGLE)[0])
        for number, waypoint in enumerate(way):
            if spec.waypoints[number].t > run.t[-1]:
                continue  # the file itself does not come to it
            if waypoint.t > run.t[-1]:  # the way was slowed: it is not over yet
                target = WaypointTrajectory(way).at(float(run.t[-1])).T_world_target
                left = (
                    waypoint.T_world_target.translation - target.translation + error[-1, POSITION]
                )
                miss = float(np.linalg.norm(left))
            else:
                until = run.t[-1] if number == len(way) - 1 else waypoint.t + NEARLY
                there = (run.t >= waypoint.t - NEARLY) & (run.t <= until)
                miss = float(far[there].min(initial=np.inf))
            if worst is None or miss > worst.value:
                worst = Found(miss, names=(name,))
    return worst


def _base(context: RunContext) -> float | None:
    if not context.setup.robot.nv_base:
        return None
    return largest(lengths([context.run["dq"]], POSITION), context.settled)


_TO_TARGETS = "palms to their targets: "
METRICS = (
    Metric(
        "palm_position_error", "m", _TO_TARGETS + "position, settled", _palm(POSITION, "settled")
    ),
    Metric("palm_angle_error", "rad", _TO_TARGETS + "angle, settled", _palm(ANGLE, "settled")),
    Metric("palm_position_worst", "m", _TO_TARGETS + "position, any time", _palm(POSITION, "all")),
    Metric("palm_position_end", "m", _TO_TARGETS + "position, last tick", _palm(POSITION, "end")),
    Metric(
        "posture_error",
        "rad",
        "largest component of q - q_ref, settled (base position in m)",
        _posture,
    ),
    Metric("path_error", "m", "frames to the paths of their own: position, settled", _path),
    Metric(
        "waypoint_miss",
        "m",
        "how near ways that are out of reach came to their waypoints; a radian counts 0.2 m",
        _miss,
    ),
    Metric("base_error", "m", "base from where its reference is, settled", _base),
)
