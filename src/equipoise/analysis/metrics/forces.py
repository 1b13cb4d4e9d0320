"""How well contact forces followed what was wanted, and what they pushed."""

from __future__ import annotations

import numpy as np

from equipoise.analysis.metrics.base import Found, Metric, least, rms
from equipoise.analysis.run_context import RunContext
from equipoise.contacts import GraspContact
from equipoise.scenarios import schema
from equipoise.spatial import Array


def _forces(context: RunContext) -> list[tuple[Array, Array]]:
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


def _force_rms(context: RunContext) -> float | None:
    errors = [rms(achieved - wanted) for wanted, achieved in _forces(context)]
    return max(errors, default=None)


def _force_share(context: RunContext) -> float | None:
    shares = [
        rms(achieved - wanted) / max(rms(wanted), 1e-9) for wanted, achieved in _forces(context)
    ]
    return max(shares, default=None)


def _travel_error(context: RunContext) -> float | None:
    errors = [
        abs(float(context.run[f"slider/{spec.slider}"][-1, 0]) - slider.travel.distance)
        for _, spec, slider in context.pushes()
    ]
    return max(errors, default=None)


def _creep(context: RunContext) -> float | None:
    """Path of a pushed object in all while its wanted push is below 95 % of the Coulomb force.

    Each hand is wanted to push with its share.
    """
    paths = []
    for name, spec, slider in context.pushes():
        share = slider.coulomb / len(context.setup.pushing[spec.slider])
        below = context.run[f"lam_ref/{name}"][:, 0] < 0.95 * share
        steps = np.abs(np.diff(context.run[f"slider/{spec.slider}"][:, 0]))
        paths.append(float(steps[below[1:] & below[:-1]].sum()))
    return max(paths, default=None)


def _surface_normal(context: RunContext) -> Found | None:
    """Return the least force at surfaces and pushed faces, which cannot pull."""
    kinds = schema.SurfaceContactSpec | schema.PushContactSpec
    names = [name for name, spec in context.scenario.contacts.items() if isinstance(spec, kinds)]
    return least([context.run[f"lam/{name}"][:, 0] for name in names], names)


def _grasp_squeeze(context: RunContext) -> Found | None:
    """Return the least squeeze of grasps whose palms face each other, or that regulate it."""
    columns, names = [], []
    for contact in context.setup.contacts.contacts:
        if isinstance(contact, GraspContact) and (contact.one_sided & {"fz"}):
            column = context.run.channels[f"lam/{contact.name}"].labels.index("fz")
            columns.append(context.run[f"lam/{contact.name}"][:, column])
            names.append(contact.name)
    return least(columns, names)


METRICS = (
    Metric("surface_normal", "N", "least force at a surface or pushed object", _surface_normal),
    Metric("grasp_squeeze", "N", "least squeeze of a held object", _grasp_squeeze),
    Metric("force_error_rms", "N", "regulated contact force, RMS, settled", _force_rms),
    Metric(
        "force_error_share",
        "",
        "its error as a share of its value (a push: while it travels)",
        _force_share,
    ),
    Metric("travel_error", "m", "pushed object from its target at the end", _travel_error),
    Metric("creep", "m", "its path while the push is below the friction force", _creep),
)
