"""Where a walk led its targets: logged every tick, and led there again from a log."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pinocchio as pin

from equipoise.runlog import Channel, TickRecord
from equipoise.spatial import POSE_SIZE, Array
from equipoise.walking import WalkTargets

LABELS = (
    *("x", "y", "z", "qx", "qy", "qz", "qw"),
    *("vx", "vy", "vz", "wx", "wy", "wz"),
)
UNITS = (*("m",) * 3, *("",) * 4, *("m/s",) * 3, *("rad/s",) * 3)
PREFIX = "led/"


def led_channels(targets: WalkTargets) -> list[Channel]:
    """Return one channel a target."""
    doc = "where a walk wants it: pose, quaternion xyzw, and twist, world axes"
    return [Channel(PREFIX + name, LABELS, UNITS, doc) for name in targets.named]


def write_led(targets: WalkTargets, record: TickRecord) -> None:
    """Fill the views of the present tick."""
    for name, led in targets.named.items():
        row, view = led.row(0.0), record.views[PREFIX + name]
        R = row[:9].reshape(3, 3).T
        view[:3], view[3:POSE_SIZE] = row[9:12], pin.Quaternion(R).coeffs()
        view[POSE_SIZE:] = row[12:]


def lead_again(targets: WalkTargets, values: Mapping[str, Array]) -> bool:
    """Lead the targets to what was logged of a tick; return whether it was, all of it."""
    named = targets.named
    logged = {name: values.get(PREFIX + name) for name in named}
    for name, led in named.items():
        row = logged[name]
        if row is None or not np.isfinite(row).all():
            return False
        led.write(pin.XYZQUATToSE3(row[:POSE_SIZE]), row[POSE_SIZE:])
    return True
