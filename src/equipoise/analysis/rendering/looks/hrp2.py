"""The look of our HRP-2: shells in two colours around its links, drawn by us from its dimensions.

Places are in the axes of each link; the left side is drawn, the right one is its mirror image. A
shell stays close to the link's collision shape, so that what seems to touch does touch.
"""

from __future__ import annotations

import numpy as np

from equipoise.analysis.rendering.looks.lofts import loft, mirrored
from equipoise.analysis.rendering.tessellation import Mesh
from equipoise.spatial import Array

WHITE, BLUE = np.array([0.87, 0.88, 0.89]), np.array([0.17, 0.26, 0.42])
JOINT, GLASS = np.array([0.17, 0.18, 0.20]), np.array([0.03, 0.04, 0.06])

Shell = tuple[str, Mesh, Array]  # link, mesh in its axes, colour

HEAD = [
    (0.000, 0.060, 0.055, 0.000, 0.0), (0.030, 0.098, 0.078, 0.000, 0.0),
    (0.075, 0.124, 0.092, -0.004, 0.0), (0.125, 0.130, 0.096, -0.008, 0.0),
    (0.158, 0.124, 0.092, -0.012, 0.0),
]  # fmt: skip


def shells() -> list[Shell]:
    """Return every shell of the robot."""
    sided = [*_arm(), *_leg()]
    right = [(f"R{link[1:]}", mirrored(mesh), rgb) for link, mesh, rgb in sided]
    return [*_trunk(), *_head(), *sided, *right]


def _trunk() -> list[Shell]:
    hips = [(0.070, 0.072, 0.096, -0.018, 0.0), (0.110, 0.112, 0.148, -0.024, 0.0),
            (0.150, 0.120, 0.158, -0.026, 0.0), (0.200, 0.116, 0.152, -0.026, 0.0)]  # fmt: skip
    belt = [(0.212, 0.100, 0.130, -0.024, 0.0), (0.262, 0.100, 0.130, -0.024, 0.0)]
    waist = [(0.250, 0.078, 0.088, -0.010, 0.0), (0.330, 0.074, 0.082, -0.006, 0.0)]
    chest = [(-0.035, 0.082, 0.100, -0.004, 0.0), (0.030, 0.118, 0.140, -0.010, 0.0),
             (0.105, 0.136, 0.176, -0.012, 0.0), (0.185, 0.134, 0.186, -0.022, 0.0),
             (0.240, 0.112, 0.172, -0.032, 0.0)]  # fmt: skip
    pack = [(0.020, 0.060, 0.118, -0.160, 0.0), (0.060, 0.072, 0.140, -0.160, 0.0),
            (0.200, 0.072, 0.146, -0.162, 0.0), (0.258, 0.058, 0.126, -0.156, 0.0)]  # fmt: skip
    plate = [(0.058, 0.118, 0.100, 0.010, 0.0), (0.110, 0.130, 0.128, 0.002, 0.0),
             (0.170, 0.130, 0.140, -0.008, 0.0), (0.205, 0.120, 0.138, -0.014, 0.0)]  # fmt: skip
    turn = [(-0.05, 0.070, 0.076, -0.02, 0.0), (0.04, 0.070, 0.076, -0.02, 0.0)]
    collar = [(0.262, 0.070, 0.092, -0.022, 0.0), (0.298, 0.056, 0.064, -0.012, 0.0)]
    return [
        ("BODY", loft("z", hips, exponent=5.5, rounding=0.014), BLUE),
        ("BODY", loft("z", belt, exponent=4.0, rounding=0.006), WHITE),
        ("BODY", loft("z", waist, rounding=0.01), JOINT),
        ("CHEST_LINK0", loft("z", turn), JOINT),
        ("CHEST_LINK1", loft("z", chest, exponent=4.2, rounding=0.042), WHITE),
        ("CHEST_LINK1", loft("z", pack, exponent=5.0, rounding=0.012), BLUE),
        ("CHEST_LINK1", loft("z", plate, exponent=4.2, rounding=0.001, arc=(-0.62, 0.62)), BLUE),
        ("CHEST_LINK1", loft("z", collar, rounding=0.01), BLUE),
    ]  # fmt: skip


