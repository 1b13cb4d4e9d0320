"""From a scenario to what comes and goes: the fades of its tasks and contacts."""

from __future__ import annotations

import math

from equipoise.contacts import ContactSchedule
from equipoise.scenarios import schema
from equipoise.simulation.build.setup import Setup
from equipoise.tasks import ContactTask, Task
from equipoise.trajectories import Fade


def build_fades(scenario: schema.Scenario) -> dict[str, Fade]:
    """Return the fades by the name of the task; what starts at time 0 was always there."""
    fades = {}
    for name, task in scenario.tasks.items():
        if task.enabled and task.window is not None:
            start, end = task.window
            fades[name] = Fade(start if start > 0.0 else -math.inf, end, task.ramp)
    for name, contact in _ramped(scenario).items():
        start = contact.start - contact.ramp if contact.start else -math.inf
        end = math.inf if contact.end is None else contact.end + contact.ramp
        fades[_rows_of(name)] = Fade(start, end, contact.ramp)
    return fades


def contact_tasks(scenario: schema.Scenario, setup: Setup, *, supports: bool = True) -> list[Task]:
    """Return the tasks of level 0: one of contacts that hold or are switched, one for each ramp.

    A contact is faded in before it holds and out when it holds no more: while it holds, the
    velocity never violates it. Without `supports` only what does not carry the robot is held.
    """
    ramped, rate = _ramped(scenario), scenario.control.contact_rate
    schedule = setup.reference_schedule
    if not ramped and supports:
        return [ContactTask("contacts", schedule, rate=rate)]
    held = [contact for contact in schedule.contacts if supports or not contact.supporting]
    kept = [contact for contact in held if contact.name not in ramped]
    tasks: list[Task] = []
    if kept:
        windows = {contact.name: schedule.windows[contact.name] for contact in kept}
        tasks.append(ContactTask("contacts", ContactSchedule(kept, windows), rate=rate))
    for contact in held:
        if contact.name in ramped:
            alone = ContactSchedule([contact], {})
            tasks.append(ContactTask(_rows_of(contact.name), alone, rate=rate))
    return tasks


def _ramped(
    scenario: schema.Scenario,
) -> dict[str, schema.PushContactSpec | schema.SurfaceContactSpec]:
    kinds = schema.PushContactSpec | schema.SurfaceContactSpec
    return {
        name: spec
        for name, spec in scenario.contacts.items()
        if isinstance(spec, kinds) and spec.ramp > 0.0
    }


def _rows_of(contact: str) -> str:
    """Return the name of the task that holds a faded contact; no scenario's task can have it."""
    return f"contact {contact}"
