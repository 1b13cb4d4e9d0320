"""Contact rows factorised in the metric of K_d: what keeps them, and what lifts onto them."""

from __future__ import annotations

import numpy as np

from equipoise.compiled import entrance
from equipoise.contacts.stack import RANK_TOLERANCE
from equipoise.control.passivity.nearest_kernels import factorise_in_metric, move_to_nearest
from equipoise.spatial import Array
from equipoise.spatial.numbers import real_array


class NearestVelocity:
    """`J` (r, nv) in the metric `K` (nv, nv), symmetric positive definite, with N and J^#.

    `J^# = K^-1 J^T (J K^-1 J^T)^-1` and `N = I - J^# J`: `N x` is the velocity nearest to x, as K
    measures it, that violates no row. Where rows depend on others, `J^# y` comes as near to y as a
    velocity can.
    Source: Gauss's principle; with K the inertia, J^# is the dynamically consistent inverse of
    Khatib 1987 and N the projector of Udwadia and Kalaba 1992.
    """

    def __init__(self, J: Array, K: Array) -> None:
        self.J = np.ascontiguousarray(real_array("J", J, None))
        r, nv = self.J.shape
        self._unroot = unroot_of(np.asarray(K, dtype=float))
        self._L, self._reflectors = np.zeros((r, nv)), np.zeros((r, nv))
        self._pivots = np.zeros(r, dtype=np.int64)
        self.rank: int = _factorise(
            self.J, self._unroot, self._L, self._reflectors, self._pivots, RANK_TOLERANCE
        )

    def keep(self, x: Array) -> Array:
        """Return `N x` (nv,)."""
        return self.move(x, np.zeros(len(self.J)))

    def lift(self, y: Array) -> Array:
        """Return `J^# y` (nv,): of all velocities x with `J x = y` the smallest in the metric."""
        return self.move(np.zeros(self.J.shape[1]), y)

    def move(self, x: Array, y: Array) -> Array:
        """Return `N x + J^# y` (nv,): the velocity nearest to x with `J x = y`."""
        out = np.array(x, dtype=float)
        _move(
            self.J, self._unroot, self._L, self._reflectors, self._pivots, self.rank,
            np.asarray(y, dtype=float), out,
        )  # fmt: skip
        return out

    @property
    def N(self) -> Array:
        """The projector as a matrix (nv, nv)."""
        return np.column_stack([self.keep(e) for e in np.eye(self.J.shape[1])])

    @property
    def J_sharp(self) -> Array:
        """The right inverse as a matrix (nv, r)."""
        return np.column_stack([self.lift(e) for e in np.eye(len(self.J))])


def unroot_of(K: Array) -> Array:
    """Return `U^-T` (nv, nv) of `K = U U^T` with U upper triangular.

    Joints stand after their parents. Where K is an inertia, row k of `U^-T` then knows only the
    joints that carry k, so that a contact's rows times it are no fuller than they were.
    Source: Featherstone 2005, "Efficient factorization of the joint-space inertia matrix".
    """
    U = np.linalg.cholesky(K[::-1, ::-1])[::-1, ::-1]
    inverse: Array = np.triu(np.linalg.inv(U))
    return np.ascontiguousarray(inverse.T)


@entrance
def _factorise(
    J: np.ndarray, unroot: np.ndarray, L: np.ndarray, reflectors: np.ndarray, pivots: np.ndarray,
    tolerance: float,
) -> int:  # fmt: skip
    return factorise_in_metric(J, unroot, L, reflectors, pivots, tolerance)


@entrance
def _move(
    J: np.ndarray, unroot: np.ndarray, L: np.ndarray, reflectors: np.ndarray, pivots: np.ndarray,
    rank: int, wanted: np.ndarray, x: np.ndarray,
) -> None:  # fmt: skip
    move_to_nearest(J, unroot, L, reflectors, pivots, rank, wanted, x)
