"""A session whose robot walks by a stick, besides being dragged, pushed and loaded."""

from __future__ import annotations

import numpy as np

from equipoise.contacts import SoleContact
from equipoise.errors import EquipoiseError
from equipoise.robots import Robot
from equipoise.scenarios import schema
from equipoise.simulation.build.rehearse import FAR
from equipoise.simulation.sensors import Reading
from equipoise.spatial import Array
from equipoise.viewer.playing.foot_places import moved, place_of
from equipoise.viewer.playing.footing import Phase
from equipoise.viewer.playing.live import LiveSession
from equipoise.viewer.playing.plant import Physics
from equipoise.viewer.playing.stroll import Stroll, walk_spec
from equipoise.walking import Stick
from equipoise.wbc import WholeBodyController

TOLD = 0.1  # [s] in which a page says what is done before it is done
HALVES = 4  # tries of steps that are shorter by half each
FALLS = 0.03  # [m] outside its soles, from which on a zero-moment point is told


class WalkingSession(LiveSession):
    """Lets a robot on two soles walk while `stick` is held, and stand when it is let go.

    While it walks its hands stay as they are, and what is dragged waits; then the handles are where
    the hands are. `fastest` is the stick at which a step goes as far as it may, None of a robot
    that cannot walk; `why_it_stands` says why.
    Raises: InputError for a robot of which nothing can be dragged, or an engine not installed.
    """

    def __init__(self, robot: Robot, physics: Physics = "rigid") -> None:
        self._stick = Stick()
        self._stroll: Stroll | None = None
        self._spec: schema.WalkSpec | None = None
        self.why_it_stands, self._doubt = "", ""
        self._rehearsed = False
        self._tries_at = np.inf  # [s] when the walk is rehearsed, behind what the page says of it
        super().__init__(robot, physics)
        self.fastest = self._find_fastest()

    @property
    def stick(self) -> Stick:
        """How fast it is wanted to walk; any thread may set it."""
        return self._stick

    @stick.setter
    def stick(self, stick: Stick) -> None:
        with self._lock:
            self._stick = stick

    @property
    def walks(self) -> bool:
        """Whether it walks, or gets ready to, or comes to rest."""
        return self._stroll is not None

    @property
    def walk_in_words(self) -> str:
        """What the walk does; nothing of a robot that stands."""
        with self._lock:
            if self._stroll is not None:
                return f"{self._stroll.sentence} {self._doubt}".strip()
            if np.isfinite(self._tries_at) and not self._rehearsed:
                return "It tries the walk in its mind, which takes a few seconds, once."
            foot = self.footing
            waits = self._stick.held and foot is not None and foot.phase is not Phase.STANDS
            return "It walks once both feet stand." if waits else ""

    def restart(self) -> None:
        with self._lock:
            self._stick, self._stroll, self._tries_at = Stick(), None, np.inf
            super().restart()

    def _find_fastest(self) -> Stick | None:
        """Return the stick of the longest steps, None where it cannot walk."""
        if self.footing is None or not self.footing.lifts:
            self.why_it_stands = "it has not two soles"
            return None
        try:
            self._spec = walk_spec(self.robot)
            stroll = self._make_stroll()
        except EquipoiseError as error:
            self.why_it_stands = str(error)
            return None
        stride, period = self._spec.stride, stroll.walk.planner.period
        return Stick(
            stride.forward / period, 0.5 * stride.side / period, 0.5 * stride.turn / period
        )

    def _make_stroll(self) -> Stroll:
        assert self.footing is not None
        assert self._spec is not None
        feet = [foot for foot in self.footing.feet.values() if isinstance(foot, SoleContact)]
        return Stroll(self.robot, self._spec, feet, self.robot.at(self._reference()))

    def _lead_on(self, seconds: float) -> None:
        stroll, foot = self._stroll, self.footing
        if stroll is not None:
            if stroll.over:
                self._stand_again(stroll)
            return
        stands = foot is not None and foot.phase is Phase.STANDS
        if self.fastest is not None and self._stick.held and stands:
            if self._rehearsed:
                self._set_off()
                return
            self._tries_at = min(self._tries_at, self.t + TOLD)
            if self.t >= self._tries_at:
                self._rehearse(self.fastest)
        else:
            self._tries_at = np.inf
        super()._lead_on(seconds)

    def _rehearse(self, fastest: Stick) -> None:
        """Find how long steps are that the legs reach, by halves; doubt what may fall."""
        assert self._spec is not None
        for _ in range(HALVES):
            behind, room = self._make_stroll().rehearse(self._reference(), fastest)
            if behind <= FAR:
                break
            stride = self._spec.stride
            half = {name: 0.5 * value for name, value in stride.model_dump().items()}
            stride = stride.model_copy(update=half)
            self._spec = self._spec.model_copy(update={"stride": stride})
            fastest = Stick(0.5 * fastest.forward, 0.5 * fastest.left, 0.5 * fastest.turn)
        self._rehearsed = True
        if room < -FALLS:
            self._doubt = (
                "It may fall: by its nominal masses its zero-moment point comes "
                f"{-1e3 * room:.0f} mm outside its soles."
            )

    def _set_off(self) -> None:
        """Hand over to the controller of a walk."""
        before, stroll = self.controller, self._make_stroll()
        q_ref, v_ref = before.motion.q_ref.copy(), before.workspace.parts["tasks"].v_ref.copy()
        made = WholeBodyController(
            self.robot, stroll.levels(), stroll.contacts, self._settings, q_ref
        )
        made.motion.reset(q_ref, v_ref)
        if self._command is not None:
            made.take_over(self._command.tau.copy())
        self._controller, self._stroll = made, stroll
        stroll.begin(self.t, made, self._plant)

    def _stand_again(self, stroll: Stroll) -> None:
        """Let hands and feet be dragged again, from where they are now."""
        assert self.footing is not None
        self._stroll, kin = None, self.robot.at(self._reference())
        for name, T in zip(stroll.walk.contacts, stroll.stance, strict=True):
            self.footing.feet[name] = moved(self.footing.feet[name], T)
            self.footing.targets[name] = place_of(self.footing.feet[name]).translation.copy()
        self.footing.stepped = True
        for frame in self.targets:
            self.targets[frame] = np.array(kin.placement(frame).translation)
        self._looks = False
        self.order(self.hands, together=self.together)

    def _tick(self) -> None:
        if self._stroll is not None:
            state = self._plant.state
            self._stroll.before_tick(self.t, self._stick, Reading(state.q, state.v, state.lam))
        super()._tick()

    def _measured(self) -> Array | dict[str, Array]:
        if self._stroll is None:
            return super()._measured()
        lam = self._plant.state.lam
        return {name: lam[self._plant_rows[name]] for name in self._stroll.carrying}
