"""The rivals by name, each with the gains it has unless others are given (docs/rivals.md)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from equipoise.contacts import ContactStack
from equipoise.control.passivity.gains import ControlGains
from equipoise.control.rivals.admittance import Admittance
from equipoise.control.rivals.gains import RivalGains
from equipoise.control.rivals.gravity_contacts import GravityContacts
from equipoise.control.rivals.hybrid import HybridPositionForce
from equipoise.control.rivals.idqp import InverseDynamicsQP
from equipoise.control.rivals.passive_qp import PassiveQP
from equipoise.control.rivals.pd_plus import PDPlus
from equipoise.control.rivals.projected_ct import ProjectedComputedTorque
from equipoise.control.rivals.rival import Rival
from equipoise.robots import Robot


@dataclass(frozen=True)
class RivalKind:
    """Makes rivals of one kind: called with robot, contacts, gains of the law and a period.

    Of the law's gains only `handover` is read: `K_d` is the law's own. `rigid` and `soft` are the
    gains on contacts that do not give, and on those that do; `changes` go over them.
    """

    law: type[Rival]
    rigid: RivalGains
    soft: RivalGains
    floor_gives: bool = False
    changes: Mapping[str, float] = field(default_factory=dict)

    @property
    def gains(self) -> RivalGains:
        """The gains of the rivals that it makes. Raises: `InputError`."""
        return replace(self.soft if self.floor_gives else self.rigid, **self.changes)

    def tuned(self, *, floor_gives: bool, **changes: float) -> RivalKind:
        """Return a kind for a floor that gives or not, with some gains changed."""
        return replace(self, floor_gives=floor_gives, changes=changes)

    def __call__(
        self, robot: Robot, contacts: ContactStack, gains: ControlGains, period: float
    ) -> Rival:
        """Return a rival; `robot` is the model that it knows."""
        return self.law(robot, contacts, self.gains, period, handover=gains.handover)


# found by benchmarks/sweep_rivals.py; docs/rivals.md has its tables
RIGID = RivalGains(kappa=300.0, alpha=20.0)
STIFF = RivalGains(kappa=300.0, alpha=40.0)  # rigid contacts, for those that survive it
SOFT = RivalGains(kappa=200.0, alpha=20.0, contact_rate=60.0)

RIVALS: dict[str, RivalKind] = {
    "idqp": RivalKind(InverseDynamicsQP, STIFF, SOFT),
    "idqp_i": RivalKind(
        InverseDynamicsQP, replace(STIFF, k_i=5.0), replace(SOFT, kappa=150.0, k_i=50.0)
    ),
    "gravity_contacts": RivalKind(GravityContacts, RIGID, SOFT),
    "pd_plus": RivalKind(PDPlus, RIGID, SOFT),
    "projected_ct": RivalKind(ProjectedComputedTorque, STIFF, SOFT),
    "passive_qp": RivalKind(PassiveQP, STIFF, SOFT),
    "hybrid": RivalKind(HybridPositionForce, STIFF, SOFT),
    "admittance": RivalKind(Admittance, RIGID, replace(SOFT, k_f=20.0)),
}
