"""What an episode is like: how far and how hard an agent may want things, and for how long."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from equipoise.errors import InputError
from equipoise.spatial.numbers import real_number

Engine = Literal["rigid", "mujoco"]


@dataclass(frozen=True)
class Episode:
    """What an episode is like.

    An action of 1 puts a hand's target `way` [m] along a world axis and `turn` [rad] about it away
    from where the hand begins, and wants `force` [N] of a contact. A step lasts `ticks` of the
    controller, an episode `steps` steps, in an `engine`.
    Raises: `InputError`.
    """

    way: float = 0.1
    turn: float = 0.3
    force: float = 20.0
    ticks: int = 20
    steps: int = 100
    engine: Engine = "rigid"

    def __post_init__(self) -> None:
        for name in ("way", "turn", "force", "ticks", "steps"):
            value = real_number(f"the {name} of an episode", getattr(self, name))
            if not value > 0.0 or (name in ("ticks", "steps") and value != round(value)):
                kind = "a whole number above 0" if name in ("ticks", "steps") else "above 0"
                raise InputError(f"the {name} of an episode must be {kind}", given=value)
        if self.engine not in get_args(Engine):
            raise InputError(
                "there is no engine of this name", given=self.engine, known=get_args(Engine)
            )
