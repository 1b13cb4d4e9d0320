"""Hierarchy: the stacked problem, an object to print and save before anyone solves it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, NoReturn

import numpy as np

from equipoise.errors import InputError, ShapeError
from equipoise.hqp.rows import Rows, refuse_lengths
from equipoise.hqp.soundness import are_sound

_FLOAT = np.dtype(np.float64)


class Block(NamedTuple):
    """Where a block of rows went: its name, unit, row labels, level and the slice it fills."""

    name: str
    unit: str
    labels: tuple[str, ...]
    level: int
    rows: slice


class Hierarchy(NamedTuple):
    """Rows of several levels, stacked: level 0 first, each level strictly before the next.

    `A` [m, n], `lower` [m], `upper` [m]; `ends[i]` is the number of rows in levels 0..i.
    Make one with `Hierarchy.stack`.
    """

    A: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    ends: tuple[int, ...]
    blocks: tuple[Block, ...]

    @classmethod
    def stack(cls, levels: Sequence[Sequence[Rows]], n: int) -> Hierarchy:
        """Stack blocks of rows; `levels[i]` holds the blocks of level i, `n` the length of v.

        Raises:
            ShapeError: a block has not n columns.
            NonFiniteError, InputError: as `Rows.check`, naming the block and the row.
        """
        matrices, lowers, uppers = [np.empty((0, n))], [np.empty(0)], [np.empty(0)]
        blocks: list[Block] = []
        ends: list[int] = []
        end = 0
        for level, group in enumerate(levels):
            for rows in group:
                if rows.A.shape[1] != n:
                    raise ShapeError(f"A of rows {rows.name!r}", rows.A.shape, (len(rows), n))
                start, end = end, end + len(rows.labels)
                matrices.append(rows.A)
                lowers.append(rows.lower)
                uppers.append(rows.upper)
                blocks.append(Block(rows.name, rows.unit, rows.labels, level, slice(start, end)))
            ends.append(end)
        A, lower, upper = (
            np.concatenate(parts, dtype=np.float64) for parts in (matrices, lowers, uppers)
        )
        return cls.of_sound(A, lower, upper, tuple(ends), tuple(blocks))

    @classmethod
    def of_sound(
        cls,
        A: np.ndarray,
        lower: np.ndarray,
        upper: np.ndarray,
        ends: tuple[int, ...],
        blocks: tuple[Block, ...],
    ) -> Hierarchy:
        """Return the hierarchy of stacked rows, once their values are found sound.

        Raises:
            NonFiniteError, InputError: as `Rows.check`, naming the block and the row.
        """
        A, lower, upper = _plain(A), _plain(lower), _plain(upper)
        made = cls(A, lower, upper, ends, blocks)
        if not are_sound(A, lower, upper, np.array(ends, dtype=np.int64)):
            made._refuse()
        return made

    def _refuse(self) -> NoReturn:
        """Raise the error of the first unsound row, or of lengths too far apart in a level."""
        A, lower, upper = self.A, self.lower, self.upper
        blocks = self.blocks or (self._whole(),)
        for block in blocks:
            own = block.rows
            Rows(block.name, block.unit, block.labels, A[own], lower[own], upper[own]).refuse()
        names = [f"row {label!r} of rows {b.name!r}" for b in blocks for label in b.labels]
        for i in range(len(self.ends)):
            own = self.level(i)
            if not are_sound(A[own], lower[own], upper[own], np.array([own.stop - own.start])):
                refuse_lengths(A[own], lower[own], upper[own], names[own])
        raise AssertionError("a hierarchy that is sound was refused")

    def _whole(self) -> Block:
        """Return all rows as one block, for a hierarchy without names."""
        labels = tuple(str(row) for row in range(len(self.lower)))
        return Block("hierarchy", "unit", labels, 0, slice(0, len(labels)))

    @property
    def n(self) -> int:
        """Length of v."""
        return self.A.shape[1]

    def level(self, i: int) -> slice:
        """Return the rows of level i as a slice.

        Raises:
            InputError: there is no level i.
        """
        if not 0 <= i < len(self.ends):
            raise InputError(
                f"There is no level {i}", given=i, remedy=f"Levels are 0 to {len(self.ends) - 1}"
            )
        return slice(self.ends[i - 1] if i else 0, self.ends[i])

    def block_of(self, row: int) -> Block:
        """Return the block that holds a row of the stack.

        Raises:
            InputError: there is no such row.
        """
        for block in self.blocks:
            if block.rows.start <= row < block.rows.stop:
                return block
        raise InputError(
            f"There is no row {row}", given=row, remedy=f"Rows are 0 to {len(self.lower) - 1}"
        )

    def name_of(self, row: int) -> str:
        """Return the full name `block/label` of a row of the stack."""
        block = self.block_of(row)
        return f"{block.name}/{block.labels[row - block.rows.start]}"

    def __str__(self) -> str:
        counts = [_count_kinds(self.lower[b.rows], self.upper[b.rows]) for b in self.blocks]
        width = max([len(b.name) for b in self.blocks], default=4)
        lines = [f"{len(self.ends)} levels, {len(self.lower)} rows, {self.n} unknowns"]
        lines += [
            f"  level {b.level}  {b.name:<{width}}  {c}  [{b.unit}]"
            for b, c in zip(self.blocks, counts, strict=True)
        ]
        return "\n".join(lines)


def _count_kinds(lower: np.ndarray, upper: np.ndarray) -> str:
    equalities = int((lower == upper).sum())
    free = int((np.isinf(lower) & np.isinf(upper)).sum())
    inequalities = len(lower) - equalities - free
    parts = [(equalities, "equal"), (inequalities, "bounded"), (free, "free")]
    text = ", ".join(f"{count} {kind}" for count, kind in parts if count) or "no rows"
    return f"{text:<24}"


def _plain(array: np.ndarray) -> np.ndarray:
    """Return the array in the one layout that kernels are compiled for."""
    if array.flags.carray and array.dtype == _FLOAT:
        return array
    return np.array(array, dtype=np.float64, order="C")
