"""The picture of a moment: robot, ghost, world and layers, with a switch for each."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pinocchio as pin
import viser

from equipoise.kinematics import KinematicsEvaluator
from equipoise.scenarios import schema
from equipoise.scenarios.levels import build_levels
from equipoise.scenarios.places import Places
from equipoise.spatial import Array
from equipoise.tasks import AvoidanceTask
from equipoise.viewer.drawing import (
    GHOST_INSET,
    GHOST_OPACITY,
    GHOST_RGB,
    Drawing,
    robot_parts,
)
from equipoise.viewer.forces import ForceLayer, PushLayer
from equipoise.viewer.hierarchy_panel import HierarchyPanel
from equipoise.viewer.layers import BalanceLayer, DistanceLayer
from equipoise.viewer.showing import Moment, Showable
from equipoise.viewer.status_line import StatusLine
from equipoise.viewer.surroundings import Surroundings
from equipoise.viewer.trail import TrailLayer
from equipoise.viewer.unveiling import Unveiling
from equipoise.world import Pair


class Display:
    """Shows moments of a scenario in a viser server; `server` may be seen by several pages."""

    def __init__(
        self, server: viser.ViserServer, scenario: schema.Scenario, places: Places
    ) -> None:
        self.server, self.places = server, places
        self.levels = build_levels(scenario, places)
        self._evaluator = KinematicsEvaluator(places.robot)
        self._ghost_data = places.robot.model.createData()
        _set_stage(server)
        robot = robot_parts(places.scene)
        self._robot = Drawing(server.scene, "/robot", robot)
        self._ghost = Drawing(
            server.scene,
            "/ghost",
            robot,
            colour=GHOST_RGB,
            opacity=GHOST_OPACITY,
            inset=GHOST_INSET,
        )
        self.trails = TrailLayer(server.scene, places)
        self.layers = (
            Surroundings(server.scene, scenario, places),
            ForceLayer(server.scene, places),
            PushLayer(server.scene, scenario, places),
            BalanceLayer(server.scene, places),
            DistanceLayer(server.scene, places, _pairs(scenario, places, self.levels)),
            self.trails,
        )
        self.unveiling = Unveiling(server, (self._ghost, *self.layers[1:]))

    def add_switches(self) -> None:
        """Add a check box a layer, and what the colours and lengths mean."""
        gui = self.server.gui
        things: dict[str, Showable] = {
            "Robot": self._robot,
            "Reference (ghost)": self._ghost,
            **{layer.title: layer for layer in self.layers},
        }
        for title, thing in things.items():
            box = gui.add_checkbox(title, initial_value=True)
            box.on_update(
                lambda event, thing=thing: self.unveiling.set_visible(thing, event.target.value)
            )
        solidity = gui.add_slider("Robot solidity", min=0.1, max=1.0, step=0.05, initial_value=1.0)
        solidity.on_update(lambda event: self._robot.set_opacity(event.target.value))
        gui.add_markdown(
            "*Red arrows: force on the robot, 1 m is 1000 N at a sole (beside the foot) and 100 N "
            "at a hand; orange: wanted; magenta: a push, 1 m is 100 N. Black: centre of mass, red "
            "dot: centre of pressure. The ghost comes out of the robot where the two differ by "
            "more than 3 mm.*"
        )

    def add_hierarchy(self) -> None:
        """Add the table of levels and tasks."""
        self._hierarchy = HierarchyPanel(self.server.gui, self.levels)

    def add_status(self) -> None:
        """Add the line that says how supervisor, law and hierarchy fare."""
        self._status = StatusLine(self.server.gui)

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
            for layer in self.layers:
                layer.show(moment)
            q_ref = moment.values.get("q_ref")
            if q_ref is not None and np.isfinite(q_ref).all():
                pin.forwardKinematics(self.places.robot.model, self._ghost_data, q_ref)
                self._ghost.place(self._ghost_data.oMi)

    def show_panels(self, moment: Moment) -> None:
        """Write table and status of a moment."""
        self._hierarchy.show(moment)
        self._status.show(moment)


def _set_stage(server: viser.ViserServer) -> None:
    """Set the floor, the light and where the camera begins."""
    server.scene.add_grid(
        "/floor", width=4.0, height=4.0, cell_size=0.1, section_size=0.5, plane="xy"
    )
    server.scene.configure_default_lights(cast_shadow=False)
    server.scene.configure_environment_map(hdri=None)  # twice as many pictures without a GPU
    server.scene.add_light_hemisphere(
        "/sky", ground_color=(150, 145, 140), intensity=2.2, position=(0.0, 0.0, 1.0)
    )
    server.initial_camera.position = (1.75, -1.4, 1.25)
    server.initial_camera.look_at = (0.2, 0.0, 0.65)


def _pairs(scenario: schema.Scenario, places: Places, levels: list) -> list[Pair]:
    pairs = {
        p.name: p
        for level in levels
        for t in level
        if isinstance(t, AvoidanceTask)
        for p in t.pairs
    }
    for first, second in scenario.monitor:
        pair = places.scene.pair(first, second)
        pairs.setdefault(pair.name, pair)
    return list(pairs.values())
