"""The search: gains proposed by Optuna, tried on the ensemble, the best ones judged on the rest."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from equipoise.errors import InputError, RunLogError
from equipoise.scenarios.gains_file import gains_text
from equipoise.studies.draw import points_of
from equipoise.studies.drive import pick_up, told_what_is_kept
from equipoise.studies.engines.base import Engine
from equipoise.studies.engines.make import make_engine
from equipoise.studies.folder import StudyFolder, write_json, write_whole
from equipoise.studies.give_out import Listed, State, give_out
from equipoise.studies.journal import Result
from equipoise.studies.plan import RunId, StudyRun
from equipoise.studies.runner import Runner
from equipoise.studies.tune.cost import Cost, Score
from equipoise.studies.tune.schema import (
    ADVISER,
    ENSEMBLE,
    HOLD_OUT,
    TUNED,
    TuneSpec,
    gain_name,
)

TUNE, GAINS, TRIALS = "tune.json", "gains.yaml", "trials.json"
FIRST_RANDOM = 10  # trials before the sampler learns
Say = Callable[[str], None]
Gains = dict[str, Any]


@dataclass(frozen=True)
class Outcome:
    """The best gains by path, and how they and the adviser's did on both sets of runs."""

    gains: Gains
    ensemble: tuple[Score, Score]  # the adviser's, then those found
    hold_out: tuple[Score, Score]
    trials: int
    file: Path | None

    @property
    def better(self) -> bool:
        """Whether they are better on the hold-out: cheaper, and stand and are good as often."""
        adviser, found = self.hold_out
        safe = found.stands >= adviser.stands and found.good >= adviser.good
        return safe and found.cost < adviser.cost

    def sentences(self) -> list[str]:
        """Return what came out."""
        lines = []
        for name, (adviser, found) in (("Ensemble", self.ensemble), ("Hold-out", self.hold_out)):
            lines += [f"{name}: adviser  {adviser}", f"{' ' * len(name)}  found    {found}"]
        if self.better:
            lines.append(f"Gains that are better on the hold-out: {self.file}")
        else:
            lines.append(
                f"Refused: after {self.trials} trials the best gains on the ensemble are not "
                "better than the adviser's on the hold-out. Nothing was written; keep the adviser's"
            )
        return lines


class _Bench:
    """Runs gains on points, with an engine that is made when it is first needed."""

    def __init__(self, spec: TuneSpec, folder: StudyFolder, modules: Sequence[str]) -> None:
        self.spec, self.study, self.folder = spec, spec.study(), folder
        self.results = pick_up(folder).results
        self._modules = modules
        self._engine: Engine | None = None
        self._points = {
            name: points_of(spec.parameters, getattr(spec, name)) for name in (ENSEMBLE, HOLD_OUT)
        }

    def run(self, where: str, gains: Gains | None, trial: int) -> list[Result]:
        """Return the results of gains, or the adviser's (None), on the points of one set."""
        contender, name = (0, ADVISER) if gains is None else (1, TUNED)
        values = {gain_name(k): gains[path] for k, path in enumerate(self.spec.gains)
                  if gains is not None}  # fmt: skip
        runs = [
            StudyRun(RunId(where, k, contender, repeat, trial), name, {**point, **values})
            for k, point in enumerate(self._points[where])
            for repeat in range(self.spec.seeds)
        ]
        state = State(Listed(runs), self.results)
        state.begin()
        if state.queue:
            with told_what_is_kept(self.folder, state):
                if self._engine is None:
                    examples = (state.queue[0],)
                    self._engine = make_engine(self.study, examples, self._modules)
                give_out(state, self._engine, self.folder, self.study, lambda standing: None)
        return [self.results[str(run.id)] for run in runs]

    def close(self) -> None:
        """End the engine."""
        if self._engine is not None:
            self._engine.close()


def tune(
    spec: TuneSpec, out: Path | str, *, say: Say = print, modules: Sequence[str] = ()
) -> Outcome:
    """Look for gains into a folder; `say` is told each better trial.

    The same call goes on where an earlier one was ended; any number of workers finds the same.
    Raises: `InputError`; `RunLogError` if the disk refuses: what is done is kept then.
    """
    optuna = _library()
    study = spec.study()
    Runner(study).check_scenario()
    folder = StudyFolder(out)
    folder.open(study)
    _open(folder, spec)
    with folder.as_only_client(lambda: say("Workers of an earlier call still work; waiting ...")):
        bench = _Bench(spec, folder, modules)
        try:
            return _search(optuna, spec, bench, say)
        except KeyboardInterrupt:
            say(f"Interrupted: {len(bench.results)} runs are kept in {folder.path}. "
                "The same command goes on.")  # fmt: skip
            raise
        finally:
            bench.close()


