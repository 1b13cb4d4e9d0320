"""The door for those who want only the motion: levels of tasks in, q_ref and v_ref out."""

from __future__ import annotations

from collections.abc import Sequence

from equipoise.contacts import Contact
from equipoise.errors import InputError
from equipoise.hqp import make_solver
from equipoise.motion.generator import MotionGenerator, MotionStep
from equipoise.motion.levels import (
    Accelerations,
    Wishes,
    bound_accelerations,
    feet_of,
    usual_levels,
)
from equipoise.robots import Robot, require_robot
from equipoise.spatial import Array
from equipoise.spatial.numbers import positive, real_period, real_vector


class InverseKinematics:
    """Strict inverse kinematics of a robot: no law, no forces, no torques.

    `tasks` are levels, highest priority first: a task, or a list of tasks that share a level.
    Around them stand what most robots need: the feet stay (every sole, or the soles and frames
    named by `feet`; none on a fixed base), joint limits hold, the centre of mass stays 2 cm inside
    the feet, and what is left goes to the posture `q_start` (nq,), half-sitting if None. `contacts`
    hold beside the feet. A task of the same kind of one's own replaces limits, balance or posture.
    `accelerations` [rad/s^2] bound the joints, one number, (na,), or by name, right below the
    contacts. `period` [s] of a step. The generator inside is `motion`, the one of
    `WholeBodyController`.
    Source: section III-C, eqs. (14)-(16).
    Raises: `InputError`, `NameNotFoundError`, `ShapeError`.
    """

    def __init__(
        self,
        robot: Robot,
        tasks: Wishes = (),
        q_start: Array | None = None,
        *,
        period: float = 0.01,
        feet: Sequence[str] | None = None,
        contacts: Sequence[Contact] = (),
        accelerations: Accelerations | None = None,
        solver: str = "active_set",
    ) -> None:
        require_robot("the robot that moves", robot)
        self.robot, self.dt = robot, real_period("the period", period)
        q = robot.q_half_sitting if q_start is None else real_vector("q_start", q_start, robot.nq)
        held: list[Contact] = [*feet_of(robot, q, feet, 0.7), *contacts]
        levels = usual_levels(robot, q, held, tasks, 0.02)
        if accelerations is not None:
            levels = bound_accelerations(robot, levels, accelerations, self.dt)
        self.motion = MotionGenerator(robot, levels, lambda: make_solver(solver), self.dt, q)
        self._ticks = 0

    @property
    def t(self) -> float:
        """The time [s] of the next step, if none is given: steps so far times the period."""
        return self._ticks * self.dt

    def step(self, t: float | None = None) -> MotionStep:
        """Return `q_ref` (nq,) and `v_ref` (nv,) of time `t` [s], and move on by a period.

        Base velocities are in base axes. Without `t` the steps count the time from zero.
        Raises: `InputError` for what is no time.
        """
        step = self.motion.step(self.t if t is None else t)
        self._ticks += 1
        return step

    def settle(self, *, speed: float = 1e-3, most: int = 2000) -> MotionStep:
        """Step until no joint moves faster than `speed` [rad/s or m/s]; return the last step.

        Targets that move are followed meanwhile. Raises: `InputError` after `most` steps.
        """
        positive("the speed that counts as rest", speed)
        if not isinstance(most, int) or most < 1:
            raise InputError("the number of steps must be a whole number above zero", given=most)
        for _ in range(most):
            step = self.step()
            if abs(step.v_ref).max() < speed:
                return step
        raise InputError(
            f"the robot still moves after {most} steps",
            given=float(abs(step.v_ref).max()),
            remedy="Give targets at rest, more steps, or a larger speed that counts as rest",
        )
