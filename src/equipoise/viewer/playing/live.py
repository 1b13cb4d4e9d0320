"""A session with the whole controller: the torque law moves a simulated robot."""

from __future__ import annotations

import math

import numpy as np

from equipoise.contacts import SupportPolygon
from equipoise.control.supervisor import Mode
from equipoise.motion.levels import feet_of, polygon_of
from equipoise.physics import DivergedError
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.tasks import ComPolygonTask, JointLimitsTask, Task
from equipoise.viewer.playing.lead import Pace
from equipoise.viewer.playing.plant import ROTORS, Physics, PlayPlant
from equipoise.viewer.playing.reason import Reason, Solved, joined
from equipoise.viewer.playing.reference import feet_names
from equipoise.viewer.playing.session import PlaySession
from equipoise.wbc import LoopSettings, WholeBodyCommand, WholeBodyController

PACE = Pace(speed=0.25, acceleration=0.5, near=2.5, joints=0.4)
FULL, LAG = 0.99, 0.05  # share of a torque limit; [rad or m] behind the reference
FRICTION = 0.7  # of the floor, as the law counts on it
LED_TICKS = 5  # ticks between two steps of what is dragged
CARRYING, FREE = 1.0, 6.0  # [rad/s^2] of the joints that carry the body, and of all others
SPEEDS = 0.8  # [rad/s] of joints: towards a stretched arm they would race
SHARE, APPROACH = 0.5, 1.5  # of the support for the centre of mass, [1/s] it nears the edge with
DELAY = 0.003  # [s] that the loop has to bear on a floor that gives


