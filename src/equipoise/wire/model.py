"""What both ends of a wire must agree on: sizes, names, limits, and a hash of them."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from equipoise.contacts import ContactStack
from equipoise.errors import InputError
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.spatial.numbers import require_period

MOST = 256  # coordinates, joints or rows of contacts: the longest packet then has 8300 bytes


@dataclass(frozen=True)
class WireModel:
    """Sizes and limits of a robot on a wire.

    `tau_max` (na,) [N m]; `digest` are 16 bytes of the SHA-256 of all names and limits, see
    docs/wire.md.
    """

    nq: int
    nv: int
    na: int
    rows: int
    tau_max: Array
    digest: bytes

    def __post_init__(self) -> None:
        sizes = {"nq": self.nq, "nv": self.nv, "na": self.na, "rows": self.rows}
        for name, size in sizes.items():
            if not 0 <= size <= MOST:
                raise InputError(f"{name} must be from 0 to {MOST} on the wire", given=size)

    @classmethod
    def of(
        cls, robot: Robot, contacts: ContactStack, period: float, *, lockstep: bool
    ) -> WireModel:
        """Return the model of a robot whose `contacts` are sent every `period` [s].

        In `lockstep` its time waits for commands; else it runs.
        """
        rows = [
            f"{contact.name}/{label} [{unit}]"
            for contact in contacts.contacts
            for label, unit in zip(contact.labels, contact.units, strict=True)
        ]
        pace = "lockstep" if lockstep else "realtime"
        limits = (robot.q_min, robot.q_max, robot.v_max, robot.tau_max)
        digest = hash_of(
            (robot.name, pace, *robot.base_position_names, *robot.velocity_names, *rows),
            (np.array([require_period(period)]), *limits),
        )
        tau_max = np.array(robot.tau_max, dtype=np.float64)
        return cls(robot.nq, robot.nv, robot.na, contacts.size, tau_max, digest)


def hash_of(names: Sequence[str], numbers: Sequence[Array]) -> bytes:
    """Return the first 16 bytes of the SHA-256 of names (UTF-8, each ended by 0) and doubles."""
    found = hashlib.sha256()
    for name in names:
        found.update(name.encode() + b"\0")
    for values in numbers:
        found.update(np.ascontiguousarray(values, dtype="<f8").tobytes())
    return found.digest()[:16]
