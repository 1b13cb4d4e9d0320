"""How the robot is controlled: period, solver, law, gains."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from equipoise.scenarios.schema.base import NotNegative, Positive, Section


class SignSpec(Section):
    """`sign`, `tanh(x / layer)` or `saturation` = clip(x / layer)."""

    kind: Literal["sign", "tanh", "saturation"] = "saturation"
    layer: Positive = 0.05


class GainsSpec(Section):
    """Gains of the law, with the paper's letters (`equipoise.control.ControlGains` has a table).

    `K_d` is `kappa` [1/s] times the nominal inertia matrix at the start, a constant computed
    once by the gain adviser; `kappa` may be left out, then the adviser chooses it.
    """

    kappa: Positive | None = None
    alpha: Positive = 20.0
    beta_p: Positive = 5.0
    k_ip: NotNegative = 5.0
    beta: Positive = 0.05
    beta_F: Positive = 5.0
    k_iF: NotNegative = 5.0
    mu: Positive = 5.0
    eta: Positive = 20.0
    sgn_p: SignSpec = SignSpec()
    sgn_F: SignSpec = SignSpec(layer=0.5)
    integral_max: Positive = 10.0
    handover: Positive = 0.3
    damp_violation: bool = False


class ControlSpec(Section):
    """Control period, controller, hierarchy solver, gains, and how the robot is found.

    `kind` of the controller: `passivity` is the paper's law; a program may register others.

    `distribution` of the base wrench over the soles: `least` cost, or `bounded` so that the floor
    can give the predicted reaction (pressing, in the cones, pressure inside the soles).
    `reaction_filter` [s]: how slowly the measured reaction is followed when it is predicted; zero
    takes it at face value, which no delay survives. `soft_floor_delay` [s]: on a floor that gives
    (engine mujoco) the adviser chooses `kappa`, `alpha` and the layer of `sgn_p` so that the loop
    has a sixfold reserve over this delay, and damps what violates a contact; zero: the gains are
    taken as they are written.

    `start`: `released`, nothing holds it and the first torque is zero; `standing`, it stands under
    its servos and the law takes over the measured joint torques without a jump.
    """

    period: Annotated[float, Field(gt=0.0, le=0.02)] = 0.001
    kind: str = "passivity"
    solver: Literal["active_set", "cascade", "daqp"] = "active_set"
    contact_rate: Positive = 10.0
    start: Literal["released", "standing"] = "released"
    distribution: Literal["least", "bounded"] = "least"
    reaction_filter: NotNegative = 0.02
    soft_floor_delay: NotNegative = 0.003
    gains: GainsSpec = GainsSpec()
