"""The clock of the targets, slowed while the robot cannot follow them.

The way stays as it is; only when the robot is where changes. A blocked hand, a push, a torque at
its limit: the targets wait, and go on smoothly.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from equipoise.compiled import compiled
from equipoise.compiled.workspace import Part, integers, matrix, vector
from equipoise.errors import InputError
from equipoise.kinematics.kernels import FRAMES
from equipoise.motion.kernels import MotionBlocks
from equipoise.motion.memory import (
    CLOCK,
    CLOCK_RATE,
    CLOCK_TIME,
    FALL,
    FRAME,
    GOVERNED,
    KIND,
    POSTURE_FREE,
    POSTURE_STOP,
    RISE,
    TARGET,
    TICK,
    TURN_FREE,
    TURN_STOP,
    WAY_FREE,
    WAY_STOP,
)
from equipoise.spatial.kernels import rotation_difference
from equipoise.spatial.numbers import positive
from equipoise.tasks.view import FRAME_POSE
from equipoise.trajectories.targets import ROWS as TARGET_ROWS


@dataclass(frozen=True)
class Governor:
    """When the clock of the targets slows, and how fast.

    `way` [m], `turn` [rad]: how far a frame of the reference may be behind its target; `posture`
    [rad or m] how far the robot behind its reference. Each pair is where slowing begins and where
    the clock stands. A clamped torque stops it too. `fall`, `rise` [s]: how long the clock takes at
    least from full speed to a stand, and back.
    Source: Dahl and Nielsen 1990 (path velocity control for limited torques).
    Raises: `InputError` for what is not positive, or a stop before its beginning.
    """

    way: tuple[float, float] = (0.01, 0.03)
    turn: tuple[float, float] = (0.05, 0.15)
    posture: tuple[float, float] = (0.02, 0.1)
    fall: float = 0.1
    rise: float = 0.5

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            for one in value if isinstance(value, tuple) else (value,):
                positive(f"{field.name} of the governor", one)
            if isinstance(value, tuple) and not value[0] < value[1]:
                raise InputError(
                    f"the governor must begin to slow before it stops: {field.name}", given=value
                )

    def write(self, part: Part) -> None:
        """Write what the kernel needs into the part of the tasks."""
        part.clock[GOVERNED:TICK] = (
            1.0, *self.way, *self.turn, *self.posture, 1.0 / self.fall, 1.0 / self.rise
        )  # fmt: skip


def bring_to_stand(part: Part, t: float, within: float) -> None:
    """Let the clock in the part of the tasks slow to a stand, from `t` [s] on if nobody slows it.

    It takes `within` [s] at full speed. A governor with errors beyond any other, so to say.
    """
    clock = part.clock
    if not clock[GOVERNED]:
        clock[GOVERNED], clock[CLOCK_TIME] = 1.0, t
    clock[WAY_FREE:POSTURE_FREE] = 1.0, 2.0, 1.0, 2.0
    clock[POSTURE_FREE], clock[POSTURE_STOP] = -2.0, -1.0
    clock[FALL] = clock[RISE] = 1.0 / within


@compiled
def room(error: float, free: float, stop: float) -> float:
    """Return the rate that an error leaves: 1 up to `free`, 0 from `stop` on, smooth between."""
    x = min(max((stop - error) / (stop - free), 0.0), 1.0)
    return x * x * (3.0 - 2.0 * x)


@compiled
def follow_clock(m: MotionBlocks, dt: float, behind: float, clamped: bool) -> bool:
    """Let the time of the targets go on by dt, slowed by what is behind; tell whether by the robot.

    `behind` is the largest posture error of the robot.
    """
    clock = vector(m.tasks, CLOCK)
    wanted = room(behind, clock[POSTURE_FREE], clock[POSTURE_STOP])
    if clamped:
        wanted = 0.0
    robot_is_behind = wanted < 1.0
    kind, frames = integers(m.tasks, KIND), matrix(m.state, FRAMES)
    rows = matrix(m.targets, TARGET_ROWS)
    for k in range(kind.shape[0]):
        if kind[k] == FRAME_POSE:
            T, target = frames[integers(m.tasks, FRAME)[k]], rows[integers(m.tasks, TARGET)[k]]
            x, y, z = target[9] - T[9], target[10] - T[10], target[11] - T[11]
            way = math.sqrt(x * x + y * y + z * z)
            x, y, z = rotation_difference(target, T)
            turn = math.sqrt(x * x + y * y + z * z)
            wanted = min(wanted, room(way, clock[WAY_FREE], clock[WAY_STOP]))
            wanted = min(wanted, room(turn, clock[TURN_FREE], clock[TURN_STOP]))
    rate = clock[CLOCK_RATE]
    rate = min(max(wanted, rate - dt * clock[FALL]), rate + dt * clock[RISE])
    clock[CLOCK_RATE] = rate
    clock[CLOCK_TIME] += dt * rate
    return robot_is_behind
