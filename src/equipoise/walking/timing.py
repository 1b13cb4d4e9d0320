"""How long the phases of a walk last."""

from __future__ import annotations

from dataclasses import dataclass, fields

from equipoise.spatial.numbers import positive


@dataclass(frozen=True)
class WalkTiming:
    """Durations [s]: a foot in the air, both feet on the ground, and the ends of the walk.

    `single`: how long a step is in the air. `double`: how long both feet then carry, while the load
    goes over. `shift`: how long the load takes from the middle to the first foot that carries
    alone, and back from the last. `settle`: how long it stands before and after, in which the
    centre of mass starts and comes to rest.
    Raises: `InputError` for what is not positive.
    """

    single: float = 0.8
    double: float = 0.4
    shift: float = 1.0
    settle: float = 0.5

    def __post_init__(self) -> None:
        for field in fields(self):
            positive(f"the duration {field.name!r} of a walk", getattr(self, field.name), "s")
