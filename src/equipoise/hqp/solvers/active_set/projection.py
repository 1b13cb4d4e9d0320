"""Compiled projection of working rows on what the solved levels leave free."""

from __future__ import annotations

from equipoise.compiled.compilation import compiled, inlined
from equipoise.hqp.solvers.active_set.primitives import (
    DEPTH,
    ORDER,
    SCRATCH,
    SINGLE,
    Buffers,
    column,
    dot,
    reflect,
)


@inlined
def project(b: Buffers, first: int, last: int, fixed: int) -> None:
    """Bring the rows at places first..last up to date with the fixed reflectors."""
    projected, reflectors, numbers = b.projected, b.reflectors, b.numbers
    n = projected.shape[1]
    begin, deepest = fixed, 0
    for i in range(first, last):
        depth = numbers[DEPTH, numbers[ORDER, i]]
        begin, deepest = min(begin, depth), max(deepest, depth)
    one_by_one = 4 * fixed * (n - fixed // 2)  # operations a row
    if deepest == 0 and (last - first) * (one_by_one - 2 * n * (n - fixed)) > one_by_one * (
        n - fixed
    ):
        project_at_once(b, first, last, fixed)
    elif begin == deepest:  # all alike, as a rule: nothing to ask row by row
        for j in range(begin, fixed):
            for i in range(first, last):
                reflect(projected, numbers[ORDER, i], reflectors, j, n)
    else:
        for j in range(begin, fixed):
            for i in range(first, last):
                if numbers[DEPTH, numbers[ORDER, i]] <= j:
                    reflect(projected, numbers[ORDER, i], reflectors, j, n)
    for i in range(first, last):
        numbers[DEPTH, numbers[ORDER, i]] = fixed


@compiled
def project_at_once(b: Buffers, first: int, last: int, fixed: int) -> None:
    """Bring many untouched rows up to date by a basis of what the fixed reflectors leave free.

    Only the coordinates from `fixed` on are written; nobody reads the others any more.
    """
    projected, reflectors, numbers, basis = b.projected, b.reflectors, b.numbers, b.basis
    columns, n = b.of_columns, b.projected.shape[1]
    for k in range(fixed, n):
        basis[k, :] = 0.0
        basis[k, k] = 1.0
    for j in range(fixed - 1, -1, -1):
        for k in range(fixed, n):
            reflect(basis, k, reflectors, j, n)
    for i in range(first, last):
        row = numbers[ORDER, i]
        place = numbers[SINGLE, row]
        for k in range(fixed, n):
            if place >= 0:
                columns[SCRATCH, k] = projected[row, place] * basis[k, place]
            else:
                columns[SCRATCH, k] = dot(projected, row, basis, k, 0, n)
        for k in range(column(fixed), column(n)):
            projected[row, k] = columns[SCRATCH, k]
