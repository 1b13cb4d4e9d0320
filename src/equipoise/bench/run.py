"""One bench from robots to rows: the contenders are made, raced, and let go."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from equipoise.bench.equipoise_contenders import DaqpBeside, HardCase, OwnParts, OwnTick, variants
from equipoise.bench.interleave import Contender, Progress, interleave
from equipoise.bench.peers import check_pythons, make_peers
from equipoise.bench.problem import make_problem
from equipoise.bench.rows import Row

QUICK_TICKS = 60


def run_bench(
    robots: Sequence[str],
    *,
    ticks: int | None = None,
    pythons: Mapping[str, str] | None = None,
    say: Callable[[str], None] = print,
    report: Progress | None = None,
) -> list[Row]:
    """Time the tick, its parts and every peer on each robot; the whole scenario unless `ticks`.

    `pythons` names Pythons for the peers that run apart; `say` is told what is left out.
    Raises: `NameNotFoundError`, `InputError`.
    """
    pythons = dict(pythons or {})
    check_pythons(pythons)
    rows: list[Row] = []
    for k, name in enumerate(robots):
        problem = make_problem(name)
        count = problem.ticks if ticks is None else min(ticks, problem.ticks)
        contenders: list[Contender] = [
            OwnTick(problem),
            OwnParts(problem),
            *variants(problem),
            DaqpBeside(problem, "tray"),
            HardCase(problem),
            DaqpBeside(problem, "hard"),
        ]
        peers = make_peers(problem, pythons, count, say if k == 0 else _hush)
        try:
            rows += interleave([*contenders, *peers], count, report)
        finally:
            for peer in peers:
                if hasattr(peer, "close"):
                    peer.close()
    return rows


def _hush(sentence: str) -> None:
    pass
