"""Our inverse-dynamics program beside TSID's own, on the same states: largest relative difference.

`python benchmarks/compare_tsid.py --python tsid/bin/python`; the Python named has `tsid` >= 1.10.
Both stand on two soles with the same tasks (base and posture, weighted 1), regularisation, bounds
and gains. States are random ones with contacts kept, some of them so pulled at that a torque or a
centre of pressure is at its bound. Cones are not compared: TSID's pyramid has four sides, ours
eight; where a cone is at its bound the state is left out, and counted.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin

from equipoise.contacts import ContactStack, SoleContact
from equipoise.control import Measurement, ReactionBounds, Reference
from equipoise.control.rivals.floor import Floor
from equipoise.control.rivals.gains import RivalGains
from equipoise.control.rivals.idqp import InverseDynamicsQP
from equipoise.robots import get_robot

DT = 1e-3
ROUGH = 3.0  # friction: the centres of pressure and motors meet their bounds before the cones
HEAVY = 0.2  # of the regularisation: TSID's solver adds 1e-8 to it, which must not count
MOST = 2e-2  # [m, rad] of the errors of the last states
TIGHT = ReactionBounds(normal_min=250.0, pressure_margin=0.04)  # so that some are met
WEAK = 0.25  # share of the torque limits, so that some are met


class Plain(InverseDynamicsQP):
    """Accelerations weighted by 1, as TSID's tasks are."""

    plain = True
    support_weight = HEAVY


def compare(python: str, count: int = 40, robot: str = "hrp2") -> dict[str, float]:
    """Return the largest relative difference of a torque, and how many states had what."""
    nominal = get_robot(robot)
    model = nominal.model.copy()
    model.upperEffortLimit = WEAK * model.upperEffortLimit
    model.lowerEffortLimit = WEAK * model.lowerEffortLimit
    weak, rng = replace(nominal, model=model), np.random.default_rng(7)
    gains = RivalGains(kappa=100.0, alpha=20.0)
    ours: list[np.ndarray] = []
    found = {"states": 0, "cone met": 0, "torque met": 0, "floor met": 0}
    asked: dict[str, list[np.ndarray]] = {
        name: [] for name in ("q", "v", "q_ref", "v_ref", "a_ref")
    }
    for k in range(count):
        pull = 1e-4 + MOST * k / count
        q = pin.integrate(model, nominal.q_half_sitting, rng.normal(size=weak.nv) * 0.05)
        v = rng.normal(size=weak.nv) * 0.02
        away = rng.normal(size=weak.nv) * pull
        away[3:6] = 0.0  # TSID takes translation and rotation apart, we the twist that leads there
        q_ref = pin.integrate(model, q, away)
        v_ref = np.concatenate((np.zeros(6), rng.normal(size=weak.na) * 0.01))
        stack = ContactStack(
            [SoleContact.standing(sole, weak.at(q), friction=ROUGH) for sole in weak.soles]
        )
        rival = Plain(weak, stack, gains, DT)
        rival.floor = Floor(stack, TIGHT)
        command = rival.step(
            0.0, Measurement(q, v, np.zeros(12)), Reference(q_ref, v_ref, np.zeros(0))
        )
        near = rival.floor.A @ command.base_reaction - rival.floor.b < 1e-6
        cones = np.zeros(len(near), bool)
        for foot in range(2):
            cones[21 * foot + 1 : 21 * foot + 9] = cones[21 * foot + 13 : 21 * foot + 21] = True
        if (near & cones).any():
            found["cone met"] += 1
            continue
        found["states"] += 1
        found["floor met"] += bool(near.any())
        found["torque met"] += bool((np.abs(command.tau) > weak.tau_max * (1.0 - 1e-9)).any())
        ours.append(command.tau)
        for name, value in (("q", q), ("v", v), ("q_ref", q_ref), ("v_ref", v_ref)):
            asked[name].append(value)
        asked["a_ref"].append(np.zeros(weak.nv))
    feet = stack.contacts
    shrunk = [_corners(foot.sole.corners, TIGHT.pressure_margin) for foot in feet]
    theirs = _ask(
        python,
        {
            **{name: np.array(values) for name, values in asked.items()},
            "urdf": np.array(str(nominal.urdf_path)),
            "joints": np.array(nominal.joint_names),
            "soles": np.array([foot.frame for foot in feet]),
            "corners": np.array(shrunk),
            "costs": np.array([sum(foot.reaction_costs()) for foot in feet]),
            "friction": np.array(TIGHT.friction_share * feet[0].friction),
            "normal_min": np.array(TIGHT.normal_min),
            "force_weight": np.array(HEAVY),
            "kp": np.array(gains.kappa * gains.alpha),
            "kd": np.array(gains.kappa),
            "contact_kp": np.array(gains.contact_rate**2),
            "contact_kd": np.array(2.0 * gains.contact_rate),
            "tau_max": weak.tau_max,
        },
    )
    mine = np.array(ours)
    apart = np.abs(theirs - mine).max(axis=1) / np.abs(mine).max(axis=1)
    return {
        **found,
        "no answer of TSID": int(np.isnan(apart).sum()),
        "apart": float(np.nanmax(apart)),
    }


def _corners(corners: np.ndarray, margin: float) -> np.ndarray:
    """Return corners (4, 3) moved inwards by a margin [m]."""
    middle = corners.mean(axis=0)
    return corners - margin * np.sign(corners - middle)


def _ask(python: str, asked: dict[str, np.ndarray]) -> np.ndarray:
    """Return the torques (n, na) that TSID has for the questions, from a process of its own."""
    worker = Path(__file__).parent / "tsid_torques.py"
    with tempfile.TemporaryDirectory(prefix="equipoise-tsid-") as folder:
        questions, answers = Path(folder) / "questions.npz", Path(folder) / "answers.npz"
        np.savez(questions, **asked)
        environment = os.environ | {"PYTHONPATH": ""}
        subprocess.run(
            [python, str(worker), str(questions), str(answers)], check=True, env=environment
        )
        return np.load(answers)["tau"]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--python", required=True, help="a Python that has tsid")
    parser.add_argument("--states", type=int, default=40)
    given = parser.parse_args()
    for name, value in compare(given.python, given.states).items():
        print(f"{name}: {value:g}")
