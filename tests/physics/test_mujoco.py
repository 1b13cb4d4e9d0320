"""The MuJoCo engine: sensors against the solver's contacts, friction, weld, warnings, absence."""

from __future__ import annotations

import sys

import numpy as np
import pinocchio as pin
import pytest

from equipoise.collision.scene import Body, Shape
from equipoise.contacts import ContactStack, SurfaceContact
from equipoise.contacts.surfaces import Plane
from equipoise.errors import InputError
from equipoise.spatial import pose
from helpers import kinematics, palm_grasp, random_state, sole_contacts

mujoco = pytest.importorskip("mujoco")

from equipoise.physics.mujoco import (  # noqa: E402
    EngineWarningError,
    LooseObject,
    MujocoEngine,
    MujocoOptions,
    Surroundings,
)
from equipoise.physics.mujoco.contact_pads import PadSensor  # noqa: E402
from equipoise.physics.mujoco.conversion import StateConversion  # noqa: E402
from equipoise.physics.mujoco.names import in_model, of_object  # noqa: E402

STIFF, DAMPED = 3000.0, 60.0


def hold(engine, ticks):
    """Hold the first posture by springs at the joints; return the last state."""
    robot, q = engine.robot, engine.state.q
    tau = engine.stand()
    for _ in range(ticks):
        state = engine.state
        dq = pin.difference(robot.model, q, state.q)
        state = engine.step(tau - STIFF * dq[6:] - DAMPED * state.v[6:])
    return state


def test_states_and_forces_survive_the_way_there_and_back(hrp2, rng):
    na = hrp2.na
    places = 7 + rng.permutation(na), 6 + rng.permutation(na)
    conversion = StateConversion(*places)
    q, v = random_state(hrp2, rng)
    qpos, qvel, qfrc = np.zeros(hrp2.nq), np.zeros(hrp2.nv), np.zeros(hrp2.nv)
    conversion.write_q(q, qpos)
    conversion.write_v(q, v, qvel)
    q_back, v_back = conversion.state(qpos, qvel)
    assert np.allclose(q_back, q, atol=1e-15)
    assert np.allclose(v_back, v, atol=1e-14)
    force = rng.normal(size=hrp2.nv)
    conversion.write_v(q, force, qfrc)
    assert qfrc @ qvel == pytest.approx(force @ v)  # power is the same in both


def test_sole_sensors_read_the_sum_of_the_contacts(hrp2):
    """The force-torque sensor against the solver's own contact forces, moved to the frame."""
    q = hrp2.q_half_sitting
    stack = ContactStack(sole_contacts(hrp2, q))
    engine = MujocoEngine(hrp2, stack, q, 1e-3, options=MujocoOptions(substeps=1))
    hold(engine, 60)
    tau = engine.stand()
    origins = {s.name: _site(engine, hrp2.frame_id(s.frame)) for s in stack.contacts}
    state = engine.step(tau)
    for sole in stack.contacts:
        wrench = _contact_sum(engine, in_model("sole", sole.name), origins[sole.name])
        assert np.allclose(state.lam[stack.rows[sole.name]], wrench, atol=2e-3 * 550.0)
        assert wrench[2] > 100.0


def test_a_hand_on_a_wall_reads_what_it_presses(hrp2):
    q = hrp2.q_half_sitting
    frame_id = hrp2.frame_id("right_palm")
    T_palm = kinematics(hrp2, q).placement(frame_id)
    offset = (0.0, 0.0, 0.04)
    normal_pose = T_palm * pose(offset, (np.pi, 0.0, 0.0))  # z of the wall against z of the palm
    wall = SurfaceContact(
        name="wall",
        regulated=("fn",),
        frame=frame_id,
        surface=Plane(),
        T_world_surface=normal_pose,
        offset=offset,
    )
    stack = ContactStack([*sole_contacts(hrp2, q), wall])
    engine = MujocoEngine(hrp2, stack, q, 1e-3, options=MujocoOptions(substeps=1))
    tau = engine.stand()
    J = wall.jacobian(kinematics(hrp2, q))[0, 6:]
    for _ in range(400):
        state = engine.state
        dq = pin.difference(hrp2.model, q, state.q)
        spring = -STIFF * dq[6:] - DAMPED * state.v[6:]
        state = engine.step(tau + spring - 20.0 * J)
    pressed = _contact_sum(engine, in_model("ball", "wall"), np.zeros(3))
    normal = wall.normal(kinematics(hrp2, state.q))
    assert state.lam[stack.rows["wall"]][0] == pytest.approx(normal @ pressed[:3], rel=1e-3)
    assert normal @ pressed[:3] > 5.0


