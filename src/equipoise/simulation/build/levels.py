"""From a scenario to levels of tasks: one builder a kind of task."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin

from equipoise.contacts import SupportPolygon
from equipoise.errors import AdviceWarning, InputError, NameNotFoundError, ScenarioError
from equipoise.motion import advise_accelerations
from equipoise.motion.levels import ground_of
from equipoise.motion.reaching import calm_reach
from equipoise.scenarios import schema
from equipoise.scenarios.lookup import at_path, frame_of, to_pose
from equipoise.simulation.build.fades import build_fades, contact_tasks
from equipoise.simulation.build.setup import (
    Setup,
    carried_by,
    check_handle,
    check_target,
    to_waypoints,
)
from equipoise.simulation.build.walk import WalkSetup
from equipoise.spatial import pose
from equipoise.tasks import (
    AvoidanceTask,
    ComPolygonTask,
    ComTask,
    ContactTask,
    DampingTask,
    FloorSupportTask,
    FrameAxesTask,
    FramePoseTask,
    GazeTask,
    JointAccelerationsTask,
    JointCouplingTask,
    JointLimitsTask,
    KeepInTask,
    KeepOutTask,
    ManipulabilityTask,
    MomentumTask,
    PostureTask,
    Reach,
    RelativeFrameTask,
    Task,
)
from equipoise.trajectories import (
    AttachedTrajectory,
    FixedPose,
    MotionLimits,
    PoseTrajectory,
    SlowedLeg,
    TravelTrajectory,
    Waypoint,
    WaypointTrajectory,
    slow_down,
)

APPROACH_TIME = 2.0  # [s] length of the way from half-sitting to the posture of time 0


def build_levels(
    scenario: schema.Scenario, setup: Setup, walk: WalkSetup | None = None
) -> list[list[Task]]:
    """Return the levels of the run: contacts at level 0, then tasks by priority.

    Where the robot walks, level 0 has the tasks of its feet in place of their contacts.
    """
    tasks = {
        name: _eased(build_task(name, spec, scenario, setup), spec)
        for name, spec in _enabled(scenario)
    }
    contacts = contact_tasks(scenario, setup, supports=walk is None)
    if walk is None:
        return _by_priority(scenario, contacts, tasks)
    first = [*walk.feet_tasks(), *contacts]
    return _by_priority(scenario, first, tasks, _of_walk(walk, walk.com_task()))


def _of_walk(walk: WalkSetup, com: Task) -> list[tuple[int, Task]]:
    """Return the tasks of a walk with their priorities."""
    trunk = [(walk.spec.trunk_priority, task) for task in walk.trunk_tasks()]
    return [(walk.spec.priority, com), *trunk]


def build_start_levels(
    scenario: schema.Scenario,
    setup: Setup,
    walk: WalkSetup | None = None,
    *,
    with_avoidance: bool,
) -> list[list[Task]]:
    """Return the levels that lead from half-sitting (t = -APPROACH_TIME) to the start (t = 0).

    At first only the soles are in contact, and hands are led to their first target on a smooth
    way; that way may cross an obstacle, which would hold the hands up for ever, so it is followed
    without avoidance. With it (and the contacts of time 0) the posture then only has to settle.
    Tasks that come later are left out.
    """
    tasks: dict[str, Task] = {}
    fades = build_fades(scenario)
    for name, spec in _enabled(scenario):
        if isinstance(spec, schema.AvoidanceSpec) and not with_avoidance:
            continue
        if isinstance(spec, schema.JointAccelerationsSpec | schema.FloorSupportSpec):
            continue  # how fast, not where
        if name in fades and fades[name].weight(0.0) == 0.0:
            continue
        if isinstance(spec, schema.HandOnObjectSpec | schema.FramePathSpec):
            followed = build_task(name, spec, scenario, setup)
            assert isinstance(followed, FramePoseTask)
            tasks[name] = _approach(followed, setup)
        else:
            tasks[name] = build_task(name, spec, scenario, setup)
    held = setup.reference_schedule.at(0.0) if with_avoidance else setup.soles
    contacts = ContactTask("contacts", held, rate=scenario.control.contact_rate)
    more = []
    if walk is not None:
        more = _of_walk(walk, walk.com_approach(setup.robot, APPROACH_TIME))
    return _by_priority(scenario, [contacts], tasks, more)


def _enabled(scenario: schema.Scenario) -> list[tuple[str, Any]]:
    return [(name, spec) for name, spec in scenario.tasks.items() if spec.enabled]


def _by_priority(
    scenario: schema.Scenario,
    contacts: list[Task],
    tasks: dict[str, Task],
    more: Sequence[tuple[int, Task]] = (),
) -> list[list[Task]]:
    placed = [*more, *((scenario.tasks[name].priority, task) for name, task in tasks.items())]
    levels: list[list[Task]] = [contacts]
    for priority in sorted({priority for priority, _ in placed}):
        levels.append([task for own, task in placed if own == priority])
    return levels


def build_task(name: str, spec: Any, scenario: schema.Scenario, setup: Setup) -> Task:
    """Return the task of a section."""
    return _BUILDERS[type(spec)](name, spec, scenario, setup).weighing(spec.weight)


def _eased(task: Task, spec: schema.TaskBase) -> Task:
    """Return a task of a run with its ease; on the way to the start nobody needs one."""
    if spec.ease is None:
        return task
    try:
        return task.easing(spec.ease)
    except InputError as error:
        raise at_path(error, f"tasks.{task.name}.ease") from None


def _hold_frame(
    name: str, spec: schema.HoldFrameSpec, scenario: schema.Scenario, setup: Setup
) -> Task:
    frame = frame_of(setup.robot, spec.frame, f"tasks.{name}.frame")
    return FramePoseTask(name, frame, FixedPose(_at_half_sitting(setup, frame)), rate=spec.rate)


def _hand_on_object(
    name: str, spec: schema.HandOnObjectSpec, scenario: schema.Scenario, setup: Setup
) -> Task:
    check_handle(scenario, spec.object, spec.hand, f"tasks.{name}.hand")
    target = setup.hand_trajectory(spec.hand, spec.object)
    return FramePoseTask(name, spec.hand, target, rate=spec.rate)


def _frame_path(
    name: str, spec: schema.FramePathSpec, scenario: schema.Scenario, setup: Setup
) -> Task:
    frame = frame_of(setup.robot, spec.frame, f"tasks.{name}.frame")
    path = _along(name, spec, WaypointTrajectory(slowed_way(spec)[0]), setup)
    return FramePoseTask(
        name,
        frame,
        path,
        rate=spec.rate,
        reach=_reach(scenario, setup, spec),
    )


def _along(name: str, spec: schema.AlongSpec, path: PoseTrajectory, setup: Setup) -> PoseTrajectory:
    """Return a path that goes along with the slider or the walk that the task names."""
    if spec.travel_of is not None:
        check_target(setup, spec.travel_of, f"tasks.{name}.travel_of")
        target = setup.targets[spec.travel_of]
        if isinstance(target, TravelTrajectory):
            path = replace(target, body=path)
    if spec.carried:
        path = carried_by(setup.carrier, path, f"tasks.{name}.carried")
    return path


def _reach(scenario: schema.Scenario, setup: Setup, spec: schema.FramePathSpec) -> Reach | None:
    """Return how the frame goes for targets that it is behind, None where nobody asks."""
    if not spec.calm and spec.pull is None and spec.pull_turn is None and spec.damping is None:
        return None
    bounds = {"pull": spec.pull, "pull_turn": spec.pull_turn, "damping": spec.damping}
    given = {name: value for name, value in bounds.items() if value is not None}
    return calm_reach(setup.robot, scenario.control.period, calm=bool(spec.calm), **given)


def slowed_way(spec: schema.FramePathSpec) -> tuple[tuple[Waypoint, ...], tuple[SlowedLeg, ...]]:
    """Return the waypoints of a frame at times that keep its limits, and the legs that take longer.

    Raises: `InputError`.
    """
    given = {
        name: value
        for name in ("speed", "acceleration", "turn", "turn_acceleration")
        if (value := getattr(spec, name)) is not None
    }
    return slow_down(to_waypoints(spec.waypoints).waypoints, MotionLimits(**given))


def tell_slowed(scenario: schema.Scenario) -> tuple[str, ...]:
    """Return in sentences which ways take longer than they were written.

    Warns of those whose file bounds them; of a way that is calm the run itself tells.
    """
    told = []
    for _, spec in _enabled(scenario):
        if not isinstance(spec, schema.FramePathSpec):
            continue
        way, slowed = slowed_way(spec)
        sentences = [leg.sentence(spec.frame) for leg in slowed]
        if slowed and way[-1].t > scenario.duration:
            sentences.append(
                f"the run ends at {scenario.duration:g} s, the way of {spec.frame} only at "
                f"{way[-1].t:.3g} s"
            )
        for sentence in () if spec.calm else sentences:
            warnings.warn(sentence, AdviceWarning, stacklevel=2)
        told += sentences
    return tuple(told)


def _approach(task: FramePoseTask, setup: Setup) -> Task:
    """Return the task that leads the same frame from half-sitting to its target of time 0."""
    first = task.target.at(0.0).T_world_target
    here = _at_half_sitting(setup, task.frame)
    path = WaypointTrajectory([Waypoint(-APPROACH_TIME, here), Waypoint(0.0, first)])
    approach = FramePoseTask(task.name, task.frame, path, rate=task.rate)
    return approach.weighing(task.weight)


def _com_polygon(
    name: str, spec: schema.ComPolygonSpec, scenario: schema.Scenario, setup: Setup
) -> Task:
    return ComPolygonTask(
        name, _polygon(name, setup), margin=spec.margin, rate=spec.rate,
        leans=spec.leans, height=ground_of(setup.soles.contacts),
    )  # fmt: skip


def _polygon(name: str, setup: Setup) -> SupportPolygon:
    """Return the support polygon. Raises: `ScenarioError` for a base that nothing carries."""
    if setup.polygon is None:
        raise ScenarioError(
            f"the base of {setup.robot.name} is fixed: there is no support polygon",
            path=f"tasks.{name}",
            remedy="Leave the task out",
        )
    return setup.polygon


def _joint_accelerations(
    name: str, spec: schema.JointAccelerationsSpec, scenario: schema.Scenario, setup: Setup
) -> Task:
    robot = setup.robot
    fastest = np.inf if spec.speed is None else spec.speed
    advice = advise_accelerations(
        robot, robot.q_half_sitting, share=spec.share, rise=spec.rise, speed=fastest
    )
    return JointAccelerationsTask(
        name,
        robot,
        advice.bound,
        scenario.control.period,
        margin=spec.margin,
        velocity_share=spec.velocity_share,
        rate=spec.rate,
    )


def _floor_support(
    name: str, spec: schema.FloorSupportSpec, scenario: schema.Scenario, setup: Setup
) -> Task:
    return FloorSupportTask(
        name,
        setup.robot,
        _polygon(name, setup),
        scenario.control.period,
        height=ground_of(setup.soles.contacts),
        margin=spec.margin,
        least=spec.least,
        leans=spec.leans,
    )


def _joint_limits(
    name: str, spec: schema.JointLimitsSpec, scenario: schema.Scenario, setup: Setup
) -> Task:
    for joint in spec.speeds:
        _check_joint(setup, joint, f"tasks.{name}.speeds.{joint}")
    for i, joint in enumerate(spec.frozen):
        _check_joint(setup, joint, f"tasks.{name}.frozen.{i}")
    return JointLimitsTask(
        name,
        setup.robot,
        margin=spec.margin,
        velocity_share=spec.velocity_share,
        rate=spec.rate,
        speeds=spec.speeds,
        frozen=spec.frozen,
    )


def _gaze(name: str, spec: schema.GazeSpec, scenario: schema.Scenario, setup: Setup) -> Task:
    check_target(setup, spec.object, f"tasks.{name}.object")
    if setup.robot.camera is None:
        raise ScenarioError(
            "the robot has no camera frame",
            path=f"tasks.{name}",
            remedy="Name one in the robot's YAML, or disable the task",
        )
    target = AttachedTrajectory(setup.targets[spec.object], pose(spec.offset))
    return GazeTask(name, setup.robot.camera, target, rate=spec.rate)


def _avoidance(
    name: str, spec: schema.AvoidanceSpec, scenario: schema.Scenario, setup: Setup
) -> Task:
    pairs = []
    for i, (first, second) in enumerate(spec.pairs):
        try:
            pairs.append(setup.scene.pair(first, second))
        except InputError as error:
            raise at_path(error, f"tasks.{name}.pairs.{i}") from None
    return AvoidanceTask(
        name,
        setup.scene,
        pairs,
        influence=spec.influence,
        security=spec.security,
        damping=spec.damping,
    )


def _posture(name: str, spec: schema.PostureSpec, scenario: schema.Scenario, setup: Setup) -> Task:
    robot = setup.robot
    q_joints = robot.q_half_sitting[robot.nq_base :].copy()
    for joint, value in spec.joints.items():
        try:
            q_joints[robot.joint_index(joint)] = value
        except NameNotFoundError as error:
            raise at_path(error, f"tasks.{name}.joints.{joint}") from None
    return PostureTask(name, robot, q_joints, rate=spec.rate)


def _check_joint(setup: Setup, joint: str, path: str) -> None:
    try:
        setup.robot.joint_index(joint)
    except NameNotFoundError as error:
        raise at_path(error, path) from None


def _frame_axes(
    name: str, spec: schema.FrameAxesSpec, scenario: schema.Scenario, setup: Setup
) -> Task:
    frame = frame_of(setup.robot, spec.frame, f"tasks.{name}.frame")
    path = _along(name, spec, to_waypoints(spec.waypoints), setup)
    return FrameAxesTask(name, frame, path, axes=spec.axes, offset=spec.offset, rate=spec.rate)


def _relative_frame(
    name: str, spec: schema.RelativeFrameSpec, scenario: schema.Scenario, setup: Setup
) -> Task:
    frame = frame_of(setup.robot, spec.frame, f"tasks.{name}.frame")
    other = frame_of(setup.robot, spec.relative_to, f"tasks.{name}.relative_to")
    if frame == other:
        raise ScenarioError(
            "a frame does not move relative to itself",
            path=f"tasks.{name}.relative_to",
            given=other,
            remedy="Name another frame",
        )
    path = to_waypoints(spec.waypoints)
    return RelativeFrameTask(name, frame, other, path, axes=spec.axes, rate=spec.rate)


def _com_point(
    name: str, spec: schema.ComPointSpec, scenario: schema.Scenario, setup: Setup
) -> Task:
    return ComTask(name, to_waypoints(spec.waypoints), axes=spec.axes, rate=spec.rate)


def _joint_coupling(
    name: str, spec: schema.JointCouplingSpec, scenario: schema.Scenario, setup: Setup
) -> Task:
    for joint in spec.joints:
        _check_joint(setup, joint, f"tasks.{name}.joints.{joint}")
    return JointCouplingTask(name, setup.robot, [spec.joints], values=[spec.value], rate=spec.rate)


def _damping(name: str, spec: schema.DampingSpec, scenario: schema.Scenario, setup: Setup) -> Task:
    return DampingTask(name, setup.robot)


def _momentum(
    name: str, spec: schema.MomentumSpec, scenario: schema.Scenario, setup: Setup
) -> Task:
    return MomentumTask(name, setup.robot, axes=spec.axes, value=spec.value)


def _manipulability(
    name: str, spec: schema.ManipulabilitySpec, scenario: schema.Scenario, setup: Setup
) -> Task:
    frame = frame_of(setup.robot, spec.frame, f"tasks.{name}.frame")
    how: dict[str, Any] = {"part": spec.part, "rate": spec.rate}
    return ManipulabilityTask(name, setup.robot, frame, spec.least, **how)


def _keep_in(name: str, spec: schema.KeepInSpec, scenario: schema.Scenario, setup: Setup) -> Task:
    frame = frame_of(setup.robot, spec.frame, f"tasks.{name}.frame")
    return KeepInTask(name, frame, to_pose(spec.at), spec.size, offset=spec.offset, rate=spec.rate)


def _keep_out(name: str, spec: schema.KeepOutSpec, scenario: schema.Scenario, setup: Setup) -> Task:
    frame = frame_of(setup.robot, spec.frame, f"tasks.{name}.frame")
    return KeepOutTask(name, frame, spec.at.xyz, spec.radius, offset=spec.offset, rate=spec.rate)


_BUILDERS: dict[type, Callable[..., Task]] = {
    schema.HoldFrameSpec: _hold_frame,
    schema.FramePathSpec: _frame_path,
    schema.HandOnObjectSpec: _hand_on_object,
    schema.ComPolygonSpec: _com_polygon,
    schema.JointLimitsSpec: _joint_limits,
    schema.JointAccelerationsSpec: _joint_accelerations,
    schema.FloorSupportSpec: _floor_support,
    schema.GazeSpec: _gaze,
    schema.AvoidanceSpec: _avoidance,
    schema.PostureSpec: _posture,
    schema.FrameAxesSpec: _frame_axes,
    schema.RelativeFrameSpec: _relative_frame,
    schema.ComPointSpec: _com_point,
    schema.JointCouplingSpec: _joint_coupling,
    schema.DampingSpec: _damping,
    schema.MomentumSpec: _momentum,
    schema.ManipulabilitySpec: _manipulability,
    schema.KeepInSpec: _keep_in,
    schema.KeepOutSpec: _keep_out,
}


def _at_half_sitting(setup: Setup, frame: str | int) -> pin.SE3:
    return setup.robot.at(setup.robot.q_half_sitting).placement(frame)
