"""The engine, and what it is told."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from equipoise.scenarios.schema.base import NotNegative, Positive, Section


class MujocoSpec(Section):
    """What the engine mujoco is told besides (see `equipoise.physics.mujoco.MujocoOptions`).

    `substeps` physics steps a control period; `joint_friction` [N m], `joint_damping`
    [N m s/rad] and `armature` [kg m^2] act at every actuated joint; `sole_friction` and
    `hand_friction` are Coulomb coefficients; `contact_time` [s] is how fast a contact pushes
    back: smaller is stiffer.
    """

    substeps: Annotated[int, Field(ge=1, le=100)] = 2
    joint_friction: NotNegative = 0.2
    joint_damping: NotNegative = 0.2
    armature: NotNegative = 0.05
    sole_friction: Positive = 0.8
    hand_friction: Positive = 0.5
    contact_time: Positive = 0.01


class PhysicsSpec(Section):
    """The engine: `rigid` or `mujoco`.

    `contacts` of the engine rigid: `bilateral`, they hold both ways, as in the paper; `unilateral`,
    soles and feet lift where they would pull and land with an inelastic impact. Left out they are
    unilateral where the robot walks, and bilateral otherwise.
    `substeps` (physics steps a control period), the two gains that take back a violated contact,
    and `joint_damping` belong to the engine rigid; `mujoco` has a section of its own.
    """

    engine: Literal["rigid", "mujoco"] = "rigid"
    contacts: Literal["bilateral", "unilateral"] | None = None
    mujoco: MujocoSpec = MujocoSpec()
    substeps: Annotated[int, Field(ge=1, le=100)] = 1
    position_gain: NotNegative = 0.1
    velocity_gain: NotNegative = 0.7
    joint_damping: NotNegative = 0.0
