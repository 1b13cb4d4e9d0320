"""A session with the whole controller: the torque law moves a simulated robot."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from equipoise.contacts import Contact, ContactStack, PointContact, SoleContact
from equipoise.control.modes import Mode
from equipoise.motion.levels import bound_accelerations
from equipoise.physics import DivergedError
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.tasks import ContactTask, JointLimitsTask, Task
from equipoise.viewer.playing.borne import HandForces
from equipoise.viewer.playing.foot_places import place_of
from equipoise.viewer.playing.footing import Footing, Phase
from equipoise.viewer.playing.limits import PACE, accelerations_of, speeds_of
from equipoise.viewer.playing.plant import ROTORS, Physics, PlayPlant
from equipoise.viewer.playing.reason import Reason, Solved, find_reason, joined
from equipoise.viewer.playing.reference import feet_names
from equipoise.viewer.playing.session import SHORT, PlaySession
from equipoise.wbc import LoopSettings, WholeBodyCommand, WholeBodyController
from equipoise.wbc.doors import Wish, mount, stand

FULL, LAG = 0.99, 0.05  # share of a torque limit; [rad or m] behind the reference
LED_TICKS = 5  # ticks between two steps of what is dragged
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
        self._arms = HandForces(robot, self.all_hands)

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
                    self._lead_on(LED_TICKS * self.controller.dt)
                self._tick()
            return self.q

    def _lead_on(self, seconds: float) -> None:
        """Lead what is dragged on for some time."""
        self._lead(seconds)
        self._step_feet(seconds)

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
        """Return by foot what presses along its normal [N]: wanted, and measured."""
        with self._lock:
            if self.footing is None:
                return {}
            controller, lam = self.controller, self._plant.state.lam
            bounds, at = controller.workspace.parts["bounds"], 0
            wanted = dict.fromkeys(self.footing.feet, 0.0)
            for contact in controller.contacts.contacts:
                wanted[contact.name] = float(bounds.predicted[at + 2])
                at += contact.size
            return {foot: (w, float(lam[self._plant_rows[foot]][2])) for foot, w in wanted.items()}

    def lifted(self) -> dict[str, tuple[float, float]]:
        """Return by hand what was put there, and what the motors of its arm lift [N]."""
        with self._lock:
            loads = self._plant.loads
            if self._command is None:
                return {hand: (9.81 * loads.get(hand, 0.0), 0.0) for hand in self._arms.hands}
            found = self._arms.lifted(self.q, self._command.tau)
            return {hand: (9.81 * loads.get(hand, 0.0), f) for hand, f in found.items()}

    @property
    def why_feet_stay(self) -> str:
        """Why no foot can be dragged, in words."""
        return "only soles can be lifted here, and these are points"

    def _tick(self) -> None:
        controller, state = self.controller, self._plant.state
        self._command = controller.step(self.t, state.q, state.v, self._measured())
        if controller.supervisor.mode in (Mode.SAFE, Mode.STOPPED):
            self.ended = str(controller.supervisor.changes[-1])
        try:
            self.q = self._plant.step(self._command.tau).q
        except DivergedError as error:
            self.ended = str(error)
        self._ticks += 1

    def _measured(self) -> Array | dict[str, Array]:
        """Return the wrenches of the feet that carry."""
        lam = self._plant.state.lam
        if self.footing is None:
            return lam
        return {name: lam[self._plant_rows[name]] for name in self.footing.carrying}

    def _reference(self) -> Array:
        return self.q if self._controller is None else self._controller.motion.q_ref.copy()

    def reason(self) -> Reason:
        """Say what stops the hands that are short, and which motors give all that they can."""
        with self._lock:
            robot, model = self.robot, self.robot.model
            spent = [robot.joint_names[i] for i in self._spent()]
            told = tuple(f"The motor of {name} gives all that it can." for name in spent)
            joints = tuple(int(model.getJointId(name)) for name in spent)
            foot = self.footing
            feet = [Reason()]
            if foot is not None and foot.short:
                solved, off = self._solved(), foot.off(robot.at(self.q))
                if solved is not None and off > SHORT:
                    feet = [find_reason(robot, solved, {foot.foot: off})]
            return joined([super().reason(), *feet, Reason(told, joints)])

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

    def _rest(self) -> Array:
        """Return half-sitting; legs that have stepped stay as they are."""
        rest = super()._rest().copy()
        if self.footing is not None and self.footing.stepped:
            now = self._reference()[self.robot.nq_base :]
            for foot in self.footing.feet.values():
                legs = list(self.robot.joints_between(str(foot.frame)))
                rest[legs] = now[legs]
        return rest

    def _joint_rates(self) -> Array:
        if self._command is None:
            return super()._joint_rates()
        rates = self._command.v_ref[self.robot.nv_base :]
        return np.where(self._lag() > LAG, np.inf, rates)  # it waits for joints that are behind

    def _take(self, levels: list[list[Task]]) -> None:
        before = self._controller
        if before is None:
            self._begin()
        made = self._make(levels)
        self._controller = made
        if before is None:
            made.take_over(self._plant.engine.stand())
            self._plant.state = self._plant.engine.state
            return
        q_ref, v_ref = before.motion.q_ref.copy(), before.workspace.parts["tasks"].v_ref.copy()
        made.motion.reset(q_ref, v_ref)
        if self._command is not None:
            made.take_over(self._command.tau.copy())
        if self.footing is not None:
            made.switch(self.footing.carrying)

    def _begin(self) -> None:
        """Choose gains, say what it stands on, and let it stand there in the engine."""
        robot = self.robot
        self._loop = LoopSettings(
            delay=DELAY, rotor_inertia=ROTORS, accelerations=accelerations_of(robot)
        )
        self._speeds = speeds_of(robot)
        nothing = Wish((), (), None)
        if robot.nv_base:
            parts = stand(robot, self.q, feet_names(robot), nothing, self._loop)
            self.footing = Footing(robot, _feet(parts.contacts), self._speeds)
        else:
            parts = mount(robot, self.q, nothing, self._loop)
            self.footing = None
        self._settings, stack = parts.settings, parts.contacts
        if self.footing is not None and self.footing.lifts:
            self._settings = replace(parts.settings, split="zmp")
        self._plant = PlayPlant(robot, stack, self.q, self._loop.period, self._physics)
        self._plant_rows = stack.rows

    def _make(self, wishes: list[list[Task]]) -> WholeBodyController:
        """Return a controller of these wishes, at the reference of now, on the feet of now."""
        robot, q_ref = self.robot, self._reference()
        feet: list[Contact] = []
        levels: list[list[Task]] = []
        if self.footing is not None:
            feet = [*self.footing.feet.values()]
            levels += [[ContactTask("contacts", ContactStack(feet))]]
            levels += self.footing.levels(robot.at(q_ref))
        else:
            levels += [[JointLimitsTask("limits", robot, rate=5.0, speeds=self._speeds)]]
        most = self._loop.accelerations
        assert most is not None
        levels = bound_accelerations(robot, levels + wishes, most, self._loop.period)
        return WholeBodyController(robot, levels, ContactStack(feet), self._settings, q_ref)

    def _step_feet(self, seconds: float) -> None:
        """Lead the foot that is dragged; where it lifts or lands, let others carry."""
        footing = self.footing
        if footing is None:
            return
        before, lam = footing.phase, self._plant.state.lam
        loads = {name: float(lam[self._plant_rows[name]][2]) for name in footing.feet}
        after = footing.advance(seconds, self.robot.at(self._reference()), loads)
        if footing.moves:
            self._try_again()
        if after is before:
            return
        foot = footing.foot
        if after is Phase.AIR:
            self.controller.switch(footing.carrying)
            self._plant.support(foot, None)
        elif after is Phase.RETURNS:
            place = place_of(footing.feet[foot])
            self.controller.switch(footing.carrying, anchors={foot: place})
            self._plant.support(foot, place)
        elif after in (Phase.STANDS, Phase.SHIFTS):
            self.order(self.hands, together=self.together)

    def _solved(self) -> Solved | None:
        if self._command is None:
            return None
        command = self._command
        return Solved(self.controller.motion.levels, command.hierarchy, command.solution.v)


def _feet(stack: ContactStack) -> list[SoleContact | PointContact]:
    return [one for one in stack.contacts if isinstance(one, SoleContact | PointContact)]
