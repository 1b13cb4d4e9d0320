"""Why a task was not met at a time of a run: its hierarchy rebuilt from the log, solved again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np

from equipoise.analysis.feet_phases import feet_at
from equipoise.errors import InputError, NonFiniteError, RunLogError
from equipoise.hqp import (
    Explanation,
    Hierarchy,
    RowDescription,
    Solution,
    explain,
    load_problem,
    make_solver,
    save_problem,
)
from equipoise.motion import MotionGenerator
from equipoise.runlog import CHECKED_WHOLE, Run, check_log, load_run
from equipoise.scenarios import schema
from equipoise.scenarios.read import parse_scenario
from equipoise.simulation.build.fades import build_fades
from equipoise.simulation.build.levels import build_levels
from equipoise.simulation.build.setup import Setup, build_setup
from equipoise.simulation.build.walk import WalkSetup, build_walk
from equipoise.simulation.led_log import lead_again
from equipoise.tasks import Task, describe_rows
from equipoise.tasks.standing import with_standing

AROUND = 0.05  # [s] what is loaded of a log on either side; more than two of the longest periods
AGREES = 1e-4  # [m/s, rad/s] how far the rebuilt velocity may be from the logged one: a robot at
# rest leaves the solver, which starts from another answer here, 1e-5 of freedom


@dataclass(frozen=True)
class RebuiltTick:
    """One tick of a run, solved again.

    `t` [s] is the time of the tick; `row_names` [m] are how rows are called; `difference`
    [m/s, rad/s] is the largest between the rebuilt and the logged reference velocity. `fading` are
    the tasks on a ramp with their weights; the solution is that of the hierarchy with all of them.
    `note` says what is damaged of the log, `feet` how each foot of a walk stood.
    """

    t: float
    hierarchy: Hierarchy
    solution: Solution
    row_names: tuple[RowDescription, ...]
    difference: float
    fading: dict[str, float]
    note: str = ""
    tasks: Mapping[str, Task] = field(default_factory=dict)
    feet: tuple[str, ...] = ()

    def explain(self, tasks: tuple[str, ...] = ()) -> Explanation:
        """Say which tasks (or which of `tasks`) were short at this tick, and why."""
        said = explain(self.hierarchy, self.solution.v, self.row_names, tasks=tasks)
        return with_standing(said, self.tasks)


def rebuild_tick(run_path: Path | str, t: float) -> RebuiltTick:
    """Rebuild the hierarchy of the tick of a run that is nearest to time `t` [s], and solve it.

    Raises: RunLogError if the run cannot be read; InputError for a time outside of it, or if what
    is rebuilt is not what was logged.
    """
    run = _load_around(run_path, t)
    scenario = parse_scenario(run.scenario_text)
    setup = build_setup(scenario)
    k = run.at(t)
    walk = _walk_at(scenario, setup, run, k)
    levels = build_levels(scenario, setup, walk)
    time = float(run.t[k])
    v_before = run["v_ref"][k - 1] if k > 0 else np.zeros(setup.robot.nv)
    fades = build_fades(scenario)
    motion = MotionGenerator(
        setup.robot, levels, partial(make_solver, scenario.control.solver), scenario.control.period,
        run["q_ref"][k], fades=fades, t_start=time,
    )  # fmt: skip
    motion.reset(run["q_ref"][k], v_before)
    step = motion.step(time)
    hierarchy, solution = step.parts[0].hierarchy, step.parts[0].solution
    difference = float(np.abs(step.v_ref - run["v_ref"][k]).max())
    if not difference <= AGREES:
        raise InputError(
            f"The tick at {time:g} s, rebuilt, does not give the velocity that was logged: they "
            f"are {difference:.2g} rad/s or m/s apart",
            given=str(run_path),
            remedy="Explain the run with the version of Equipoise, and the robot, that made it",
        )
    tasks = {task.name: task for level in levels for task in level}
    row_names = describe_rows(
        [*tasks.values()],
        hierarchy,
        setup.robot.at(run["q_ref"][k], None, time),
        scenario.control.period,
    )
    weights = {name: fade.weight(time) for name, fade in fades.items()}
    fading_now = {name: w for name, w in weights.items() if 0.0 < w < 1.0}
    return RebuiltTick(
        time,
        hierarchy,
        solution,
        row_names,
        difference,
        fading_now,
        run.note,
        tasks,
        feet_at(run, k),
    )


def _walk_at(scenario: schema.Scenario, setup: Setup, run: Run, k: int) -> WalkSetup | None:
    """Return the walk of a run with its targets where they were led at tick k.

    Raises: `InputError` if the log does not say where.
    """
    walk = build_walk(scenario, setup)
    if walk is not None and not lead_again(walk.targets, {name: run[name][k] for name in run}):
        raise InputError(
            "The log of this walk does not say where its targets were led: it is of a version "
            "before that was logged",
            given=str(run.folder),
            remedy="Run the scenario again",
        )
    return walk


def explain_tick(
    run_path: Path | str,
    t: float | None,
    tasks: Sequence[str] = (),
    *,
    details: bool = False,
    save: Path | None = None,
) -> list[str]:
    """Return what to tell about the tick of a run at time `t` [s]; `save` also writes it to a file.

    Raises: as `rebuild_tick`; InputError without a time; NameNotFoundError for an unknown task.
    """
    if t is None:
        raise InputError("A run has many ticks", given=str(run_path), remedy="Say which: --at T")
    tick = rebuild_tick(run_path, t)
    said = tick.explain(tuple(tasks))
    noted = tick.note or check_log(run_path, at_most=CHECKED_WHOLE)
    lines = [f"Note: {noted}"] * bool(noted)
    lines += [
        f"t = {tick.t:g} s",
        *tick.feet,
        *_about_fading(tick),
        said.details() if details else str(said),
    ]
    if save is not None:
        note = f"{run_path}, t = {tick.t:g} s"
        save_problem(save, tick.hierarchy, words=tick.row_names, note=note)
        lines.append(f"Written to {save}")
    return lines


def explain_file(
    path: Path, tasks: Sequence[str] = (), *, details: bool = False, save: Path | None = None
) -> list[str]:
    """Return what to tell about a saved hierarchy, solved by the cascade.

    Raises: InputError if the file holds none; NameNotFoundError for an unknown task.
    """
    problem = load_problem(path)
    solution = make_solver("cascade").solve(problem.hierarchy)
    said = explain(problem.hierarchy, solution.v, problem.words, tasks=tasks)
    lines = [*filter(None, (problem.note,)), str(problem.hierarchy), solution.status.value]
    lines.append(said.details() if details else str(said))
    if save is not None:
        save_problem(save, problem.hierarchy, words=problem.words, note=problem.note)
        lines.append(f"Written to {save}")
    return lines


def _about_fading(tick: RebuiltTick) -> list[str]:
    shares = ", ".join(f"{name} by {weight:.0%}" for name, weight in tick.fading.items())
    return [f"Faded in now: {shares}. What follows is about all of them counting fully."] * bool(
        tick.fading
    )


def _load_around(run_path: Path | str, t: float) -> Run:
    """Return the ticks around `t`, without loading a long log whole."""
    if not np.isfinite(t):
        raise NonFiniteError("A time to explain is a finite number of seconds", given=t)
    run = load_run(run_path, start=t - AROUND, stop=t + AROUND)
    period = parse_scenario(run.scenario_text).control.period
    if run.t.size and np.abs(run.t - t).min() <= 0.501 * period:
        return run
    whole = load_run(run_path)
    if not whole.t.size:
        raise RunLogError(f"The run in {whole.folder} has no tick to explain. {whole.note}".strip())
    inside = whole.t[0] <= t <= whole.t[-1] + period
    problem = "has no tick near" if inside else "does not reach to"
    raise InputError(
        f"The run {problem} t = {t:g} s. {whole.note}".strip(),
        given=t,
        remedy=f"Give a time from {whole.t[0]:g} to {whole.t[-1]:g} s",
    )
