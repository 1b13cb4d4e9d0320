"""Contacts with kernels of their own, filled by one call: what each is, and where its rows go."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from equipoise.compiled.compilation import entrance
from equipoise.contacts.base import CompiledContact
from equipoise.contacts.grasp import grasp_drift, grasp_rows
from equipoise.contacts.point import point_drift_rows, point_rows
from equipoise.contacts.rows import ContactRows
from equipoise.contacts.sole import sole_drift, sole_rows
from equipoise.kinematics import Kinematics

SOLE, GRASP, POINT = range(3)
KERNELS = {"sole": SOLE, "grasp": GRASP, "point": POINT}


class ContactProgram:
    """The rows of some contacts in a stack; their numbers are gathered here once.

    Calling a kernel from Python costs more than most of these kernels, hence one call for all.
    """

    def __init__(self, contacts: Sequence[CompiledContact], starts: Sequence[int]) -> None:
        self.count = len(contacts)
        self._kinds = np.array([KERNELS[c.kernel] for c in contacts], dtype=np.int64)
        self._frames = np.array([c.frames for c in contacts], dtype=np.int64).reshape(-1, 2)
        self._poses = np.array([c.kept for c in contacts], dtype=float).reshape(-1, 12)
        self._starts = np.array(starts, dtype=np.int64)

    def fill(self, kin: Kinematics, rows: ContactRows, *, drift: bool) -> None:
        """Write rows and residuals, and the drifts if asked for."""
        live = kin.live_with_drift if drift else kin.live
        fill_rows(
            self._kinds,
            self._frames,
            self._poses,
            self._starts,
            live.joint_ids,
            live.columns,
            live.carries,
            live.frames,
            rows.J,
            rows.residual,
        )
        if drift:
            fill_drifts(
                self._kinds,
                self._frames,
                self._poses,
                self._starts,
                live.joint_ids,
                live.joints,
                live.velocities,
                live.accelerations,
                live.frames,
                rows.drift,
            )


@entrance
def fill_rows(
    kinds: np.ndarray,
    frame_ids: np.ndarray,
    poses: np.ndarray,
    starts: np.ndarray,
    joint_ids: np.ndarray,
    columns: np.ndarray,
    carries: np.ndarray,
    frames: np.ndarray,
    J: np.ndarray,
    residual: np.ndarray,
) -> None:
    """Write J and residual of each contact i from row starts[i] on."""
    for i in range(kinds.shape[0]):
        a, b, pose, at = frame_ids[i, 0], frame_ids[i, 1], poses[i], starts[i]
        carried_a, T_a = carries[joint_ids[a]], frames[a]
        if kinds[i] == SOLE:
            sole_rows(columns, carried_a, T_a, pose, J, residual, at)
        elif kinds[i] == GRASP:
            carried_b = carries[joint_ids[b]]
            grasp_rows(columns, carried_a, carried_b, T_a, frames[b], pose, J, residual, at)
        else:
            point_rows(columns, carried_a, T_a, pose, J, residual, at)


@entrance
def fill_drifts(
    kinds: np.ndarray,
    frame_ids: np.ndarray,
    poses: np.ndarray,
    starts: np.ndarray,
    joint_ids: np.ndarray,
    joints: np.ndarray,
    velocities: np.ndarray,
    accelerations: np.ndarray,
    frames: np.ndarray,
    drift: np.ndarray,
) -> None:
    """Write the drift of each contact i from row starts[i] on."""
    for i in range(kinds.shape[0]):
        a, b, pose, at = frame_ids[i, 0], frame_ids[i, 1], poses[i], starts[i]
        m, T = joint_ids[a], frames[a]
        if kinds[i] == SOLE:
            sole_drift(joints[m], velocities[m], accelerations[m], T, pose, drift, at)
        elif kinds[i] == GRASP:
            n = joint_ids[b]
            grasp_drift(joints, velocities, accelerations, m, n, T, frames[b], drift, at)
        else:
            point_drift_rows(joints[m], velocities[m], accelerations[m], T, pose, drift, at)
