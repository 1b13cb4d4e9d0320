"""The gains of a run: as the scenario writes them, or as the adviser wants them on a soft floor."""

from __future__ import annotations

from equipoise.control import ControlGains, GainAdvice, SignFunction, advise_for_soft_floor
from equipoise.control.passivity.gains import Projector
from equipoise.scenarios import schema


def gains_of(scenario: schema.Scenario) -> schema.GainsSpec:
    """Return the gains that the run uses."""
    control = scenario.control
    if scenario.physics.engine != "mujoco" or control.soft_floor_delay == 0.0:
        usual: Projector = "euclidean" if scenario.walk is None else "damping"
        projector = control.gains.projector or usual
        return control.gains.model_copy(update={"projector": projector})
    projector = control.gains.projector or "damping"
    soft = advise_for_soft_floor(
        control.soft_floor_delay, control.period, control.gains.k_ip, projector=projector
    )
    return control.gains.model_copy(
        update={
            "kappa": soft.kappa,
            "alpha": soft.alpha,
            "sgn_p": schema.SignSpec(kind="saturation", layer=soft.layer),
            "damp_violation": True,
            "projector": projector,
        }
    )


def to_control_gains(spec: schema.GainsSpec, advice: GainAdvice) -> ControlGains:
    """Return the gains of the law with the adviser's `K_d`."""
    values = spec.model_dump(exclude={"kappa", "shape", "hand_load", "sgn_p", "sgn_F"})
    return ControlGains(
        K_d=advice.K_d,
        sgn_p=SignFunction(spec.sgn_p.kind, spec.sgn_p.layer),
        sgn_F=SignFunction(spec.sgn_F.kind, spec.sgn_F.layer),
        **values,
    )
