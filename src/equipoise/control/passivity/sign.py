"""The sign function that stands under the integrals of (22d) and (23d), and its smooth kin."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from equipoise.control.passivity.manifold_kernels import SATURATION, SIGN, TANH, sign_of
from equipoise.errors import InputError
from equipoise.spatial import Array
from equipoise.spatial.numbers import not_negative, positive

SignKind = Literal["sign", "tanh", "saturation"]
_CODES = {"sign": SIGN, "tanh": TANH, "saturation": SATURATION}


@dataclass(frozen=True)
class SignFunction:
    """`sgn`, `tanh(x / layer)` or `clip(x / layer, -1, 1)`, by component.

    Inside the boundary layer the integral of the last two is a linear integrator of gain
    `k_i / layer`; a layer thinner than about `k_i dt` only chatters.
    """

    kind: SignKind = "sign"
    layer: float = 0.02

    def __post_init__(self) -> None:
        if self.kind not in _CODES:
            raise InputError("unknown sign function", given=self.kind, known=tuple(_CODES))
        check = not_negative if self.kind == "sign" else positive  # a sign has no layer
        object.__setattr__(self, "layer", check("the boundary layer", self.layer))

    @property
    def code(self) -> int:
        """The kind as kernels know it."""
        return _CODES[self.kind]

    def __call__(self, x: Array) -> Array:
        """Return the sign of `x` (k,) by component, in [-1, 1]."""
        out = np.empty(len(x))
        sign_of(x, self.code, self.layer, out)
        return out
