"""What a simulated robot really did, beside what its controller saw of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin

from equipoise.errors import InputError
from equipoise.runlog import Run
from equipoise.scenarios.read import parse_scenario
from equipoise.simulation.build.setup import build_setup
from equipoise.simulation.simulated_robot import SimulatedRobot
from equipoise.spatial import Array

NAMES = ("t", "q", "v", "lam")


class Truth:
    """Notes the true states of a robot, one a period."""

    def __init__(self, robot: SimulatedRobot) -> None:
        self._robot = robot
        self._states: dict[float, tuple[Array, ...]] = {}

    def note(self) -> None:
        """Note the state of the moment; the same moment twice counts once."""
        state = self._robot.plant.engine.state
        if state.t not in self._states:
            self._states[state.t] = (np.array(state.t), state.q, state.v, state.lam)

    def save(self, path: Path) -> None:
        """Write `t` (N,) [s], `q` (N, nq), `v` (N, nv), `lam` (N, r) to an npz file."""
        columns = [np.array(column) for column in zip(*self._states.values(), strict=True)]
        t, q, v, lam = columns
        np.savez_compressed(path, t=t, q=q, v=v, lam=lam)


def estimate_errors(run: Run, truth: Path, after: float = 0.0) -> dict[str, float]:
    """Return how far what a run logged was from what really was, from `after` [s] on.

    Largest error of the base's position [m], angle [rad], velocity [m/s] and rate [rad/s], and for
    every contact the largest error of a component [N or N m] and its RMS, over common ticks.
    Raises: `InputError` if they have none in common.
    """
    with np.load(truth) as kept:
        true = {name: kept[name] for name in NAMES}
    setup = build_setup(parse_scenario(run.scenario_text))
    rows = {round(1e6 * t): k for k, t in enumerate(true["t"])}
    pairs = [
        (i, rows[round(1e6 * t)])
        for i, t in enumerate(run.t)
        if t >= after and round(1e6 * t) in rows and rows[round(1e6 * t)] + 1 < len(true["t"])
    ]
    if not pairs:
        raise InputError("the run and the truth have no tick in common", given=str(truth))
    seen, was = (np.array(column) for column in zip(*pairs, strict=True))
    model, nv = setup.robot.model, setup.robot.nv_base
    apart = np.array(
        [
            pin.difference(model, q, q_seen)[:nv]
            for q, q_seen in zip(true["q"][was], run["q"][seen], strict=True)
        ]
    )
    faster = (run["v"][seen] - true["v"][was])[:, :nv]
    errors = {}
    for name, unit, values in (("base", ("m", "rad"), apart), ("twist", ("m/s", "rad/s"), faster)):
        for one, part in zip(unit, np.split(values, 2, axis=1), strict=True):
            errors[f"{name} [{one}]"] = float(np.linalg.norm(part, axis=1).max(initial=0.0))
    for name, own in setup.contacts.rows.items():
        off = run[f"lam/{name}"][seen] - true["lam"][was + 1][:, own]  # acts during the tick
        errors[f"{name} worst"] = float(np.abs(off).max())
        errors[f"{name} rms"] = float(np.sqrt((off**2).mean()))
    return errors
