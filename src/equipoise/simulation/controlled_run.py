"""A run as the loop sees it: a controller and a robot somewhere, tick by tick."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator

import numpy as np

from equipoise.runlog import Channel, TickRecord
from equipoise.simulation.build.assemble import Controls
from equipoise.simulation.operator import Operator, OperatorPort
from equipoise.simulation.recorder import Recorder


class ControlledRun(ABC):
    """What every run has, whether its robot is in this process or behind a wire."""

    def __init__(self, controls: Controls, recorder: Recorder) -> None:
        self.controls, self.recorder = controls, recorder
        self.scenario, self.setup = controls.scenario, controls.setup
        self.robot, self.levels = self.setup.robot, controls.levels
        self.controller = controls.controller
        self.dt = self.scenario.control.period
        self.steps = round(self.scenario.duration / self.dt)
        self.tick_ns = np.zeros((self.steps, 2), dtype=np.int64)
        self.operator_port: OperatorPort | None = None

    @property
    def channels(self) -> list[Channel]:
        """What every tick logs."""
        operated = self.operator_port.channels if self.operator_port is not None else []
        return self.recorder.channels + self.robot_channels + operated

    @property
    @abstractmethod
    def robot_channels(self) -> list[Channel]:
        """What the robot's side adds to the log."""

    @property
    def story(self) -> tuple[str, ...]:
        """What a person changed and what the supervisor did, in sentences."""
        changes = self.operator_port.changes if self.operator_port is not None else []
        return (*self.controls.told, *changes, *self.happened, *self.controller.story)

    @property
    def happened(self) -> tuple[str, ...]:
        """What else happened on the way, in sentences."""
        return ()

    def operate(self, operator: Operator) -> None:
        """Let someone change pushes, gains and wanted forces while it runs."""
        self.operator_port = OperatorPort(self.controller, operator)

    @abstractmethod
    def ticks(self, record: TickRecord | None = None) -> Iterator[tuple[float, TickRecord]]:
        """Run; yield time and record of each tick. `lam` acts during the tick.

        Without a `record` of these channels one is made; the next tick overwrites it.
        Raises: `DivergedError`, `RobotLostError`, `StopRequested`.
        """
