"""Short-lived memory of a kernel, on the stack.

Kernels are compiled without Numba's reference counts (see `compilation`), which cost a fifth of
their time, and so cannot allocate. A scratch array dies with the function that asked for it: it
must not be returned, nor asked for inside a loop, where each round would take more of the stack.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import lower_builtin, type_callable
from numba.np.arrayobj import make_array, populate_array


def scratch(size: int) -> np.ndarray:
    """Return an array [size] of anything."""
    return np.empty(size)


def scratch_matrix(rows: int, columns: int) -> np.ndarray:
    """Return an array [rows, columns] of anything."""
    return np.empty((rows, columns))


@type_callable(scratch)
def _type_of_scratch(typing_context: Any) -> Callable[..., types.Array]:
    return lambda size: types.Array(types.float64, 1, "C")


@type_callable(scratch_matrix)
def _type_of_scratch_matrix(typing_context: Any) -> Callable[..., types.Array]:
    return lambda rows, columns: types.Array(types.float64, 2, "C")


@lower_builtin(scratch, types.Integer)
@lower_builtin(scratch_matrix, types.Integer, types.Integer)
def _array_on_stack(context: Any, builder: Any, signature: Any, args: Sequence[Any]) -> Any:
    shape = [
        context.cast(builder, size, kind, types.intp)
        for size, kind in zip(args, signature.args, strict=True)
    ]
    count = shape[0]
    for extent in shape[1:]:
        count = builder.mul(count, extent)
    memory = builder.alloca(ir.DoubleType(), size=count)
    memory.align = 64
    itemsize = context.get_constant(types.intp, 8)
    strides = [itemsize]
    for extent in reversed(shape[1:]):
        strides.insert(0, builder.mul(strides[0], extent))
    array = make_array(signature.return_type)(context, builder)
    populate_array(
        array,
        data=builder.bitcast(memory, array.data.type),
        shape=cgutils.pack_array(builder, shape),
        strides=cgutils.pack_array(builder, strides),
        itemsize=itemsize,
        meminfo=None,
    )
    return array._getvalue()
