"""The page of `play`: a robot with handles on hands and feet, and words for what stops it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from html import escape
from itertools import permutations

import numpy as np
import viser

from equipoise.analysis.rendering.scene_meshes import robot_parts
from equipoise.kinematics import KinematicsEvaluator
from equipoise.spatial import Array
from equipoise.viewer.drawing import Drawing
from equipoise.viewer.floor_and_sky import add_floor_and_sky
from equipoise.viewer.plain_text import in_markdown
from equipoise.viewer.playing.camera import FollowingCamera
from equipoise.viewer.playing.live import LiveSession
from equipoise.viewer.playing.live_panel import TEXT, LivePanel
from equipoise.viewer.playing.reason import Reason
from equipoise.viewer.playing.session import GAZE, PlaySession
from equipoise.viewer.playing.stick_panel import StickPanel
from equipoise.viewer.playing.walking import WalkingSession
from equipoise.viewer.server import ViewerServer

PICTURES = 30.0  # [1/s] at most
ASKED = 0.4  # [s] between two questions why: an answer solves the hierarchy several times
LIT, OPACITY, OUTSET = (225, 40, 30), 0.75, 0.003  # colour, and [m] outwards
HANDLE, SMALL_HANDLE = 0.22, 0.12  # [m] of a hand's; of a foot's and of the gaze's
MOVED = 1e-3  # [m] from which on a handle goes to where its foot was put down
REAL = 0.95  # share of real time that counts as real time
MOST_ORDERED = 3  # hands of which every order is offered
ABOUT = (
    "Drag a handle. The hands follow in their order; joint limits and balance hold. "
    "What stops a hand is red, and said below. "
)
FEET = "Drag a foot: the weight goes over the other feet first. Drag it to the floor to step. "
WALK = "Hold the stick, and it walks; its arms stay as they are meanwhile. "
FEET_STAY = "Feet have no handles: {}. "
REFERENCE_ONLY = "*What moves is the reference: no torque law and no engine runs here.*"
WITH_LAW = "*The torque law moves a simulated robot, in the engine {engine}.*"


class Play:
    """Shows a session in a guarded server; `start` lets it run until `stop`."""

    def __init__(self, session: PlaySession, server: ViewerServer) -> None:
        self.session, self._server = session, server.viser
        robot = session.robot
        self._evaluator = KinematicsEvaluator(robot)
        self._still = np.zeros(robot.nv)
        self._parts = robot_parts(robot)
        scene = self._server.scene
        add_floor_and_sky(scene)
        scene.configure_default_lights(cast_shadow=False)
        self._drawing = Drawing(scene, "/robot", self._parts, robot.model.parents)
        self._lit: dict[int, Drawing] = {}
        size = _size(session)
        self._server.initial_camera.position = (1.25 * size, -size, 0.85 * size)
        self._server.initial_camera.look_at = (0.15, 0.0, 0.55 * size)
        self.handles = {
            hand: self._add_handle(hand, place, HANDLE, self.session.drag)
            for hand, place in session.targets.items()
        }
        self.feet = {
            foot: self._add_handle(foot, place, SMALL_HANDLE, self.session.drag_foot)
            for foot, place in session.feet.items()
        }
        self.gaze = None if session.seen is None else self._add_gaze(session.seen)
        self.orders = _orders(session.all_hands)
        self.stick: StickPanel | None = None
        self._camera, self._walked = FollowingCamera(self._server), False
        self.live = self._add_panel()
        self._ended = threading.Event()
        self._asked, self._reason = -np.inf, Reason()
        self._thread: threading.Thread | None = None
        self.show()

    def start(self) -> None:
        """Let the robot follow its handles, in a thread of its own."""
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End the thread."""
        self._ended.set()
        if self._thread is not None:
            self._thread.join(timeout=5.0)

    def show(self) -> None:
        """Draw the robot as it is, and say what stops its hands."""
        kin = self._evaluator.at(self.session.q, self._still)
        now = time.perf_counter()
        if now - self._asked > ASKED:
            self._asked, self._reason = now, self.session.reason()
        reason = self._reason
        with self._server.atomic():
            self._drawing.place(kin.pin_data.oMi)
            self._light(reason.joints)
            for joint in reason.joints:
                if joint in self._lit:
                    self._lit[joint].place(kin.pin_data.oMi)
            self._follow_feet()
            if self.live is not None:
                self.live.show(kin)
            self._show_walk()
        text = reasons_as_html(reason)
        if text != self._said.content:
            self._said.content = text

    def _show_walk(self) -> None:
        """Say how the walk goes; handles are away meanwhile, and where the hands are behind it."""
        session = self.session
        if self.stick is None or not isinstance(session, WalkingSession):
            return
        self.stick.show()
        self._camera.follow(session.q[:3], walks=session.walks)
        if session.walks is self._walked:
            return
        self._walked = session.walks
        gaze = [] if self.gaze is None else [self.gaze]
        for handle in (*self.handles.values(), *self.feet.values(), *gaze):
            handle.visible = not self._walked
        if not self._walked:
            for hand, handle in self.handles.items():
                handle.position = session.targets[hand]
            if self.gaze is not None and session.seen is not None:
                self.gaze.position = session.seen

    def _run(self) -> None:
        period, told = 1.0 / PICTURES, 0.0
        while not self._ended.is_set():
            began = time.perf_counter()
            self.session.run(period)
            self.show()
            took = time.perf_counter() - began
            if began - told > 1.0:
                told = began
                self._speed.content = speed_in_words(period / max(took, period))
            self._ended.wait(max(0.0, period - took))

    def _add_handle(
        self, name: str, place: Array, size: float, drag: Callable[[str, Array], None]
    ) -> viser.TransformControlsHandle:
        handle = self._server.scene.add_transform_controls(
            f"/handles/{name}",
            scale=size,
            disable_rotations=True,
            position=place,
            depth_test=False,
        )
        handle.on_update(lambda event: drag(name, np.array(event.target.position)))
        return handle

    def _add_gaze(self, place: Array) -> viser.TransformControlsHandle:
        handle = self._add_handle(
            GAZE, place, SMALL_HANDLE, lambda _, there: self.session.look(there)
        )
        self._server.scene.add_label(f"/handles/{GAZE}/name", "looked at")
        return handle

    def _add_panel(self) -> LivePanel | None:
        gui, session = self._server.gui, self.session
        live = isinstance(session, LiveSession)
        engine = session.plant.physics if isinstance(session, LiveSession) else ""
        feet = FEET if session.feet else FEET_STAY.format(session.why_feet_stay)
        about = (
            ABOUT
            + (feet if session.robot.nv_base else "")
            + self._about_walking()
            + (WITH_LAW.format(engine=engine) if live else REFERENCE_ONLY)
        )
        gui.add_markdown(f"**{in_markdown(session.robot.name)}**")
        if isinstance(session, WalkingSession) and session.fastest is not None:
            self.stick = StickPanel(self._server, session)
        gui.add_markdown(about)
        order = gui.add_dropdown("Order", tuple(self.orders), initial_value=next(iter(self.orders)))
        order.on_update(lambda event: self._reorder(str(event.target.value)))
        back = gui.add_button("Handles back to the start")
        back.on_click(lambda _: self.take_back())
        self._said = gui.add_html(reasons_as_html(Reason()))
        self._speed = gui.add_markdown("")
        panel = None
        if isinstance(session, LiveSession):
            panel = LivePanel(self._server, session, self.begin_anew)
        gui.main_panel.dock_right()
        return panel

    def _about_walking(self) -> str:
        session = self.session
        if not isinstance(session, WalkingSession) or not session.robot.nv_base:
            return ""
        if session.fastest is not None:
            return WALK
        return f"It has no stick to walk with: {in_markdown(session.why_it_stands)}. "

    def begin_anew(self) -> None:
        """Put every handle where it was at the start, and let the stick go."""
        if self.stick is not None:
            self.stick.release()
        self.take_back()

    def take_back(self) -> None:
        """Put every handle, and the hand with it, where it was at the start."""
        kin = self.session.robot.at(self.session.robot.q_half_sitting)
        for hand, handle in self.handles.items():
            handle.position = kin.placement(hand).translation
            self.session.drag(hand, np.array(handle.position))
        for foot, handle in self.feet.items():
            handle.position = self.session.feet_at_start[foot]
            self.session.drag_foot(foot, np.array(handle.position))

    def _follow_feet(self) -> None:
        """Put the handles of feet where they were put down."""
        for foot, place in self.session.feet.items():
            if np.abs(np.array(self.feet[foot].position) - place).max() > MOVED:
                self.feet[foot].position = place

    def _reorder(self, name: str) -> None:
        hands, together = self.orders[name]
        self.session.order(hands, together=together)

    def _light(self, joints: Sequence[int]) -> None:
        """Show the links behind these joints in red, and no others."""
        for joint in joints:
            parts = [part for part in self._parts if part.joint == joint]
            if joint not in self._lit and parts:
                self._lit[joint] = Drawing(
                    self._server.scene,
                    f"/lit/{joint}",
                    parts,
                    colour=LIT,
                    opacity=OPACITY,
                    inset=-OUTSET,
                )
        for joint, drawing in self._lit.items():
            drawing.set_visible(joint in joints)