def _head() -> list[Shell]:
    visor = [(z, a + 0.006, b + 0.006, ca, cb) for z, a, b, ca, cb in HEAD[2:5]]
    visor[0] = (0.084, *visor[0][1:])
    neck = [(-0.05, 0.046, 0.046, -0.004, 0.0), (0.03, 0.050, 0.050, -0.004, 0.0)]
    found: list[Shell] = [
        ("HEAD_LINK0", loft("z", neck, exponent=2.0), JOINT),
        ("HEAD_LINK1", loft("z", HEAD, exponent=2.7, rounding=(0.01, 0.052)), WHITE),
        ("HEAD_LINK1", loft("z", visor, exponent=2.7, rounding=0.001, arc=(-1.15, 1.15)), GLASS),
    ]
    cap = [(0.078, 0.040, 0.040, -0.012, 0.115), (0.112, 0.036, 0.036, -0.012, 0.115)]
    fin = [(0.090, 0.022, 0.006, -0.020, 0.108), (0.150, 0.020, 0.006, -0.034, 0.112),
           (0.225, 0.010, 0.004, -0.062, 0.116)]  # fmt: skip
    # across y the axes that follow are z and x
    ear = loft("y", [(y, b, a, z, x) for y, a, b, x, z in cap], exponent=2.0, rounding=0.006)
    blade = loft("z", fin, exponent=2.4, rounding=0.006)
    for part in (ear, blade):
        found += [("HEAD_LINK1", part, BLUE), ("HEAD_LINK1", mirrored(part), BLUE)]
    return found


def _arm() -> list[Shell]:
    shoulder = [(-0.055, 0.058, 0.058, 0.000, 0.004), (0.000, 0.070, 0.070, 0.000, 0.004),
                (0.050, 0.058, 0.058, 0.000, 0.004)]  # fmt: skip
    upper = [(-0.262, 0.040, 0.040, -0.004, 0.006), (-0.200, 0.046, 0.044, -0.005, 0.008),
             (-0.110, 0.052, 0.050, -0.006, 0.008),
             (-0.040, 0.048, 0.046, -0.004, 0.006)]  # fmt: skip
    across = [(-0.04, 0.044, 0.044, 0.01, 0.0), (0.03, 0.044, 0.044, 0.01, 0.0)]
    elbow = [(-0.040, 0.043, 0.043, 0.000, 0.000), (0.052, 0.043, 0.043, 0.000, 0.000)]
    below = [(-0.165, 0.039, 0.039, 0.000, 0.006), (-0.090, 0.044, 0.043, 0.000, 0.010),
             (-0.010, 0.040, 0.040, 0.000, 0.008)]  # fmt: skip
    wrist = [(-0.012, 0.030, 0.030, 0.000, 0.000), (0.030, 0.038, 0.037, -0.001, 0.000),
             (0.085, 0.041, 0.040, -0.001, 0.002)]  # fmt: skip
    palm = [(-0.112, 0.041, 0.030, 0.006, -0.003), (-0.070, 0.043, 0.034, 0.006, -0.001),
            (-0.010, 0.030, 0.030, 0.002, 0.000)]  # fmt: skip
    found: list[Shell] = [
        ("LARM_LINK0", loft("y", shoulder, exponent=2.0, rounding=0.03), BLUE),
        ("LARM_LINK1", loft("x", across, exponent=2.0), JOINT),
        ("LARM_LINK2", loft("z", upper, rounding=0.025), WHITE),
        ("LARM_LINK3", loft("y", elbow, exponent=2.0, rounding=0.012), JOINT),
        ("LARM_LINK3", loft("z", below, rounding=0.02), BLUE),
        ("LARM_LINK4", loft("z", wrist, rounding=0.012), WHITE),
        ("LARM_LINK5", loft("z", palm, exponent=4.0, rounding=0.01), JOINT),
    ]  # fmt: skip
    for x in (-0.024, -0.003, 0.018):
        finger = [(-0.186, 0.007, 0.008, x, -0.014), (-0.150, 0.009, 0.010, x, -0.008),
                  (-0.108, 0.010, 0.012, x, -0.004)]  # fmt: skip
        found.append(("LARM_LINK5", loft("z", finger, exponent=3.0, rounding=0.006), JOINT))
    thumb = [(-0.080, 0.008, 0.009, -0.002, -0.002), (-0.040, 0.010, 0.011, -0.002, 0.006),
             (0.004, 0.013, 0.014, -0.002, 0.006)]  # fmt: skip
    return [*found, ("LARM_LINK6", loft("z", thumb, exponent=3.0, rounding=0.006), JOINT)]


