"""What the rigid engine works in."""

from __future__ import annotations

from equipoise.compiled.workspace import Arrays, Shape

DYNAMICS = Arrays(
    ("J", "L", "half", "half_free", "delassus", "slip_speed", "a_free", "rhs", "damping", "force",
     "a", "lam", "total", "compliance", "settings", "coulomb", "viscosity", "travel", "at",
     "active", "kept", "bilateral", "pushed", "mode", "outcome"),
    frozenset({"at", "active", "kept", "bilateral", "pushed", "mode", "outcome"}),
)  # fmt: skip
(J_PHI, L_FACTOR, HALF, HALF_FREE, DELASSUS, SLIP_SPEED, A_FREE, RHS, DAMPING, FORCE, ACCELERATION,
 LAM, TOTAL, COMPLIANCE, SETTINGS, COULOMB, VISCOSITY, TRAVEL, AT, ACTIVE, KEPT, BILATERAL, PUSHED,
 MODE, OUTCOME) = range(len(DYNAMICS.names))  # fmt: skip

# entries of `settings`: the step [s], gains on position [1/s^2] and velocity [1/s], the proximal
# term, and the largest violation seen since it was last set to zero
STEP, POSITION_GAIN, VELOCITY_GAIN, PROXIMAL, VIOLATION = range(5)
# modes of a pushed object: see `PushedObjectMode`
FREE, STICK, SLIP = range(3)
# values of `outcome`
SOLVED, SINGULAR = range(2)


def dynamics_shapes(
    rows: int, nv: int, contacts: int, pushed: int
) -> list[tuple[str, Shape, bool]]:
    """Return the arrays for r rows of contacts, of which some belong to pushed objects.

    `half` [r, nv] is `(L^-1 J^T)^T` with the factor `L` [nv, nv] of the inertia, `delassus` [r, r]
    is `J M^-1 J^T`. Pushed object i stands behind row `pushed[i]`. `bilateral` [r] tells the rows
    that hold both ways.
    """
    r, p = max(rows, 1), max(pushed, 1)
    return DYNAMICS.shapes(
        J=(r, nv), L=(nv, nv), half=(r, nv), half_free=nv, delassus=(r, r), slip_speed=r, a_free=r,
        rhs=r, damping=nv, force=nv, a=nv, lam=r, total=r, compliance=r, settings=5, coulomb=p,
        viscosity=p, travel=p, at=max(contacts, 1), active=r, kept=r, bilateral=r, pushed=p, mode=p,
        outcome=1,
    )  # fmt: skip
