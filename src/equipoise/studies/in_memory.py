"""A run without a log: every tick in one array, measured as if it had been read back."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter, process_time

import numpy as np

from equipoise.analysis.metrics import METRICS
from equipoise.analysis.metrics.base import Found
from equipoise.analysis.run_context import RunContext
from equipoise.physics import DivergedError
from equipoise.runlog import Run, RunWriter, TickRecord
from equipoise.scenarios.read import resolved_text
from equipoise.simulation.recorder import MODE_CODES
from equipoise.simulation.simulation import Simulation
from equipoise.spatial import Array

SAFE = min(code for mode, code in MODE_CODES.items() if mode.name in ("SAFE", "STOPPED"))
COMPLETED, DIVERGED, OFF = "completed", "diverged", "off"


@dataclass(frozen=True, eq=False)
class Ticks:
    """What a run left in memory: times (n,) [s], `numbers` (n, k) of its record, how it ended."""

    simulation: Simulation
    t: Array
    numbers: Array
    record: TickRecord
    ended: str
    why: str
    wall: float
    cpu: float

    @property
    def run(self) -> Run:
        """The same run as its log would give it."""
        channels = {channel.name: channel for channel in self.simulation.channels}
        arrays = {name: self.numbers[:, place] for name, place in self.record.places.items()}
        seed = self.simulation.scenario.seed
        return Run(Path(), self.t, arrays, channels, "", seed, {}, None, complete=True)

    def metrics(self, names: Iterable[str]) -> dict[str, float]:
        """Return the metrics of these names that apply to the run."""
        context = RunContext(self.run, self.simulation.scenario, self.simulation.setup)
        values = {}
        for name in names:
            found = METRICS[name].compute(context) if len(self.t) else None
            if found is not None:
                values[name] = float(found.value if isinstance(found, Found) else found)
        return values

    def write_log(self, folder: Path) -> None:
        """Write the log that `equipoise run` would have written. Raises: `RunLogError`."""
        scenario = self.simulation.scenario
        with RunWriter(
            folder,
            self.simulation.channels,
            scenario_text=resolved_text(scenario),
            seed=scenario.seed,
            info={"robot": scenario.robot, "scenario": scenario.name},
        ) as writer:
            for t, numbers in zip(self.t, self.numbers, strict=True):
                writer.record.numbers[:] = numbers
                writer.write_record(float(t))


def run_in_memory(simulation: Simulation, *, stop_when_off: bool) -> Ticks:
    """Run a simulation; with `stop_when_off` it ends when the supervisor switches the law off."""
    record = TickRecord(simulation.channels)
    t = np.zeros(simulation.steps)
    numbers = np.empty((simulation.steps, record.numbers.size))
    mode, count, ended, why = record["mode"], 0, COMPLETED, ""
    wall, cpu = perf_counter(), process_time()
    try:
        for now, _ in simulation.ticks(record):
            t[count], numbers[count] = now, record.numbers
            count += 1
            if stop_when_off and mode[0] >= SAFE:
                ended = OFF
                break
    except DivergedError as error:
        ended, why = DIVERGED, str(error)
    spent = perf_counter() - wall, process_time() - cpu
    if ended == OFF or (count and numbers[:count, record.places["mode"]].max() >= SAFE):
        changes = simulation.controller.supervisor.changes
        why = next((change.cause for change in changes if MODE_CODES[change.mode] >= SAFE), why)
    return Ticks(simulation, t[:count], numbers[:count], record, ended, why, *spent)
