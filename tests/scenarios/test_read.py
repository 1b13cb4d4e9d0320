"""Reading scenarios: what is wrong is named with line, path and what is known."""

from __future__ import annotations

from typing import get_args
from xml.etree import ElementTree

import pytest
from pydantic import BaseModel

from equipoise.errors import NameNotFoundError, ScenarioError
from equipoise.scenarios import (
    named_scenarios,
    parse_scenario,
    read_scenario,
    resolved_text,
)
from equipoise.scenarios.lookup import frame_of
from equipoise.scenarios.overrides import NAMED
from equipoise.scenarios.schema import Name, Scenario
from equipoise.simulation.build.plant import plant_robot
from equipoise.simulation.build.setup import build_setup

TEXT = named_scenarios()["tray"].read_text(encoding="utf-8")


def complaint(text: str = TEXT, *overrides: str) -> ScenarioError:
    with pytest.raises(ScenarioError) as caught:
        parse_scenario(text, overrides)
    return caught.value


@pytest.mark.parametrize("name", sorted(named_scenarios()))
def test_resolved_text_parses_back_to_itself(name):
    scenario = read_scenario(name)
    text = resolved_text(scenario)
    assert parse_scenario(text) == scenario
    assert resolved_text(parse_scenario(text)) == text


def test_overrides_reach_every_depth():
    scenario = parse_scenario(
        TEXT,
        (
            "control.gains.alpha=7",
            "tasks.obstacles.enabled=false",
            "world.objects.tray.waypoints.0.xyz=[0.5, 0, 0.7]",
            "disturbances.payloads=[{mass: 5.0, object: tray}]",
        ),
    )
    assert scenario.control.gains.alpha == 7.0
    assert scenario.tasks["obstacles"].enabled is False
    assert scenario.world.objects["tray"].waypoints[0].xyz == [0.5, 0, 0.7]
    assert scenario.disturbances.payloads[0].mass == 5.0


@pytest.mark.parametrize(
    ("override", "path", "message"),
    [
        ("durration=3", "durration", "Did you mean 'duration'"),
        ("control.gains.alhpa=3", "control.gains.alhpa", "Did you mean 'alpha'"),
        ("tasks.obstacles.influense=1", "tasks.obstacles.influense", "'influence'"),
        ("contacts.grasp.hand=[a, b]", "contacts.grasp.hand", "'hands'"),
        ("duration=.nan", "duration", "finite"),
        ("duration=-1", "duration", "greater than 0"),
        ("duration=soon", "duration", "number"),
        ("control.gains.alpha=.inf", "control.gains.alpha", "finite"),
        ("tasks.look.priority=true", "tasks.look.priority", "integer"),
        ("tasks.look.kind=gase", "tasks.look", "Did you mean 'gaze'"),
        ("tasks.wave={frame: left_palm}", "tasks.wave", "'kind' is missing. Known: hold_frame"),
        ("tasks.look=3", "tasks.look", "a mapping of keys is wanted. Given: 3"),
        ("disturbances.links={BODY: 1.2}", "disturbances.links.BODY", "Known: mass, inertia"),
        ("world.objects.tray.waypoints.1.t=0.1", "world.objects.tray", "in the past"),
        ("world.objects.tray.waypoints.0.t=-0.1", "world.objects.tray.waypoints.0.t", "greater"),
        ("tasks.obstacles.security=0.5", "tasks.obstacles", "security must be less"),
        ("acceptance.limits.clearance={}", "acceptance.limits.clearance", "give max or min"),
        ("disturbances.payloads=[{mass: 1.0}]", "disturbances.payloads.0", "exactly one of"),
        ("tasks.look.rate=1001", "tasks.look.rate", "at most 1000 1/s"),
        ("tasks.obstacles.damping=66", "tasks.obstacles.damping", "1015.38 1/s is too fast"),
        ("control.contact_rate=2e3", "control.contact_rate", "control.period 0.001 s"),
        ("control.gains.alpha=1001", "control.gains.alpha", "would go past what it approaches"),
        ("tasks.look.rate=-1", "tasks.look.rate", "greater than 0"),
        ("tasks.limits.velocity_share=-0.5", "tasks.limits.velocity_share", "greater than 0"),
    ],
)
def test_wrong_values_are_named(override, path, message):
    error = complaint(TEXT, override)
    assert error.path == path
    assert message in str(error)


