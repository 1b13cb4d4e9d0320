"""Write the scenarios `sphere` and `cylinder`: waypoints of a palm that lies on a curved surface.

Run it from the checkout: python tools/author_surface_paths.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin

FOLDER = Path(__file__).parents[1] / "src/equipoise/scenarios/files"
SKIN = 0.04  # [m] from the palm frame to the skin, along the palm's normal

Steps = list[tuple[float, np.ndarray, np.ndarray]]  # time [s], point [m], normal

HEADER = """# A palm slides along a {name} and keeps pressing it with a wanted force.
# Written by tools/author_surface_paths.py. Lengths in m, angles in rad, times in s, forces in N.
name: {name}
title: HRP-2 slides a palm along a {name} with a tracked normal force
robot: hrp2
duration: 10.0
world:
  bodies:
    {name}:
      shapes:
        - {{{shape}, at: {{xyz: {centre}}}, colour: [0.75, 0.62, 0.2, 1.0]}}
contacts:
  left_sole: {{kind: sole, sole: left_sole}}
  right_sole: {{kind: sole, sole: right_sole}}
  press:
    kind: surface
    frame: right_palm
    offset: [0.0, 0.0, {skin}]  # on the palm's skin
    surface: {{{surface}, at: {{xyz: {centre}}}}}
    force: {{times: [0.0, 0.6, 4.5, 5.5], values: [3.0, 8.0, 8.0, 5.0]}}
tasks:
  left_foot: {{kind: hold_frame, frame: left_sole, priority: 1}}
  right_foot: {{kind: hold_frame, frame: right_sole, priority: 1}}
  com: {{kind: com_polygon, margin: 0.11, priority: 1}}
  right_hand:
    kind: frame_path
    frame: right_palm
    priority: 2
    waypoints:
{waypoints}
  left_hand: {{kind: hold_frame, frame: left_palm, priority: 2}}
  limits: {{kind: joint_limits, priority: 2}}
  obstacles:  # the robot leans; without these its arms sink into waist and chest
    kind: avoidance
    priority: 3
    influence: 0.15
    security: 0.003
    damping: 0.25
    pairs:
      - [RARM_LINK2, BODY]
      - [LARM_LINK3, CHEST_LINK1]
      - [RARM_LINK3, CHEST_LINK1]
  posture: {{kind: posture, rate: 2.0, priority: 4}}
control:
  start: standing
  gains: {{kappa: 300.0}}
acceptance:
  after: 1.0
  limits:
    completed: {{min: 1}}
    force_error_share: {{max: 0.01}}
    contact_violation: {{max: 0.0001}}
    posture_error: {{max: 0.005}}
    joint_margin: {{min: 0.0}}
    velocity_share: {{max: 1.0}}
    torque_share: {{max: 1.0}}
    torque_step: {{max: 0.05}}
    com_margin: {{min: 0.01}}
    reaction_normal: {{min: 0.0}}
    reaction_friction: {{min: 0.0}}
    reaction_pressure: {{min: 0.0}}
    reaction_yaw: {{min: 0.0}}
    slack_level0: {{max: 1.0e-6}}
"""


def palm_on(point: np.ndarray, normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return xyz and rpy of the palm frame whose skin touches `point`, palm against `normal`."""
    z = -normal
    forward = np.array([np.cos(0.1), 0.0, -np.sin(0.1)])
    x = forward - z * (z @ forward)
    x /= np.linalg.norm(x)
    R = np.column_stack((x, np.cross(z, x), z))
    return point + SKIN * normal, pin.rpy.matrixToRpy(R)


def waypoints(path: Steps) -> str:
    """Return YAML lines for (time, point, normal)."""
    lines = []
    for t, point, normal in path:
        xyz, rpy = palm_on(point, normal)
        numbers = [", ".join(f"{value:.5f}" for value in v) for v in (xyz, rpy)]
        lines.append(f"      - {{t: {t:.2f}, xyz: [{numbers[0]}], rpy: [{numbers[1]}]}}")
    return "\n".join(lines)


def right_side(azimuth: float, elevation: float) -> np.ndarray:
    """Return the unit normal at angles [rad] from the -y direction."""
    across = np.cos(elevation)
    return np.array([np.sin(azimuth) * across, -np.cos(azimuth) * across, np.sin(elevation)])


def sphere() -> str:
    """Return the scenario of the sphere: once around a loop of 25 by 12 degrees."""
    centre, radius = np.array([0.42, -0.10, 0.92]), 0.15
    path: Steps = []
    for turn in np.linspace(0.0, 2.0 * np.pi, 13):
        normal = right_side(np.radians(25.0) * np.sin(turn), np.radians(12.0) * np.sin(2 * turn))
        path.append((0.5 + 9.0 * turn / (2.0 * np.pi), centre + radius * normal, normal))
    return fill("sphere", f"sphere: {radius}", f"sphere: {radius}", centre, path)


def cylinder() -> str:
    """Return the scenario of the cylinder: 25 degrees either way, 8 cm up and down."""
    centre, radius = np.array([0.42, -0.12, 0.92]), 0.12
    path: Steps = []
    for turn in np.linspace(0.0, 2.0 * np.pi, 13):
        normal = right_side(np.radians(25.0) * np.sin(turn), 0.0)
        up = np.array([0.0, 0.0, 0.08 * np.sin(2 * turn)])
        path.append((0.5 + 9.0 * turn / (2.0 * np.pi), centre + up + radius * normal, normal))
    shape = f"cylinder: [{radius}, 0.4]"
    return fill("cylinder", shape, f"cylinder: {radius}", centre, path)


def fill(name: str, shape: str, surface: str, centre: np.ndarray, path: Steps) -> str:
    """Return the filled-in scenario."""
    return HEADER.format(
        name=name,
        shape=shape,
        surface=surface,
        centre=[float(x) for x in centre],
        skin=SKIN,
        waypoints=waypoints(path),
    )


if __name__ == "__main__":
    for text, name in ((sphere(), "sphere"), (cylinder(), "cylinder")):
        (FOLDER / f"{name}.yaml").write_text(text, encoding="utf-8")
