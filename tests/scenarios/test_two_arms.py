"""Two fixed arms and one object: on rigid contacts, in MuJoCo, and held by friction alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from equipoise import run_scenario
from equipoise.analysis.joint_groups import joint_groups_of
from equipoise.robots import get_robot, named_robots
from equipoise.scenarios import read_scenario
from equipoise.simulation.build.plant import plant_robot
from equipoise.simulation.build.setup import build_setup

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(bool(named_robots()["baxter"].missing), reason="baxter is not installed"),
]
HEAVY = "disturbances.payloads=[{mass: 3.0, object: box}]"
SQUEEZE = "contacts.grasp.regulated.fz"


def run(folder: Path, name: str, *overrides: str) -> Any:
    return run_scenario(name, out=folder / "run", overrides=list(overrides), figures=False)


def values(finished: Any) -> dict[str, float]:
    return {name: row["value"] for name, row in finished.metrics.items()}


@pytest.mark.parametrize(
    "disturbance",
    [(), (HEAVY,), ("disturbances.mass_scale=1.3",), ("disturbances.mass_scale=0.7",)],
    ids=["nominal", "3kg", "heavy", "light"],
)
def test_rigid(tmp_path: Path, disturbance: tuple[str, ...]) -> None:
    finished = run(tmp_path, "two_arms", *disturbance)
    found = values(finished)
    assert finished.summary["passed"]
    assert found["palm_position_error"] < 1e-3
    assert found["force_error_share"] < 0.005
    assert found["saturated_ticks"] == 0
    assert found["torque_share"] < 0.8
    wanted = finished["lam_ref/grasp"][finished.t > 3.0, 0]
    assert (wanted.min(), wanted.max()) == pytest.approx((15.0, 25.0), abs=0.01)


def test_what_it_is_asked_to_do() -> None:
    """Up by 0.15 m, aside by 0.05 m, turned by 30 degrees."""
    setup = build_setup(read_scenario("two_arms"))
    start, lifted, moved = (setup.targets["box"].at(t).T_world_target for t in (0.0, 2.0, 4.5))
    assert lifted.translation[2] - start.translation[2] >= 0.15
    assert np.linalg.norm(moved.translation - lifted.translation) >= 0.05
    angle = np.arccos(0.5 * (np.trace(lifted.rotation.T @ moved.rotation) - 1.0))
    assert np.degrees(angle) == pytest.approx(30.0, abs=1e-6)


def test_a_step_of_force_does_not_move_the_object(tmp_path: Path) -> None:
    step = f"{SQUEEZE}={{times: [0.0, 0.3, 1.5, 1.501], values: [0.0, 20.0, 20.0, 25.0]}}"
    rest = "world.objects.box.waypoints=[{t: 0.0, xyz: [0.44, 0.0, 1.04]}]"
    finished = run(tmp_path, "two_arms", step, rest, "duration=2.5")
    setup = build_setup(read_scenario("two_arms"))
    places = []
    for q in finished["q"][1400:]:
        kin = setup.robot.at(q)
        T = kin.placement("left_palm") * setup.handles["box", "left_palm"].inverse()
        places.append(T.translation.copy())
    moved = np.abs(np.array(places) - places[0]).max()
    assert moved < 1e-4
    assert finished["lam/grasp"][-1, 2] == pytest.approx(25.0, abs=0.1)


def test_mujoco(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    finished = run(tmp_path, "two_arms", "physics.engine=mujoco")
    assert finished.summary["passed"]
    assert values(finished)["force_error_share"] < 0.05


def test_friction_holds_at_the_announced_squeeze_and_slips_below_it(tmp_path: Path) -> None:
    """Coulomb: two palms carry at most 2 mu F, so less than m g / (2 mu) cannot hold."""
    pytest.importorskip("mujoco")
    held = run(tmp_path, "two_arms_slip")
    assert held.summary["passed"]
    scenario = read_scenario("two_arms_slip")
    mass, friction = scenario.world.objects["box"].mass, scenario.physics.mujoco.hand_friction
    least = mass * 9.81 / (2.0 * friction)
    announced = scenario.contacts["grasp"].regulated["fz"].values[-1]
    assert least < announced < 1.5 * least
    weak = f"{SQUEEZE}.values=[0.0, {0.9 * least:.3f}]"
    let_go = run(tmp_path / "weak", "two_arms_slip", weak, "duration=1.5")
    fallen = [log["object/box"][:1500, 2] - log["object/box"][0, 2] for log in (held, let_go)]
    assert fallen[0].min() > -0.005
    assert fallen[1].min() < -0.01


def test_an_unknown_load_is_shared_by_the_hands() -> None:
    """Each hand bears half: the plant is the nominal robot with two halves of the mass."""
    scenario = read_scenario("two_arms", [HEAVY])
    setup = build_setup(scenario)
    plant = plant_robot(scenario, setup)
    more = {
        name: plant.model.inertias[j].mass - setup.robot.model.inertias[j].mass
        for j, name in enumerate(plant.model.names)
    }
    loaded = {name: mass for name, mass in more.items() if mass > 1e-12}
    assert loaded == pytest.approx({"left_w2": 1.5, "right_w2": 1.5})


def test_each_arm_is_a_group_of_seven_joints() -> None:
    baxter = get_robot("baxter")
    groups = {group.title: group.joints for group in joint_groups_of(baxter, baxter.joint_names)}
    assert groups == {"Left arm": tuple(range(7)), "Right arm": tuple(range(7, 14))}
