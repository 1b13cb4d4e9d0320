"""The environment: a robot in an engine, its controller, and an agent that says what to want."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
import pinocchio as pin

from equipoise.contacts import Contact
from equipoise.control import Mode
from equipoise.errors import InputError
from equipoise.gym.episode import Episode
from equipoise.physics import PhysicsEngine, PhysicsState, RigidContactEngine
from equipoise.robots import Robot, get_robot
from equipoise.spatial import Array
from equipoise.spatial.numbers import real_vector
from equipoise.tasks import FramePoseTask
from equipoise.wbc import LoopSettings, WholeBodyCommand, WholeBodyController

SPEED = 2.0  # of a joint's limit: where observed speeds end
FAR = 4.0  # of the way: where observed positions end
OVER = 5.0  # of the force: where observed forces end


class WholeBodyEnv(gymnasium.Env[Array, Array]):
    """An agent sets where hands should be and how hard contacts should be pressed.

    `robot` by name or as an object; `hands` are frames, a task each that share a level; `contacts`
    hold beside the feet, and each of their regulated rows is wanted by the agent. A robot whose
    base is fixed has no feet.

    Action, in [-1, 1]: of each hand position (3,) and rotation vector (3,) of its target relative
    to where it begins, world axes, times `way` and `turn` of the `episode`; of each regulated row
    half of (a + 1) times `force`. Observation: joints [rad or m], their speeds; of each hand
    position [m] and rotation vector [rad] relative to where it begins; the goal of the first
    hand (3,) [m] in the same way; pressed and wanted forces [N]. Values beyond the bounds of the
    space are cut.

    `reset` draws a goal for the first hand and wanted forces. `reward` is minus the distance to the
    goal by `way`, minus the errors of the forces by `force`; override it for another. An episode
    ends if the supervisor switches the law off, and is cut after `steps`.
    Raises: `InputError`, `NameNotFoundError`.
    """

    metadata = {"render_modes": []}  # noqa: RUF012  as Gymnasium has it

    def __init__(
        self,
        robot: Robot | str = "hrp2",
        hands: Sequence[str] = ("right_palm",),
        *,
        contacts: Sequence[Contact] = (),
        episode: Episode | None = None,
        loop: LoopSettings | None = None,
        render_mode: None = None,
    ) -> None:
        if isinstance(hands, str) or not hands:
            raise InputError("hands are one frame or more", given=hands, remedy='("right_palm",)')
        self.robot = get_robot(robot) if isinstance(robot, str) else robot
        self.episode, self.render_mode = episode or Episode(), render_mode
        kin = self.robot.at(self.robot.q_half_sitting)
        self.begins = [kin.placement(hand).copy() for hand in hands]
        self.hands = [
            FramePoseTask(hand, hand, T) for hand, T in zip(hands, self.begins, strict=True)
        ]
        rigid = self.episode.engine == "rigid"
        loop = loop or LoopSettings(delay=0.0 if rigid or not self.robot.nv_base else 0.003)
        door = WholeBodyController.standing if self.robot.nv_base else WholeBodyController.fixed
        self.controller = door(
            self.robot, tasks=[self.hands], contacts=contacts, loop=loop,
            forces={c.name: [0.0] * len(c.regulated) for c in contacts if c.regulated},
        )  # fmt: skip
        self._fresh = self.controller.state()
        self._rows = self.controller.contacts.regulated_rows
        self.action_space = gymnasium.spaces.Box(
            -1.0, 1.0, (6 * len(self.hands) + len(self._rows),), np.float64
        )
        self._bound = self._bounds()
        self.observation_space = gymnasium.spaces.Box(*self._bound, dtype=np.float64)
        self.goal, self.wanted = np.zeros(3), np.zeros(len(self._rows))
        self._engine = self._new_engine()
        self._state, self._ticks = self._engine.state, 0

    def _bounds(self) -> tuple[Array, Array]:
        """Return the least and the greatest of every observed number."""
        robot, episode, rows = self.robot, self.episode, len(self._rows)
        slack = 0.1 * (robot.q_max - robot.q_min)
        hand = np.array([FAR * episode.way] * 3 + [2.0 * np.pi] * 3)
        ends = np.concatenate(
            (np.tile(hand, len(self.hands)), [episode.way] * 3, [OVER * episode.force] * 2 * rows)
        )
        low = np.concatenate((robot.q_min - slack, -SPEED * robot.v_max, -ends))
        return low, np.concatenate((robot.q_max + slack, SPEED * robot.v_max, ends))

    def _new_engine(self) -> PhysicsEngine:
        """Return an engine in which the robot stands, and let the controller begin with that."""
        given = (
            self.robot, self.controller.contacts, self.robot.q_half_sitting, self.controller.dt
        )  # fmt: skip
        engine: PhysicsEngine
        if self.episode.engine == "mujoco":
            from equipoise.physics.mujoco import MujocoEngine

            engine = MujocoEngine(*given)
        else:
            engine = RigidContactEngine(*given)
        self.controller.take_over(engine.stand())
        return engine

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Begin anew, at rest at half-sitting, with a goal that the seed draws.

        `options` may give the `goal` (3,) [m] of the first hand, relative to where it begins.
        """
        super().reset(seed=seed)
        self.controller.restore(self._fresh)
        self._engine, self._ticks = self._new_engine(), 0
        self._state = self._engine.state
        self.goal = self.np_random.uniform(-1.0, 1.0, 3) * self.episode.way
        self.wanted = self.np_random.uniform(0.2, 1.0, len(self._rows)) * self.episode.force
        if options and "goal" in options:
            self.goal = real_vector("the goal", options["goal"], 3)
        return self._observe(), self._info("")

    def step(self, action: Array) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Want what the action says for the ticks of a step; see the class for the numbers."""
        action = np.clip(
            real_vector("action", action, 6 * len(self.hands) + len(self._rows)), -1.0, 1.0
        )
        self._want(action)
        command = self._run()
        off = command.mode in (Mode.SAFE, Mode.STOPPED)
        cut = self._ticks >= self.episode.steps * self.episode.ticks
        return self._observe(), self.reward(self._state), off, cut, self._info(str(command.status))

    def _want(self, action: Array) -> None:
        episode = self.episode
        for k, (hand, begin) in enumerate(zip(self.hands, self.begins, strict=True)):
            a = action[6 * k : 6 * k + 6]
            R = pin.exp3(episode.turn * a[3:]) @ begin.rotation
            hand.target = pin.SE3(R, begin.translation + episode.way * a[:3])
        shares = 0.5 * (action[6 * len(self.hands) :] + 1.0)
        for row, share in zip(self.controller.rows, shares, strict=True):
            self.controller.want(row, episode.force * float(share))

    def _run(self) -> WholeBodyCommand:
        """Run the ticks of a step, or until the law is switched off; return the last command."""
        for _ in range(self.episode.ticks):
            q, v, lam = self._state.q, self._state.v, self._state.lam
            command = self.controller.step(self._ticks * self.controller.dt, q, v, lam)
            self._state = self._engine.step(command.tau)
            self._ticks += 1
            if command.mode in (Mode.SAFE, Mode.STOPPED):
                break
        return command

    def reward(self, state: PhysicsState) -> float:
        """Return how good a state is: minus the shares by which goal and forces are missed."""
        missed = float(np.linalg.norm(self._hand_at(state)[:3] - self.goal)) / self.episode.way
        pressed = np.abs(state.lam[self._rows] - self.wanted).sum() / self.episode.force
        return -missed - float(pressed)

    def _hand_at(self, state: PhysicsState) -> Array:
        """Return positions and rotation vectors (6 hands,) relative to where the hands begin."""
        kin, seen = self.robot.at(state.q), []
        for hand, begin in zip(self.hands, self.begins, strict=True):
            T = kin.placement(hand.name)
            turned = pin.log3(T.rotation @ begin.rotation.T)
            seen.append(np.concatenate((T.translation - begin.translation, turned)))
        return np.concatenate(seen)

    def _observe(self) -> Array:
        robot, state = self.robot, self._state
        seen = (
            state.q[robot.nq_base :], state.v[robot.nv_base :], self._hand_at(state), self.goal,
            state.lam[self._rows], self.wanted,
        )  # fmt: skip
        return np.clip(np.concatenate(seen), *self._bound)

    def _info(self, status: str) -> dict[str, Any]:
        missed = float(np.linalg.norm(self._hand_at(self._state)[:3] - self.goal))
        return {"t": self._state.t, "distance": missed, "status": status}
