"""What a description of a robot gives, in whatever format it is written."""

from __future__ import annotations

from dataclasses import dataclass, field

import pinocchio as pin

from equipoise.robots.base import Base
from equipoise.robots.files.finding import Finding
from equipoise.robots.files.laws import Law

Pairs = set[tuple[str, str]]


@dataclass
class Described:
    """Models of a robot, its postures (name -> joint -> coordinate), and what was found.

    `disabled` are the pairs of links whose collisions are not looked at; `start` names the posture
    to begin with, if there is one. `laws` tell which joints follow others. `coupled` are those, and
    what was locked because its leader is: a posture may name them, and says nothing.
    """

    name: str
    model: pin.Model
    collision: pin.GeometryModel
    visual: pin.GeometryModel
    base: Base
    disabled: Pairs
    postures: dict[str, dict[str, float]] = field(default_factory=dict)
    start: str | None = None
    findings: list[Finding] = field(default_factory=list)
    coupled: set[str] = field(default_factory=set)
    laws: list[Law] = field(default_factory=list)
