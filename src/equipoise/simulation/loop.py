"""The one loop: runs a simulation, logs every tick, and says how it ended."""

from __future__ import annotations

import gc
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from time import perf_counter

import numpy as np

from equipoise.physics import DivergedError
from equipoise.runlog import RunWriter
from equipoise.scenarios.read import resolved_text
from equipoise.simulation.controlled_run import ControlledRun
from equipoise.simulation.operator import StopRequested
from equipoise.wire.interface import RobotLostError

Progress = Callable[[float], None]


class Ending(Enum):
    """How a run ended; the value is a sentence."""

    COMPLETED = "the run reached its duration"
    DIVERGED = "the simulated state became infinite"
    LOST = "the robot was lost; what came until then is in the log"
    INTERRUPTED = "the run was interrupted; what was computed is in the log"


@dataclass(frozen=True)
class RunOutcome:
    """How a run ended, at which time [s], and how long it took.

    `wall` [s] is the whole loop; `first_wall` [s] its first tick, in which kernels are loaded, or
    compiled where that was never done; `log_wall` [s] the part of it spent writing. `tick_us` are
    median and 99th percentile [us] of motion and control, `physics_us` of the engine. `changes`
    says what a person changed and which modes the supervisor chose; pauses do not count into
    `wall`.
    """

    ending: Ending
    t_end: float
    wall: float
    first_wall: float
    log_wall: float
    tick_us: tuple[float, float]
    physics_us: tuple[float, float]
    note: str = ""
    changes: tuple[str, ...] = ()


def run_simulation(
    simulation: ControlledRun, folder: Path, progress: Progress | None = None
) -> RunOutcome:
    """Run into `folder` (created, must hold no run yet); `progress` is told the time ever so often.

    Raises: `RunLogError` if the log cannot be written; Ctrl-C ends the run as INTERRUPTED.
    """
    scenario = simulation.scenario
    ending, note = Ending.COMPLETED, ""
    t, ticks, first_wall, log_wall = 0.0, 0, 0.0, 0.0
    gc.collect()
    gc.freeze()  # what is loaded by now stays: the collector need not look at it every tick
    began = perf_counter()
    with RunWriter(
        folder,
        simulation.channels,
        scenario_text=resolved_text(scenario),
        seed=scenario.seed,
        info={"robot": scenario.robot, "scenario": scenario.name},
    ) as writer:
        try:
            for t, _ in simulation.ticks(writer.record):
                writing = perf_counter()
                if not ticks:
                    first_wall = writing - began - _paused(simulation)
                writer.write_record(t)
                log_wall += perf_counter() - writing
                ticks += 1
                if progress is not None and ticks % 50 == 0:
                    progress(t)
        except DivergedError as error:
            ending, note = Ending.DIVERGED, str(error)
        except RobotLostError as error:
            ending, note = Ending.LOST, str(error)
        except (KeyboardInterrupt, StopRequested):
            ending = Ending.INTERRUPTED
    gc.unfreeze()
    wall = perf_counter() - began - _paused(simulation)
    spent = simulation.tick_ns[: max(ticks, 1)] / 1000.0
    return RunOutcome(
        ending,
        t + simulation.dt,
        wall,
        first_wall,
        log_wall,
        _median_and_tail(spent[:, 0]),
        _median_and_tail(spent[:, 1]),
        note,
        simulation.story,
    )


def _paused(simulation: ControlledRun) -> float:
    """Return for how long [s] a person has let the run stand."""
    return (
        simulation.operator_port.operator.paused_s if simulation.operator_port is not None else 0.0
    )


def _median_and_tail(microseconds: np.ndarray) -> tuple[float, float]:
    return float(np.median(microseconds)), float(np.percentile(microseconds, 99))
