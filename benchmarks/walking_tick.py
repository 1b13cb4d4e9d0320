"""The tick of a walk beside that of the tray, in MuJoCo: `python benchmarks/walking_tick.py`.

Both scenarios run as shipped, by turns, in one process; a tick is what reading, walker and
controller take. Writes `benchmarks/walking_tick.json`, from which `python docs/walking_tables.py`
writes the sentence in docs/walking.md. Ends with 1 where the walk takes more than 1.3 times.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from equipoise.bench.interleave import TURN, interleave
from equipoise.bench.rows import write_rows
from equipoise.scenarios import read_scenario
from equipoise.simulation.simulation import Simulation

OUT = Path(__file__).with_name("walking_tick.json")
TICKS = 6000  # of the walk of four steps
MOST = 1.3  # times a tick of the tray


class Runs:
    """A scenario in MuJoCo, run tick by tick."""

    turn = TURN
    failures: Mapping[str, int] = {}
    remarks: Mapping[str, str] = {}

    def __init__(self, scenario: str) -> None:
        self.name = f"tick/mujoco/{scenario}"
        self.simulation = Simulation(read_scenario(scenario, ["physics.engine=mujoco"]))
        self._ticks = self.simulation.ticks()

    def run(self, first: int, count: int) -> Mapping[str, Sequence[int]]:
        """Go on by some ticks; return how long [ns] each took without the engine."""
        for _ in range(count):
            next(self._ticks)
        return {self.name: self.simulation.tick_ns[first : first + count, 0].tolist()}


def main() -> int:
    """Time, keep and print."""
    walk, tray = rows = interleave([Runs("walk"), Runs("tray")], TICKS)
    write_rows(OUT, rows)
    ratio = walk.median_us / tray.median_us
    for row in rows:
        print(f"{row.name:<20}{row.median_us:8.1f} us{row.p99_us:8.1f} us")
    print(f"ratio {ratio:.3f}, at most {MOST} is wanted")
    return 0 if ratio <= MOST else 1


if __name__ == "__main__":
    sys.exit(main())
