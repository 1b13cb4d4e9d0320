"""What happened to the feet of a walk, in sentences."""

from __future__ import annotations

from dataclasses import dataclass

NAMES = ("left", "right")


@dataclass(frozen=True)
class WalkEvent:
    """What happened at time `t` [s], and to which foot.

    `kind` is lift, touch, bounce, lost, late, aside, stop or stood.
    `early` [s] is how long before its plan a foot touched, negative behind it; `off` (3,) [m] how
    far from where it was to be.
    """

    t: float
    kind: str
    step: int = 0
    foot: int = -1
    early: float = 0.0
    off: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __str__(self) -> str:
        if self.kind == "touch":
            x, y, z = (1e3 * value for value in self.off)
            return (
                f"t = {self.t:.3f} s: step {self.step}, the {NAMES[self.foot]} foot touches "
                f"{1e3 * self.early:+.0f} ms before its plan, ({x:+.1f}, {y:+.1f}, {z:+.1f}) mm off"
            )
        if self.kind == "aside":
            x, y, _ = (1e3 * value for value in self.off)
            return (
                f"t = {self.t:.3f} s: step {self.step}, the {NAMES[self.foot]} foot is put "
                f"({x:+.0f}, {y:+.0f}) mm from its plan to catch the robot"
            )
        words = {
            "lift": f"step {self.step}, the {NAMES[self.foot]} foot lifts",
            "lost": f"the {NAMES[self.foot]} foot has lost its ground, and is put down again",
            "bounce": f"step {self.step}, the {NAMES[self.foot]} foot comes off again",
            "late": f"step {self.step}, the {NAMES[self.foot]} foot finds no ground; it searches",
            "stop": "it is told to stop",
            "stood": "it stands",
        }
        return f"t = {self.t:.3f} s: {words[self.kind]}"
