"""The memory of a tick: one block of floats, one of integers, and a table of what is where.

A tick that is called with a hundred arrays spends more time on passing them than on most of what it
computes, and finds them spread over memory. Here all of them lie in two blocks. A `Workspace` is
made of parts (the kinematics of a state, the rows of a hierarchy, ...); a part is a list of named
arrays. Kernels are given a `Block`, the two blocks with the table of one part, and take an array by
the number of its name in that list; Python takes it by its name. The same kernel can so run over two
parts of the same kind, the kinematics of two states for example.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numba import types
from numba.core import cgutils
from numba.extending import lower_builtin, type_callable
from numba.np.arrayobj import make_array, populate_array
from numpy.typing import NDArray

from equipoise.compiled.compilation import inlined

LINE = 8  # numbers in a cache line: every array begins at one


class Block(NamedTuple):
    """What a kernel is given of a part: the two blocks, and offset, rows, columns of each array."""

    floats: np.ndarray
    integers: np.ndarray
    table: np.ndarray


def vector_at(memory: np.ndarray, at: int, size: int) -> np.ndarray:
    """Return the view memory[at : at + size]."""
    return memory[at : at + size]


def matrix_at(memory: np.ndarray, at: int, rows: int, columns: int) -> np.ndarray:
    """Return the view [rows, columns] of memory that begins at `at`."""
    return memory[at : at + rows * columns].reshape(rows, columns)


@type_callable(vector_at)
def _type_of_vector(typing_context: Any) -> Callable:
    return lambda memory, at, size: types.Array(memory.dtype, 1, "C")


@type_callable(matrix_at)
def _type_of_matrix(typing_context: Any) -> Callable:
    return lambda memory, at, rows, columns: types.Array(memory.dtype, 2, "C")


@lower_builtin(vector_at, types.Array, types.Integer, types.Integer)
@lower_builtin(matrix_at, types.Array, types.Integer, types.Integer, types.Integer)
def _view(context: Any, builder: Any, signature: Any, args: Sequence[Any]) -> Any:
    """Make an array that points into the memory of another, which must outlive it."""
    source = make_array(signature.args[0])(context, builder, args[0])
    at, *shape = (
        context.cast(builder, value, kind, types.intp)
        for value, kind in zip(args[1:], signature.args[1:], strict=True)
    )
    itemsize = context.get_constant(types.intp, 8)
    strides = [itemsize]
    for extent in reversed(shape[1:]):
        strides.insert(0, builder.mul(strides[0], extent))
    array = make_array(signature.return_type)(context, builder)
    populate_array(
        array,
        data=builder.gep(source.data, [at]),
        shape=cgutils.pack_array(builder, shape),
        strides=cgutils.pack_array(builder, strides),
        itemsize=itemsize,
        meminfo=None,
    )
    return array._getvalue()


@inlined
def part_of(floats: np.ndarray, integers: np.ndarray, tables: np.ndarray, number: int) -> Block:
    """Return the block of a part of the workspace."""
    rows, columns = tables.shape[1], tables.shape[2]
    flat = tables.reshape(-1)
    table = matrix_at(flat, number * rows * columns, rows, columns)
    return Block(floats, integers, table)


@inlined
def vector(block: Block, name: int) -> np.ndarray:
    """Return an array of floats as a vector."""
    size = block.table[name, 1] * block.table[name, 2]
    return vector_at(block.floats, block.table[name, 0], size)


@inlined
def matrix(block: Block, name: int) -> np.ndarray:
    """Return an array of floats as a matrix."""
    table = block.table
    return matrix_at(block.floats, table[name, 0], table[name, 1], table[name, 2])


@inlined
def integers(block: Block, name: int) -> np.ndarray:
    """Return an array of integers as a vector."""
    size = block.table[name, 1] * block.table[name, 2]
    return vector_at(block.integers, block.table[name, 0], size)


@inlined
def integer_matrix(block: Block, name: int) -> np.ndarray:
    """Return an array of integers as a matrix."""
    table = block.table
    return matrix_at(block.integers, table[name, 0], table[name, 1], table[name, 2])


Shape = tuple[int, ...]


class Arrays(NamedTuple):
    """The arrays of a part: `names` in the order of their numbers in kernels; `whole` are integers."""

    names: tuple[str, ...]
    whole: frozenset[str] = frozenset()

    def shapes(self, **shapes: int | Shape) -> list[tuple[str, Shape, bool]]:
        """Return name, shape and whether it holds integers, of each array; each must be given."""
        missing, extra = set(self.names) - set(shapes), set(shapes) - set(self.names)
        if missing or extra:
            raise AssertionError(f"shapes missing: {sorted(missing)}, unknown: {sorted(extra)}")
        return [
            (name, shape if isinstance(shape, tuple) else (shape,), name in self.whole)
            for name in self.names
            for shape in (shapes[name],)
        ]


class Part:
    """The arrays of a part by name, as views (an attribute each), and its number."""

    def __init__(self, number: int, views: Mapping[str, NDArray[Any]], block: Block) -> None:
        self.number = number
        self.block = block
        self._views = dict(views)

    def __getattr__(self, name: str) -> NDArray[Any]:
        try:
            return self.__dict__["_views"][name]
        except KeyError:
            raise AttributeError(name) from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._views)


class Workspace:
    """Two blocks of memory, zero at first, with parts of named arrays.

    `parts` gives for each part what `Arrays.shapes` returns. `floats`, `integers` and `tables` are
    what entrances are called with. `memory` names, as "part.array", what has to be kept from one
    tick to the next: a copy of these is the whole state.
    """

    def __init__(
        self,
        parts: Mapping[str, list[tuple[str, Shape, bool]]],
        memory: Sequence[str] = (),
    ) -> None:
        longest = max((len(arrays) for arrays in parts.values()), default=0)
        self.tables = np.zeros((len(parts), max(longest, 1), 3), dtype=np.int64)
        ends = [0, 0]
        for number, arrays in enumerate(parts.values()):
            for k, (_, shape, whole) in enumerate(arrays):
                rows, columns = (1, *shape)[-2:]
                self.tables[number, k] = ends[whole], rows, columns
                ends[whole] += -(-rows * columns // LINE) * LINE
        self.floats = _aligned(ends[0])
        self.integers = np.zeros(max(ends[1], 1), dtype=np.int64)
        self.parts: dict[str, Part] = {}
        for number, (name, arrays) in enumerate(parts.items()):
            views = {}
            for k, (label, shape, whole) in enumerate(arrays):
                source = self.integers if whole else self.floats
                at = self.tables[number, k, 0]
                views[label] = source[at : at + int(np.prod(shape))].reshape(shape)
            block = Block(self.floats, self.integers, self.tables[number])
            self.parts[name] = Part(number, views, block)
        self._memory = tuple(tuple(name.split(".")) for name in memory)

    def __getattr__(self, name: str) -> Part:
        try:
            return self.__dict__["parts"][name]
        except KeyError:
            raise AttributeError(name) from None

    def state(self) -> dict[str, NDArray[Any]]:
        """Return a copy of what is kept from one tick to the next, by "part.array"."""
        return {
            f"{part}.{array}": getattr(self.parts[part], array).copy()
            for part, array in self._memory
        }

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Write a copy that `state` made back, bit by bit."""
        for part, array in self._memory:
            getattr(self.parts[part], array)[...] = state[f"{part}.{array}"]


def _aligned(count: int) -> np.ndarray:
    """Return zeros that begin at a cache line."""
    raw = np.zeros(count + LINE)
    start = -(raw.ctypes.data // 8) % LINE
    return raw[start : start + max(count, 1)]
