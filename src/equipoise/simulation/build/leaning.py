"""From what hands are wanted to push with to how a walk leans into it."""

from __future__ import annotations

import numpy as np

from equipoise.contacts import MovingSurfaceContact, SurfaceContact
from equipoise.scenarios import schema
from equipoise.simulation.build.forces import wanted_forces
from equipoise.simulation.build.setup import Setup
from equipoise.simulation.build.walk import WalkSetup
from equipoise.spatial import Array
from equipoise.tasks import FrameAxesTask, FramePoseTask, Task
from equipoise.walking import Leaning


def build_leaning(
    scenario: schema.Scenario, setup: Setup, levels: list[list[Task]], walk: WalkSetup
) -> Leaning | None:
    """Return how the centre of mass leans into the wanted forces of hands, None if there are none.

    A hand pushes where its task wants it while the force is greatest; that height, and the normal
    there, count for the whole run.
    """
    if not walk.spec.lean:
        return None
    dt = scenario.control.period
    t = np.arange(round(scenario.duration / dt) + 1) * dt
    wanted = wanted_forces(scenario)
    total: Array = np.zeros((len(t), 2))
    for contact in setup.reference_schedule.contacts:
        if not isinstance(contact, SurfaceContact | MovingSurfaceContact) or contact.supporting:
            continue
        start, end = setup.reference_schedule.windows.get(contact.name, (-np.inf, np.inf))
        holds = (t >= start) & (t <= end)
        force = np.where(holds, [wanted[contact.name][0].at(float(now)) for now in t], 0.0)
        normal, height = _where(contact, float(t[np.argmax(force)]), setup, levels)
        height -= walk.plan.ground.at(0.0)[0]
        total -= np.outer(force, normal * height / walk.weight)
    return Leaning(walk.planner.settings.omega, dt, total) if total.any() else None


def _where(
    contact: SurfaceContact | MovingSurfaceContact, t: float, setup: Setup, levels: list[list[Task]]
) -> tuple[Array, float]:
    """Return the normal (2,) along the ground, and the height [m] in the world, of a push at t."""
    robot = setup.robot
    kin = robot.at(robot.q_half_sitting, None, t)
    normal = contact.normal(kin)[:2]
    for level in levels:
        for task in level:
            if not isinstance(task, FramePoseTask | FrameAxesTask) or task.frame != contact.frame:
                continue
            wanted = task.target.at(t).T_world_target
            offset = contact.offset if isinstance(task, FramePoseTask) else (0.0, 0.0, 0.0)
            return normal, float(wanted.act(np.array(offset))[2])
    return normal, float(kin.placement(contact.frame).act(np.array(contact.offset))[2])
