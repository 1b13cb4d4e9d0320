"""Both engines offer the loop all that `PhysicsEngine` says, in the same words."""

from __future__ import annotations

import inspect

import numpy as np
import pinocchio as pin
import pytest

from equipoise.contacts import ContactStack
from equipoise.errors import NameNotFoundError
from equipoise.physics import (
    PhysicsEngine,
    PhysicsState,
    RigidContactEngine,
    UnilateralContactEngine,
)
from equipoise.scenarios import read_scenario
from equipoise.simulation.build.engines import make_engine
from equipoise.simulation.build.setup import build_setup
from helpers import sole_contacts

WANTED = {
    *("external", "sliders", "object_names", "state"),
    *("step", "stand", "support", "remove", "object_pose", "object_twist"),
}


def rigid(robot):
    q = robot.q_half_sitting
    return RigidContactEngine(robot, ContactStack(sole_contacts(robot, q)), q, 1e-3)


def unilateral(robot):
    q = robot.q_half_sitting
    return UnilateralContactEngine(robot, ContactStack(sole_contacts(robot, q)), q, 1e-3)


def in_mujoco(robot):
    pytest.importorskip("mujoco")
    from equipoise.physics.mujoco import MujocoEngine

    q = robot.q_half_sitting
    return MujocoEngine(robot, ContactStack(sole_contacts(robot, q)), q, 1e-3)


ENGINES = pytest.mark.parametrize("make", [rigid, unilateral, in_mujoco])


def members():
    written = {name for name in vars(PhysicsEngine) if not name.startswith("_")}
    return written | set(PhysicsEngine.__annotations__)


def test_the_protocol_is_what_the_loop_uses():
    assert members() == WANTED


@ENGINES
def test_every_member_is_there_with_the_same_arguments(hrp2, make):
    engine = make(hrp2)
    for name in members():
        assert hasattr(engine, name), name
        ours = vars(PhysicsEngine).get(name)
        if inspect.isfunction(ours):
            theirs = inspect.signature(getattr(type(engine), name))
            assert theirs == inspect.signature(ours), name
        elif isinstance(ours, property) and isinstance(vars(type(engine)).get(name), property):
            theirs = inspect.signature(vars(type(engine))[name].fget)
            assert theirs == inspect.signature(ours.fget), name


@ENGINES
def test_a_tick_through_the_protocol_alone(hrp2, make):
    engine: PhysicsEngine = make(hrp2)
    tau = engine.stand()
    before = engine.state
    engine.external = np.zeros(hrp2.nv)
    after = engine.step(tau)
    for state in (before, after):
        assert isinstance(state, PhysicsState)
        assert (state.q.shape, state.v.shape) == ((hrp2.nq,), (hrp2.nv,))
        assert state.lam.shape == (12,)
    assert after.t == pytest.approx(1e-3)
    assert np.array_equal(engine.state.q, after.q)
    assert np.array_equal(engine.state.v, after.v)
    assert not engine.sliders
    for ask in (engine.object_pose, engine.object_twist):
        with pytest.raises(NameNotFoundError, match="loose object"):
            ask("tray")


def test_a_held_state_does_not_change_with_the_engine(hrp2):
    """What `step` returned is the caller's: the next step writes into memory of its own."""
    for make in (rigid, in_mujoco):
        engine = make(hrp2)
        state = engine.step(engine.stand())
        kept = [np.copy(part) for part in state]
        engine.step(np.zeros(hrp2.na))
        assert all(np.array_equal(a, b) for a, b in zip(state, kept, strict=True))


@pytest.mark.parametrize("scenario", ["tray_real", "telephone_real"])
def test_objects_and_sliders_are_asked_for_by_their_names(scenario):
    pytest.importorskip("mujoco")
    spec = read_scenario(scenario)
    setup = build_setup(spec)
    engine = make_engine(spec, setup, setup.robot.q_half_sitting)
    assert set(engine.object_names) == {*spec.world.objects, *spec.world.sliders}
    assert {slider.contact for slider in engine.sliders} == {
        name for name, contact in spec.contacts.items() if getattr(contact, "slider", None)
    }
    for name in engine.object_names:
        assert isinstance(engine.object_pose(name), pin.SE3)
        assert engine.object_twist(name).shape == (6,)