def test_friction_is_coulombs(hrp2):
    """A block on the floor under a side force: below the cone it stays, above it goes."""
    block = Body("block", (Shape("box", (0.1, 0.1, 0.1), pose((0, 0, 0))),), pose((2.0, 0.0, 0.05)))
    for share, moves in ((0.9, False), (1.2, True)):
        loose = LooseObject(block, 2.0, 0.5, block.T_parent_body)
        q = hrp2.q_half_sitting
        engine = MujocoEngine(
            hrp2, ContactStack([]), q, 1e-3, surroundings=Surroundings(loose=(loose,))
        )
        adr = engine.model.compiled.joint(of_object("block")).dofadr[0]
        engine.simulated.qfrc_applied[adr] = share * 0.5 * 2.0 * 9.81
        for _ in range(200):
            engine.step(np.zeros(hrp2.na))
        gone = engine.object_pose("block").translation[0] - 2.0
        assert (gone > 0.01) == moves
        assert moves or gone < 2e-3


def test_a_welded_tray_is_squeezed_and_carried(hrp2):
    """Its weight reaches the soles, and drops out of the squeeze that is measured."""
    q = hrp2.q_half_sitting
    grasp = palm_grasp(hrp2, q)
    kin = kinematics(hrp2, q)
    T_a, T_b = kin.placement(grasp.frame_a), kin.placement(grasp.frame_b)
    middle = pin.SE3(np.eye(3), 0.5 * (T_a.translation + T_b.translation))
    tray = LooseObject(
        Body("tray", (Shape("box", (0.1, 0.1, 0.1), pose((0.3, 0, 0))),), middle),
        1.5,
        0.6,
        middle,
        handles=((grasp.frame_a, middle.actInv(T_a)), (grasp.frame_b, middle.actInv(T_b))),
    )
    stack = ContactStack([*sole_contacts(hrp2, q), grasp])
    engine = MujocoEngine(hrp2, stack, q, 1e-3, surroundings=Surroundings(loose=(tray,)))
    state = hold(engine, 400)
    carried = state.lam[2] + state.lam[8]
    assert carried == pytest.approx(9.81 * (hrp2.mass + 1.5), rel=2e-3)
    assert abs(engine.object_pose("tray").translation[2] - middle.translation[2]) < 0.02
    assert np.abs(state.lam[stack.rows["grasp"]][:3]).max() < 5.0


def test_warnings_end_the_run_with_a_sentence(hrp2):
    engine = MujocoEngine(hrp2, ContactStack([]), hrp2.q_half_sitting, 1e-3)
    with pytest.raises(EngineWarningError, match=r"MuJoCo warned at t = 0\.00"):
        engine.step(np.full(hrp2.na, 1e300))


def test_a_reset_would_be_noticed(hrp2):
    engine = MujocoEngine(hrp2, ContactStack([]), hrp2.q_half_sitting, 1e-3)
    engine.step(np.zeros(hrp2.na))
    mujoco.mj_resetData(engine.model.compiled, engine.simulated)
    with pytest.raises(EngineWarningError, match="reset"):
        engine.step(np.zeros(hrp2.na))


def test_no_log_file_is_left_behind(hrp2, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    engine = MujocoEngine(hrp2, ContactStack([]), hrp2.q_half_sitting, 1e-3)
    with pytest.raises(EngineWarningError):
        engine.step(np.full(hrp2.na, 1e300))
    assert not list(tmp_path.iterdir())


def test_without_mujoco_the_error_names_the_extra(hrp2, monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(InputError, match=r"equipoise\[mujoco\]"):
        MujocoEngine(hrp2, ContactStack([]), hrp2.q_half_sitting, 1e-3)


@pytest.mark.parametrize("wrong", [{"substeps": 0}, {"armature": -1.0}, {"contact_time": np.nan}])
def test_impossible_options_are_refused(wrong):
    with pytest.raises(InputError, match=next(iter(wrong)).split("_")[0][:5]):
        MujocoOptions(**wrong)


def _site(engine, frame_id):
    site = engine.model.compiled.site(PadSensor(frame_id).site).id
    return engine.simulated.site_xpos[site].copy()


def _contact_sum(engine, geom_name, origin):
    """Return the wrench (6,) on a geom at `origin`, world axes, from the solver's contacts."""
    model, simulated = engine.model.compiled, engine.simulated
    geom = model.geom(geom_name).id
    total = np.zeros(6)
    for k in range(simulated.ncon):
        contact = simulated.contact[k]
        if geom not in (contact.geom1, contact.geom2):
            continue
        result = np.zeros(6)
        mujoco.mj_contactForce(model, simulated, k, result)
        force = contact.frame.reshape(3, 3).T @ result[:3]
        force = force if contact.geom2 == geom else -force
        total[:3] += force
        total[3:] += np.cross(contact.pos - origin, force)
    return total
