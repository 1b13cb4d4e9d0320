"""Logs made up for the viewer: the tray's robot sways, written by the package's own writer."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from equipoise.runlog import Channel, RunWriter
from equipoise.scenarios import read_scenario, resolved_text
from equipoise.simulation.build.setup import Setup, build_setup

DT = 1e-3
SPIKE = 987.0  # in the first torque, on one tick
WRENCH = ("fx", "fy", "fz", "mx", "my", "mz")
WRENCH_UNITS = ("N",) * 3 + ("N m",) * 3


@cache
def tray_places() -> Setup:
    """Return the places of the shipped scenario."""
    return build_setup(read_scenario("tray"))


def channels() -> list[Channel]:
    """Return what the made-up log holds."""
    robot = tray_places().robot
    q_names = ("x", "y", "z", "qx", "qy", "qz", "qw", *robot.joint_names)
    q_units = ("m",) * 3 + ("",) * 4 + ("rad",) * robot.na
    return [
        Channel("q", q_names, q_units),
        Channel("q_ref", q_names, q_units),
        Channel("v", robot.velocity_names, "rad/s"),
        Channel("dq", robot.velocity_names, "rad"),
        Channel("tau", robot.joint_names, "N m"),
        Channel("s", robot.velocity_names, "rad/s"),
        Channel("distance", ("tray - desk", "tray - BODY"), "m"),
        Channel("slack", tuple(f"level{i}" for i in range(5)), ""),
        Channel("lam/left_sole", WRENCH, WRENCH_UNITS),
        Channel("lam/right_sole", WRENCH, WRENCH_UNITS),
        Channel("lam/grasp", WRENCH, WRENCH_UNITS),
        Channel("lam_ref/grasp", ("fz",), "N"),
        Channel("error/left_hand", ("x", "y", "z", "rx", "ry", "rz"), "m"),
    ]


def write_sway(folder: Path, ticks: int) -> Path:
    """Write `ticks` ticks in which every joint sways by 0.2 rad, and return the folder."""
    robot, rng = tray_places().robot, np.random.default_rng(3)
    text = resolved_text(read_scenario("tray"))
    with RunWriter(folder, channels(), scenario_text=text, seed=0) as writer:
        for k in range(ticks):
            values = {c.name: 0.01 * rng.normal(size=c.size) for c in channels_cached()}
            q = robot.q_half_sitting.copy()
            q[7:] += 0.2 * np.sin(2.0 * np.pi * k * DT)
            values |= {"q": q, "q_ref": q, "slack": np.array([0.0, 1e-9, 1e-8, 1.0, 2.0])}
            for side in ("left", "right"):
                values[f"lam/{side}_sole"] = np.array([0.0, 0.0, 280.0, 2.8, -5.6, 0.0])
            values["lam/grasp"][2] = 15.0
            if k == ticks // 3:
                values["tau"][0] = SPIKE
            writer.write(k * DT, values)
    return folder


@cache
def channels_cached() -> tuple[Channel, ...]:
    """Return the channels, made once."""
    return tuple(channels())
