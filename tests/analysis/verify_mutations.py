"""Mutations of the code behind each equation: (file, before, after, group that must notice)."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Mutation:
    """Replace `before` by `after` in `file`; some row of `group` must then fail."""

    equation: str
    file: str
    before: str
    after: str
    group: str


def _m(equation: str, file: str, before: str, after: str, group: str) -> Mutation:
    return Mutation(equation, file, before, after, group)


LAW, MANIFOLDS = "control/law.py", "control/manifolds.py"
RIGID, STACK = "physics/rigid.py", "contacts/stack.py"
DYNAMICS, CLOSED = "analysis/dynamics.py", "analysis/closed_forms.py"

MUTATIONS = (
    _m("(1) Coriolis dropped", DYNAMICS, "(self.C + self.D) @ v + self.g", "self.g", "dynamics"),
    _m("(1) gravity sign", DYNAMICS, "@ v + self.g", "@ v - self.g", "dynamics"),
    _m("(2) identity block", "coordinates.py", "= np.eye(3)\n    J_x", "= -np.eye(3)\n    J_x",
       "geometry"),
    _m("(3) half", "coordinates.py", "0.5 * skew(R", "1.0 * skew(R", "geometry"),
    _m("(3) rows for columns", "coordinates.py", "skew(R[:, i])", "skew(R[i])", "geometry"),
    _m("(4), (5) lever of a grasp", "contacts/grasp.py", "= R_a.T @ skew(lever)",
       "= -R_a.T @ skew(lever)", "geometry"),
    _m("(5) lever of a point", "contacts/body_point.py", "J[:3] - skew", "J[:3] + skew",
       "geometry"),
    _m("(5) sole axes", "contacts/sole.py", "self.T_world_anchor.rotation.T)",
       "self.T_world_anchor.rotation)", "geometry"),
    _m("(6) reaction sign", RIGID, "half_free + half @ lam", "half_free - half @ lam",
       "dynamics"),
    _m("(6) bias sign", RIGID, "free = force - bias", "free = force + bias", "dynamics"),
    _m("(7) stabilisation dropped", RIGID, "self._position_gain * phi", "0.0 * phi", "geometry"),
    _m("(8) drift dropped", RIGID, "-self.contacts.drift(kin)", "0.0", "geometry"),
    _m("(8) centrifugal term", "contacts/body_point.py",
       "+ np.cross(omega, np.cross(omega, lever))", "", "geometry"),
    _m("(8) Hessian dropped", "contacts/surface.py", "n @ bias + turning @ xdot", "n @ bias",
       "geometry"),
    _m("(8) normalisation dropped", "contacts/surface.py", "bent - n * (n @ bent)", "bent",
       "geometry"),
    _m("(8) Coriolis of a moving surface", "contacts/moving.py", "- 2.0 * np.cross", "- np.cross",
       "geometry"),
    _m("(8) acceleration of a moving surface", "contacts/moving.py",
       "- sample.acceleration_world[:3]", "", "geometry"),
    _m("(9) error sign", "spatial.py", "T_ref.translation - T.translation",
       "T.translation - T_ref.translation", "motion"),
    _m("(10) sign", "tasks/frame_pose.py", "+ self.rate * error", "- self.rate * error",
       "motion"),
    _m("(10) feed-forward dropped", "tasks/frame_pose.py", "sample.twist_world + self.rate",
       "self.rate", "motion"),
    _m("(11) lift", STACK, "        return self._Q1 @ solution",
       "        return -self._Q1 @ solution", "motion"),
    _m("(12) projector sign", STACK, "return v - self._Q1", "return v + self._Q1", "geometry"),
    _m("(12) projector matrix", STACK, "np.eye(self.J_phi.shape[1]) - self._Q1",
       "np.eye(self.J_phi.shape[1]) + self._Q1", "geometry"),
    _m("(13) torus curvature", "contacts/surfaces/torus.py", "across / (rho * length)",
       "1.0 / rho", "geometry"),
    _m("(13) sphere curvature", "contacts/surfaces/base.py",
       "projector - np.outer(direction, direction)", "projector", "geometry"),
    _m("(14) residual of the levels above", "hqp/recursion.py", "(target - A @ v)", "target",
       "motion"),
    _m("(14) free directions", "hqp/recursion.py", "free @ right[rank:].T", "free", "motion"),
    _m("(16) contacts not in level 0", "scenarios/levels.py",
       "levels: list[list[Task]] = [[contacts]]", "levels: list[list[Task]] = [[]]", "motion"),
    _m("(17) transpose", "coordinates.py", "np.linalg.pinv(J_x.T)", "np.linalg.pinv(J_x).T * 2",
       "geometry"),
    _m("(18) polarisation", DYNAMICS, "0.5 * quadratic", "quadratic", "dynamics"),
    _m("(18) bracket dropped", DYNAMICS, "a_r + 0.5 * bracket", "a_r", "dynamics"),
    _m("(19) s rate dropped", DYNAMICS, "dynamics.M @ s_rate + ", "", "dynamics"),
    _m("(19) reference sign", DYNAMICS, "return self.M @ a_r + (self.C + self.D) @ v_r",
       "return self.M @ a_r - (self.C + self.D) @ v_r", "dynamics"),
    _m("(20), (22a) alpha", MANIFOLDS, "self.s_p = dv + self.alpha * dq",
       "self.s_p = dv - self.alpha * dq", "law"),
    _m("(21) force part sign", LAW, "- self.gains.beta * stacked.lift",
       "+ self.gains.beta * stacked.lift", "law"),
    _m("(21) force part dropped", LAW, "- self.gains.beta * stacked.lift(s_rF)", "", "law"),
    _m("(21) projection dropped", LAW, "s = stacked.project(s_rp)", "s = s_rp", "law"),
    _m("(22b) growth", MANIFOLDS, "np.exp(-self.beta_p", "np.exp(self.beta_p", "promises"),
    _m("(22c) dropped", MANIFOLDS, "self.s_qp = self.s_p - self.s_p0",
       "self.s_qp = self.s_p - 0.0 * self.s_p0", "promises"),
    _m("(22d) sign", MANIFOLDS, "self.s_qp + self.k_ip", "self.s_qp - self.k_ip", "law"),
    _m("(23a) sign", MANIFOLDS, "self.s_F + dt * dlam", "self.s_F - dt * dlam", "law"),
    _m("(23b) growth", MANIFOLDS, "np.exp(-self.beta_F", "np.exp(self.beta_F", "promises"),
    _m("(23c) sign", MANIFOLDS, "self.s_F - s_dF", "self.s_F + s_dF", "promises"),
    _m("(23d) sign", MANIFOLDS, "self.s_qF + self.k_iF", "self.s_qF - self.k_iF", "law"),
    _m("(24) damping sign", LAW, "return -self.K_d @ s", "return self.K_d @ s", "law"),
    _m("(24) wanted force", LAW, "            -lam_ref\n", "            lam_ref\n", "law"),
    _m("(24) printed sign of ds_dF", LAW, "- force.rate_of_s_dF", "+ force.rate_of_s_dF",
       "promises"),
    _m("(24) tanh dropped", LAW, "+ gains.k_iF * np.tanh(gains.mu * force.s_qF)", "", "law"),
    _m("(24) eta sign", LAW, "+ gains.eta * force.s_rF", "- gains.eta * force.s_rF", "law"),
    _m("(26) printed gain", DYNAMICS, "- k_iF * sign", "- sign", "dynamics"),
    _m("(26) eta sign", DYNAMICS, "eta * s_rF + s_rF_rate", "-eta * s_rF + s_rF_rate",
       "dynamics"),
    _m("(27) half", DYNAMICS, "0.5 * float(s @ M @ s", "float(s @ M @ s", "law"),
    _m("(27) force part", DYNAMICS, "+ beta * s_rF @ s_rF", "- beta * s_rF @ s_rF", "law"),
    _m("(28) disturbance sign", DYNAMICS, "-float(s @ reference_force)",
       "float(s @ reference_force)", "law"),
    _m("(28) damping dropped", DYNAMICS, "s @ (dynamics.D + K_d) @ s", "s @ dynamics.D @ s",
       "law"),
    _m("(28) force dissipation sign", DYNAMICS, "force_dissipation=beta", "force_dissipation=-beta",
       "law"),
    _m("(28) sign mismatch", DYNAMICS, "sign_mismatch=-beta", "sign_mismatch=beta", "law"),
    _m("closed form of posture", CLOSED, "dq_0 * decay + s_p0", "dq_0 * decay - s_p0",
       "promises"),
    _m("closed form of force", CLOSED, "return -beta_F", "return beta_F", "promises"),
    _m("base wrench", "control/base_wrench.py", "GW.T @ multiplier - lam_without",
       "GW.T @ multiplier", "dynamics"),
    _m("frame of v_ref", "spatial.py", "T_world_base.actInv(T_world_ref)",
       "T_world_ref.actInv(T_world_base)", "law"),
)  # fmt: skip
