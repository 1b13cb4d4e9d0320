"""The picture of a moment: robot, ghost, world and layers, with a switch for each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import viser

from equipoise.analysis.rendering.scene_meshes import robot_parts
from equipoise.collision.scene import Pair
from equipoise.kinematics import KinematicsEvaluator
from equipoise.scenarios import schema
from equipoise.simulation.build.fades import build_fades
from equipoise.simulation.build.levels import build_levels
from equipoise.simulation.build.setup import Setup
from equipoise.simulation.build.walk import build_walk
from equipoise.simulation.led_log import lead_again
from equipoise.spatial import Array
from equipoise.tasks import AvoidanceTask, Task
from equipoise.viewer.collision_shapes import CollisionShapes
from equipoise.viewer.drawing import Drawing
from equipoise.viewer.feet import FeetLayer
from equipoise.viewer.floor_and_sky import add_floor_and_sky
from equipoise.viewer.forces import ForceLayer, PushLayer
from equipoise.viewer.ghost import Ghost
from equipoise.viewer.hierarchy_panel import HierarchyPanel
from equipoise.viewer.layer import Moment, Showable
from equipoise.viewer.layers import BalanceLayer, DistanceLayer
from equipoise.viewer.panels import Panels
from equipoise.viewer.progressive import ProgressiveDisplay
from equipoise.viewer.status_line import StatusLine
from equipoise.viewer.surroundings import Surroundings
from equipoise.viewer.trail import TrailLayer


class Display:
    """Shows moments of a scenario in a viser server; `server` may be seen by several pages."""

    def __init__(self, server: viser.ViserServer, scenario: schema.Scenario, setup: Setup) -> None:
        self.server, self.setup = server, setup
        self._walk = build_walk(scenario, setup)
        self.levels = build_levels(scenario, setup, self._walk)
        self._fades = build_fades(scenario)
        self._evaluator = KinematicsEvaluator(setup.robot)
        _set_up_scene(server)
        parts, model = robot_parts(setup.robot), setup.robot.model
        self._robot = Drawing(server.scene, "/robot", parts, model.parents)
        self._ghost = Ghost(server.scene, parts, model, self._robot)
        self._shapes = CollisionShapes(server.scene, setup.robot)
        self.trails = TrailLayer(server.scene, setup)
        self.layers = (
            Surroundings(server.scene, scenario, setup),
            ForceLayer(server.scene, setup),
            PushLayer(server.scene, scenario, setup),
            BalanceLayer(server.scene, setup),
            FeetLayer(server.scene, setup),
            DistanceLayer(server.scene, setup, _pairs(scenario, setup, self.levels)),
            self.trails,
        )
        self.panels = Panels(server.gui)
        later = (self._ghost, *self.layers[1:])
        self.progressive = ProgressiveDisplay(server, ((self.panels,), later))

    def add_panels(self) -> None:
        """Add the line of the supervisor's mode, the switches of the layers and the hierarchy."""
        gui = self.server.gui
        self._status = StatusLine(gui)
        with gui.add_folder("Layers", expand_by_default=False):
            self._add_switches()
        with gui.add_folder("Hierarchy"):
            self._hierarchy = HierarchyPanel(gui, self.setup.robot, self.levels, self._fades)

    def moment(self, t: float, values: Mapping[str, Array]) -> Moment | None:
        """Return the moment of logged `values`; None if the state in them is not finite."""
        q, v = values["q"], values["v"]
        if not (np.isfinite(q).all() and np.isfinite(v).all()):
            return None
        return Moment(t, values, self._evaluator.at(q, v, t))

    def show(self, moment: Moment) -> None:
        """Draw everything of a moment but the table."""
        with self.server.atomic():
            self._robot.place(moment.kin.pin_data.oMi)
            self._shapes.place(moment.kin.pin_data.oMi)
            for layer in self.layers:
                layer.show(moment)
            q_ref = moment.values.get("q_ref")
            if q_ref is not None and np.isfinite(q_ref).all():
                self._ghost.place(q_ref, moment.kin.pin_data.oMi)

    def show_panels(self, moment: Moment) -> None:
        """Write table and status of a moment."""
        if self._walk is not None:
            lead_again(self._walk.targets, moment.values)
        self._hierarchy.show(moment)
        self._status.show(moment)

    def _add_switches(self) -> None:
        """Add a check box a layer, and what the colours and lengths mean."""
        gui = self.server.gui
        items: dict[str, Showable] = {
            "Robot": self._robot,
            "Reference (ghost)": self._ghost,
            **{layer.title: layer for layer in self.layers},
        }
        for title, item in items.items():
            box = gui.add_checkbox(title, initial_value=True)
            box.on_update(partial(self._switch, item))
        shapes = gui.add_checkbox("Collision shapes", initial_value=False)
        shapes.on_update(lambda event: self._shapes.set_visible(bool(event.target.value)))
        solidity = gui.add_slider("Robot solidity", min=0.1, max=1.0, step=0.05, initial_value=1.0)
        solidity.on_update(lambda event: self._make_solid(event.target.value))
        gui.add_markdown(
            "*Red arrows: force on the robot, 1 m is 1000 N at a sole (beside the foot) and 100 N "
            "at a hand; orange: wanted; magenta: a push, 1 m is 100 N. Black: centre of mass, red "
            "dot: centre of pressure. Soles of a walk: green ones carry, grey ones are in the air, "
            "as planned; orange ones touched early, red ones are late, magenta ones are lost. The "
            "ghost comes out of the robot where the two differ by more than 3 mm.*"
        )

    def _switch(self, item: Showable, event: viser.GuiEvent[Any]) -> None:
        self.progressive.set_visible(item, bool(event.target.value))
        self._ghost.reconsider()

    def _make_solid(self, solidity: float) -> None:
        self._robot.set_opacity(solidity)
        self._ghost.reconsider()


def _set_up_scene(server: viser.ViserServer) -> None:
    """Set the floor, the light and where the camera begins."""
    add_floor_and_sky(server.scene)
    server.scene.configure_default_lights(cast_shadow=False)
    server.scene.configure_environment_map(hdri=None)  # twice as many pictures without a GPU
    server.scene.add_light_hemisphere(
        "/sky", ground_color=(150, 145, 140), intensity=2.2, position=(0.0, 0.0, 1.0)
    )
    server.initial_camera.position = (1.75, -1.4, 1.25)
    server.initial_camera.look_at = (0.2, 0.0, 0.65)


def _pairs(scenario: schema.Scenario, setup: Setup, levels: Sequence[Sequence[Task]]) -> list[Pair]:
    pairs = {
        p.name: p
        for level in levels
        for t in level
        if isinstance(t, AvoidanceTask)
        for p in t.pairs
    }
    for first, second in scenario.monitor:
        pair = setup.scene.pair(first, second)
        pairs.setdefault(pair.name, pair)
    return list(pairs.values())
