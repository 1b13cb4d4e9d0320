"""Whether a robot is fit to be driven: motors that are hot, somebody who wants it to stop."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from equipoise.spatial import Array

HOTTEST_AT_START, HOTTEST = 70.0, 90.0  # [deg C] of a motor: chosen here, no maker's figures


class Health(NamedTuple):
    """What a robot says of its motors, by joint (na,); empty where it says nothing.

    `temperature` [deg C] the hottest of each motor, `voltage` [V] at it, zero where not said;
    `words` what it reports in a code of its maker. `stop`: somebody asks for the end.
    """

    temperature: Array = np.zeros(0)
    voltage: Array = np.zeros(0)
    words: Array = np.zeros(0, dtype=int)
    stop: bool = False


NOTHING_SAID = Health()


def trouble(health: Health, names: Sequence[str], hottest: float = HOTTEST) -> str:
    """Return in words why a robot must not be driven, empty if nothing speaks against it."""
    if health.stop:
        return "the stop on its remote control is pressed"
    if health.temperature.size and not (health.temperature <= hottest).all():
        worst = int(np.argmax(health.temperature))
        return (
            f"the motor of {names[worst]} has {health.temperature[worst]:.0f} deg C, "
            f"{hottest:.0f} are allowed"
        )
    return ""


def told_of_health(health: Health, names: Sequence[str]) -> list[str]:
    """Return in words what a robot says of its motors."""
    said = []
    if health.temperature.any():
        worst = int(np.argmax(health.temperature))
        said.append(f"its hottest motor has {health.temperature[worst]:.0f} deg C ({names[worst]})")
    elif health.temperature.size:
        said.append("its motors tell no temperature")
    if health.voltage.any():
        said.append(f"its motors have {health.voltage.min():.1f} V or more")
    elif health.voltage.size:
        said.append("its motors tell no voltage")
    if health.voltage.size:
        said.append("its battery is not looked at: it has messages of its own")
    if health.words.any():
        which = ", ".join(
            f"{name} {int(word):#x}" for name, word in zip(names, health.words, strict=True) if word
        )
        said.append(f"its motors report codes that are not understood here: {which}")
    return said