@pytest.mark.parametrize(
    ("override", "path", "message"),
    [
        ("tasks.lok.priority=2", "tasks.lok", "There is no task 'lok'"),
        ("contacts.left_soul.friction=0.5", "contacts.left_soul", "Did you mean 'left_sole'"),
        ("contacts.grip.regulated.fz.values=[1]", "contacts.grip", "Known: grasp, left_sole"),
        ("world.bodies.dask.at.xyz=[0, 0, 0]", "world.bodies.dask", "Did you mean 'desk'"),
        ("world.objects.trai.mass=1.0", "world.objects.trai", "--set 'world.objects.trai={...}'"),
        ("world.sliders.box.mass=1.0", "world.sliders.box", "There is no slider 'box'"),
    ],
)
def test_a_key_of_what_does_not_exist_makes_nothing_new(override, path, message):
    error = complaint(TEXT, override)
    assert error.path == path
    assert message in str(error)


def test_a_whole_mapping_makes_something_new_whose_keys_can_then_be_changed():
    new = "tasks.wave={kind: hold_frame, frame: left_palm, priority: 4}"
    scenario = parse_scenario(TEXT, (new, "tasks.wave.rate=3"))
    assert scenario.tasks["wave"].frame == "left_palm"
    assert scenario.tasks["wave"].rate == 3.0
    assert set(scenario.tasks) == {*parse_scenario(TEXT).tasks, "wave"}


def named_sections(model: type[BaseModel], path: str = "") -> set[str]:
    """Return the paths of all mappings whose keys are names that the scenario makes itself."""
    found = set()
    for key, field in model.model_fields.items():
        arguments = get_args(field.annotation)
        if arguments and arguments[0] == Name:
            found.add(f"{path}{key}")
        elif isinstance(field.annotation, type) and issubclass(field.annotation, BaseModel):
            found |= named_sections(field.annotation, f"{path}{key}.")
    return found


def test_all_sections_with_names_of_their_own_are_guarded():
    assert named_sections(Scenario) == set(NAMED)


def test_an_unknown_key_tells_its_line_and_the_known_ones():
    error = complaint(TEXT.replace("duration: 6.2", "durration: 6.2"))
    assert error.line == 1 + TEXT[: TEXT.index("duration")].count("\n")
    assert "duration" in error.known


def test_a_missing_key_is_named():
    assert "'duration' is missing" in str(complaint(TEXT.replace("duration: 6.2", "")))


def test_duplicate_keys_are_refused_with_their_line():
    error = complaint(TEXT + "\nname: again\n")
    assert "duplicate key" in str(error)
    assert error.line is not None


@pytest.mark.parametrize("text", ["", "- a\n- b\n", "a: [1, 2", "\tname: x", "x" * 1_000_001])
def test_what_is_no_scenario_is_refused(text):
    complaint(text)


@pytest.mark.parametrize("override", ["duration", "=3", "duration.x=3", "tasks.look.offset.9=1"])
def test_malformed_overrides_are_refused(override):
    complaint(TEXT, override)


@pytest.mark.parametrize(
    ("override", "path", "message"),
    [
        ("contacts.left_sole.sole=left_soul", "contacts.left_sole.sole", "'left_sole'"),
        ("contacts.grasp.hands=[left_palm, left_plam]", "contacts.grasp.hands", "left_palm"),
        ("contacts.grasp.regulated={fq: {times: [0], values: [1]}}", "contacts.grasp.reg", "fz"),
        ("robot=hpr2", "", "hrp2"),
    ],
)
def test_names_that_do_not_exist_are_refused_when_built(override, path, message):
    scenario = parse_scenario(TEXT, (override,))
    with pytest.raises((ScenarioError, NameNotFoundError), match=message) as caught:
        build_setup(scenario)
    assert str(caught.value).startswith(path)


@pytest.mark.parametrize(
    ("override", "path"),
    [
        ("tasks.left_foot.frame=left_soul", "tasks.left_foot.frame"),
        ("tasks.left_hand.hand=left_hand", "tasks.left_hand.hand"),
        ("tasks.look.object=trai", "tasks.look.object"),
        ("tasks.obstacles.pairs.0=[tray, dask]", "tasks.obstacles.pairs.0"),
        ("tasks.posture.joints={LARM_JOINT9: 0.1}", "tasks.posture.joints.LARM_JOINT9"),
    ],
)
def test_wrong_names_in_tasks_carry_their_path(override, path):
    from equipoise.simulation.build.levels import build_levels

    scenario = parse_scenario(TEXT, (override,))
    with pytest.raises(ScenarioError) as caught:
        build_levels(scenario, build_setup(scenario))
    assert caught.value.path == path


