"""Phases of contacts: hysteresis in load and time, and what each phase means."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from equipoise.contacts import (
    ContactPhases,
    Phase,
    PhaseSettings,
    PointContact,
    SurfaceContact,
    load_of,
)
from equipoise.contacts.surfaces import Plane
from equipoise.errors import InputError
from helpers import kinematics, sole_contacts

DT = 1e-3


def wrench(load):
    return np.array([0.0, 0.0, load, 0.0, 0.0, 0.0])


@pytest.fixture
def soles(hrp2):
    return sole_contacts(hrp2, hrp2.q_half_sitting)


def run(phases, soles, story):
    """Let loads of the right sole pass, with what is planned; return its phases tick by tick."""
    left, right = (one.name for one in soles)
    found = []
    for tick, (planned, load) in enumerate(story):
        names = (left, right) if planned else (left,)
        lam = {left: wrench(500.0), right: wrench(load)}
        found.append(phases.update(tick * DT, names, lam)[right])
    return found


def test_a_step_goes_through_its_phases(soles):
    phases = ContactPhases(soles, [one.name for one in soles], PhaseSettings(15.0, 3.0, 2 * DT))
    story = [
        *[(True, 250.0)] * 3,
        *[(False, 10.0)] * 3,  # planned to lift, and still pressed: it carries though it should not
        *[(False, 0.0)] * 5,
        *[(False, 30.0)] * 5,  # early
        *[(True, 200.0)] * 3,
        *[(True, 0.0)] * 5,  # lost
        *[(True, 100.0)] * 5,
        *[(False, 0.0)] * 5,
        *[(True, 0.0)] * 3,  # late
    ]
    found = run(phases, soles, story)
    seen = [found[0], *(b for a, b in pairwise(found) if b is not a)]
    assert seen == [
        Phase.HELD, Phase.TOUCHED, Phase.FREE, Phase.TOUCHED, Phase.HELD, Phase.LOST, Phase.HELD,
        Phase.TOUCHED, Phase.FREE, Phase.LATE,
    ]  # fmt: skip
    assert [one.phase for one in phases.changes] == seen[1:]
    assert phases.those(Phase.LATE) == (soles[1].name,)
    assert phases.carrying == (soles[0].name,)
    assert "has not touched yet (0 N)" in str(phases.changes[-1])


@pytest.mark.parametrize("dwell", [0, 1, 3, 10])
def test_no_phase_changes_before_its_dwell_and_it_does_then(soles, dwell):
    names = [one.name for one in soles]
    phases = ContactPhases(soles, names, PhaseSettings(15.0, 3.0, dwell * DT))
    found = run(phases, soles, [(True, 0.0)] * (dwell + 1))
    assert found[:dwell] == [Phase.HELD] * dwell
    assert found[dwell] is Phase.LOST


def test_a_load_that_chatters_between_the_thresholds_changes_nothing(soles, rng):
    names = [one.name for one in soles]
    for planned, phase in ((True, Phase.HELD), (False, Phase.FREE)):
        start = names if planned else names[:1]
        phases = ContactPhases(soles, start, PhaseSettings(15.0, 3.0, 0.0))
        loads = rng.uniform(3.0, 15.0, size=200)
        assert set(run(phases, soles, [(planned, load) for load in loads])) == {phase}
        assert not phases.changes


def test_a_load_that_is_not_measured_changes_nothing(soles):
    phases = ContactPhases(soles, [one.name for one in soles], PhaseSettings(15.0, 3.0, 0.0))
    assert set(run(phases, soles, [(True, np.nan)] * 5)) == {Phase.HELD}


def test_the_load_is_what_presses(hrp2, soles):
    kin = kinematics(hrp2, hrp2.q_half_sitting)
    palm = hrp2.palms[0].frame
    p = kin.placement(palm).translation
    held = PointContact(name="held", frame=palm, p_world=p)
    wall = SurfaceContact(
        name="wall", regulated=("fn",), frame=palm, surface=Plane(),
        T_world_surface=kin.placement(palm),
    )  # fmt: skip
    assert load_of(soles[0], wrench(42.0)) == 42.0
    assert load_of(held, np.array([3.0, 0.0, -4.0])) == 5.0
    assert load_of(wall, np.array([7.0])) == 7.0


def test_thresholds_that_cross_are_refused():
    with pytest.raises(InputError, match="smaller load"):
        PhaseSettings(touch=3.0, release=5.0)
    assert PhaseSettings.for_weight(1000.0) == PhaseSettings(30.0, 5.0, loaded=100.0, steady=0.04)


def test_what_is_newly_planned_may_take_its_time(soles):
    """With patience a landing a little late is no phase of its own; one far too late still is."""
    left, right = (one.name for one in soles)
    settings = PhaseSettings(15.0, 3.0, 2 * DT, patience=10 * DT)

    def seen(story):
        found = run(ContactPhases(soles, [left, right], settings), soles, story)
        return [found[0], *(b for a, b in pairwise(found) if b is not a)]

    lift = [*[(True, 250.0)] * 3, *[(False, 20.0)] * 5, *[(False, 0.0)] * 10]  # it clings a little
    landing = [*[(True, 0.0)] * 5, *[(True, 200.0)] * 20]
    assert seen([*lift, *landing]) == [Phase.HELD, Phase.FREE, Phase.HELD]
    assert seen([*lift, *[(True, 0.0)] * 12]) == [Phase.HELD, Phase.FREE, Phase.LATE]
    clings = [(True, 250.0), *[(False, 20.0)] * 12]
    assert seen(clings) == [Phase.HELD, Phase.TOUCHED]
    # what a force does against an old plan is told at once
    assert seen([*lift, *[(False, 200.0)] * 4]) == [Phase.HELD, Phase.FREE, Phase.TOUCHED]
    assert seen([*[(True, 250.0)] * 3, *[(True, 0.0)] * 4]) == [Phase.HELD, Phase.LOST]


def test_phases_continue_from_a_saved_state_in_the_middle_of_waiting(soles):
    left, right = (one.name for one in soles)
    settings = PhaseSettings(15.0, 3.0, 2 * DT, patience=10 * DT)
    lam = {left: wrench(500.0), right: wrench(0.0)}
    one = ContactPhases(soles, [left], settings)
    for tick in range(5):
        one.update(tick * DT, [left, right] if tick > 1 else [left], lam)
    other = ContactPhases(soles, [left, right], settings)
    other.restore(one.state())
    for tick in range(5, 20):
        assert one.update(tick * DT, [left, right], lam) == other.update(
            tick * DT, [left, right], lam
        )
    assert other.phases[right] is Phase.LATE


def test_what_has_touched_and_was_never_loaded_is_not_lost(soles):
    """A foot that bounces has a load that is large or lasts; loaded is what is both."""
    left, right = (one.name for one in soles)
    settings = PhaseSettings(15.0, 3.0, 2 * DT, loaded=50.0, steady=10 * DT)

    def last(story, planned=(left,)):
        phases = ContactPhases(soles, planned, settings)
        return phases, run(phases, soles, story)[-1]

    bounce, rest = [(True, 300.0)] * 8, [(True, 0.0)] * 5
    for touched in (bounce, [(True, 40.0)] * 30, [*bounce, *rest, *bounce]):
        phases, phase = last([(False, 0.0), *touched, *rest])
        assert phase is Phase.TOUCHED
        assert phases.missing == (right,)
    # a load that comes and goes does not add up, one that stays does
    dips = [*[(True, 300.0)] * 8, (True, 49.0), *[(True, 300.0)] * 8]
    assert last([(False, 0.0), *dips, *rest])[1] is Phase.TOUCHED
    phases, phase = last([(False, 0.0), *[(True, 60.0)] * 14, *rest])
    assert phase is Phase.LOST
    assert phases.missing == (right,)
    # once loaded it stays so until it is planned to be in the air
    assert last([(False, 0.0), *[(True, 60.0)] * 14, (True, 20.0), *rest])[1] is Phase.LOST
    assert last([*[(True, 60.0)] * 14, *[(False, 0.0)] * 5, *rest], (left, right))[1] is Phase.LATE
    # what bounced while it was planned to be in the air has not touched
    assert last([*[(False, 300.0)] * 5, *[(False, 0.0)] * 5, *rest])[1] is Phase.LATE
    phases, phase = last([(False, 0.0), *bounce])
    assert phase is Phase.HELD
    assert not phases.missing
    with pytest.raises(InputError, match="loaded"):
        PhaseSettings(15.0, 3.0, loaded=10.0)
