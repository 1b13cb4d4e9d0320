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


LAW, MANIFOLDS = "control/passivity/kernels.py", "control/passivity/manifold_kernels.py"
NEAREST = "control/passivity/nearest_kernels.py"
SWITCH = "control/passivity/switch.py"
RIGID, FACTOR = "physics/rigid/kernels.py", "contacts/factor.py"
FRAME_POSE, RECURSION = "tasks/frame_pose.py", "hqp/solvers/recursion.py"
COORDINATES = "spatial/coordinates.py"
DYNAMICS, CLOSED = "verify/error_dynamics.py", "verify/closed_forms.py"

MUTATIONS = (
    _m("(1) Coriolis dropped", DYNAMICS, "(self.C + self.D) @ v + self.g", "self.g", "dynamics"),
    _m("(1) gravity sign", DYNAMICS, "@ v + self.g", "@ v - self.g", "dynamics"),
    _m("(2) identity block", COORDINATES, "= np.eye(3)\n    J_x", "= -np.eye(3)\n    J_x",
       "geometry"),
    _m("(3) half", COORDINATES, "0.5 * skew(R", "1.0 * skew(R", "geometry"),
    _m("(3) rows for columns", COORDINATES, "skew(R[:, i])", "skew(R[i])", "geometry"),
    _m("(4), (5) lever of a grasp", "contacts/grasp.py",
       "crossed(wx, wy, wz, T_b[9], T_b[10], T_b[11])",
       "crossed(T_b[9], T_b[10], T_b[11], wx, wy, wz)", "geometry"),
    _m("(5) lever of a point", "kinematics/kernels.py", "crossed(p[0], p[1], p[2], nx, ny, nz)",
       "crossed(nx, ny, nz, p[0], p[1], p[2])", "geometry"),
    _m("(5) sole axes", "contacts/sole.py", "turned_back(anchor, lx, ly, lz)", "lx, ly, lz",
       "geometry"),
    _m("(6) reaction sign", RIGID, "a[c] += half[i, c] * lam[i]", "a[c] -= half[i, c] * lam[i]",
       "dynamics"),
    _m("(6) bias sign", RIGID, "force[i] - bias[i]", "force[i] + bias[i]", "dynamics"),
    _m("(7) stabilisation dropped", RIGID, "settings[POSITION_GAIN] * phi[i]", "0.0 * phi[i]",
       "geometry"),
    _m("(8) drift dropped", RIGID, "-drift[i]\n", "0.0\n", "geometry"),
    _m("(8) centrifugal term", "kinematics/kernels.py",
       "cx, cy, cz = crossed(twist[3], twist[4], twist[5], vx, vy, vz)",
       "cx, cy, cz = 0.0, 0.0, 0.0", "geometry"),
    _m("(8) Hessian dropped", "contacts/sliding.py", "wanted + bent_across - bent_along * along",
       "wanted", "geometry"),
    _m("(8) normalisation dropped", "contacts/sliding.py", "bent_across - bent_along * along",
       "bent_across", "geometry"),
    _m("(8) Coriolis of a moving surface", "contacts/sliding.py", "x + 2.0 * vx", "x + vx",
       "geometry"),
    _m("(8) acceleration of a moving surface", "contacts/sliding.py", "TWIST_RATE, lx", "TWIST, lx",
       "geometry"),
    _m("(9) error sign", FRAME_POSE, "rate * (target[9 + i] - T[9 + i])",
       "rate * (T[9 + i] - target[9 + i])", "motion"),
    _m("(10) sign", FRAME_POSE, "target[12 + i] + rate", "target[12 + i] - rate", "motion"),
    _m("(10) feed-forward dropped", FRAME_POSE, "target[12 + i] + rate", "rate", "motion"),
    _m("(11) lift", FACTOR, "row[0, k] = total / L[k, k]", "row[0, k] = -total / L[k, k]",
       "motion"),
    _m("(12) projector sign", FACTOR, "row[0, k] = 0.0", "row[0, k] *= -1.0", "geometry"),
    _m("(12) projector matrix", "contacts/stack.py", "[self.project(e) for e in",
       "[-self.project(e) for e in", "geometry"),
    _m("(13) torus curvature", "contacts/surfaces/torus.py", "across / (rho * length)",
       "1.0 / rho", "geometry"),
    _m("(13) sphere curvature", "contacts/surfaces/sphere.py",
       " - out[1 + i] * out[1 + k]) / length", ") / length", "geometry"),
    _m("(14) residual of the levels above", RECURSION, "(target - A @ v)", "target", "motion"),
    _m("(14) free directions", RECURSION, "free @ right[rank:].T", "free", "motion"),
    _m("(16) contacts not in level 0", "simulation/build/levels.py",
       "levels: list[list[Task]] = [contacts]", "levels: list[list[Task]] = [[]]", "motion"),
    _m("(17) transpose", COORDINATES, "np.linalg.pinv(J_x.T)", "np.linalg.pinv(J_x).T * 2",
       "geometry"),
    _m("(18) polarisation", DYNAMICS, "0.5 * quadratic", "quadratic", "dynamics"),
    _m("(18) bracket dropped", DYNAMICS, "a_r + 0.5 * bracket", "a_r", "dynamics"),
    _m("(19) s rate dropped", DYNAMICS, "dynamics.M @ s_rate + ", "", "dynamics"),
    _m("(19) reference sign", DYNAMICS, "return self.M @ a_r + (self.C + self.D) @ v_r",
       "return self.M @ a_r - (self.C + self.D) @ v_r", "dynamics"),
    _m("(20), (22a) alpha", MANIFOLDS, "= dv[i] + alpha * dq[i]", "= dv[i] - alpha * dq[i]", "law"),
    _m("(21) force part sign", LAW, "-= gains[BETA] * force", "+= gains[BETA] * force", "law"),
    _m("(21) force part dropped", LAW, "-= gains[BETA] * force", "-= 0.0 * force", "law"),
    _m("(21) projection dropped", LAW, "project(reflectors, rank, x, out)\n    lift",
       "copy(x, out)\n    lift", "law"),
    _m("N: lift sign", NEAREST, "total = wanted[i]", "total = -wanted[i]", "metric"),
    _m("N: projection dropped", NEAREST, "total -= J[i, c] * x[c]", "total -= 0.0 * x[c]",
       "metric"),
    _m("N: metric of the rows", NEAREST, "seen[i, c] += along * unroot[k, c]",
       "seen[i, c] += along * unroot[c, k]", "metric"),
    _m("N: metric of the answer", NEAREST, "total += unroot[i, c] * z[c]",
       "total += unroot[c, i] * z[c]", "metric"),
    _m("N: root", "control/passivity/nearest.py", "np.linalg.cholesky(K[::-1, ::-1])[::-1, ::-1]",
       "np.linalg.cholesky(K)", "metric"),
    _m("N: supports", LAW, "total += J[row, c] * dv[c]", "total -= J[row, c] * dv[c]", "metric"),
    _m("S: what the torque keeps", SWITCH, "(u[k] - w[k])", "(u[k] + w[k])", "switch"),
    _m("S: force of what was lost", SWITCH, "before[i] = carried[i]", "before[i] = -carried[i]",
       "switch"),
    _m("S: projection dropped", SWITCH, "kept[i] = z[i] if i >= rank else 0.0", "kept[i] = z[i]",
       "switch"),
    _m("S: integral", SWITCH, "tangent[i] / gains[K_IP]", "-tangent[i] / gains[K_IP]", "switch"),
    _m("S: metric", SWITCH, "total += unroot[i, k] * kept[k]", "total += unroot[k, i] * kept[k]",
       "switch"),
    _m("S: reaction", SWITCH, "G[pivots[k]] = total / L[k, k]", "G[pivots[k]] = -total / L[k, k]",
       "switch"),
    _m("S: internal forces", LAW, "left * (found[i] - wish[i])", "0.0 * left", "switch"),
    _m("(22b) growth", MANIFOLDS, "math.exp(-beta_p", "math.exp(beta_p", "promises"),
    _m("(22c) dropped", MANIFOLDS, " - memory[S_P0, i] * forgotten", "", "promises"),
    _m("(22d) sign", MANIFOLDS, "memory[S_QP, i] + k_ip", "memory[S_QP, i] - k_ip", "law"),
    _m("(23a) sign", MANIFOLDS, "memory[S_F, i] += dt", "memory[S_F, i] -= dt", "law"),
    _m("(23b) growth", MANIFOLDS, "math.exp(-beta_F", "math.exp(beta_F", "promises"),
    _m("(23c) sign", MANIFOLDS, "memory[S_F, i] - s_dF", "memory[S_F, i] + s_dF", "promises"),
    _m("(23d) sign", MANIFOLDS, "memory[S_QF, i] + k_iF", "memory[S_QF, i] - k_iF", "law"),
    _m("(24) damping sign", LAW, "u[i] = -total", "u[i] = total", "law"),
    _m("(24) wanted force", LAW, "            -lam_ref[i]\n", "            lam_ref[i]\n", "law"),
    _m("(24) printed sign of ds_dF", LAW, "- force[RATE_OF_S_DF, i]",
       "+ force[RATE_OF_S_DF, i]", "promises"),
    _m("(24) tanh dropped", LAW, "+ gains[K_IF] * math.tanh(gains[MU] * force[S_QF, i])", "",
       "law"),
    _m("(24) eta sign", LAW, "+ gains[ETA] * force[S_RF, i]", "- gains[ETA] * force[S_RF, i]",
       "law"),
    _m("(26) printed gain", DYNAMICS, "- k_iF * sign", "- sign", "dynamics"),
    _m("(26) eta sign", DYNAMICS, "eta * s_rF + s_rF_rate", "-eta * s_rF + s_rF_rate",
       "dynamics"),
    _m("(27) half", DYNAMICS, "0.5 * float(s @ M @ s", "float(s @ M @ s", "law"),
    _m("(27) force part", DYNAMICS, "+ beta * s_rF @ s_rF", "- beta * s_rF @ s_rF", "law"),
    _m("(28) disturbance sign", DYNAMICS, "-float(s @ reference_force)",
       "float(s @ reference_force)", "law"),
    _m("(28) damping dropped", DYNAMICS, "s @ (dynamics.D + K_d) @ s", "s @ dynamics.D @ s",
       "law"),
    _m("(28) force dissipation sign", DYNAMICS, "force_dissipation=gains.beta",
       "force_dissipation=-gains.beta", "law"),
    _m("(28) sign mismatch", DYNAMICS, "sign_mismatch=-gains.beta", "sign_mismatch=gains.beta",
       "law"),
    _m("closed form of posture", CLOSED, "dq_0 * decay + s_p0", "dq_0 * decay - s_p0",
       "promises"),
    _m("closed form of force", CLOSED, "return -beta_F", "return beta_F", "promises"),
    _m("base wrench", "control/base_wrench/least.py", "(costs[k] * costs[k]) - lam_without[k]",
       "(costs[k] * costs[k])", "dynamics"),
    _m("frame of v_ref", "kinematics/manifold.py", "turned_back(base, wx, wy, wz)",
       "turned_back(ref, wx, wy, wz)", "law"),
)  # fmt: skip