class LiveSession(PlaySession):
    """Lets the whole controller run: hierarchy, torque law, supervisor, and a simulated robot.

    `physics` is `rigid` (feet lift, never slip) or `mujoco`. Hands are led so that stretched arms
    stay calm: slowly, and more slowly where joints would race. Where the supervisor stops the law,
    or the simulation diverges, `ended` says so, and nothing moves any more until `restart`.
    Raises: InputError for a robot of which nothing can be dragged, or an engine not installed.
    """

    def __init__(self, robot: Robot, physics: Physics = "rigid") -> None:
        self._physics: Physics = physics
        self._controller: WholeBodyController | None = None
        self._command: WholeBodyCommand | None = None
        self._ticks = 0
        self.ended = ""
        super().__init__(robot, PACE)

    @property
    def controller(self) -> WholeBodyController:
        """The controller that runs."""
        assert self._controller is not None
        return self._controller

    @property
    def plant(self) -> PlayPlant:
        """The simulated robot."""
        return self._plant

    @property
    def t(self) -> float:
        """The time [s] that it has run."""
        return self._ticks * self.controller.dt

    @property
    def physics_in_words(self) -> str:
        """Which engine moves the robot."""
        return f"the robot is simulated by the engine {self._physics}"

    def run(self, seconds: float) -> Array:
        """Go on for some time, at least a tick; return the configuration (nq,) of the robot."""
        with self._lock:
            for _ in range(max(1, round(seconds / self.controller.dt))):
                if self.ended:
                    break
                if self._ticks % LED_TICKS == 0:
                    self._lead(LED_TICKS * self.controller.dt)
                self._tick()
            return self.q

    def restart(self) -> None:
        """Begin anew at half-sitting, with nothing in the hands and nothing dragged."""
        with self._lock:
            kin = self.robot.at(self.robot.q_half_sitting)
            self.ended, self._ticks, self._controller = "", 0, None
            self.q = np.array(self.robot.q_half_sitting)
            for frame in self.targets:
                self.targets[frame] = np.array(kin.placement(frame).translation)
            self.order(self.hands, together=self.together)

    def push(self, frame: str, force: Array) -> None:
        """Push a frame with a force (3,) [N], world axes, for 0.2 s. Raises: InputError."""
        with self._lock:
            self._plant.push(frame, force)

    def carry(self, frame: str, mass: float) -> None:
        """Let a frame carry a mass [kg] that nobody told the law of. Raises: InputError."""
        with self._lock:
            self._plant.carry(frame, mass)

    def set_friction(self, friction: float) -> None:
        """Let the floor have another friction. Raises: InputError in the engine rigid."""
        with self._lock:
            self._plant.set_friction(friction)

    def forces(self) -> dict[str, tuple[float, float]]:
        """Return by supporting contact what presses along its normal [N]: wanted, and measured."""
        with self._lock:
            controller, lam = self.controller, self._plant.state.lam
            bounds = controller.workspace.parts.get("bounds")
            found, at = {}, 0
            for contact in controller.contacts.contacts:
                if contact.supporting:
                    wanted = math.nan if bounds is None else float(bounds.predicted[at + 2])
                    rows = self._plant_rows[contact.name]
                    found[contact.name] = wanted, float(lam[rows][2])
                    at += contact.size
            return found

    def _tick(self) -> None:
        controller, state = self.controller, self._plant.state
        self._command = controller.step(self.t, state.q, state.v, state.lam)
        if controller.supervisor.mode in (Mode.SAFE, Mode.STOPPED):
            self.ended = str(controller.supervisor.changes[-1])
        try:
            self.q = self._plant.step(self._command.tau).q
        except DivergedError as error:
            self.ended = str(error)
        self._ticks += 1

    def _reference(self) -> Array:
        return self.q if self._controller is None else self._controller.motion.q_ref.copy()

    def reason(self) -> Reason:
        """Say what stops the hands that are short, and which motors give all that they can."""
        with self._lock:
            robot, model = self.robot, self.robot.model
            spent = [robot.joint_names[i] for i in self._spent()]
            told = tuple(f"The motor of {name} gives all that it can." for name in spent)
            joints = tuple(int(model.getJointId(name)) for name in spent)
            return joined([super().reason(), Reason(told, joints)])

    def _spent(self) -> list[int]:
        """Return the joints that are behind their reference with all the torque they have."""
        if self._command is None:
            return []
        full = np.abs(self._command.tau) > FULL * self.robot.tau_max
        return [int(i) for i in np.flatnonzero(full & (self._lag() > LAG))]

    def _lag(self) -> Array:
        """Return how far (na,) [rad or m] the joints are from their reference."""
        base = self.robot.nq_base
        return np.abs(self.q[base:] - self._reference()[base:])

    def _joint_rates(self) -> Array:
        if self._command is None:
            return super()._joint_rates()
        rates = self._command.v_ref[self.robot.nv_base :]
        return np.where(self._lag() > LAG, np.inf, rates)  # it waits for joints that are behind

    def _take(self, levels: list[list[Task]]) -> None:
        before = self._controller
        if before is None:
            self._begin(levels)
            return
        q_ref, v_ref = before.motion.q_ref.copy(), before.workspace.parts["tasks"].v_ref.copy()
        tau = None if self._command is None else self._command.tau.copy()
        self._controller = WholeBodyController(
            self.robot,
            [*before.motion.levels[: self._kept], *levels],
            before.contacts,
            before.settings,
            q_ref,
        )
        self._controller.motion.reset(q_ref, v_ref)
        if tau is not None:
            self._controller.take_over(tau)

    def _begin(self, levels: list[list[Task]]) -> None:
        robot = self.robot
        loop = LoopSettings(
            delay=DELAY,
            rotor_inertia=ROTORS,
            accelerations=_accelerations(robot),
        )
        most = np.minimum(robot.v_max, SPEEDS)
        speeds = dict(zip(robot.joint_names, most.tolist(), strict=True))
        keep: list[Task] = [JointLimitsTask("limits", robot, rate=5.0, speeds=speeds)]
        if robot.nv_base:
            feet = feet_of(robot, self.q, feet_names(robot), FRICTION)
            polygon = _shrunk(polygon_of(feet), robot.at(self.q).p_world_com)
            keep.append(ComPolygonTask("balance", polygon, margin=0.0, rate=APPROACH))
            self._controller = WholeBodyController.standing(
                robot, tasks=[keep, *levels], feet=feet_names(robot), loop=loop
            )
        else:
            self._controller = WholeBodyController.fixed(robot, tasks=[keep, *levels], loop=loop)
        self._kept = len(self._controller.motion.levels) - len(levels)
        stack = self._controller.contacts
        self._plant = PlayPlant(robot, stack, self.q, loop.period, self._physics)
        self._plant_rows = stack.rows
        self._controller.take_over(self._plant.engine.stand())
        self._plant.state = self._plant.engine.state

    def _solved(self) -> Solved | None:
        if self._command is None:
            return None
        command = self._command
        return Solved(self.controller.motion.levels, command.hierarchy, command.solution.v)


def _shrunk(polygon: SupportPolygon, com: Array) -> SupportPolygon:
    """Return a polygon drawn together about the middle of its corners, and around where `com` is.

    What is left outside is for pushes, loads and what moving the body itself takes.
    """
    corners = np.asarray(polygon.vertices, dtype=float)
    middle = corners.mean(axis=0)
    return SupportPolygon.of_points(np.vstack((middle + SHARE * (corners - middle), com[:2])))


def _accelerations(robot: Robot) -> Array:
    """Return how fast joints may speed up (na,): those under the body throw it off its feet."""
    most = np.full(robot.na, FREE)
    for frame in [*(sole.frame for sole in robot.soles), *(foot.frame for foot in robot.feet)]:
        most[list(robot.joints_between(frame))] = CARRYING
    return most
