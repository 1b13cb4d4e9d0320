"""The curves beside the picture: what each shows, and how it comes from what was logged."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from equipoise.analysis.joint_groups import joint_groups_of
from equipoise.runlog import Channel
from equipoise.simulation.build.setup import Setup
from equipoise.spatial import Array

Channels = Mapping[str, Channel]
Compute = Callable[[Mapping[str, Array]], Array]
MOST_CURVES = 6
LEAST_SLACK = 1e-16  # what a logarithmic axis shows for nothing


@dataclass(frozen=True)
class Curve:
    """A scalar over time: `compute` maps arrays (n, k) by channel to values (n,)."""

    label: str
    compute: Compute


@dataclass(frozen=True)
class Plot:
    """Curves with one unit; of `many` curves those are shown that come nearest to zero."""

    title: str
    unit: str
    curves: tuple[Curve, ...]
    logarithmic: bool = False
    many: bool = False


def plots_of(channels: Channels, setup: Setup) -> dict[str, Plot]:
    """Return every plot that there are channels for, by title."""
    makers = (
        _posture,
        _hands,
        _forces,
        _torques,
        _distances,
        _slack,
        _energy,
        _sliding,
        _balance,
        _modes,
    )
    plots = [plot for make in makers if (plot := make(channels, setup)) is not None]
    plots += _joints(channels, setup)
    return {plot.title: plot for plot in plots}


def _column(channel: str, index: int, scale: float = 1.0) -> Compute:
    return lambda arrays: scale * arrays[channel][:, index]


def _length(channel: str, part: slice, scale: float) -> Compute:
    return lambda arrays: scale * np.linalg.norm(arrays[channel][:, part], axis=1)


def _largest(channel: str, columns: list[int], scale: float | Array) -> Compute:
    return lambda arrays: (np.abs(arrays[channel][:, columns]) * scale).max(axis=1)


def _posture(channels: Channels, setup: Setup) -> Plot | None:
    if "dq" not in channels:
        return None
    curves = [
        Curve(group.title, _largest("dq", [setup.robot.nv_base + i for i in group.joints], 1e3))
        for group in joint_groups_of(setup.robot, setup.robot.joint_names)
    ]
    return Plot("Posture error", "mrad", tuple(curves[:MOST_CURVES]))


def _hands(channels: Channels, setup: Setup) -> Plot | None:
    names = [name for name in channels if name.startswith("error/")]
    curves = [
        Curve(name.removeprefix("error/"), _length(name, slice(0, 3), 1e3))
        for name in names[-MOST_CURVES:]
    ]
    return Plot("Task errors (position)", "mm", tuple(curves)) if curves else None


def _forces(channels: Channels, setup: Setup) -> Plot | None:
    curves = []
    for contact in setup.contacts.contacts:
        name = contact.name
        if f"lam/{name}" not in channels:
            continue
        labels = channels[f"lam/{name}"].labels
        if f"lam_ref/{name}" in channels:
            for i, row in enumerate(channels[f"lam_ref/{name}"].labels):
                curves.append(Curve(f"{name} {row}", _column(f"lam/{name}", labels.index(row))))
                curves.append(Curve(f"{name} {row} wanted", _column(f"lam_ref/{name}", i)))
        elif "fz" in labels:
            curves.append(Curve(f"{name} fz", _column(f"lam/{name}", labels.index("fz"))))
    return Plot("Contact forces", "N", tuple(curves[:MOST_CURVES])) if curves else None


def _torques(channels: Channels, setup: Setup) -> Plot | None:
    if "tau" not in channels:
        return None
    robot = setup.robot
    curves = [
        Curve(
            group.title, _largest("tau", list(group.joints), 100.0 / robot.tau_max[[*group.joints]])
        )
        for group in joint_groups_of(robot, robot.joint_names)
    ]
    return Plot("Torques", "% of the limit", tuple(curves[:MOST_CURVES]))


def _distances(channels: Channels, setup: Setup) -> Plot | None:
    if "distance" not in channels:
        return None
    labels = channels["distance"].labels
    curves = [Curve(label, _column("distance", i, 1e3)) for i, label in enumerate(labels)]
    return Plot("Distances", "mm", tuple(curves), many=True) if curves else None


def _slack(channels: Channels, setup: Setup) -> Plot | None:
    if "slack" not in channels:
        return None

    def of_level(i: int) -> Compute:
        return lambda arrays: np.maximum(arrays["slack"][:, i], LEAST_SLACK)

    labels = channels["slack"].labels
    curves = [Curve(label, of_level(i)) for i, label in enumerate(labels)]
    return Plot("Slack of the levels", "", tuple(curves), logarithmic=True)


def _energy(channels: Channels, setup: Setup) -> Plot | None:
    names = [name for name in channels if name in ("V", "energy", "storage")]
    curves = [
        Curve(f"{name} {label}", _column(name, i))
        for name in names
        for i, label in enumerate(channels[name].labels)
    ]
    return Plot("Storage function V", "J", tuple(curves[:MOST_CURVES])) if curves else None


def _sliding(channels: Channels, setup: Setup) -> Plot | None:
    if "s" not in channels:
        return None
    size = channels["s"].size
    curves = (
        Curve("largest joint", _largest("s", list(range(setup.robot.nv_base, size)), 1.0)),
        Curve("base, turning", _largest("s", [3, 4, 5], 1.0)),
    )
    return Plot("Extended error s", "rad/s", curves)


def _balance(channels: Channels, setup: Setup) -> Plot | None:
    if "com_margin" not in channels or setup.polygon is None:
        return None
    curves = [Curve("CoM to the edge", _column("com_margin", 0, 1e3))]
    for name, channel in channels.items():
        if name.startswith("margin/") and "pressure" in channel.labels:
            label = f"CoP in {name.removeprefix('margin/')}"
            curves.append(Curve(label, _column(name, channel.labels.index("pressure"), 1e3)))
    return Plot("Balance: margin to the edge", "mm", tuple(curves[:MOST_CURVES]))


def _modes(channels: Channels, setup: Setup) -> Plot | None:
    curves = [
        Curve(f"{name}: {label}", _column(name, i))
        for name in ("mode", "status")
        if name in channels
        for i, label in enumerate(channels[name].labels)
    ]
    return Plot("Mode and status (0 is well)", "", tuple(curves)) if curves else None


def _joints(channels: Channels, setup: Setup) -> list[Plot]:
    if "q" not in channels or "q_ref" not in channels:
        return []
    base = setup.robot.nq_base
    return [
        Plot(
            f"Joint {name}",
            "rad",
            (
                Curve("measured", _column("q", base + i)),
                Curve("reference", _column("q_ref", base + i)),
            ),
        )
        for i, name in enumerate(setup.robot.joint_names)
    ]
