"""The memory of a tick: one block of floats, one of integers, and a table of what is where.

A tick that is called with a hundred arrays spends more time on passing them than on most of what it
computes, and finds them spread over memory. Here all of them lie in two blocks. A `Workspace` is
made of parts (the kinematics of a state, the rows of a hierarchy, ...); a part is a list of named
arrays. Kernels are given a `Block`, the two blocks with the table of one part, and take an array by
the number of its name in that list; Python takes it by its name. The same kernel can so run over
two parts of the same kind, the kinematics of two states for example.
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

LINE = 8  # numbers in a cache line: every array begins at one
SLOTS = 8  # integers at the beginning that hold the addresses of stages


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
def _type_of_vector(typing_context: Any) -> Callable[..., types.Array]:
    return lambda memory, at, size: types.Array(memory.dtype, 1, "C")


@type_callable(matrix_at)
def _type_of_matrix(typing_context: Any) -> Callable[..., types.Array]:
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
    return _array(context, builder, signature.return_type, builder.gep(source.data, [at]), shape)


def part_of(floats: np.ndarray, integers: np.ndarray, tables: np.ndarray, number: int) -> Block:
    """Return the block of a part of the workspace."""
    return Block(floats, integers, tables[number])


def vector(block: Block, name: int) -> np.ndarray:
    """Return an array of floats as a vector."""
    at, rows, columns = block.table[name]
    return block.floats[at : at + rows * columns]


def matrix(block: Block, name: int) -> np.ndarray:
    """Return an array of floats as a matrix."""
    at, rows, columns = block.table[name]
    return block.floats[at : at + rows * columns].reshape(rows, columns)


def integers(block: Block, name: int) -> np.ndarray:
    """Return an array of integers as a vector."""
    at, rows, columns = block.table[name]
    return block.integers[at : at + rows * columns]


def integer_matrix(block: Block, name: int) -> np.ndarray:
    """Return an array of integers as a matrix."""
    at, rows, columns = block.table[name]
    return block.integers[at : at + rows * columns].reshape(rows, columns)


def _taken(memory: int, dimensions: int) -> Callable[..., Any]:
    """Return the typing of a view into one of the blocks of memory (0 floats, 1 integers)."""

    def type_of(context: Any) -> Callable[..., Any]:
        def typed(block: Any, name: Any) -> Any:
            if isinstance(block, types.BaseNamedTuple) and isinstance(name, types.Integer):
                return types.Array(block.types[memory].dtype, dimensions, "C")
            return None

        return typed

    return type_of


for _function, _memory, _dimensions in (
    (vector, 0, 1), (matrix, 0, 2), (integers, 1, 1), (integer_matrix, 1, 2)
):  # fmt: skip
    type_callable(_function)(_taken(_memory, _dimensions))


@lower_builtin(vector, types.BaseNamedTuple, types.Integer)
@lower_builtin(matrix, types.BaseNamedTuple, types.Integer)
@lower_builtin(integers, types.BaseNamedTuple, types.Integer)
@lower_builtin(integer_matrix, types.BaseNamedTuple, types.Integer)
def _take(context: Any, builder: Any, signature: Any, args: Sequence[Any]) -> Any:
    """Make the view that the table tells: lean code, since every kernel takes dozens of them."""
    kind, wanted = signature.args[0], signature.return_type
    place = 0 if wanted.dtype == types.float64 else 1
    memory = _pointer_of(context, builder, kind, args[0], place)
    table = _pointer_of(context, builder, kind, args[0], 2)
    name = context.cast(builder, args[1], signature.args[1], types.intp)
    entry = builder.mul(name, context.get_constant(types.intp, 3))
    at, rows, columns = (
        builder.load(builder.gep(table, [builder.add(entry, context.get_constant(types.intp, k))]))
        for k in range(3)
    )
    shape = [builder.mul(rows, columns)] if wanted.ndim == 1 else [rows, columns]
    return _array(context, builder, wanted, builder.gep(memory, [at]), shape)


def _pointer_of(context: Any, builder: Any, kind: Any, block: Any, place: int) -> Any:
    """Return where the numbers of an array in a block begin."""
    return make_array(kind.types[place])(context, builder, builder.extract_value(block, place)).data


def _array(context: Any, builder: Any, wanted: Any, data: Any, shape: Sequence[Any]) -> Any:
    """Return an array that points to numbers, row by row."""
    itemsize = context.get_constant(types.intp, 8)
    strides = [itemsize]
    for extent in reversed(shape[1:]):
        strides.insert(0, builder.mul(strides[0], extent))
    array = make_array(wanted)(context, builder)
    populate_array(
        array,
        data=data,
        shape=cgutils.pack_array(builder, list(shape)),
        strides=cgutils.pack_array(builder, strides),
        itemsize=itemsize,
        meminfo=None,
    )
    return array._getvalue()


@type_callable(part_of)
def _type_of_part(typing_context: Any) -> Callable[..., Any]:
    def typed(floats: Any, integers: Any, tables: Any, number: Any) -> Any:
        table = types.Array(tables.dtype, 2, "C")
        return types.NamedTuple((floats, integers, table), Block)

    return typed


@lower_builtin(part_of, types.Array, types.Array, types.Array, types.Integer)
def _part(context: Any, builder: Any, signature: Any, args: Sequence[Any]) -> Any:
    tables = make_array(signature.args[2])(context, builder, args[2])
    _, rows, columns = cgutils.unpack_tuple(builder, tables.shape, 3)
    number = context.cast(builder, args[3], signature.args[3], types.intp)
    start = builder.mul(number, builder.mul(rows, columns))
    data = builder.gep(tables.data, [start])
    table = _array(context, builder, signature.return_type.types[2], data, [rows, columns])
    return context.make_tuple(builder, signature.return_type, (args[0], args[1], table))


Shape = tuple[int, ...]


class Arrays(NamedTuple):
    """The arrays of a part: `names` in the order of their numbers; `whole` are integers."""

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
    tick to the next: a copy of these is its whole memory. `stages` are the kernels that are called
    by address (see `stages`).
    """

    def __init__(
        self,
        parts: Mapping[str, list[tuple[str, Shape, bool]]],
        memory: Sequence[str] = (),
        stages: Sequence[Any] = (),
    ) -> None:
        longest = max((len(arrays) for arrays in parts.values()), default=0)
        self.tables = np.zeros((len(parts), max(longest, 1), 3), dtype=np.int64)
        ends = [0, SLOTS]
        for number, arrays in enumerate(parts.values()):
            for k, (_, shape, whole) in enumerate(arrays):
                rows, columns = (1, *shape)[-2:]
                self.tables[number, k] = ends[whole], rows, columns
                ends[whole] += -(-rows * columns // LINE) * LINE
        self.floats = _aligned(ends[0])
        self.integers = np.zeros(ends[1], dtype=np.int64)
        for stage in stages:
            self.integers[stage.slot] = stage.address
        self.parts: dict[str, Part] = {}
        for number, (name, arrays) in enumerate(parts.items()):
            views = {}
            for k, (label, shape, whole) in enumerate(arrays):
                source = self.integers if whole else self.floats
                at = self.tables[number, k, 0]
                views[label] = source[at : at + int(np.prod(shape))].reshape(shape)
            block = Block(self.floats, self.integers, self.tables[number])
            self.parts[name] = Part(number, views, block)
        self._shapes = dict(parts)
        self._kept = tuple(tuple(name.split(".")) for name in memory)

    def shapes_of(self, part: str) -> list[tuple[str, Shape, bool]]:
        """Return the arrays that a part was made of."""
        return self._shapes[part]

    def take(self, other: Workspace) -> None:
        """Copy all arrays of the parts that another workspace has in the same shape."""
        for name, part in other.parts.items():
            for label in part:
                getattr(self.parts[name], label)[...] = getattr(part, label)

    def __getattr__(self, name: str) -> Part:
        try:
            return self.__dict__["parts"][name]
        except KeyError:
            raise AttributeError(name) from None

    def memory(self) -> dict[str, NDArray[Any]]:
        """Return a copy of what is kept from one tick to the next, by "part.array"."""
        return {
            f"{part}.{array}": getattr(self.parts[part], array).copy() for part, array in self._kept
        }

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Write back a copy that `memory` made, bit by bit."""
        for part, array in self._kept:
            getattr(self.parts[part], array)[...] = state[f"{part}.{array}"]


def _aligned(count: int) -> np.ndarray:
    """Return zeros that begin at a cache line."""
    raw = np.zeros(count + LINE)
    start = -(raw.ctypes.data // 8) % LINE
    return raw[start : start + max(count, 1)]
