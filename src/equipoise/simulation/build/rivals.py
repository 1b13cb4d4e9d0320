"""What a scenario tells a controller with a model: the robot that it knows, a rival's gains."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin

from equipoise.control.rivals.gains import require_slow_enough
from equipoise.control.rivals.kinds import RivalKind
from equipoise.errors import InputError
from equipoise.robots import Robot
from equipoise.scenarios import schema
from equipoise.scenarios.lookup import at_path


def known_robot(scenario: schema.Scenario, robot: Robot) -> Robot:
    """Return the robot as a controller with a model knows it: nominal, with an error of its own.

    The rotors of the engine are its `armature`, so that Pinocchio's inertia has them; they are not
    scaled.
    """
    spec, physics = scenario.control.model, scenario.physics
    known = robot.scaled(spec.mass_scale) if spec.mass_scale != 1.0 else robot
    model = known.model.copy()
    if physics.engine == "mujoco":
        rotors = np.array(model.armature)
        rotors[robot.nv_base :] += physics.mujoco.armature
        model.armature = rotors
    shift = np.array(spec.com_shift)
    if shift.any():
        for joint in range(1, model.njoints):
            one = model.inertias[joint]
            model.inertias[joint] = pin.Inertia(one.mass, one.lever + shift, one.inertia)
    return replace(known, model=model)


def tuned_rival(scenario: schema.Scenario, kind: RivalKind) -> RivalKind:
    """Return the rival with the gains of the scenario. Raises: `ScenarioError`."""
    changes = scenario.control.rival.model_dump(exclude_none=True)
    tuned = kind.tuned(floor_gives=scenario.physics.engine == "mujoco", **changes)
    try:
        require_slow_enough(tuned.gains, scenario.control.period)
    except InputError as error:
        raise at_path(error, "control.rival") from None
    return tuned
