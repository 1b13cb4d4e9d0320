"""The numbers that tell how a run went, each computed from its log alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from equipoise.analysis.object_metrics import OBJECT_METRICS
from equipoise.contacts import ReactionMargins
from equipoise.runlog import Run
from equipoise.scenarios import schema
from equipoise.scenarios.places import Places
from equipoise.scenarios.read import parse_scenario
from equipoise.spatial import Array


@dataclass(frozen=True)
class Context:
    """A run with its scenario and places; `settled` (N,) marks ticks after `acceptance.after`."""

    run: Run
    scenario: schema.Scenario
    places: Places
    settled: Array

    @classmethod
    def of(cls, run: Run, places: Places | None = None) -> Context:
        """Return the context of a run; `places` is built from its scenario unless given."""
        from equipoise.scenarios.places import build_places

        scenario = parse_scenario(run.scenario_text)
        settled = run.t >= scenario.acceptance.after
        return cls(run, scenario, places or build_places(scenario), settled)

    def errors_of(self, kind: type[schema.TaskBase] = schema.HandOnObjectSpec) -> list[Array]:
        """Return the pose error (N, 6) of each task of a kind: hands that follow an object."""
        return [
            self.run[f"error/{name}"]
            for name, spec in self.scenario.tasks.items()
            if isinstance(spec, kind) and f"error/{name}" in self.run
        ]

    def pushes(self) -> list[tuple[str, schema.PushContactSpec, schema.SliderSpec]]:
        """Return each pushing contact with its slider."""
        return [
            (name, spec, self.scenario.world.sliders[spec.slider])
            for name, spec in self.scenario.contacts.items()
            if isinstance(spec, schema.PushContactSpec)
        ]

    def margins(self, kind: str) -> list[Array]:
        """Return one component (N,) of the reaction margins of each sole."""
        column = ReactionMargins.LABELS.index(kind)
        return [self.run[n][:, column] for n in self.run.names if n.startswith("margin/")]


@dataclass(frozen=True)
class Metric:
    """A named number: its unit, what it says, and how it is computed (None: does not apply)."""

    name: str
    unit: str
    doc: str
    compute: Callable[[Context], float | None]


def compute_metrics(context: Context) -> dict[str, float]:
    """Return every metric that applies to the run, by name."""
    values = {}
    for metric in METRICS.values():
        value = metric.compute(context) if len(context.run.t) else None
        if value is not None:
            values[metric.name] = float(value)
    return values


def _largest(arrays: list[Array], keep: Array) -> float | None:
    """Largest absolute value over the kept ticks; infinite if there is no such tick."""
    if not arrays:
        return None
    if not keep.any():
        return np.inf
    return max(float(np.abs(a[keep]).max()) for a in arrays)


def _least(arrays: list[Array]) -> float | None:
    return min(float(a.min()) for a in arrays) if arrays else None


def _lengths(errors: list[Array], part: slice) -> list[Array]:
    return [np.linalg.norm(e[:, part], axis=1) for e in errors]


_POSITION, _ANGLE = slice(0, 3), slice(3, 6)


def _palm(part: slice, ticks: str) -> Callable[[Context], float | None]:
    def compute(context: Context) -> float | None:
        keep = {
            "settled": context.settled,
            "all": np.ones(len(context.run.t), dtype=bool),
            "end": np.arange(len(context.run.t)) == len(context.run.t) - 1,
        }[ticks]
        return _largest(_lengths(context.errors_of(), part), keep)

    return compute


def _forces(context: Context) -> list[tuple[Array, Array]]:
    """Return wanted and achieved multipliers (K, k) of each contact with regulated rows.

    Of a pushing contact only the ticks of the travel count, of others the settled ones.
    """
    travels = {name: slider.travel for name, _, slider in context.pushes()}
    t, found = context.run.t, []
    for name in context.scenario.contacts:
        if f"lam_ref/{name}" not in context.run:
            continue
        keep = context.settled
        if name in travels:
            keep = (t >= travels[name].start) & (t <= travels[name].end)
        regulated = context.run.channels[f"lam_ref/{name}"].labels
        labels = context.run.channels[f"lam/{name}"].labels
        columns = [labels.index(r) for r in regulated]
        wanted = context.run[f"lam_ref/{name}"][keep]
        found.append((wanted, context.run[f"lam/{name}"][:, columns][keep]))
    return found


def _rms(values: Array) -> float:
    return float(np.sqrt((values**2).mean(axis=0)).max()) if len(values) else np.inf


def _force_rms(context: Context) -> float | None:
    errors = [_rms(achieved - wanted) for wanted, achieved in _forces(context)]
    return max(errors) if errors else None


def _force_share(context: Context) -> float | None:
    shares = [
        _rms(achieved - wanted) / max(_rms(wanted), 1e-9) for wanted, achieved in _forces(context)
    ]
    return max(shares) if shares else None


def _travel_error(context: Context) -> float | None:
    errors = [
        abs(float(context.run[f"slider/{spec.slider}"][-1, 0]) - slider.travel.distance)
        for _, spec, slider in context.pushes()
    ]
    return max(errors) if errors else None


def _creep(context: Context) -> float | None:
    """Way a slider goes in all while its wanted push is below 95 % of its Coulomb force."""
    ways = []
    for name, spec, slider in context.pushes():
        below = context.run[f"lam_ref/{name}"][:, 0] < 0.95 * slider.coulomb
        steps = np.abs(np.diff(context.run[f"slider/{spec.slider}"][:, 0]))
        ways.append(float(steps[below[1:] & below[:-1]].sum()))
    return max(ways) if ways else None


def _torque_step(context: Context) -> float | None:
    tau = context.run["tau"][context.settled]
    if len(tau) < 2:
        return None
    return float((np.abs(np.diff(tau, axis=0)) / context.places.robot.tau_max).max())


def _security_shortfall(context: Context) -> float | None:
    shortfalls = []
    labels = context.run.channels["distance"].labels
    for spec in context.scenario.tasks.values():
        if isinstance(spec, schema.AvoidanceSpec) and spec.enabled:
            columns = [labels.index(f"{a} - {b}") for a, b in spec.pairs]
            shortfalls.append(spec.security - float(context.run["distance"][:, columns].min()))
    return max(shortfalls) if shortfalls else None


def _clearance(context: Context) -> float | None:
    from equipoise.analysis.clearance import least_clearance

    found = least_clearance(context.run, context.places)
    return found.distance if found is not None else None


def _joint_room(context: Context) -> float:
    q, robot = context.run["q"][:, 7:], context.places.robot
    return float(np.minimum(q - robot.q_min, robot.q_max - q).min())


def _share(channel: str, skip: int, limit: str) -> Callable[[Context], float]:
    def compute(context: Context) -> float:
        bound = getattr(context.places.robot, limit)
        return float((np.abs(context.run[channel][:, skip:]) / bound).max())

    return compute


def _status_count(column: int, code: float) -> Callable[[Context], float]:
    return lambda context: float((context.run["status"][:, column] >= code).sum())


def _completed(context: Context) -> float:
    wanted = round(context.scenario.duration / context.scenario.control.period)
    return float(len(context.run.t) == wanted)


def _margin(kind: str) -> Callable[[Context], float | None]:
    return lambda context: _least(context.margins(kind))


_ALL = (
    Metric("completed", "", "1 if the run reached its duration", _completed),
    Metric(
        "palm_position_error",
        "m",
        "palms to their targets: position, settled",
        _palm(_POSITION, "settled"),
    ),
    Metric(
        "palm_angle_error",
        "rad",
        "palms to their targets: angle, settled",
        _palm(_ANGLE, "settled"),
    ),
    Metric(
        "palm_position_worst",
        "m",
        "palms to their targets: position, any time",
        _palm(_POSITION, "all"),
    ),
    Metric(
        "palm_position_end",
        "m",
        "palms to their targets: position, last tick",
        _palm(_POSITION, "end"),
    ),
    Metric(
        "posture_error",
        "rad",
        "largest component of q - q_ref, settled (base position in m)",
        lambda c: _largest([c.run["dq"]], c.settled),
    ),
    Metric(
        "way_error",
        "m",
        "frames to the ways of their own: position, settled",
        lambda c: _largest(_lengths(c.errors_of(schema.FrameWaySpec), _POSITION), c.settled),
    ),
    Metric(
        "base_error",
        "m",
        "base from where its reference is, settled",
        lambda c: _largest(_lengths([c.run["dq"]], _POSITION), c.settled),
    ),
    Metric("force_error_rms", "N", "regulated contact force, RMS, settled", _force_rms),
    Metric(
        "force_error_share",
        "",
        "its error as a share of its value (a push: while it travels)",
        _force_share,
    ),
    Metric("travel_error", "m", "pushed object from its target at the end", _travel_error),
    Metric("creep", "m", "its way while the push is below the friction force", _creep),
    Metric("torque_step", "", "largest change of a torque in a tick, by its limit", _torque_step),
    Metric("clearance", "m", "least distance of any pair of bodies, every 10th tick", _clearance),
    Metric(
        "security_shortfall", "m", "worst intrusion into a security distance", _security_shortfall
    ),
    Metric("joint_room", "rad", "least distance to a joint position limit", _joint_room),
    Metric(
        "velocity_share", "", "largest share of a joint velocity limit", _share("v", 6, "v_max")
    ),
    Metric("torque_share", "", "largest share of a torque limit", _share("tau", 0, "tau_max")),
    Metric("saturated_ticks", "", "ticks with a clamped torque or worse", _status_count(0, 1.0)),
    Metric("held_ticks", "", "ticks on which the last torque was kept", _status_count(0, 2.0)),
    Metric("unsolved_ticks", "", "ticks with an unsolved hierarchy", _status_count(1, 1.0)),
    Metric(
        "com_margin",
        "m",
        "least distance of the CoM projection to the edge of the polygon",
        lambda c: _least([c.run["com_margin"]]),
    ),
    Metric("reaction_normal", "N", "least normal force at a sole", _margin("normal")),
    Metric("reaction_friction", "N", "least distance to the friction cone", _margin("friction")),
    Metric("reaction_pressure", "m", "least room of the centre of pressure", _margin("pressure")),
    Metric("reaction_yaw", "N m", "least room of the yaw moment", _margin("yaw")),
    Metric(
        "contact_drift", "m", "largest contact violation (or rad)", lambda c: c.run["drift"].max()
    ),
    Metric("slack_level0", "", "largest |w| of level 0", lambda c: c.run["slack"][:, 0].max()),
)

_OBJECTS = tuple(Metric(*row) for row in OBJECT_METRICS)

METRICS = {metric.name: metric for metric in (*_ALL, *_OBJECTS)}
