"""From the walk of a scenario to its plan, and to the tasks that follow it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from equipoise.contacts import ContactStack, SoleContact
from equipoise.errors import InputError, ScenarioError
from equipoise.robots import Robot
from equipoise.scenarios import schema
from equipoise.scenarios.lookup import at_path, to_vector
from equipoise.simulation.build.setup import Setup
from equipoise.tasks import ComTask, FrameAxesTask, FramePoseTask, Task
from equipoise.trajectories import Waypoint, WaypointTrajectory
from equipoise.walking import (
    LEFT,
    RIGHT,
    BalanceFeedback,
    BalanceSettings,
    Feet,
    Footstep,
    LedPose,
    SteeredWalk,
    Stick,
    StickSchedule,
    Stride,
    StrideLimits,
    SwingShape,
    TouchSettings,
    Walker,
    WalkLimits,
    WalkMode,
    WalkPlan,
    WalkPlanner,
    WalkSettings,
    WalkTargets,
    WalkTiming,
    require_feasible,
    steps_along,
    steps_to,
)
from equipoise.walking.feet import Stance, level_pose
from equipoise.walking.leg import leg_lever
from equipoise.walking.settings import GRAVITY

TOUCH = 0.03  # of the weight, on a foot, is a touchdown
FEET = {"left": LEFT, "right": RIGHT}
TRUNK = ("pelvis", "torso")  # parts of the body that stay upright


@dataclass(frozen=True)
class WalkSetup:
    """The walk of a scenario: its plan, what it leads, and the contacts of its feet by name.

    `tasks` are those of level 0, of the centre of mass, and of the trunk.
    """

    spec: schema.WalkSpec
    planner: WalkPlanner
    plan: WalkPlan
    targets: WalkTargets
    contacts: tuple[str, str]
    weight: float

    def walker(self, balance: BalanceFeedback | None = None) -> Walker:
        """Return who leads the targets, from the start of the plan on."""
        touch = TouchSettings(TOUCH * self.weight)
        return Walker(self.planner, self.plan, touch, self.targets, balance=balance)

    def steered(self, walker: Walker) -> SteeredWalk | None:
        """Return who makes the footsteps of a walk that is steered, None for any other."""
        if self.spec.steer is None:
            return None
        return SteeredWalk(
            walker,
            StrideLimits(**self.spec.stride.model_dump()),
            WalkLimits(margin=self.spec.margin),
        )

    @property
    def sticks(self) -> StickSchedule:
        """How fast it is to walk, and when."""
        steer = self.spec.steer or ()
        return StickSchedule([(o.at, Stick(o.forward, o.left, o.turn)) for o in steer])

    def balance(self, dt: float) -> BalanceFeedback | None:
        """Return the feedback on the centre of mass for a period `dt` [s], if it is wanted."""
        if self.spec.balance is None:
            return None
        settings = BalanceSettings(**self.spec.balance.model_dump())
        return BalanceFeedback(settings, self.planner.settings.omega, dt)

    def feet_tasks(self) -> list[Task]:
        """Return the tasks of the feet."""
        return [
            FramePoseTask(f"walk {name}", sole.frame, led, rate=self.spec.foot_rate)
            for name, sole, led in zip(
                self.contacts, self.planner.feet.soles, self.targets.soles, strict=True
            )
        ]

    def trunk_tasks(self) -> list[Task]:
        """Return the tasks of what stays upright."""
        return [
            FrameAxesTask(f"walk {frame}", frame, led, axes=("rx", "ry", "rz"), rate=self.spec.rate)
            for frame, led in self.targets.upright.items()
        ]

    def com_task(self) -> Task:
        """Return the task of the centre of mass."""
        return ComTask("walk com", self.targets.centre, rate=self.spec.rate)

    def com_approach(self, robot: Robot, duration: float) -> Task:
        """Return the task that leads the centre of mass to its start, which is at time 0."""
        start = robot.at(robot.q_half_sitting).p_world_com
        here = pin.SE3(np.eye(3), start.copy())
        there = self.targets.centre.at(0.0).T_world_target
        way = WaypointTrajectory(
            [Waypoint(-duration, here), Waypoint(0.0, pin.SE3(np.eye(3), there.translation))]
        )
        return ComTask("walk com", way, rate=self.spec.rate)


def build_walk(scenario: schema.Scenario, setup: Setup) -> WalkSetup | None:
    """Return the walk that a scenario wants, None if it stands.

    Raises: `ScenarioError` for what cannot be walked, with the step and the reason.
    """
    spec = scenario.walk
    if spec is None:
        return None
    carrier = setup.carrier if _carries(scenario) else None
    try:
        return make_walk(spec, setup.robot, setup.soles, carrier)
    except ScenarioError:
        raise
    except InputError as error:
        raise at_path(error, "walk") from None


def make_walk(
    spec: schema.WalkSpec, robot: Robot, standing: ContactStack, carrier: LedPose | None = None
) -> WalkSetup:
    """Return a walk of a robot that stands on these contacts, its trunk upright.

    Raises: `InputError` for what cannot be walked, with the step and the reason.
    """
    feet = Feet.of(robot)
    contacts = {c.sole.name: c for c in standing.contacts if isinstance(c, SoleContact)}
    for sole in feet.soles:
        if sole.name not in contacts:
            raise ScenarioError(
                f"the sole {sole.name!r} is no contact, and both feet have to stand",
                path="contacts",
                given=[one.name for one in standing.contacts],
                remedy="Add a contact of kind sole for each foot",
            )
    left, right = (contacts[name] for name in feet.names)
    stance = (left.T_world_anchor, right.T_world_anchor)
    kin, turned = robot.at(robot.q_half_sitting), feet.middle(stance).rotation
    flat = 0.5 * sum(float(kin.placement(sole.frame).translation[2]) for sole in feet.soles)
    leg = leg_lever(robot, feet) if spec.legs == "nominal" else 0.0
    settings = walk_settings(spec, float(kin.p_world_com[2]) - flat - spec.crouch, leg)
    planner = WalkPlanner(feet, settings)
    plan = planner.begin(stance, footsteps(spec, feet, stance))
    if spec.steer is not None:  # it has come to rest before, and may begin at once
        plan = planner.begin(stance, [], -plan.end)
    require_feasible(plan, feet, settings, WalkLimits(margin=spec.margin))
    up = np.array([0.0, 0.0, settings.height])
    centre = pin.SE3(np.eye(3), planner.feet.middle(stance).translation + up)
    upright = {
        frame: LedPose(pin.SE3(turned, np.zeros(3)) * kin.placement(frame))
        for frame in _trunk(robot)
    }
    targets = WalkTargets(
        (LedPose(stance[LEFT]), LedPose(stance[RIGHT])), LedPose(centre), upright, carrier
    )
    return WalkSetup(spec, planner, plan, targets, (left.name, right.name), robot.mass * GRAVITY)


def walk_settings(spec: schema.WalkSpec, height: float, leg: float = 0.0) -> WalkSettings:
    """Return what a walk is planned with.

    `height` [m] of the centre of mass over the ground, `leg` [s^2] the lever of a swinging leg.
    """
    return WalkSettings(
        height,
        WalkMode.SLOW if spec.mode == "slow" else WalkMode.PENDULUM,
        WalkTiming(**spec.timing.model_dump()),
        SwingShape(**spec.swing.model_dump()),
        spec.inward,
        leg,
    )


def footsteps(spec: schema.WalkSpec, feet: Feet, stance: Stance) -> list[Footstep]:
    """Return the footsteps that the section asks for, from a stance. Raises: `InputError`."""
    if spec.along is not None:
        along = spec.along
        stride = Stride(along.forward, along.left, along.turn, along.up)
        first = None if along.first is None else FEET[along.first]
        return steps_along(feet, stance, stride, along.count, first)
    if spec.to is not None:
        limits = StrideLimits(spec.to.forward, spec.to.side, spec.to.turn)
        return steps_to(feet, stance, spec.to.goal, limits)
    return [
        Footstep(FEET[one.foot], level_pose(*to_vector(one.xyz), one.yaw))
        for one in spec.steps or ()
    ]


def _carries(scenario: schema.Scenario) -> bool:
    """Return whether anything goes along with the walk."""
    frames = (spec for spec in scenario.tasks.values() if isinstance(spec, schema.AlongSpec))
    return any(one.carried for one in (*scenario.world.objects.values(), *frames))


def _trunk(robot: Robot) -> list[str]:
    """Return the frames that stay upright; the base where the robot names no such part."""
    named = [robot.parts[part][-1] for part in TRUNK if part in robot.parts]
    frames = [one for one in dict.fromkeys(named) if one in robot.frame_names]
    if frames:
        return frames
    base = next(
        f for f in robot.model.frames if f.type == pin.FrameType.BODY and f.parentJoint == 1
    )
    return [base.name]
