"""How far an arm reaches: from its shoulder to the point about which its hand turns."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from equipoise.kinematics.followers import axes_of
from equipoise.robots.robot import Robot

LEAST_JOINTS = 3  # of an arm
BEFORE_WRIST, WRIST = 4, 3  # joints of shoulder and elbow; at most as many of a wrist
SWEEPS = 12  # over the joints of the arm, in search of its greatest length
TURNS = 24  # postures of the wrist that are looked at
ORIGIN_COUNTS = 1e-3  # weight of a wrist's origin beside its axes, where these leave a point open


@dataclass(frozen=True)
class ArmSpan:
    """An arm that carries a frame: its `joints` by their number among
    those of the robot, its `shoulder`, a joint of the model, its wrist (3,) [m] in the frame.

    `p_world_shoulder` (3,) [m] is where the shoulder is at the start. The wrist is the point of the
    frame that moves least as the hand turns. At most it is `longest` [m] from the shoulder, and at
    least `surely`, however the hand is turned: where the axes of the wrist meet these are the same.
    Limits of joints are those of the elbow, not of the wrist.
    """

    joints: tuple[int, ...]
    shoulder: int
    p_world_shoulder: np.ndarray
    p_frame_wrist: np.ndarray
    longest: float
    surely: float


def arm_span(robot: Robot, frame: str | int, q: np.ndarray) -> ArmSpan | None:
    """Return the span of the arm that carries a frame, None if no arm does.

    An arm is what carries the frame and no other palm, and no sole, of at least three joints that
    turn; its shoulder is the second of them. `q` (nq,) is where the search begins.
    """
    arm = _arm_of(robot, robot.frame_id(frame))
    if len(arm) < LEAST_JOINTS:
        return None
    model, placements, frame_id = robot.model, robot.model.createData(), robot.frame_id(frame)
    shoulder, wrist = arm[1], arm[max(len(arm) - WRIST, BEFORE_WRIST) :]

    pin.framesForwardKinematics(model, placements, q)
    axes, p_shoulder = axes_of(model)[:, 3:], placements.oMi[shoulder].translation.copy()
    p_wrist = _meeting_point(placements, axes, wrist, placements.oMf[frame_id])

    def reached(q: np.ndarray) -> np.ndarray:
        """Return where the wrist is as seen from the shoulder (3,), in world axes."""
        pin.framesForwardKinematics(model, placements, q)
        found: np.ndarray = placements.oMf[frame_id].act(p_wrist)
        return found - placements.oMi[shoulder].translation

    joints = tuple(model.joints[joint].idx_v - robot.nv_base for joint in arm)
    q = _stretched(robot, q, arm[1:], reached)
    turned = [float(np.linalg.norm(reached(one))) for one in _wrist_turned(robot, q, wrist)]
    return ArmSpan(
        joints, shoulder, p_shoulder, p_wrist, float(np.linalg.norm(reached(q))), min(turned)
    )


def _arm_of(robot: Robot, frame_id: int) -> list[int]:
    """Return the joints that carry a frame and nothing else that touches the world."""
    model = robot.model
    others = [palm.frame for palm in robot.palms] + [sole.frame for sole in robot.soles]
    chain = list(model.supports[model.frames[frame_id].parentJoint])[1:]
    for other in others:
        if robot.frame_id(other) == frame_id:
            continue
        carrier = model.frames[robot.frame_id(other)].parentJoint
        if carrier == model.frames[frame_id].parentJoint:
            continue  # another frame of the same hand
        taken = set(model.supports[carrier])
        chain = [joint for joint in chain if joint not in taken]
    turning = np.abs(axes_of(model)[:, 3:]).max(axis=1) > 0.0
    return [joint for joint in chain if turning[joint] and model.joints[joint].nq == 1]


def _meeting_point(
    placements: pin.Data, axes: np.ndarray, wrist: list[int], T: pin.SE3
) -> np.ndarray:
    """Return the point (3,) of a frame that is nearest to the axes of the wrist's joints."""
    if not wrist:
        return np.zeros(3)
    H, g = np.zeros((3, 3)), np.zeros(3)
    for joint in wrist:
        M = placements.oMi[joint]
        o, a = M.translation, M.rotation @ axes[joint]
        across = np.eye(3) - np.outer(a, a) + ORIGIN_COUNTS * np.eye(3)
        H += across
        g += across @ o
    found: np.ndarray = T.actInv(np.linalg.solve(H, g))
    return found


def _stretched(
    robot: Robot, q: np.ndarray, joints: list[int], reached: Callable[[np.ndarray], np.ndarray]
) -> np.ndarray:
    """Return `q` (nq,) with the joints turned so that what is reached is as far as it can be.

    Along one joint the square of the distance is `a + b cos + c sin` of its angle.
    """
    q, model = q.copy(), robot.model

    def square(at: int, angle: float) -> float:
        q[at] = angle
        p = reached(q)
        return float(p @ p)

    for _ in range(SWEEPS):
        for joint in joints:
            at, begin = model.joints[joint].idx_q, q[model.joints[joint].idx_q]
            low, high = model.lowerPositionLimit[at], model.upperPositionLimit[at]
            ahead, left, behind = (square(at, turn) for turn in (0.0, np.pi / 2, np.pi))
            middle = (ahead + behind) / 2
            best = float(np.arctan2(left - middle, ahead - middle))
            angles = [begin, low, high, *(best + turn for turn in (-2 * np.pi, 0.0, 2 * np.pi))]
            within = [one for one in angles if low <= one <= high]
            far = [square(at, one) for one in within]
            q[at] = within[int(np.argmax(far))] if within else begin
    return q


def _wrist_turned(robot: Robot, q: np.ndarray, wrist: list[int]) -> Iterator[np.ndarray]:
    """Yield `q` (nq,), and with the joints of the wrist turned by chance, always the same."""
    rng, model = np.random.default_rng(0), robot.model
    yield q
    places = [model.joints[joint].idx_q for joint in wrist]
    for _ in range(TURNS if places else 0):
        turned = q.copy()
        low, high = model.lowerPositionLimit[places], model.upperPositionLimit[places]
        turned[places] = rng.uniform(np.maximum(low, -np.pi), np.minimum(high, np.pi))
        yield turned
