"""Find the gains of the rivals: every pair of a small grid, in nominal and disturbed runs.

`python benchmarks/sweep_rivals.py press mujoco --out rivals_press.jsonl` runs and prints one line a
run; what the file holds already is not run again. `--table FILE` prints it as a table. Chosen are,
of the gains that stand in all conditions, those with the least palm error in the worst of them.
`--nominal` prints every rival with the gains that it has, on whole nominal runs.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from equipoise.control.modes import Mode
from equipoise.errors import EquipoiseError
from equipoise.scenarios import read_scenario
from equipoise.simulation.simulation import Simulation

FALLEN = 0.3  # [m] of a palm from its reference
LATE = "faults.measurement_delay"
CONDITIONS = {
    "press": {
        "nominal": [],
        "5 ms": [f"{LATE}=0.005"],
        "3 ms, 5 kg": [f"{LATE}=0.003", "disturbances.payloads=[{mass: 5, frame: right_palm}]"],
    },
    "tray": {
        "nominal": [],
        "2 ms": [f"{LATE}=0.002"],
        "1 ms, 5 kg": [f"{LATE}=0.001", "disturbances.payloads=[{mass: 5, object: tray}]"],
    },
}
SECONDS = {"press": 1.6, "tray": 2.0}
PAIRS = {
    "mujoco": [(50, 10), (100, 10), (100, 20), (150, 20), (200, 20), (300, 20)],
    "rigid": [(100, 20), (300, 20), (300, 40)],
}
FURTHER = {  # beside kappa and alpha; on rigid contacts the others hardly matter
    "mujoco": {
        "idqp": {"contact_rate": [10, 30, 60]},
        "idqp_i": {"k_i": [5, 10, 20, 50]},
        "admittance": {"k_f": [5, 20]},
    },
    "rigid": {"idqp_i": {"k_i": [5, 20]}},
}
NOMINAL = (("tray", "rigid"), ("press", "rigid"), ("press", "mujoco"))
KINDS = (
    "idqp", "idqp_i", "gravity_contacts", "pd_plus", "projected_ct", "passive_qp", "hybrid",
    "admittance",
)  # fmt: skip


@dataclass(frozen=True)
class Outcome:
    """How a run went: palm [mm] from its reference at worst, force error [N] RMS, both settled."""

    stands: bool
    palm: float
    force: float


def main() -> None:
    """Sweep, or print a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenario", nargs="?", choices=CONDITIONS)
    parser.add_argument("engine", nargs="?", choices=PAIRS)
    parser.add_argument("--kinds", nargs="*", default=KINDS)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--table", type=Path)
    parser.add_argument("--nominal", action="store_true")
    given = parser.parse_args()
    if given.table is not None:
        print(table(given.table))
        return
    if given.nominal:
        print_nominal(given.kinds)
        return
    text = given.out.read_text("utf-8") if given.out is not None and given.out.exists() else ""
    done = [(row["kind"], row["gains"]) for row in map(json.loads, text.splitlines())]
    for kind in given.kinds:
        for gains in grid(kind, given.engine):
            if (kind, gains) in done:
                continue
            row = {"kind": kind, "gains": gains, "runs": {}}
            for name, changes in CONDITIONS[given.scenario].items():
                outcome = run(
                    given.scenario,
                    changes_of(given.scenario, given.engine, kind, gains, changes),
                )
                row["runs"][name] = vars(outcome)
                if not outcome.stands:
                    break  # out of the choice: the other conditions are not asked
            line = json.dumps(row)
            print(line, flush=True)
            if given.out is not None:
                with given.out.open("a", encoding="utf-8") as file:
                    file.write(line + "\n")


def grid(kind: str, engine: str) -> Iterator[dict[str, float]]:
    """Yield the gains to try."""
    for kappa, alpha in PAIRS[engine]:
        further = FURTHER[engine].get(kind, {})
        for name, values in further.items():
            for value in values:
                yield {"kappa": kappa, "alpha": alpha, name: value}
        if not further:
            yield {"kappa": kappa, "alpha": alpha}


def print_nominal(kinds: tuple[str, ...]) -> None:
    """Print a Markdown table of whole nominal runs."""
    names = [f"{scenario}, {engine}" for scenario, engine in NOMINAL]
    print("| rival | " + " | ".join(names) + " |\n" + "|---" * (len(names) + 1) + "|")
    for kind in kinds:
        cells = [
            _cell(vars(run(scenario, [f"physics.engine={engine}", f"control.kind={kind}"])))
            for scenario, engine in NOMINAL
        ]
        print(f"| `{kind}` | " + " | ".join(cells) + " |", flush=True)


def changes_of(
    scenario: str, engine: str, kind: str, gains: dict[str, float], condition: list[str]
) -> list[str]:
    """Return the overrides of a run of the sweep."""
    own = [f"control.rival.{name}={value}" for name, value in gains.items()]
    start = ["control.start=standing", f"duration={SECONDS[scenario]}"]
    return [f"physics.engine={engine}", *start, f"control.kind={kind}", *own, *condition]


def run(scenario: str, changes: list[str]) -> Outcome:
    """Run a scenario with a rival and say how far its palms were from their reference."""
    simulation = Simulation(read_scenario(scenario, changes))
    robot, dt = simulation.robot, simulation.dt
    settled = min(1.0, simulation.scenario.duration / 2.0)
    palms, forces = [0.0], [0.0]
    supervisor = simulation.controller.supervisor
    try:
        for k, (t, record) in enumerate(simulation.ticks()):
            if supervisor.mode is not Mode.RUN:
                return Outcome(False, np.inf, np.inf)
            if t < settled or k % round(0.005 / dt):
                continue
            at, ref = robot.at(record["q"].copy()), robot.at(record["q_ref"].copy())
            for palm in robot.palms:
                away = at.placement(palm.frame).translation - ref.placement(palm.frame).translation
                palms.append(float(np.linalg.norm(away)))
            if palms[-1] > FALLEN:
                return Outcome(False, np.inf, np.inf)
            held = simulation.controller.contacts
            lam = np.concatenate([record[f"lam/{c.name}"] for c in held.contacts])
            forces.append(float(lam[held.regulated_rows][0] - simulation.controller.wanted[0]))
    except EquipoiseError:  # the engine diverged
        return Outcome(False, np.inf, np.inf)
    force = float(np.sqrt(np.mean(np.square(forces))))
    return Outcome(True, 1e3 * max(palms), force)


def table(path: Path) -> str:
    """Return a Markdown table of a file, the chosen gains of each rival in bold."""
    rows = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
    names = list(max((row["runs"] for row in rows), key=len))
    lines = ["| rival | gains | " + " | ".join(names) + " |", "|---" * (len(names) + 2) + "|"]
    for kind in dict.fromkeys(row["kind"] for row in rows):
        own = [row for row in rows if row["kind"] == kind]
        best = min(own, key=worst)
        for row in own:
            text = ", ".join(f"{name} {value:g}" for name, value in row["gains"].items())
            if row is best:
                text = f"**{text}**"
            cells = [_cell(row["runs"].get(name)) for name in names]
            lines.append(f"| `{kind}` | {text} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def worst(row: dict) -> float:
    """Return the largest palm error of a row's runs [mm], infinite if one fell."""
    return max(one["palm"] for one in row["runs"].values())


def _cell(one: dict | None) -> str:
    if one is None:
        return "-"
    return f"{one['palm']:.2f} mm, {one['force']:.2f} N" if one["stands"] else "falls"


if __name__ == "__main__":
    main()