def test_unknown_scenario_suggests():
    with pytest.raises(NameNotFoundError, match="tray"):
        read_scenario("trya")


def test_missing_file_is_an_error_of_ours(tmp_path):
    with pytest.raises(ScenarioError, match="there is no file"):
        read_scenario(str(tmp_path / "none.yaml"))


def test_disturbances_change_the_true_robot_only():
    scenario = parse_scenario(
        TEXT,
        ("disturbances.mass_scale=1.3", "disturbances.payloads=[{mass: 5.0, object: tray}]"),
    )
    setup = build_setup(scenario)
    nominal = setup.robot.mass
    assert plant_robot(scenario, setup).mass == pytest.approx(1.3 * nominal + 5.0)
    assert setup.robot.mass == nominal


def true_mass(setup, links: str) -> float:
    return plant_robot(parse_scenario(TEXT, (f"disturbances.links={links}",)), setup).mass


@pytest.fixture(scope="module")
def tray_places():
    return build_setup(parse_scenario(TEXT))


@pytest.mark.parametrize("name", ["LLEG_LINK5", "LLEG_JOINT5"])
def test_a_link_is_scaled_by_its_name_or_its_joint(tray_places, name):
    """The independent answer is the mass in the URDF."""
    urdf = ElementTree.parse(tray_places.robot.urdf_path)
    mass = float(urdf.find("./link[@name='LLEG_LINK5']/inertial/mass").get("value"))
    more = true_mass(tray_places, f"{{{name}: {{mass: 1.5}}}}") - tray_places.robot.mass
    assert more == pytest.approx(0.5 * mass)


@pytest.mark.parametrize(
    ("name", "carrier"),
    [
        ("left_sole", "LLEG_LINK5"),
        ("left_sole_fixed", "LLEG_LINK5"),
        ("left_palm_skin", "LARM_LINK5"),
        ("camera", "HEAD_LINK1"),
    ],
)
def test_what_is_fixed_to_a_link_has_no_mass_to_scale(tray_places, name, carrier):
    with pytest.raises(ScenarioError, match=f"is fixed to the link '{carrier}'") as caught:
        true_mass(tray_places, f"{{{name}: {{mass: 1.5}}}}")
    assert caught.value.path == f"disturbances.links.{name}"
    assert name not in caught.value.known
    for known in caught.value.known:  # what is offered is accepted
        true_mass(tray_places, f"{{{known}: {{mass: 1.5}}}}")


def test_the_world_has_no_mass_to_scale_and_is_not_pushed(tray_places):
    with pytest.raises(ScenarioError, match="frame 'universe' belongs to the world"):
        true_mass(tray_places, "{universe: {mass: 1.5}}")
    with pytest.raises(ScenarioError, match="belongs to the world") as caught:
        frame_of(tray_places.robot, "universe", "faults.pushes.0.frame")
    assert caught.value.path == "faults.pushes.0.frame"


def test_a_waypoint_inside_the_desk_is_refused_by_name():
    from equipoise.simulation.build.checks import check_waypoints

    scenario = parse_scenario(TEXT, ("world.objects.tray.waypoints.4.xyz=[0.52, 0.0, 0.80]",))
    with pytest.raises(ScenarioError, match="mm inside desk") as caught:
        check_waypoints(scenario, build_setup(scenario))
    assert caught.value.path == "world.objects.tray.waypoints.4"
    nominal = parse_scenario(TEXT)
    check_waypoints(nominal, build_setup(nominal))


def test_a_contact_that_cannot_hold_is_refused_by_name():
    """A palm on a sphere two metres away, while both feet stand: no small step closes the gap."""
    from equipoise.simulation.build.checks import check_contacts

    far = (
        "contacts.far={kind: surface, frame: left_sole, "
        "surface: {sphere: 0.1, at: {xyz: [2.0, 0.0, 1.0]}}, force: {times: [0], values: [5.0]}}"
    )
    scenario = parse_scenario(TEXT, (far,))
    setup = build_setup(scenario)
    with pytest.raises(ScenarioError, match="cannot hold together") as caught:
        check_contacts(setup, setup.robot.q_half_sitting, setup.schedule.at(0.0))
    assert caught.value.path in ("contacts.far", "contacts.grasp")
