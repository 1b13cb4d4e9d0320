"""What the picture is shown: one moment of a run, and what a layer of the picture must do."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass

from equipoise.kinematics import Kinematics
from equipoise.spatial import Array


@dataclass(frozen=True)
class Moment:
    """Logged `values` by channel at time `t` [s], and the kinematics of the measured state."""

    t: float
    values: Mapping[str, Array]
    kin: Kinematics


class Showable(ABC):
    """Something that can be hidden."""

    @abstractmethod
    def set_visible(self, visible: bool) -> None:
        """Show or hide everything of it."""


class Layer(Showable):
    """Something in the scene that changes with the moment."""

    title: str

    @abstractmethod
    def show(self, moment: Moment) -> None:
        """Draw that moment."""
