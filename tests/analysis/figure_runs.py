"""Runs made up in memory, of any length and with chosen channels, for tests of the figures."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from equipoise.runlog import Channel, Run
from equipoise.scenarios import read_scenario, resolved_text
from equipoise.simulation.build.setup import Setup, build_setup

WRENCH = ("fx", "fy", "fz", "mx", "my", "mz")
WRENCH_UNITS = ("N",) * 3 + ("N m",) * 3
POSE = ("x", "y", "z", "rx", "ry", "rz")


@cache
def tray_places() -> Setup:
    """Return the places of the shipped scenario."""
    return build_setup(read_scenario("tray"))


def channels() -> list[Channel]:
    """Return the channels that a run of the tray scenario logs, but for what no figure reads."""
    robot = tray_places().robot
    q_names = ("x", "y", "z", "qx", "qy", "qz", "qw", *robot.joint_names)
    pairs = ("tray - desk", "LARM_LINK5 - desk", "RARM_LINK5 - desk", "tray - BODY")
    made = [
        Channel("q", q_names, ("m",) * 3 + ("",) * 4 + ("rad",) * robot.na),
        Channel("q_ref", q_names, ("m",) * 3 + ("",) * 4 + ("rad",) * robot.na),
        Channel("v", robot.velocity_names, ("m/s",) * 3 + ("rad/s",) * (robot.na + 3)),
        Channel("v_ref", robot.velocity_names, ("m/s",) * 3 + ("rad/s",) * (robot.na + 3)),
        Channel("dq", robot.velocity_names, ("m",) * 3 + ("rad",) * (robot.na + 3)),
        Channel("tau", robot.joint_names, "N m"),
        Channel("com", ("x", "y", "z"), "m"),
        Channel("com_margin", ("edge",), "m"),
        Channel("distance", pairs, "m"),
        Channel("lam/grasp", WRENCH, WRENCH_UNITS),
        Channel("lam_ref/grasp", ("fz",), "N"),
    ]
    for side in ("left", "right"):
        units = ("N", "N", "m", "N m")
        labels = ("normal", "friction", "pressure", "yaw")
        made.append(Channel(f"margin/{side}_sole", labels, units))
        made.append(Channel(f"error/{side}_hand", POSE, ("m",) * 3 + ("rad",) * 3))
    return made


def made_run(ticks: int, *, without: tuple[str, ...] = (), scenario: str | None = None) -> Run:
    """Return a run at half-sitting with small random motions; `without` leaves channels out."""
    rng = np.random.default_rng(5)
    robot = tray_places().robot
    arrays, kept = {}, {}
    for channel in channels():
        if channel.name in without:
            continue
        values = 0.05 * rng.normal(size=(ticks, channel.size)).cumsum(axis=0)
        if channel.name.startswith("q"):
            values = np.tile(robot.q_half_sitting, (ticks, 1))
            values[:, 7:] += 0.1 * np.sin(np.arange(ticks) / 40.0)[:, None]
        kept[channel.name], arrays[channel.name] = channel, values
    text = resolved_text(read_scenario("tray")) if scenario is None else scenario
    t = 1e-3 * np.arange(ticks)
    return Run(Path("made"), t, arrays, kept, text, 0, {}, None, True)