def _search(optuna: Any, spec: TuneSpec, bench: _Bench, say: Say) -> Outcome:
    advised = bench.run(ENSEMBLE, None, 0)
    duration = float(Runner(bench.study).duration)
    cost = Cost.over(advised, spec.cost, spec.fall, duration)
    adviser = cost.score(advised)
    say(f"adviser: {adviser}")
    sampler = optuna.samplers.TPESampler(
        seed=spec.seed, multivariate=True, n_startup_trials=FIRST_RANDOM
    )
    asked = optuna.create_study(sampler=sampler)
    best: tuple[Score, Gains] | None = None
    trials: list[dict[str, Any]] = []
    for number in range(spec.trials):
        trial = asked.ask()
        gains = {path: _suggest(trial, path, spec) for path in spec.gains}
        score = cost.score(bench.run(ENSEMBLE, gains, number))
        asked.tell(trial, score.cost)
        trials.append({"gains": gains, "cost": score.cost, "stands": score.stands,
                       "good": score.good})  # fmt: skip
        if best is None or score.cost < best[0].cost:
            best = score, gains
            say(f"trial {number + 1} of {spec.trials}: {score}")
    assert best is not None
    judged = cost.score(bench.run(HOLD_OUT, None, 0))
    numbers = [trial["gains"] for trial in trials]
    found = cost.score(bench.run(HOLD_OUT, best[1], numbers.index(best[1])))
    outcome = Outcome(best[1], (adviser, best[0]), (judged, found), spec.trials, None)
    return _written(spec, bench.folder, outcome, trials)


def _suggest(trial: Any, path: str, spec: TuneSpec) -> Any:
    gain = spec.gains[path]
    if gain.choice is not None:
        return gain.choice[trial.suggest_categorical(path, list(range(len(gain.choice))))]
    low, high = gain.uniform or gain.log_uniform or (0.0, 1.0)
    value = trial.suggest_float(path, low, high, log=gain.log_uniform is not None)
    return float(f"{value:.4g}")


def _written(
    spec: TuneSpec, folder: StudyFolder, outcome: Outcome, trials: list[dict[str, Any]]
) -> Outcome:
    """Write the trials, and the gains if they are better; return the outcome with their file."""
    file = folder.path / GAINS
    try:
        write_json(folder.path / TRIALS, trials)
        if not outcome.better:
            file.unlink(missing_ok=True)  # of an earlier call with fewer trials
            return outcome
        adviser, found = outcome.hold_out
        about = [
            f"found by equipoise tune {spec.name} for {spec.scenario}"
            + (f" on {spec.robot}" if spec.robot else ""),
            f"on {found.of} runs of the hold-out: {found}",
            f"the adviser's there: {adviser}",
        ]
        write_whole(file, gains_text({**spec.fixed, **outcome.gains}, about))
    except OSError as error:
        raise RunLogError(f"Cannot write in {folder.path}: {error.strerror}.") from error
    return Outcome(outcome.gains, outcome.ensemble, outcome.hold_out, outcome.trials, file)


def _open(folder: StudyFolder, spec: TuneSpec) -> None:
    """See that the folder belongs to this search. Raises: `InputError`, `RunLogError`."""
    content = spec.model_dump(mode="json", exclude={"engine", "trials"})
    text = json.dumps(content, indent=1, ensure_ascii=False) + "\n"
    path = folder.path / TUNE
    try:
        if not path.exists():
            write_whole(path, text)
        elif path.read_text(encoding="utf-8") != text:
            raise InputError(
                "the folder holds another search", given=str(folder.path), remedy="Give a new --out"
            )
    except OSError as error:
        raise RunLogError(f"Cannot use {folder.path}: {error.strerror}.") from error


def _library() -> Any:
    try:
        import optuna
    except ImportError:
        raise InputError("tune needs optuna", remedy="pip install 'equipoise[study]'") from None
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    return optuna