def _size(session: PlaySession) -> float:
    """Return how far [m] the robot reaches up or out at the start."""
    kin = session.robot.at(session.robot.q_half_sitting)
    places = [kin.placement(name).translation for name in session.robot.frame_names]
    return float(np.clip(np.abs(places).max(), 0.4, 2.0))


def _orders(hands: Sequence[str]) -> dict[str, tuple[tuple[str, ...], bool]]:
    """Return what the list of orders offers: hands, and whether they share a level."""
    found: dict[str, tuple[tuple[str, ...], bool]] = {}
    ordered = list(permutations(hands)) if len(hands) <= MOST_ORDERED else [tuple(hands)]
    for one in ordered:
        found[" before ".join(one)] = (one, False)
    if len(hands) > 1:
        found["all on one level (weights)"] = (tuple(hands), True)
        for hand in hands:
            found[f"only {hand}"] = ((hand,), False)
    return found


def reasons_as_html(reason: Reason) -> str:
    """Return what is said of the hands that are short."""
    if not reason.sentences:
        return f'<p style="{TEXT}" id="equipoise-reasons">Every hand can follow.</p>'
    rows = "".join(f"<li>{escape(sentence)}</li>" for sentence in reason.sentences)
    return f'<ul style="{TEXT}; color: #b3261e" id="equipoise-reasons">{rows}</ul>'


def speed_in_words(share: float) -> str:
    """Return how fast it runs, as a share of real time."""
    if share >= REAL:
        return "*At real time.*"
    return f"*At {share:.1f} × real time.*"
