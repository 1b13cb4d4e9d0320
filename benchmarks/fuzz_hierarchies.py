"""Random hierarchies of every awkward kind: the solver against the reference and the certificate.

`python benchmarks/fuzz_hierarchies.py --count 10000 [--seed 0] [--kind random hard walk]`

`random`: 1 to 5 levels, 1 to 40 unknowns, equalities, bounds, rows without bounds. `hard`: the same
with rows repeated or dependent, zero, of lengths 1e-4 to 1e4, 1e4 apart inside a level, many bounds
in one point, levels that contradict each other, levels of unit rows with and without free columns,
rows left out. `walk`: a hard one that changes little by little and jumps now and then, and is
started warm.

An answer is good if the solver calls it solved, the certificate holds to 1e-7 and v is that of the
cascade to 1e-6, all relative. Where answers differ and both are certified, or neither is, the
problem is called ambiguous: some rows depend on others to about 1e-8, and one direction more or
less counts as free. Ends with 1 if an answer failed.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Iterator

import numpy as np

from equipoise.hqp import Hierarchy, Rows, certify, make_solver
from equipoise.hqp.solvers.active_set.solver import ActiveSet

CERTIFIED = 1e-7
AGREED = 1e-6
WALK = 25  # problems in a row


def random_rows(rng: np.random.Generator, m: int, v: np.ndarray, clash: float) -> list[np.ndarray]:
    """Return A [m, n] and bounds around a point v [n], moved away from it for a share of rows."""
    n = len(v)
    A = rng.normal(size=(m, n))
    A[rng.random((m, n)) < rng.choice([0.0, 0.5])] = 0.0
    centre = A @ v + rng.normal(size=m) * np.sqrt(n) * (rng.random(m) < clash)
    lower, upper = centre - rng.exponential(size=m), centre + rng.exponential(size=m)
    lower[rng.random(m) < 0.3] = -np.inf
    upper[rng.random(m) < 0.3] = np.inf
    equal = rng.random(m) < 0.5
    lower[equal] = upper[equal] = centre[equal]
    return [A, lower, upper]


def unit_rows(rng: np.random.Generator, v: np.ndarray, goal: bool) -> list[np.ndarray]:
    """Return rows of single unknowns: a goal of equal weights, or limits; some columns left out."""
    n = len(v)
    columns = np.sort(rng.permutation(n)[: max(1, n - int(rng.integers(0, 1 + n // 3)))])
    A = np.eye(n)[columns] * (float(rng.choice([1.0, 3.0])) if goal else 1.0)
    centre = A @ (v + 0.5 * rng.normal(size=n))
    width = 0.0 if goal else rng.exponential(size=len(columns))
    return [A, centre - width, centre + width]


def make_hard(rng: np.random.Generator, rows: list[np.ndarray], seen: np.ndarray) -> None:
    """Repeat, combine, empty and scale rows in place."""
    A, lower, upper = rows
    m = len(A)
    for _ in range(int(rng.integers(0, 4))):
        r, what = int(rng.integers(m)), rng.random()
        if what < 0.3 and len(seen):
            A[r] = seen[rng.integers(len(seen))]
        elif what < 0.5 and m > 1:
            A[r] = A.T @ rng.normal(size=m) - A[r] * rng.normal()
        elif what < 0.6 and len(seen):
            A[r] = seen.T @ rng.normal(size=len(seen))
        elif what < 0.7:
            A[r] = 0.0
        elif what < 0.8:
            k = int(rng.integers(m))
            A[r], lower[r], upper[r] = A[k], lower[k], upper[k]
    if rng.random() < 0.4:
        scale = 10.0 ** (rng.uniform(-2.0, 2.0, size=m) + rng.uniform(-2.0, 2.0))
        A *= scale[:, None]
        lower *= scale
        upper *= scale


def problem(rng: np.random.Generator, hard: bool) -> Hierarchy:
    """Return a random hierarchy."""
    n, levels = int(rng.integers(1, 41)), int(rng.integers(1, 6))
    v, clash = rng.normal(size=n), rng.choice([0.0, 0.3, 0.8])
    blocks, seen = [], np.empty((0, n))
    for i in range(levels):
        kind = rng.random()
        if hard and kind < 0.25:
            rows = unit_rows(rng, v, goal=kind < 0.15)
        else:
            m = int(rng.integers(1, 2 + n // 2))
            rows = random_rows(rng, m, v, clash)
            if hard:
                make_hard(rng, rows, seen)
        if hard and rng.random() < 0.2:  # many bounds in one point
            at, (A, lower, upper) = rng.random(len(rows[0])) < 0.5, rows
            lower[at] = np.where(lower[at] == upper[at], lower[at], (A @ v)[at])
            upper[at] = np.maximum(upper[at], lower[at])
        seen = np.vstack([seen, rows[0]])
        labels = tuple(str(r) for r in range(len(rows[0])))
        blocks.append([Rows(f"level {i}", "1", labels, *rows)])
    return Hierarchy.stack(blocks, n)


def walk(rng: np.random.Generator) -> Iterator[Hierarchy]:
    """Yield problems that change little by little, and jump now and then."""
    h = problem(rng, hard=True)
    A, lower, upper = h.A.copy(), h.lower.copy(), h.upper.copy()
    finite = np.concatenate([lower[np.isfinite(lower)], upper[np.isfinite(upper)]])
    size = float(np.median(np.abs(finite))) if len(finite) else 1.0
    for _ in range(WALK):
        jump = rng.random() < 0.15
        by = rng.normal(size=len(lower)) * size * (1.0 if jump else 0.01)
        by *= rng.random(len(lower)) < 0.5
        lower, upper = lower + by, upper + by
        if rng.random() < 0.1:
            scale = 10.0 ** rng.uniform(-6.0, 6.0)
            yield Hierarchy(A, lower * scale, upper * scale, h.ends, h.blocks)
        A = A * (1.0 + 1e-3 * rng.normal(size=A.shape) * (rng.random() < 0.5))
        yield Hierarchy(A, lower, upper, h.ends, h.blocks)


def judge(h: Hierarchy, solver: ActiveSet) -> str:
    """Return what an answer is: good, ambiguous, or what is wrong with it."""
    answer = solver.solve(h)
    if not answer.solved:
        return answer.status.name
    certificate = certify(h, answer.v)
    reference = make_solver("cascade").solve(h)
    far = float(np.abs(answer.v - reference.v).max())
    agreed = far <= AGREED * max(float(np.linalg.norm(reference.v)), 1e-100)
    certified = certificate.holds(CERTIFIED)
    if agreed:
        return "good" if certified else "agrees, not certified"
    if certified == certify(h, reference.v).holds(CERTIFIED):
        return "ambiguous"
    return "reference not certified" if certified else "not certified"


def problems(kind: str, seed: int) -> Iterator[Hierarchy]:
    """Yield the problems of a seed: one, or those of a walk."""
    rng = np.random.default_rng([("random", "hard", "walk").index(kind), seed])
    if kind == "walk":
        yield from walk(rng)
    else:
        yield problem(rng, kind == "hard")


def main() -> int:
    """Run the fuzzer."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1000, help="problems of each kind [1000]")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--kind", nargs="+", default=["random", "hard", "walk"])
    given = parser.parse_args()
    failed = 0
    for kind in given.kind:
        outcomes: Counter[str] = Counter()
        seed = given.seed
        while sum(outcomes.values()) < given.count:
            solver = ActiveSet()
            for tick, h in enumerate(problems(kind, seed)):
                outcome = judge(h, solver)
                outcomes[outcome] += 1
                if outcome != "good":
                    print(f"  {kind} seed {seed} tick {tick}: {outcome}")
            seed += 1
        failed += sum(n for name, n in outcomes.items() if name not in ("good", "ambiguous"))
        print(f"{kind}: {sum(outcomes.values())} problems, {dict(outcomes)}", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