def _leg() -> list[Shell]:
    hip = [(-0.030, 0.056, 0.056, -0.004, 0.010), (0.060, 0.056, 0.056, -0.004, 0.010)]
    thigh = [(-0.285, 0.056, 0.052, 0.006, 0.056), (-0.200, 0.064, 0.058, 0.006, 0.062),
             (-0.100, 0.074, 0.066, 0.004, 0.064), (-0.010, 0.072, 0.064, 0.000, 0.058),
             (0.030, 0.056, 0.050, 0.000, 0.050)]  # fmt: skip
    knee = [(0.005, 0.058, 0.058, 0.000, 0.004), (0.107, 0.058, 0.058, 0.000, 0.004)]
    shin = [(-0.272, 0.042, 0.044, 0.006, 0.040), (-0.210, 0.050, 0.050, 0.008, 0.046),
            (-0.130, 0.062, 0.060, 0.006, 0.054), (-0.060, 0.062, 0.062, 0.010, 0.056),
            (0.020, 0.060, 0.060, 0.014, 0.056)]  # fmt: skip
    cap = [(-0.085, 0.061, 0.052, 0.011, 0.056), (-0.030, 0.065, 0.058, 0.012, 0.056),
           (0.030, 0.062, 0.054, 0.013, 0.056)]  # fmt: skip
    ankle = [(-0.050, 0.040, 0.040, 0.000, 0.004), (0.050, 0.040, 0.040, 0.000, 0.004)]
    upper = [(-0.098, 0.052, 0.026, 0.010, -0.066), (-0.055, 0.060, 0.040, 0.010, -0.054),
             (0.015, 0.060, 0.046, 0.010, -0.050), (0.075, 0.062, 0.028, 0.010, -0.066),
             (0.124, 0.052, 0.014, 0.010, -0.080)]  # fmt: skip
    sole = [(-0.105, 0.112, 0.064, 0.015, 0.010), (-0.088, 0.112, 0.064, 0.015, 0.010)]
    top = [(-0.02, 0.050, 0.050, -0.006, 0.0), (0.10, 0.056, 0.056, -0.006, 0.0)]
    return [
        ("LLEG_LINK0", loft("z", top, exponent=2.0), JOINT),
        ("LLEG_LINK1", loft("y", [(y, a, b, z, x) for y, a, b, x, z in hip], exponent=2.0), JOINT),
        ("LLEG_LINK2", loft("z", thigh, exponent=3.0, rounding=0.02), WHITE),
        ("LLEG_LINK3", loft("y", knee, exponent=2.0, rounding=0.01), JOINT),
        ("LLEG_LINK3", loft("z", shin, exponent=2.8, rounding=0.015), WHITE),
        ("LLEG_LINK3", loft("z", cap, exponent=3.2, rounding=0.004, arc=(-1.0, 1.0)), BLUE),
        ("LLEG_LINK4", loft("y", ankle, exponent=2.0, rounding=0.01), JOINT),
        ("LLEG_LINK5", loft("x", upper, exponent=3.4, rounding=0.02), BLUE),
        ("LLEG_LINK5", loft("z", sole, exponent=5.0, rounding=0.003), JOINT),
    ]  # fmt: skip
