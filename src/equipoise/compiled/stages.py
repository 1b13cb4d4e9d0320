"""Large kernels that others call by address, so that they are compiled once and not once a caller.

Numba compiles what a kernel calls into it, again for every kernel that calls it: a solver of a
thousand lines that three entrances use is optimised many times over. A stage is compiled alone; a
workspace keeps its address, and kernels call it there. It takes two blocks and a number and returns
a number.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numba
import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import lower_builtin, type_callable
from numba.np.arrayobj import make_array, populate_array

from equipoise.compiled.compilation import OPTIONS, is_kept, kept_where, specialised
from equipoise.compiled.workspace import SLOTS, Block

_TABLE = 1 << 20  # rows a table may have; nobody looks at it
_SIGNATURE = types.int64(
    types.CPointer(types.float64), types.CPointer(types.int64), types.CPointer(types.int64),
    types.CPointer(types.int64), types.int64,
)  # fmt: skip


def _memory_at(pointer: Any) -> np.ndarray:
    """Return the memory that begins at a pointer; nobody looks at its size."""
    raise NotImplementedError("only compiled kernels have pointers")


def _table_at(pointer: Any) -> np.ndarray:
    """Return the table [.., 3] that begins at a pointer; nobody looks at its length."""
    raise NotImplementedError("only compiled kernels have pointers")


@type_callable(_memory_at)
def _type_of_memory(context: Any) -> Callable[..., Any]:
    return lambda pointer: types.Array(pointer.dtype, 1, "C")


@type_callable(_table_at)
def _type_of_table(context: Any) -> Callable[..., Any]:
    return lambda pointer: types.Array(pointer.dtype, 2, "C")


@lower_builtin(_memory_at, types.CPointer)
@lower_builtin(_table_at, types.CPointer)
def _array_at(context: Any, builder: Any, signature: Any, args: Sequence[Any]) -> Any:
    size = context.get_constant
    flat = signature.return_type.ndim == 1
    shape = [size(types.intp, 1)] if flat else [size(types.intp, _TABLE), size(types.intp, 3)]
    strides = [size(types.intp, 8)] if flat else [size(types.intp, 24), size(types.intp, 8)]
    array = make_array(signature.return_type)(context, builder)
    populate_array(
        array,
        data=args[0],
        shape=cgutils.pack_array(builder, shape),
        strides=cgutils.pack_array(builder, strides),
        itemsize=size(types.intp, 8),
        meminfo=None,
    )
    return array._getvalue()


def kernel(first: Block, second: Block, number: int) -> int:
    """Stand for the kernel of a stage in `_run`."""
    raise NotImplementedError


def _run(floats: Any, whole: Any, first: Any, second: Any, number: int) -> int:
    """Call a kernel, given pointers to the two blocks of memory and to two tables."""
    memory, integers = _memory_at(floats), _memory_at(whole)
    one = Block(memory, integers, _table_at(first))
    other = Block(memory, integers, _table_at(second))
    return kernel(one, other, number)


class Stage:
    """A kernel `function(first, second, number) -> number` on two blocks of one workspace.

    Kernels call `stage.call`; Python too. `slot` is where its address stands in a workspace that
    was made with it.
    """

    def __init__(self, slot: int, function: Callable[[Block, Block, int], int]) -> None:
        assert 0 <= slot < SLOTS
        self.slot, self.function = slot, function
        self._compiled: Any = None
        self.call = self._callable()

    @property
    def address(self) -> int:
        """The address of the compiled kernel, which is loaded or compiled when first asked for."""
        if numba.config.DISABLE_JIT:
            return 0
        if self._compiled is None:
            self._compiled = self._compile()
        return int(self._compiled.address)

    def _compile(self) -> Any:
        source = getattr(self.function, "py_func", self.function)
        run = specialised(_run, f"stage_{source.__name__}", kernel=self.function)
        with kept_where(Path(source.__code__.co_filename).parent):
            return numba.cfunc(_SIGNATURE, cache=is_kept(), **OPTIONS)(run)

    def _callable(self) -> Callable[[Block, Block, int], int]:
        stage = self

        def call(first: Block, second: Block, number: int) -> int:
            return stage.function(first, second, number)

        @type_callable(call)
        def type_of_call(context: Any) -> Callable[..., Any]:
            return lambda first, second, number: types.int64

        @lower_builtin(call, types.BaseNamedTuple, types.BaseNamedTuple, types.Integer)
        def call_at_address(context: Any, builder: Any, signature: Any, args: Sequence[Any]) -> Any:
            return _call(context, builder, signature, args, stage.slot)

        return call


def _call(context: Any, builder: Any, signature: Any, args: Sequence[Any], slot: int) -> Any:
    """Emit the call of the kernel whose address stands in a slot of the integers."""
    first, second, number = signature.args
    pointers = []
    for kind, value, place in ((first, args[0], 0), (first, args[0], 1), (first, args[0], 2),
                               (second, args[1], 2)):  # fmt: skip
        array = builder.extract_value(value, place)
        pointers.append(make_array(kind.types[place])(context, builder, array).data)
    whole = ir.IntType(64)
    function = ir.FunctionType(
        whole, [pointers[0].type, pointers[1].type, pointers[2].type, pointers[3].type, whole]
    )
    offset = context.get_constant(types.intp, slot)
    address = builder.load(builder.gep(pointers[1], [offset]))
    kernel = builder.inttoptr(address, function.as_pointer())
    last = context.cast(builder, args[2], number, types.int64)
    return builder.call(kernel, [*pointers, last])
