"""How far tasks whose errors are not logged were from what they ask, looked at every 10th tick."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from equipoise.analysis.metrics.base import Metric
from equipoise.analysis.run_context import RunContext
from equipoise.scenarios import schema
from equipoise.simulation.build.fades import build_fades
from equipoise.simulation.build.levels import build_task
from equipoise.tasks import Task

EVERY = 10
KINDS = (
    schema.FrameAxesSpec, schema.RelativeFrameSpec, schema.ComPointSpec, schema.JointCouplingSpec,
    schema.KeepInSpec, schema.KeepOutSpec,
)  # fmt: skip


def _worst(unit: str) -> Callable[[RunContext], float | None]:
    def compute(context: RunContext) -> float | None:
        tasks = _tasks(context, unit)
        if not tasks or context.scenario.control.governor is not None:
            return None  # with a governor the targets follow a clock of their own
        ticks = np.flatnonzero(context.settled)[::EVERY]
        if not len(ticks):
            return np.inf
        fades, run = build_fades(context.scenario), context.run
        worst = 0.0
        for tick in ticks.tolist():
            t = float(run.t[tick])
            kin = context.setup.robot.at(run["q"][tick], run["v"][tick], t)
            for task in tasks:
                if task.name in fades and fades[task.name].weight(t) < 1.0:
                    continue  # it comes or goes
                rows = [i for i, one in enumerate(task.units) if one == unit]
                error = float(np.linalg.norm(task.error(kin, t)[rows]))
                worst = error if not error <= worst else worst  # a NaN is the worst of all
        return worst

    return compute


def _tasks(context: RunContext, unit: str) -> list[Task]:
    """Return the tasks of these kinds that have an error of a unit."""
    specs = context.scenario.tasks.items()
    wanted = [(name, spec) for name, spec in specs if isinstance(spec, KINDS) and spec.enabled]
    tasks = [build_task(name, spec, context.scenario, context.setup) for name, spec in wanted]
    return [task for task in tasks if unit in task.units]


_WHOSE = "axes, relative frames, centre of mass, couplings and volumes: "
METRICS = (
    Metric("task_position_error", "m", _WHOSE + "largest distance, settled", _worst("m")),
    Metric("task_angle_error", "rad", _WHOSE + "largest angle, settled", _worst("rad")),
)
