"""Rivals on soles and a grasp, random ticks for them, and a short closed loop."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from equipoise.contacts import ContactStack
from equipoise.control import Measurement, Reference
from equipoise.control.rivals.gains import RivalGains
from equipoise.control.rivals.kinds import RIVALS
from equipoise.physics import RigidContactEngine
from helpers import full_stack, sole_contacts

DT = 1e-3
LAWS = {kind: made.law for kind, made in RIVALS.items() if kind != "idqp_i"}


def rival_at(robot, q, law, *, stack=None, dt=DT, **gains):
    """Return a rival on soles and grasp anchored at `q`."""
    stack = full_stack(robot, q) if stack is None else stack
    return law(robot, stack, RivalGains(**gains), dt)


def random_tick(robot, rng, q, size=18, *, near=1e-3, speed=0.02):
    """Return a measurement near `q` and a reference there."""
    at = pin.integrate(robot.model, q, rng.normal(size=robot.nv) * near)
    measured = Measurement(at, rng.normal(size=robot.nv) * speed, rng.normal(size=size) * 30)
    regulated = np.array([15.0]) if size == 18 else np.zeros(0)
    return measured, Reference(q, rng.normal(size=robot.nv) * speed, regulated)


def seen_by(rival, measured, reference, t=0.0):
    """Run a step; return its command and the `Tick` that the law saw."""
    seen, law = [], rival.wanted

    def wanted(tick):
        seen.append(tick)
        return law(tick)

    rival.wanted = wanted
    try:
        command = rival.step(t, measured, reference)
    finally:
        del rival.wanted
    return command, seen[-1]


def stand(robot, rival, dt, seconds=0.4):
    """Return the largest posture error [rad, m] at the end of a stand that begins at rest."""
    q, stack = robot.q_half_sitting, rival.contacts
    engine = RigidContactEngine(robot, stack, q, dt)
    still = Reference(q, np.zeros(robot.nv), np.zeros(0))
    state = engine.state
    for k in range(round(seconds / dt)):
        command = rival.step(k * dt, Measurement(state.q, state.v, state.lam), still)
        state = engine.step(command.tau)
    return float(np.abs(pin.difference(robot.model, q, state.q)).max())


def soles_only(robot, q) -> ContactStack:
    """Return both soles as a stack."""
    return ContactStack(sole_contacts(robot, q))
