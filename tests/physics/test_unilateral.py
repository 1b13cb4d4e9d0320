"""Contacts that lift and land: in both engines where both can, else against formulas."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from equipoise.contacts import ContactStack, PointContact, SoleContact
from equipoise.control.passivity.gain_advice import inertia_matrix
from equipoise.errors import InputError, NameNotFoundError
from equipoise.physics import (
    PushedObject,
    RigidContactEngine,
    RigidOptions,
    UnilateralContactEngine,
)
from helpers import kinematics, sole_contacts

DT = 1e-3


def rigid(robot, contacts, q, v=None):
    return UnilateralContactEngine(robot, ContactStack(contacts), q, DT, v_start=v)


def in_mujoco(robot, contacts, q, v=None):
    mujoco = pytest.importorskip("equipoise.physics.mujoco")
    pads = pytest.importorskip("equipoise.physics.mujoco.contact_pads")
    stack = ContactStack(contacts)
    around = mujoco.Surroundings(floor_height=pads.floor_height(stack))
    return mujoco.MujocoEngine(robot, stack, q, DT, surroundings=around, v_start=v)


ENGINES = pytest.mark.parametrize("make", [rigid, in_mujoco], ids=["rigid", "mujoco"])


class Servos:
    """Springs and dampers that hold a posture beside a torque."""

    def __init__(self, robot, q, tau):
        self.robot, self.q, self.tau = robot, q, tau
        self.M = inertia_matrix(robot, q)[6:, 6:]

    def __call__(self, state):
        dq = pin.difference(self.robot.model, self.q, state.q)
        return self.tau - self.M @ (2000.0 * dq[6:] + 80.0 * state.v[6:])


def raised(robot, height):
    q = robot.q_half_sitting.copy()
    q[2] += height
    return q


@ENGINES
def test_feet_lift_when_something_pulls_the_robot_up(hrp2, make):
    """With 1.2 times its weight pulling, it rises with 0.2 g, and nothing touches it."""
    q = hrp2.q_half_sitting
    engine = make(hrp2, sole_contacts(hrp2, q), q)
    servos = Servos(hrp2, q, 0.0 * engine.stand())
    M = inertia_matrix(hrp2, q)
    engine.external[:] = M @ (np.eye(hrp2.nv)[2] * 1.2 * 9.81)  # a uniform field, upwards
    for _ in range(300):
        state = engine.step(servos(engine.state))
    assert np.abs(state.lam).max() < 1e-9
    com = kinematics(hrp2, state.q).p_world_com - kinematics(hrp2, q).p_world_com
    assert com[2] == pytest.approx(0.5 * 0.2 * 9.81 * 0.3**2, rel=0.05)


@ENGINES
def test_a_robot_that_is_let_go_lands_and_stands(hrp2, make):
    q = hrp2.q_half_sitting
    high = raised(hrp2, 0.02)
    engine = make(hrp2, sole_contacts(hrp2, q), q)
    tau = engine.stand()
    engine = make(hrp2, sole_contacts(hrp2, q), high)
    servos = Servos(hrp2, q, 0.0 * tau)
    for k in range(800):
        state = engine.step(servos(engine.state))
        if k < 55:  # it falls for 64 ms, without weight
            assert np.abs(state.lam).max() < 1e-9
        elif state.lam.any():
            servos.tau = tau
    assert state.lam[2] + state.lam[8] == pytest.approx(9.81 * hrp2.mass, rel=0.02)
    assert abs(state.q[2] - q[2]) < 5e-3


@ENGINES
def test_a_foot_whose_load_is_taken_leaves_the_other_to_carry(hrp2, make):
    """A pull at one foot that is more than its load lifts it; the other one has the rest."""
    q = hrp2.q_half_sitting
    soles = sole_contacts(hrp2, q)
    engine = make(hrp2, soles, q)
    servos = Servos(hrp2, q, engine.stand())
    J = kinematics(hrp2, q).jacobian(soles[1].frame)
    lifted = False
    for k in range(120):
        engine.external[:] = J[:3].T @ [0.0, 0.0, min(k / 60.0, 1.0) * 400.0]
        state = engine.step(servos(engine.state))
        lifted = lifted or (state.lam[8] == 0.0 and state.lam[2] > 100.0)
    assert lifted


def landing(robot, speed):
    """Return an engine in the moment before its soles land, and what it had."""
    q = raised(robot, 3e-4)
    v = np.zeros(robot.nv)
    v[2] = -speed
    engine = rigid(robot, sole_contacts(robot, robot.q_half_sitting), q, v)
    servos = Servos(robot, q, np.zeros(robot.na))
    while not engine.events:
        before = engine.state
        tau = servos(before)
        engine.step(tau)
    return engine, before, tau


def test_a_landing_takes_the_momentum_and_energy_of_the_formulas(hrp2):
    """Impulses are the change of the momentum of the centre of mass; the energy the quadratic form.

    Both from the state before and behind: neither from what the engine solved.
    """
    engine, before, _ = landing(hrp2, 0.3)
    events = [one for one in engine.events if one.kind == "land"]
    assert [one.name for one in events] == ["left_sole", "right_sole"]
    kin = kinematics(hrp2, before.q, before.v)
    J = np.vstack([kin.jacobian(c.frame) for c in sole_contacts(hrp2, before.q)])
    M = inertia_matrix(hrp2, before.q)
    gap = J @ before.v
    lost = 0.5 * gap @ np.linalg.solve(J @ np.linalg.solve(M, J.T), gap)
    assert sum(one.lost for one in events) == pytest.approx(lost, rel=1e-9)
    p = np.linalg.solve(J @ np.linalg.solve(M, J.T), -gap)
    v = before.v + np.linalg.solve(M, J.T @ p)
    change = hrp2.mass * kin.J_com @ (v - before.v)
    told = sum(one.impulse[:3] for one in events)
    assert np.allclose(told, change, atol=1e-9 * abs(change[2]))
    kinetic = 0.5 * before.v @ M @ before.v - 0.5 * v @ M @ v
    assert kinetic == pytest.approx(lost, rel=1e-9)
    assert np.abs(J @ v).max() < 1e-12
    again = kinematics(hrp2, engine.state.q, engine.state.v)
    assert max(np.abs(again.twist(c.frame)).max() for c in sole_contacts(hrp2, before.q)) < 1e-3


def test_between_events_it_is_the_engine_whose_contacts_hold(hrp2):
    q = hrp2.q_half_sitting
    stack = ContactStack(sole_contacts(hrp2, q))
    options = RigidOptions(substeps=2)
    one = UnilateralContactEngine(hrp2, stack, q, DT, options=options)
    other = RigidContactEngine(hrp2, stack, q, DT, options=options)
    tau = one.stand()
    assert np.allclose(tau, other.stand())
    for _ in range(20):
        a, b = one.step(0.99 * tau), other.step(0.99 * tau)
    assert not one.events
    assert np.allclose(a.q, b.q, atol=1e-12)
    assert np.allclose(a.lam, b.lam, atol=1e-6)


def test_a_foot_that_is_lost_lands_where_it_comes_to_the_floor(hrp2):
    q = hrp2.q_half_sitting
    engine = rigid(hrp2, sole_contacts(hrp2, q), q)
    tau = engine.stand()
    servos = Servos(hrp2, q, tau)
    engine.lose("right_sole")
    assert engine.held == ("left_sole",)
    assert [one.kind for one in engine.events] == ["loss"]
    for _ in range(5):
        state = engine.step(servos(engine.state))
    assert "land" in [one.kind for one in engine.events]
    assert engine.held == ("left_sole", "right_sole")
    assert state.lam[8] > 0.0
    with pytest.raises(NameNotFoundError, match="foot that stands"):
        engine.lose("tail")


def test_points_lift_and_land_too(hrp2):
    q = hrp2.q_half_sitting
    kin = kinematics(hrp2, q)
    points = []
    for sole in hrp2.soles:
        T = kin.placement(sole.frame)
        for k, corner in enumerate(sole.corners):
            points.append(PointContact(name=f"{sole.name}_{k}", supporting=True, frame=sole.frame,
                                       offset=tuple(corner), p_world=T.act(corner)))  # fmt: skip
    engine = rigid(hrp2, points, q)
    servos = Servos(hrp2, q, engine.stand())
    for _ in range(300):
        state = engine.step(servos(engine.state))
    normal = state.lam.reshape(-1, 3)[:, 2]
    assert (normal >= 0.0).all()
    assert normal.sum() == pytest.approx(9.81 * hrp2.mass, rel=0.05)


def test_a_wrench_is_told_in_the_axes_that_are_asked_for(hrp2):
    """The same force, turned: its size stays, and so does what the world does."""
    q = hrp2.q_half_sitting
    [left, right] = sole_contacts(hrp2, q)
    engine = rigid(hrp2, [left, right], q)
    tau = engine.stand()
    plain = engine.step(tau).lam[:6]
    R = pin.utils.rotate("z", 0.3)
    engine.support("left_sole", pin.SE3(R, left.T_world_anchor.translation))
    turned = engine.step(tau).lam[:6]
    back = np.concatenate((R @ turned[:3], R @ turned[3:]))
    assert np.allclose(left.T_world_anchor.rotation @ plain[:3], back[:3], atol=0.05)


def test_what_it_cannot_do_is_refused(hrp2):
    q = hrp2.q_half_sitting
    stack = ContactStack(sole_contacts(hrp2, q))
    with pytest.raises(InputError, match="pushed"):
        UnilateralContactEngine(hrp2, stack, q, DT, pushed=[PushedObject("push", 1.0, 1.0)])
    with pytest.raises(InputError, match="cannot be lifted"):
        RigidContactEngine(hrp2, stack, q, DT).support("left_sole", None)
    assert isinstance(stack.contacts[0], SoleContact)
