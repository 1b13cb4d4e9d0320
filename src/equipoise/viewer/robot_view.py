"""A robot of one's own: joint sliders, frames, limits, and what the loader's checks say."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from functools import partial
from html import escape
from typing import Any

import numpy as np
import pinocchio as pin
import viser

from equipoise.analysis.joint_groups import joint_groups_of
from equipoise.analysis.rendering.scene_meshes import robot_parts
from equipoise.kinematics import KinematicsEvaluator
from equipoise.robots import Robot
from equipoise.robots.files.finding import Finding
from equipoise.viewer.controls import write
from equipoise.viewer.drawing import Drawing
from equipoise.viewer.floor_and_sky import add_floor_and_sky
from equipoise.viewer.plain_text import in_markdown
from equipoise.viewer.server import ViewerServer

_AXES = 0.08  # [m]
_WIDEST = 2.0 * np.pi  # [rad or m] either way that a slider goes


class RobotView:
    """Shows a robot in a guarded server; its posture follows the sliders."""

    def __init__(self, robot: Robot, findings: Sequence[Finding], server: ViewerServer) -> None:
        self.robot, self._server = robot, server.viser
        self.q = np.array(robot.q_half_sitting)
        self._evaluator = KinematicsEvaluator(robot)
        self._still = np.zeros(robot.nv)
        self._lock = threading.RLock()
        scene = self._server.scene
        add_floor_and_sky(scene)
        self._server.initial_camera.position = (1.4, -1.0, 1.05)
        self._server.initial_camera.look_at = (0.0, 0.0, 0.6)
        self._drawing = Drawing(scene, "/robot", robot_parts(robot), robot.model.parents)
        self._frames = _Frames(self._server, robot)
        self._sliders: list[viser.GuiSliderHandle[float]] = []
        self._add_panel(findings)
        self.show()

    def show(self) -> None:
        """Draw the robot at `q`."""
        with self._lock, self._server.atomic():
            kin = self._evaluator.at(self.q, self._still)
            self._drawing.place(kin.pin_data.oMi)
            self._frames.place(kin.pin_data.oMf)

    def set_joints(self, joints: np.ndarray) -> None:
        """Go to joint positions (na,) [rad or m], sliders included."""
        with self._lock:
            for slider, value in zip(self._sliders, joints, strict=True):
                write(slider, float(np.clip(value, slider.min, slider.max)))
            self.show()

    def _add_panel(self, findings: Sequence[Finding]) -> None:
        gui, robot = self._server.gui, self.robot
        gui.add_markdown(
            f"**{in_markdown(robot.name)}** — {robot.na} joints, {robot.mass:.2f} kg\n\n"
            f"soles: {_names([s.frame for s in robot.soles])}; "
            f"palms: {_names([p.frame for p in robot.palms])}; "
            f"camera: {_names([robot.camera] if robot.camera else [])}"
        )
        with gui.add_folder("Checks of the loader", expand_by_default=bool(findings)):
            gui.add_html(findings_table(findings))
        with gui.add_folder("Frames", expand_by_default=False):
            self._frames.add_switches()
        back = gui.add_button("Half-sitting")
        back.on_click(lambda _: self.set_joints(robot.q_half_sitting[robot.nq_base :]))
        zero = gui.add_button("All joints to zero")
        zero.on_click(lambda _: self.set_joints(np.zeros(robot.na)))
        sliders: dict[int, viser.GuiSliderHandle[float]] = {}
        for group in joint_groups_of(robot, robot.joint_names):
            with gui.add_folder(group.title, expand_by_default=False):
                for joint, name in zip(
                    group.joints, group.short_names(robot.joint_names), strict=True
                ):
                    sliders[joint] = self._add_slider(joint, name)
        self._sliders = [sliders[i] for i in range(robot.na)]
        with gui.add_folder("Limits", expand_by_default=False):
            gui.add_html(limits_table(robot))
        gui.main_panel.dock_right()

    def _add_slider(self, joint: int, name: str) -> viser.GuiSliderHandle[float]:
        low = max(float(self.robot.q_min[joint]), -_WIDEST)
        high = min(float(self.robot.q_max[joint]), _WIDEST)
        start = float(np.clip(self.q[self.robot.nq_base + joint], low, high))
        slider = self._server.gui.add_slider(
            name, low, max(high, low + 1e-6), max(1e-4, (high - low) / 2000.0), start
        )
        slider.on_update(lambda event: self._slid(joint, float(event.target.value)))
        return slider

    def _slid(self, joint: int, value: float) -> None:
        with self._lock:
            self.q[self.robot.nq_base + joint] = value
            self.show()


class _Frames:
    """Axes at the named frames: soles, palms and camera, and those of all links."""

    def __init__(self, server: viser.ViserServer, robot: Robot) -> None:
        self._gui = server.gui
        named = [s.frame for s in robot.soles] + [p.frame for p in robot.palms]
        named += [robot.camera] if robot.camera else []
        self._nodes: dict[int, viser.FrameHandle] = {}
        self._named = {robot.frame_id(name) for name in named}
        for index, frame in enumerate(robot.model.frames):
            if frame.type == pin.FrameType.BODY or index in self._named:
                node = server.scene.add_frame(
                    f"/frames/{index}",
                    axes_length=_AXES,
                    axes_radius=_AXES / 25.0,
                    visible=index in self._named,
                )
                server.scene.add_label(f"/frames/{index}/name", frame.name)
                self._nodes[index] = node

    def add_switches(self) -> None:
        """Add a check box for the named frames and one for the rest."""
        for label, wanted, shown in (
            ("Soles, palms, camera", True, True),
            ("All links", False, False),
        ):
            box = self._gui.add_checkbox(label, initial_value=shown)
            box.on_update(partial(self._switch, wanted))

    def place(self, placements: Sequence[pin.SE3]) -> None:
        """Move the axes to the placements of the frames."""
        for index, node in self._nodes.items():
            pose = pin.SE3ToXYZQUAT(placements[index])
            node.position, node.wxyz = pose[:3], pose[[6, 3, 4, 5]]

    def _switch(self, named: bool, event: viser.GuiEvent[Any]) -> None:
        visible = bool(event.target.value)
        for index, node in self._nodes.items():
            if (index in self._named) == named:
                node.visible = visible


def findings_table(findings: Sequence[Finding]) -> str:
    """Return the loader's findings as HTML."""
    if not findings:
        return '<p style="margin: 0.4em 1em" id="equipoise-findings">No errors, no warnings.</p>'
    rows = "".join(f"<li>{escape(str(finding))}</li>" for finding in findings)
    return f'<ul style="margin: 0.4em 1em; font-size: 0.85em" id="equipoise-findings">{rows}</ul>'


def limits_table(robot: Robot) -> str:
    """Return the limits of all joints as HTML."""
    head = "".join(f"<th>{t}</th>" for t in ("joint", "from", "to", "speed", "torque"))
    rows = "".join(
        f"<tr><td>{escape(name)}</td><td>{robot.q_min[i]:.3g}</td><td>{robot.q_max[i]:.3g}</td>"
        f"<td>{robot.v_max[i]:.3g}</td><td>{robot.tau_max[i]:.4g}</td></tr>"
        for i, name in enumerate(robot.joint_names)
    )
    return (
        '<table style="margin: 0 0.8em; font-size: 0.75em; text-align: right">'
        f"<tr>{head}</tr>{rows}</table>"
        '<p style="margin: 0.4em 1em; font-size: 0.75em">rad, rad/s, N m (m, m/s, N where a joint '
        "slides)</p>"
    )


def _names(names: Sequence[str]) -> str:
    return in_markdown(", ".join(names) or "none")
