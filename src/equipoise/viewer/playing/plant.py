"""The robot that is simulated under a session: pushed, loaded, on a floor that may get slippery."""

from __future__ import annotations

from dataclasses import replace
from importlib.util import find_spec
from typing import Literal, Protocol

import numpy as np
import pinocchio as pin

from equipoise.contacts import ContactStack
from equipoise.errors import InputError
from equipoise.kinematics import KinematicsEvaluator
from equipoise.physics import PhysicsState, RigidContactEngine, UnilateralContactEngine
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.spatial.numbers import positive, real_vector

Physics = Literal["rigid", "mujoco"]
ENGINES: tuple[Physics, ...] = ("rigid", "mujoco")
PUSH_TIME = 0.2  # [s]
ROTORS = 0.05  # [kg m^2] of every joint behind its gear


def usual_physics() -> Physics:
    """Return the engine mujoco where it is installed: there feet can slip."""
    return "mujoco" if find_spec("mujoco") is not None else "rigid"


class PlayEngine(Protocol):
    """What a session asks of an engine."""

    external: Array

    @property
    def state(self) -> PhysicsState:
        """The present state."""

    def step(self, tau: Array) -> PhysicsState:
        """Advance by one control period."""

    def stand(self) -> Array:
        """Return the torque (na,) [N m] under which it stands."""

    def support(self, name: str, T_world_anchor: pin.SE3 | None) -> None:
        """Read the wrench of a foot in the axes of another place."""

    def weigh(self, robot: Robot) -> None:
        """Let everything weigh what it weighs in this robot from now on."""


class PlayPlant:
    """A robot at rest at `q` (nq,) in an engine, which other people do things to.

    Raises: InputError for an engine that is not known, or not installed.
    """

    def __init__(
        self, robot: Robot, contacts: ContactStack, q: Array, dt: float, physics: Physics
    ) -> None:
        if physics == "rigid":
            robot = _with_rotors(robot)
        self.robot, self.physics, self._contacts = robot, physics, contacts
        self.engine = _engine(robot, contacts, q, dt, physics)
        self.loads: dict[str, float] = {}  # [kg] by frame
        self.state = self.engine.state
        self._evaluator = KinematicsEvaluator(robot)
        self._push, self._pushed, self._push_end = np.zeros(3), "", -np.inf

    def push(self, frame: str, force: Array, seconds: float = PUSH_TIME) -> None:
        """Push a frame with a force (3,) [N], world axes, for some time. Raises: InputError."""
        force = real_vector("a push", force, 3)
        self.robot.frame_id(frame)
        self._pushed, self._push = frame, force
        self._push_end = self.state.t + positive("the time of a push", seconds, "s")

    @property
    def pushing(self) -> tuple[str, Array] | None:
        """Where it is pushed now, and the force (3,) [N]; None where it is not."""
        if self.state.t >= self._push_end:
            return None
        return self._pushed, self._push

    def carry(self, frame: str, mass: float) -> None:
        """Let a frame carry a mass [kg] in place of what it carried; nobody tells the law.

        Raises: NameNotFoundError, InputError.
        """
        loads = {**self.loads, frame: mass}
        loaded = self.robot
        for name, load in loads.items():
            loaded = loaded.with_payload(name, load)
        self.engine.weigh(loaded)
        self.loads = loads

    @property
    def slips(self) -> bool:
        """Whether its feet can slip."""
        return self.physics == "mujoco" and bool(self._contacts.supporting_rows.size)

    def set_friction(self, friction: float) -> None:
        """Let the floor have another friction. Raises: InputError where feet never slip."""
        positive("the friction of the floor", friction)
        change = getattr(self.engine, "set_sole_friction", None)
        if not self.slips or change is None:
            raise InputError(
                "feet do not slip in the engine rigid: its floor has no friction to change",
                remedy="Use the engine mujoco",
            )
        change(friction)

    def support(self, name: str, T_world_foot: pin.SE3 | None) -> None:
        """Read the wrench of a sole where it stands now; None: it is in the air."""
        self.engine.support(name, T_world_foot)

    def step(self, tau: Array) -> PhysicsState:
        """Go on by one control period. Raises: DivergedError."""
        self.engine.external[:] = 0.0
        pushing = self.pushing
        if pushing is not None:
            J = self._evaluator.at(self.state.q).jacobian(pushing[0])
            self.engine.external[:] = J[:3].T @ pushing[1]
        self.state = self.engine.step(tau)
        return self.state


def _with_rotors(robot: Robot) -> Robot:
    """Return the robot with rotors, which the other engine gives it by itself."""
    model = robot.model.copy()
    armature = np.array(model.armature)
    armature[robot.nv_base :] += ROTORS
    model.armature = armature
    return replace(robot, model=model)


def _engine(
    robot: Robot, contacts: ContactStack, q: Array, dt: float, physics: Physics
) -> PlayEngine:
    if physics not in ENGINES:
        raise InputError("unknown engine", given=physics, known=ENGINES)
    if physics == "mujoco":
        from equipoise.physics.mujoco import MujocoEngine, MujocoOptions, Surroundings
        from equipoise.physics.mujoco.contact_pads import floor_height

        options, around = (
            MujocoOptions(armature=ROTORS),
            Surroundings((), (), floor_height(contacts)),
        )
        return MujocoEngine(robot, contacts, q, dt, options=options, surroundings=around)
    if robot.nv_base:
        return UnilateralContactEngine(robot, contacts, q, dt)
    return RigidContactEngine(robot, contacts, q, dt)
