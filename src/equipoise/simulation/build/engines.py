"""The engine that a scenario asks for, given the true robot and the true world."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from equipoise.errors import InputError, ScenarioError
from equipoise.physics import (
    PhysicsEngine,
    RigidContactEngine,
    RigidOptions,
    UnilateralContactEngine,
)
from equipoise.physics.rigid.ground import Block
from equipoise.scenarios import schema
from equipoise.scenarios.lookup import at_path, to_vector
from equipoise.simulation.build.plant import one_sided_surfaces, plant_objects, plant_robot
from equipoise.simulation.build.setup import Setup
from equipoise.spatial import Array

if TYPE_CHECKING:
    from equipoise.physics.mujoco import LooseObject, MujocoEngine, Surroundings


def make_engine(scenario: schema.Scenario, setup: Setup, q_start: Array) -> PhysicsEngine:
    """Return the engine at rest at `q_start` (nq,).

    Raises: `InputError` if the engine is not installed or cannot be given the world.
    """
    if scenario.physics.engine == "mujoco":
        return _mujoco(scenario, setup, q_start)
    physics = scenario.physics
    kind = physics.contacts or ("bilateral" if scenario.walk is None else "unilateral")
    if scenario.walk is not None and kind == "bilateral":
        raise ScenarioError(
            "the robot walks, and bilateral contacts never lift",
            path="physics.contacts",
            remedy="Leave it out, say unilateral, or use the engine mujoco",
        )
    given = plant_robot(scenario, setup), setup.contacts, q_start, scenario.control.period
    options = RigidOptions(
        substeps=physics.substeps,
        position_gain=physics.position_gain,
        velocity_gain=physics.velocity_gain,
        joint_damping=physics.joint_damping,
    )
    pushed, one_sided = plant_objects(scenario), one_sided_surfaces(scenario)
    _require_one_hand(scenario, setup, kind)
    if kind == "bilateral":
        return RigidContactEngine(*given, options=options, pushed=pushed, one_sided=one_sided)
    if one_sided:
        raise ScenarioError(
            "a surface that comes or goes needs feet that hold both ways in the engine rigid",
            path=f"contacts.{one_sided[0]}",
            remedy="Use the engine mujoco, or physics.contacts: bilateral",
        )
    blocks = _blocks(scenario, setup) if scenario.walk is not None else []
    return UnilateralContactEngine(*given, options=options, pushed=pushed, blocks=blocks)


def _blocks(scenario: schema.Scenario, setup: Setup) -> list[Block]:
    """Return the boxes of the world, on which feet may land. Raises: `ScenarioError`."""
    bodies = {body.name: body for body in setup.scene.bodies}
    blocks = []
    for name in scenario.world.bodies:
        body = bodies[name]
        for shape in body.shapes:
            try:
                if shape.kind == "box":
                    T = body.T_parent_body * shape.T_body_shape
                    blocks.append(Block(T, shape.size, name))
            except InputError as error:
                raise at_path(error, f"world.bodies.{name}") from None
    return blocks


def _require_one_hand(scenario: schema.Scenario, setup: Setup, kind: str) -> None:
    """Refuse sliders that the rigid engine does not have. Raises: `ScenarioError`."""
    for name, hands in setup.pushing.items():
        if kind == "unilateral" or len(hands) > 1:
            why = "by several hands" if len(hands) > 1 else "by a robot whose feet lift"
            raise ScenarioError(
                f"the engine rigid knows no object that is pushed {why}",
                path=f"world.sliders.{name}",
                given=list(hands),
                remedy="Use the engine mujoco",
            )


def _mujoco(scenario: schema.Scenario, setup: Setup, q_start: Array) -> MujocoEngine:
    from equipoise.physics.mujoco import MujocoEngine, MujocoOptions

    pushed = {}
    for slider in plant_objects(scenario):
        spec = scenario.contacts[slider.contact]
        assert isinstance(spec, schema.PushContactSpec)
        pushed[slider] = (spec.slider, setup.sliders[spec.slider])
    return MujocoEngine(
        plant_robot(scenario, setup),
        setup.contacts,
        q_start,
        scenario.control.period,
        options=MujocoOptions(**scenario.physics.mujoco.model_dump()),
        surroundings=_surroundings(scenario, setup, q_start),
        pushed=pushed,
    )


def _surroundings(scenario: schema.Scenario, setup: Setup, q_start: Array) -> Surroundings:
    from equipoise.physics.mujoco import LooseObject, Surroundings
    from equipoise.physics.mujoco.contact_pads import floor_height

    bodies = {body.name: body for body in setup.scene.bodies}
    world = scenario.world
    loose = [_held(scenario, setup, q_start, name) for name in world.objects]
    for name, spec in world.sliders.items():
        loose.append(
            LooseObject(
                bodies[name],
                spec.mass,
                spec.friction,
                bodies[name].T_parent_body,
                viscosity=spec.viscosity,
                felt=spec.felt,
            )
        )
    return Surroundings(
        tuple(bodies[name] for name in world.bodies), tuple(loose), floor_height(setup.contacts)
    )


def _held(scenario: schema.Scenario, setup: Setup, q_start: Array, name: str) -> LooseObject:
    from equipoise.physics.mujoco import LooseObject

    spec = scenario.world.objects[name]
    body = next(body for body in setup.scene.bodies if body.name == name)
    kin = setup.robot.at(q_start)
    first = next(iter(spec.handles))
    T_world_start = kin.placement(first) * setup.handles[name, first].inverse()
    return LooseObject(
        body,
        spec.mass,
        spec.friction,
        T_world_start,
        handles=tuple((hand, setup.handles[name, hand]) for hand in spec.handles),
        grip=spec.grip,
        release=min(
            (
                contact.end
                for contact in scenario.contacts.values()
                if isinstance(contact, schema.GraspContactSpec)
                and contact.object == name
                and contact.end is not None
            ),
            default=np.inf,
        ),
        payloads=tuple(
            (load.mass, to_vector(load.at))
            for load in scenario.disturbances.payloads
            if load.object == name
        ),
    )
