"""A hand that leans on a wall: it carries what the soles cannot, and without it the robot falls."""

from __future__ import annotations

import numpy as np
import pytest

from equipoise.errors import ScenarioError
from equipoise.robots import named_robots
from equipoise.scenarios import parse_scenario, read_scenario
from equipoise.simulation.build.fades import build_fades
from equipoise.simulation.simulation import Simulation

WALL = """
name: touch
robot: hrp2
duration: 1.0
contacts:
  left_sole: {kind: sole, sole: left_sole}
  right_sole: {kind: sole, sole: right_sole}
  wall:
    kind: surface
    frame: right_palm_skin
    surface: {plane: true, at: {xyz: [0.48, -0.3, 1.33], rpy: [0.0, -1.5707963267948966, 0.0]}}
    start: 0.4
    force: {times: [0.4], values: [2.0]}
tasks: {posture: {kind: posture, priority: 1}}
"""


def lean(
    engine: str, duration: float, *, hand: bool = True, robot: str | None = None
) -> dict[str, np.ndarray]:
    """Run the scenario, or the same motion without a wall, and return what was logged."""
    overrides = [f"physics.engine={engine}", f"duration={duration}"]
    scenario = read_scenario("lean", overrides, robot=robot)
    if not hand:
        contacts = {n: c for n, c in scenario.contacts.items() if n != "wall"}
        scenario = scenario.model_copy(update={"contacts": contacts})
    names = ["t", "q", "com", "com_margin", "lam/left_sole", "lam/right_sole"]
    names += ["lam/wall", "lam_ref/wall"] if hand else []
    log: dict[str, list] = {name: [] for name in names}
    for t, record in Simulation(scenario).ticks():
        for name in names:
            log[name].append(t if name == "t" else record[name].copy())
    return {name: np.array(values) for name, values in log.items()}


@pytest.mark.parametrize(
    ("robot", "engine", "share"),
    [
        ("hrp2", "rigid", 0.02),
        ("hrp2", "mujoco", 0.1),
        pytest.param("talos", "mujoco", 0.1, marks=pytest.mark.slow),
        pytest.param("g1", "mujoco", 0.1, marks=pytest.mark.slow),
    ],
)
def test_the_centre_of_mass_goes_past_the_toes_and_back(robot, engine, share):
    if engine == "mujoco":
        pytest.importorskip("mujoco")
    if named_robots()[robot].missing:
        pytest.skip(f"{robot} is not installed: {named_robots()[robot].missing}")
    log = lean(engine, 9.0, robot=None if robot == "hrp2" else robot)
    t, wall, wanted = log["t"], log["lam/wall"][:, 0], log["lam_ref/wall"][:, 0]
    leans = (t > 2.3) & (t < 8.0)
    assert wall[leans].min() > 0.0  # never lost
    assert np.sqrt(np.mean((wall - wanted)[leans] ** 2)) < share * np.sqrt(
        np.mean(wanted[leans] ** 2)
    )
    assert log["com_margin"].min() == pytest.approx(-0.01, abs=2e-4)  # 1 cm past the toes
    assert log["com_margin"][-1] > 0.03  # and back
    assert wanted.max() == pytest.approx(35.0 if robot == "g1" else 40.0)
    assert not wall[t < 1.9].any()
    assert not wall[t > 8.4].any()  # it touches and lets go


def test_what_the_hand_carries_is_what_the_soles_miss():
    """While the lean stands still, force and moment about the toes balance (Newton, Euler)."""
    log = lean("rigid", 5.3)
    k = int(np.argmin(np.abs(log["t"] - 5.2)))
    com = log["com"][k]
    load = log["lam/left_sole"][k, 2] + log["lam/right_sole"][k, 2]
    along = log["lam/left_sole"][k, 0] + log["lam/right_sole"][k, 0]
    assert along == pytest.approx(log["lam/wall"][k, 0], rel=0.01)
    pitch = 0.0
    for name in ("left_sole", "right_sole"):  # about the frame of each sole, at x = 0
        pitch += log[f"lam/{name}"][k, 4]
    zmp = -pitch / load
    lever = 1.33 * log["lam/wall"][k, 0] / load
    assert zmp == pytest.approx(com[0] - lever, abs=2e-3)
    assert com[0] > 0.13 > zmp


def test_without_the_hand_the_same_motion_falls():
    pytest.importorskip("mujoco")
    log = lean("mujoco", 6.0, hand=False)
    assert log["q"][-1, 2] < 0.6 * log["q"][0, 2]


def test_a_surface_may_come_and_go():
    scenario = parse_scenario(WALL)
    assert scenario.contacts["wall"].comes_or_goes
    ramped = parse_scenario(WALL, ["contacts.wall.ramp=0.2"])
    fade = build_fades(ramped)["contact wall"]
    assert [fade.weight(t) for t in (0.1, 0.2, 0.4, 9.0)] == [0.0, 0.0, 1.0, 1.0]


@pytest.mark.parametrize(
    "override", ["contacts.wall.end=0.3", "contacts.wall.ramp=0.5", "contacts.wall.start=-1.0"]
)
def test_times_without_sense_are_refused(override):
    with pytest.raises(ScenarioError, match=r"contacts\.wall"):
        parse_scenario(WALL, [override])


def test_feet_that_lift_and_surfaces_that_come_are_not_for_one_rigid_engine():
    with pytest.raises(ScenarioError, match="feet that hold both ways"):
        Simulation(read_scenario("lean", ["physics.contacts=unilateral", "physics.engine=rigid"]))
