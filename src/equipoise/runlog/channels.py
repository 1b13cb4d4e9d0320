"""What one logged vector is: its name, its components and their units."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass

from equipoise.errors import InputError


@dataclass(frozen=True)
class Channel:
    """Describe one vector that is logged every tick.

    `name` is free text such as "q" or "lam/left_sole"; `labels` names each component; `unit` is
    one unit for all components or one for each; `doc` says in a line what the vector is.

    Raises: InputError if the name is empty, "t" or unprintable, if labels repeat, or if there are
    several units but not one for each label.
    """

    name: str
    labels: tuple[str, ...]
    unit: str | tuple[str, ...]
    doc: str = ""

    def __post_init__(self) -> None:
        if isinstance(self.labels, str):
            raise InputError(
                f"The labels of channel {self.name!r} are one text",
                given=self.labels,
                remedy="Give a sequence with one label for each component, such as ('x', 'y', 'z')",
            )
        object.__setattr__(self, "labels", tuple(self.labels))
        if not isinstance(self.unit, str):
            object.__setattr__(self, "unit", tuple(self.unit))
        self._check()

    @property
    def size(self) -> int:
        """Number of components."""
        return len(self.labels)

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of each component."""
        return (self.unit,) * self.size if isinstance(self.unit, str) else self.unit

    @property
    def columns(self) -> tuple[str, ...]:
        """Column title of each component, for example "v[left_knee] (rad/s)"."""
        return tuple(
            f"{self.name}[{label}]" + (f" ({unit})" if unit else "")
            for label, unit in zip(self.labels, self.units, strict=True)
        )

    def _check(self) -> None:
        texts = (self.name, *self.labels, *self.units, self.doc)
        if not all(isinstance(text, str) for text in texts):
            raise InputError(
                f"Channel {self.name!r} holds something that is not a text",
                given=[text for text in texts if not isinstance(text, str)],
                remedy="Give name, labels, unit and doc as texts",
            )
        if not self.name or self.name == "t" or not self.name.isprintable():
            raise InputError(
                "A channel needs a printable name other than 't', which is the time",
                given=self.name,
            )
        if len(set(self.labels)) < self.size:
            repeated = sorted({label for label in self.labels if self.labels.count(label) > 1})
            raise InputError(f"Labels of channel {self.name!r} repeat", given=repeated)
        if len(self.units) != self.size:
            raise InputError(
                f"Channel {self.name!r} has {self.size} components but {len(self.units)} units",
                given=self.unit,
                remedy="Give one unit for all components or one for each",
            )


def check_channels(channels: Iterable[Channel]) -> tuple[Channel, ...]:
    """Return the channels as a tuple.

    Raises: InputError if there are none or if two share a name.
    """
    checked = tuple(channels)
    if not checked:
        raise InputError("A log needs at least one channel")
    names = [channel.name for channel in checked]
    repeated = sorted({name for name in names if names.count(name) > 1})
    if repeated:
        raise InputError("Channels share a name", given=repeated, known=sorted(set(names)))
    return checked


def channels_to_json(channels: Sequence[Channel]) -> str:
    """Write the channels as JSON text."""
    return json.dumps([asdict(channel) for channel in channels])


def channels_from_json(text: str) -> tuple[Channel, ...]:
    """Read the channels back from JSON text.

    Raises: ValueError, TypeError or InputError if the text holds something else.
    """
    return check_channels(Channel(**entry) for entry in json.loads(text))
