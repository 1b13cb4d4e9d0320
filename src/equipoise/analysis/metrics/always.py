"""What every run must show, whatever its file asks for: that nothing impossible happened.

A file loosens one of these by naming the metric with a weaker bound; the table then says so.
"""

from __future__ import annotations

from dataclasses import dataclass

from equipoise.scenarios.schema import Limit

CLAMPED_MOST = 0.1  # [s] that a torque may stay clamped before the motion is no longer the law's
TOUCH = 0.01  # [m] that the hull of a link may reach into what its contact touches
STOP = 0.001  # [rad] by which a joint's stop may give way
SQUEEZE = 0.5  # [N] that a palm may seem to pull: what a start without torque costs
NORMAL = 0.01  # [N] the same for a surface or a pushed object, where nothing of the kind is seen
OVERSPEED = 2.0  # share of a joint's speed limit at which the state counts as diverged
DEGRADED = 1.0  # the worst mode in which the law still runs


@dataclass(frozen=True)
class Possible:
    """What is possible: a bound on a metric, and what it means when it is not kept."""

    limit: Limit
    fault: str


MISSED = 0.02  # [m] from a waypoint that was to be come to


ALWAYS: dict[str, Possible] = {
    "completed": Possible(Limit(min=1.0), "the run did not reach its end"),
    "mode_worst": Possible(Limit(max=DEGRADED), "the supervisor switched the law off"),
    "finite": Possible(Limit(min=1.0), "the state or a torque became infinite or undefined"),
    "velocity_share": Possible(Limit(max=OVERSPEED), "a joint went faster than it can"),
    "clamped_longest": Possible(
        Limit(max=CLAMPED_MOST),
        "a torque stood at its limit: a motor could not give what it had to",
    ),
    "waypoint_miss": Possible(
        Limit(max=MISSED), "a frame got as far as it could, and not to where it was sent"
    ),
    "joint_margin": Possible(Limit(min=-STOP), "a joint went past its stop"),
    "clearance": Possible(Limit(min=0.0), "two bodies were inside one another"),
    "touch_depth": Possible(Limit(max=TOUCH), "a body was inside of what it only touches"),
    "reaction_normal": Possible(Limit(min=0.0), "a floor cannot pull, but it had to"),
    "reaction_friction": Possible(Limit(min=0.0), "a sole would have slipped"),
    "reaction_pressure": Possible(Limit(min=0.0), "a sole would have tipped over its edge"),
    "reaction_yaw": Possible(Limit(min=0.0), "a sole would have turned on the floor"),
    "surface_normal": Possible(Limit(min=-NORMAL), "a surface cannot pull, but it had to"),
    "grasp_squeeze": Possible(Limit(min=-SQUEEZE), "palms cannot pull, but they had to"),
}
