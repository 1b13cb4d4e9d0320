"""The arrows: they add up as the contacts' own Jacobians say, and stand where they act."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from viewer_logs import tray_places

pytest.importorskip("viser", reason="needs the extra 'viewer': pip install -e '.[viewer]'")

from equipoise.analysis.rendering.force_arrows import HAND_SCALE, hand_arrows
from equipoise.analysis.rendering.sole_arrows import OUTSIDE, SOLE_SCALE, outer_sides, sole_arrow
from equipoise.contacts import SoleContact
from equipoise.kinematics import Kinematics, KinematicsEvaluator
from equipoise.scenarios import read_scenario
from equipoise.spatial import Array
from equipoise.viewer.forces import PUSH_SCALE, PushLayer
from equipoise.viewer.layer import Moment
from equipoise.viewer.server import ViewerServer


@pytest.fixture(scope="module")
def kin() -> Kinematics:
    robot = tray_places().robot
    q = robot.q_half_sitting.copy()
    q[7:] += 0.1 * np.random.default_rng(4).normal(size=robot.na)
    return KinematicsEvaluator(robot).at(q, np.zeros(robot.nv))


def _ways(arrows: list[Array], scale: float) -> list[Array]:
    return [(tip - tail) / scale for tail, tip in arrows]


def test_the_floor_pushes_the_feet_up_beside_them() -> None:
    setup = tray_places()
    sides, standing = outer_sides(setup), setup.robot.at(setup.robot.q_half_sitting)
    assert sorted(sides.values()) == [-1.0, 1.0]
    weight = setup.robot.mass * 9.81
    total = np.zeros(3)
    for contact in setup.soles.contacts:
        arm, force = np.array([0.03, -0.01, 0.0]), np.array([4.0, -3.0, weight / 2.0])
        lam = np.concatenate([force, np.cross(arm, force)])
        arrow = sole_arrow(contact, standing, lam, sides[contact.name])
        assert arrow is not None
        tail, tip = arrow
        assert tip[2] - tail[2] > 0.0
        total += (tip - tail) / SOLE_SCALE
        T, sole = contact.T_world_anchor, contact.sole
        foot = T.actInv(tail)
        assert np.allclose(foot[[0, 2]], arm[[0, 2]])  # on the floor, level with the pressure
        outside = max(foot[1] - sole.y_max, sole.y_min - foot[1])
        assert outside == pytest.approx(OUTSIDE)
        others = [c.T_world_anchor.translation for c in setup.soles.contacts if c is not contact]
        middle = T.translation
        assert all(np.dot(tail - middle, other - middle) < 0.0 for other in others)
        further = sole_arrow(contact, standing, lam, sides[contact.name], 0.02)
        assert further is not None
        assert np.linalg.norm(further[0] - tail) == pytest.approx(0.02)
    assert total[2] == pytest.approx(weight)


def test_the_arrow_goes_with_a_foot_that_walks(kin) -> None:
    setup = tray_places()
    standing = setup.robot.at(setup.robot.q_half_sitting)
    for contact in setup.soles.contacts:
        assert isinstance(contact, SoleContact)
        lam = np.array([3.0, -2.0, 300.0, 1.0, 4.0, 0.0])
        before, after = (sole_arrow(contact, at, lam, 1.0) for at in (standing, kin))
        assert before is not None
        assert after is not None
        moved = kin.placement(contact.sole.frame) * standing.placement(contact.sole.frame).inverse()
        assert np.allclose(after, [moved.act(point) for point in before])
        assert np.linalg.norm(after - before) > 0.01


def test_no_arrow_for_a_foot_in_the_air(kin) -> None:
    contact = tray_places().soles.contacts[0]
    assert isinstance(contact, SoleContact)
    assert sole_arrow(contact, kin, np.zeros(6), 1.0) is None
    assert sole_arrow(contact, kin, np.full(6, np.nan), 1.0) is None


def test_arrows_of_a_grasp_do_the_work_of_its_multiplier(kin: Kinematics) -> None:
    """J_phi^T lam is what the drawn forces and the moments about b's origin do to the joints."""
    setup = tray_places()
    contact = next(c for c in setup.contacts.contacts if c.name == "grasp")
    lam = np.array([2.0, -1.0, 15.0, 0.0, 0.0, 0.0])
    arrows = hand_arrows(contact, kin, lam)
    on_b, on_a = _ways(arrows, HAND_SCALE)
    T_a, T_b = kin.placement(contact.frame_a), kin.placement(contact.frame_b)
    assert np.allclose([tip for _, tip in arrows], [T_b.translation, T_a.translation])
    assert np.allclose(on_a + on_b, 0.0)
    apart = T_b.translation - T_a.translation
    J_a, J_b = kin.jacobian(contact.frame_a), kin.jacobian(contact.frame_b)
    moment_on_a = np.cross(apart, on_a)  # the force on a acts at b's origin
    drawn = J_b[:3].T @ on_b + J_a[:3].T @ on_a + J_a[3:].T @ moment_on_a
    rows = setup.contacts.rows["grasp"]
    J_phi = setup.contacts.jacobian(kin)[rows]
    assert np.allclose(drawn, J_phi.T @ lam, atol=1e-9)
    assert np.dot(on_b, apart) > 0.0  # squeezing, the object pushes the hands apart


def test_a_push_ends_where_it_acts(server: ViewerServer, kin: Kinematics) -> None:
    setup = tray_places()
    palm = setup.robot.palms[0].frame
    pushes = f"faults.pushes=[{{frame: {palm}, force: [0, 50, 0], start: 1.0, duration: 0.5}}]"
    layer = PushLayer(server.viser.scene, read_scenario("tray", [pushes]), setup)
    point, force = np.array([0.1, 0.2, 0.9]), np.array([30.0, -10.0, 5.0])

    def drawn(t: float, **values: Array) -> np.ndarray:
        layer.show(Moment(t, values, kin))
        return np.array(layer._handle.points)

    assert len(drawn(0.0, push=np.zeros(3), push_point=np.full(3, np.nan))) == 0
    [(tail, tip)] = drawn(0.0, push=force, push_point=point)
    assert np.allclose(tip, point, atol=1e-6)
    assert np.allclose((tip - tail) / PUSH_SCALE, force, atol=1e-3)
    [(tail, tip)] = drawn(1.2)
    at = kin.placement(setup.robot.frame_id(palm)).translation
    assert np.allclose(tip, at, atol=1e-6)
    assert np.allclose((tip - tail) / PUSH_SCALE, (0.0, 50.0, 0.0), atol=1e-3)
    assert len(drawn(1.2, push=force, push_point=point)) == 2
    assert len(drawn(1.5)) == 0


def test_unknown_contacts_have_no_arrow(kin: Kinematics) -> None:
    assert hand_arrows(SimpleNamespace(), kin, np.ones(3)) == []
