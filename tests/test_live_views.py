"""Live views show what the library holds, at every state, and refuse another layout."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from equipoise.collision.distances import DistanceEvaluator
from equipoise.collision.scene import Scene
from equipoise.errors import NonFiniteError
from equipoise.kinematics import KinematicsEvaluator
from equipoise.kinematics.live_views import LayoutError, motion_rows, pose_rows


def random_state(robot, rng):
    q = pin.integrate(robot.model, robot.q_half_sitting, 0.3 * rng.normal(size=robot.nv))
    return q, rng.normal(size=robot.nv)


def test_kinematics_shows_what_pinocchio_computes(hrp2, rng):
    evaluator, model = KinematicsEvaluator(hrp2), hrp2.model
    frame_axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    for _ in range(5):
        q, v = random_state(hrp2, rng)
        kin = evaluator.at(q, v)
        other = model.createData()
        pin.forwardKinematics(model, other, q, v, np.zeros(hrp2.nv))
        for frame in ("left_palm", "right_sole", "HEAD_LINK1"):
            i = hrp2.frame_id(frame)
            J = pin.computeFrameJacobian(model, other, q, i, frame_axes)
            drift = pin.getFrameClassicalAcceleration(model, other, i, frame_axes).vector
            assert np.allclose(kin.jacobian(i), J, atol=1e-13)
            assert np.allclose(kin.twist(i), J @ v, atol=1e-12)
            assert np.allclose(kin.drift(i), drift, atol=1e-11)
        assert np.allclose(kin.p_world_com, pin.centerOfMass(model, other, q), atol=1e-13)


def test_distances_are_coals(hrp2, rng):
    scene = Scene(hrp2)
    pairs = [scene.pair("LARM_LINK5", "BODY"), scene.pair("LARM_LINK3", "CHEST_LINK1")]
    found, evaluator = DistanceEvaluator(scene, pairs), KinematicsEvaluator(hrp2)
    geometry = scene.geometry.copy()
    for _ in range(5):
        q, v = random_state(hrp2, rng)
        distances = found.at(evaluator.at(q, v))
        geometry_data = geometry.createData()
        pin.updateGeometryPlacements(
            hrp2.model, hrp2.model.createData(), geometry, geometry_data, q
        )
        for pair, distance in zip(pairs, distances, strict=True):
            between = []
            for i in scene.shapes_of(pair.first):
                for k in scene.shapes_of(pair.second):
                    one = geometry.copy()
                    one.removeAllCollisionPairs()
                    one.addCollisionPair(pin.CollisionPair(i, k))
                    own = one.createData()
                    pin.updateGeometryPlacements(hrp2.model, hrp2.model.createData(), one, own, q)
                    between.append(pin.computeDistance(one, own, 0).min_distance)
            assert np.isclose(distance, min(between), atol=1e-12)


def test_elements_that_lie_apart_are_refused():
    with pytest.raises(LayoutError, match="not contiguous"):
        pose_rows([pin.SE3.Random() for _ in range(4)])


def test_numbers_in_another_order_are_refused(hrp2):
    class Swapped:
        def __init__(self, motion):
            self.linear = motion.linear
            self.vector = np.concatenate((motion.angular, motion.linear))

    model, state = hrp2.model, hrp2.model.createData()
    pin.forwardKinematics(model, state, hrp2.q_half_sitting, np.arange(1.0, hrp2.nv + 1.0))
    with pytest.raises(LayoutError, match="another order"):
        motion_rows([Swapped(motion) for motion in state.v])


def test_a_state_that_is_refused_leaves_the_last_one_as_it_was(hrp2):
    q, v = hrp2.q_half_sitting, np.zeros(hrp2.nv)
    evaluator = KinematicsEvaluator(hrp2)
    kin = evaluator.at(q, v)
    for wrong in ((np.full(hrp2.nq, np.nan), v), (q + 0.1, np.full(hrp2.nv, np.inf))):
        with pytest.raises(NonFiniteError):
            evaluator.at(*wrong)
        assert np.array_equal(kin.live.q, q)
