"""How much of the MuJoCo engine's time is MuJoCo's own: a control period beside its bare steps."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter_ns

import numpy as np
import pinocchio as pin

from equipoise.bench.rows import Row
from equipoise.physics.mujoco import MujocoEngine
from equipoise.scenarios import read_scenario
from equipoise.simulation.build.engines import make_engine
from equipoise.simulation.simulation import Simulation

STIFFNESS, DAMPING = 3000.0, 60.0  # of the springs that hold the posture
UNTIMED = 20  # ticks, in which kernels are loaded


def engine_rows(scenario: str, ticks: int = 400) -> list[Row]:
    """Time control periods of a scenario's world in MuJoCo, and as many bare `mj_step` beside them.

    The robot is held where it starts. After each period a twin of MuJoCo's data takes the same
    steps under the same forces, so that the ratio of the two rows is of one run.
    """
    simulation = Simulation(read_scenario(scenario, ["physics.engine=mujoco"]))
    engine = make_engine(simulation.scenario, simulation.setup, simulation.assembly.q_start)
    if not isinstance(engine, MujocoEngine):
        raise AssertionError("the engine asked for is MuJoCo's")
    periods, steps = _time(engine, ticks)
    share = float(np.median(steps) / np.median(periods))
    name = f"engine/mujoco/{scenario}"
    remark = f"mj_step is {100.0 * share:.0f} % of it, {engine.substeps} a period"
    return [_row(name, periods, remark), _row(f"{name}/mj_step", steps, "")]


def step_share(rows: list[Row]) -> float:
    """Return the median of the bare steps as a share of the engine's."""
    engine, steps = rows
    return steps.median_us / engine.median_us


def _time(engine: MujocoEngine, ticks: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the times [us] (ticks,) of periods and of the bare steps of each."""
    mujoco, compiled, simulated = engine.mujoco, engine.model.compiled, engine.simulated
    standing, state = engine.stand(), engine.state
    q_held, twin = state.q, mujoco.MjData(compiled)
    mujoco.mj_copyData(twin, compiled, simulated)
    times = np.zeros((UNTIMED + ticks, 2))
    for row in times:
        dq = pin.difference(engine.robot.model, q_held, state.q)
        tau = standing - STIFFNESS * dq[6:] - DAMPING * state.v[6:]
        began = perf_counter_ns()
        state = engine.step(tau)
        row[0] = perf_counter_ns() - began
        twin.qfrc_applied[:], twin.eq_active[:] = simulated.qfrc_applied, simulated.eq_active
        row[1] = _elapsed(lambda: [mujoco.mj_step(compiled, twin) for _ in range(engine.substeps)])
    return times[UNTIMED:, 0] / 1e3, times[UNTIMED:, 1] / 1e3


def _elapsed(act: Callable[[], object]) -> int:
    began = perf_counter_ns()
    act()
    return perf_counter_ns() - began


def _row(name: str, times: np.ndarray, remark: str) -> Row:
    return Row(
        name,
        float(np.median(times)),
        float(np.percentile(times, 99)),
        ticks=len(times),
        remark=remark,
    )
