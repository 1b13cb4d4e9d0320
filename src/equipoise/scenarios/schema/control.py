"""How the robot is controlled: period, solver, law, gains."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from equipoise.scenarios.schema.base import NotNegative, Positive, Section, Vector3


class SignSpec(Section):
    """`sign`, `tanh(x / layer)` or `saturation` = clip(x / layer)."""

    kind: Literal["sign", "tanh", "saturation"] = "saturation"
    layer: Positive = 0.05


class GainsSpec(Section):
    """Gains of the law, with the paper's letters (`equipoise.control.ControlGains` has a table).

    `K_d` is `kappa` [1/s] times the nominal inertia matrix at the start, a constant computed
    once by the gain adviser; `kappa` may be left out, then the adviser chooses it. `shape`
    `postures` takes the mean of that matrix over postures of the arms instead of that at the start:
    weaker at the start, and stable with a stretched arm too. `hand_load` [kg] is added to that
    matrix at each palm: stiffer wrists, for who carries what is not told.

    `projector`: `euclidean` is Q_phi as printed, `damping` the projector that is orthogonal in K_d
    (docs: the law); left out it is `damping` where the adviser chooses gains for a soft floor, and
    where the robot walks.
    """

    kappa: Positive | None = None
    shape: Literal["start", "postures"] = "start"
    hand_load: NotNegative = 0.0
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
    root: NotNegative = 0.0
    adapt: NotNegative = 0.0
    growth_max: NotNegative = 4.0
    handover: Positive = 0.3
    damp_violation: bool = False
    projector: Literal["euclidean", "damping"] | None = None


class GovernorSpec(Section):
    """The clock of the targets slows while the robot cannot follow (`equipoise.motion.Governor`).

    `way` [m], `turn` [rad] of a frame of the reference behind its target and `posture` [rad] of the
    robot behind its reference: where slowing begins, where the clock stands. A clamped torque stops
    it. `fall`, `rise` [s]: from full speed to a stand, and back, at least.
    """

    way: Annotated[list[Positive], Field(min_length=2, max_length=2)] = [0.01, 0.03]
    turn: Annotated[list[Positive], Field(min_length=2, max_length=2)] = [0.05, 0.15]
    posture: Annotated[list[Positive], Field(min_length=2, max_length=2)] = [0.02, 0.1]
    fall: Positive = 0.1
    rise: Positive = 0.5

    @model_validator(mode="after")
    def _ordered(self) -> GovernorSpec:
        for name in ("way", "turn", "posture"):
            begins, stops = getattr(self, name)
            if stops <= begins:
                raise ValueError(f"{name}: the second number must be larger than the first")
        return self


class ModelSpec(Section):
    """The model of the dynamics that a controller knows, the shipped law excepted: it has none.

    It is the nominal robot with the rotors of the engine, its masses and inertias multiplied by
    `mass_scale` and every centre of mass moved by `com_shift` [m], in axes of its joint.
    """

    mass_scale: Positive = 1.0
    com_shift: Vector3 = [0.0, 0.0, 0.0]


class RivalSpec(Section):
    """Gains of a rival controller [1/s] (`docs/rivals.md`); what is left out has its default.

    `kappa` and `alpha` of the posture, `k_i` of its integral, `k_f` of the integral of a force,
    `contact_rate` at which a violated contact is wanted to close.
    """

    kappa: Positive | None = None
    alpha: Positive | None = None
    k_i: NotNegative | None = None
    k_f: NotNegative | None = None
    contact_rate: Positive | None = None


class ControlSpec(Section):
    """Control period, controller, hierarchy solver, gains, and how the robot is found.

    `kind` of the controller: `passivity` is the paper's law; its rivals are `idqp`, `idqp_i`,
    `gravity_contacts`, `pd_plus`, `projected_ct`, `passive_qp`, `hybrid` and `admittance`; a
    program may register others. `model` is what such a controller knows of the robot, `rival` the
    gains of a rival: those of `gains` belong to the paper's law, all but `handover`.

    `distribution` of the base wrench over the soles: `least` cost, or `bounded` so that the floor
    can give the predicted reaction (pressing, in the cones, pressure inside the soles) and then so
    that the joints that carry need no more than `torque_share` of their motors; left out it is
    `bounded` in the engine mujoco, and where the robot walks.
    `reaction_filter` [s]: how slowly the measured reaction is followed when it is predicted; zero
    takes it at face value, which no delay survives. `soft_floor_delay` [s]: on a floor that gives
    (engine mujoco) the adviser chooses `kappa`, `alpha` and the layer of `sgn_p` so that the loop
    has a threefold reserve over this delay (sixfold with the printed projector), and damps what
    violates a contact; zero: the gains are taken as they are written.

    `start`: `released`, nothing holds it and the first torque is zero; `standing`, it stands under
    its servos and the law takes over the measured joint torques without a jump.

    `governor`: `{}` slows the clock of the targets while the robot cannot follow; contacts must not
    come or go then.
    """

    period: Annotated[float, Field(gt=0.0, le=0.02)] = 0.001
    kind: str = "passivity"
    solver: Literal["active_set", "cascade", "daqp"] = "active_set"
    contact_rate: Positive = 10.0
    start: Literal["released", "standing"] = "released"
    distribution: Literal["least", "bounded"] | None = None
    torque_share: Annotated[float, Field(gt=0.0, le=1.0)] = 0.7
    reaction_filter: NotNegative = 0.02
    soft_floor_delay: NotNegative = 0.003
    gains: GainsSpec = GainsSpec()
    model: ModelSpec = ModelSpec()
    rival: RivalSpec = RivalSpec()
    governor: GovernorSpec | None = None
