"""TSID's torques at the states of a file; runs in a Python that has `tsid`, knows nothing of ours.

`python tsid_torques.py QUESTIONS.npz ANSWERS.npz`: see `compare_tsid.py`, which writes the one and
reads the other.
"""

from __future__ import annotations

import sys

import numpy as np
import pinocchio as pin
import tsid


def torque(asked: dict[str, np.ndarray], robot: tsid.RobotWrapper, k: int) -> np.ndarray:
    """Return TSID's torque (na,) at state k, NaN where it has none."""
    q, v = asked["q"][k], asked["v"][k]
    form = tsid.InverseDynamicsFormulationAccForce("check", robot, False)
    form.computeProblemData(0.0, q, v)
    data, na = form.data(), robot.nv - 6
    kp, kd = float(asked["kp"]), float(asked["kd"])
    kept = []
    for i, frame in enumerate(asked["soles"]):
        contact = tsid.Contact6d(
            str(frame), robot, str(frame), asked["corners"][i].T, np.array([0.0, 0.0, 1.0]),
            float(asked["friction"]), float(asked["normal_min"]), 1e6,
        )  # fmt: skip
        contact.setKp(float(asked["contact_kp"]) * np.ones(6))
        contact.setKd(float(asked["contact_kd"]) * np.ones(6))
        contact.setReference(robot.framePosition(data, robot.model().getFrameId(str(frame))))
        contact.setRegularizationTaskWeightVector(asked["costs"][i])
        form.addRigidContact(contact, float(asked["force_weight"]))
        kept.append(contact)
    # the base: TSID's acceleration of a point turns with the body, ours is the twist's derivative
    base = tsid.TaskSE3Equality("base", robot, "root_joint")
    base.setKp(kp * np.ones(6))
    base.setKd(kd * np.ones(6))
    T, now = pin.XYZQUATToSE3(asked["q_ref"][k][:7]), pin.XYZQUATToSE3(q[:7])
    sample = tsid.TrajectorySample(12, 6)
    sample.value(np.concatenate((T.translation, T.rotation.T.ravel())))
    sample.derivative(np.zeros(6))
    turning = np.concatenate((np.cross(v[3:6], v[:3]), np.zeros(3)))
    a_base = asked["a_ref"][k][:6] + turning
    R = now.rotation
    sample.second_derivative(np.concatenate((R @ a_base[:3], R @ a_base[3:])))
    base.setReference(sample)
    form.addMotionTask(base, 1.0, 1, 0.0)
    posture = tsid.TaskJointPosture("posture", robot)
    posture.setKp(kp * np.ones(na))
    posture.setKd(kd * np.ones(na))
    sample = tsid.TrajectorySample(na, na)
    sample.value(asked["q_ref"][k][7:])
    sample.derivative(asked["v_ref"][k][6:])
    sample.second_derivative(asked["a_ref"][k][6:])
    posture.setReference(sample)
    form.addMotionTask(posture, 1.0, 1, 0.0)
    limits = tsid.TaskActuationBounds("limits", robot)
    limits.setBounds(-asked["tau_max"], asked["tau_max"])
    form.addActuationTask(limits, 1.0, 0, 0.0)
    solver = tsid.SolverHQuadProgFast("solver")
    solver.resize(form.nVar, form.nEq, form.nIn)
    answer = solver.solve(form.computeProblemData(0.0, q, v))
    if answer.status != 0:
        return np.full(na, np.nan)
    return np.array(form.getActuatorForces(answer))


def main(questions: str, answers: str) -> None:
    """Answer all questions."""
    asked = dict(np.load(questions))
    robot = tsid.RobotWrapper(str(asked["urdf"]), [], pin.JointModelFreeFlyer(), False)
    if list(robot.model().names)[2:] != [str(name) for name in asked["joints"]]:
        raise SystemExit("TSID reads other joints from the URDF, or in another order")
    np.savez(answers, tau=np.array([torque(asked, robot, k) for k in range(len(asked["q"]))]))


if __name__ == "__main__":
    main(*sys.argv[1:])
