"""What is said to block a task blocks it: bounds are moved by what was said, and solved again."""

from __future__ import annotations

import numpy as np
import pytest
from hqp_problems import KINDS, block, equalities, random_hierarchy

from equipoise.errors import NameNotFoundError, NonFiniteError
from equipoise.hqp import Hierarchy, RowDescription, Shortfall, explain, make_solver
from equipoise.hqp.explanation import Blocker


def solve(hierarchy: Hierarchy):
    return make_solver("cascade").solve(hierarchy)


def moved(hierarchy: Hierarchy, shortfall: Shortfall, share: float = 1.0) -> Hierarchy:
    """Return the hierarchy with every named bound moved by `share` of what was said."""
    lower, upper = hierarchy.lower.copy(), hierarchy.upper.copy()
    for b in shortfall.breaking:
        side = upper if b.broken > 0.0 else lower
        side[b.row] += share * b.broken
    return Hierarchy(hierarchy.A, lower, upper, hierarchy.ends, hierarchy.blocks)


def only(hierarchy: Hierarchy, rows: list[int]) -> Hierarchy:
    """Return the hierarchy with every other row free."""
    lower, upper = np.full(len(hierarchy.lower), -np.inf), np.full(len(hierarchy.upper), np.inf)
    lower[rows], upper[rows] = hierarchy.lower[rows], hierarchy.upper[rows]
    return Hierarchy(hierarchy.A, lower, upper, hierarchy.ends, hierarchy.blocks)


def slack_of(hierarchy: Hierarchy, task: str, w: np.ndarray) -> float:
    return float(np.linalg.norm(next(w[b.rows] for b in hierarchy.blocks if b.name == task)))


def own_rows(hierarchy: Hierarchy, task: str) -> list[int]:
    rows = next(b.rows for b in hierarchy.blocks if b.name == task)
    return list(range(rows.start, rows.stop))


@pytest.mark.parametrize("kind", KINDS)
def test_named_bounds_that_give_way_are_enough_and_others_do_not_matter(kind) -> None:
    seen = 0
    for seed in range(12):
        h = random_hierarchy(kind, 200 + seed, n=9)
        v = solve(h).v
        for s in explain(h, v).shortfalls:
            left = slack_of(h, s.task, solve(moved(h, s)).w)
            assert abs(left - s.alone) <= 1e-9 * (s.size + np.abs(h.A).max())
            blocking = [*(b.row for b in s.blockers), *s.behind, *own_rows(h, s.task)]
            still = slack_of(h, s.task, solve(only(h, blocking)).w)
            assert still == pytest.approx(s.size, rel=1e-8)
            seen += 1
    assert (seen == 0) == (kind in ("feasible", "degenerate"))


def test_half_of_what_was_said_is_not_enough() -> None:
    """The price is the least: on the least important rows that must give way, |broken| is least."""
    for seed in range(8):
        h = random_hierarchy("infeasible", 300 + seed, n=9)
        for s in explain(h, solve(h).v).shortfalls:
            if len({b.level for b in s.breaking}) == 1 and not s.alone:
                assert slack_of(h, s.task, solve(moved(h, s, 0.5)).w) > 1e-3 * s.size


def test_shares_are_what_a_little_relaxation_gains() -> None:
    """Moving all named bounds by a share e removes e of the shortfall; each its own part of it."""
    wall = block("wall", np.eye(2), np.full(2, -np.inf), np.array([1.0, 0.5]))
    task = equalities("task", np.array([[1.0, 2.0]]), np.array([4.0]))
    h = Hierarchy.stack([[wall], [task]], 2)
    s = explain(h, solve(h).v).of("task")
    assert s.size == pytest.approx(2.0)
    assert sum(b.share for b in s.blockers) == pytest.approx(1.0)
    assert {b.name: b.broken for b in s.breaking} == pytest.approx(
        {"wall/wall0": 0.4, "wall/wall1": 0.8}
    )
    for b in s.breaking:
        upper = h.upper.copy()
        upper[b.row] += 1e-6 * b.broken
        eased = Hierarchy(h.A, h.lower, upper, h.ends, h.blocks)
        gain = s.size - slack_of(h, "task", solve(eased).w)
        assert gain / 1e-6 == pytest.approx(b.share * s.size, rel=1e-4)


def test_the_less_important_row_gives_way_first() -> None:
    first = block("first", np.array([[1.0, 0.0]]), np.array([-1.0]), np.array([1.0]))
    second = block("second", np.array([[0.0, 1.0]]), np.array([-1.0]), np.array([1.0]))
    task = equalities("task", np.array([[1.0, 1.0]]), np.array([5.0]))
    h = Hierarchy.stack([[first], [second], [task]], 2)
    s = explain(h, solve(h).v).of("task")
    assert [(b.name, b.broken) for b in s.breaking] == [("second/second0", pytest.approx(3.0))]
    assert {b.name for b in s.blockers} == {"first/first0", "second/second0"}
    assert "while first holds" in str(s)


def test_tasks_of_one_level_block_each_other() -> None:
    here = equalities("here", np.array([[1.0]]), np.array([0.0]))
    there = equalities("there", np.array([[1.0]]), np.array([1.0]))
    h = Hierarchy.stack([[here, there]], 1)
    said = explain(h, solve(h).v)
    assert [s.task for s in said.shortfalls] == ["here", "there"]
    assert [b.broken for b in said.of("here").breaking] == [pytest.approx(-1.0)]
    assert said.of("there").breaking[0].name == "here/here0"


def test_what_no_motion_can_meet_is_told_apart() -> None:
    twice = equalities(
        "twice", np.array([[1.0, 0.0], [1.0, 0.0], [0.0, 0.0]]), np.array([0.0, 2.0, 1.0])
    )
    h = Hierarchy.stack([[twice]], 2)
    s = explain(h, solve(h).v).of("twice")
    assert s.alone == pytest.approx(s.size)
    assert not s.blockers
    assert "no motion" in str(s)


def test_the_sentence_has_the_units_that_a_person_knows() -> None:
    limit = block("limits", np.array([[1.0, 0.0]]), np.array([-1.0]), np.array([0.2]), "rad/s")
    near = block("near", np.array([[0.0, -1.0]]), np.array([-0.1]), np.array([np.inf]))
    palm = equalities("left palm", np.array([[0.5, 1.0]]), np.array([0.52]))
    h = Hierarchy.stack([[limit], [near], [palm]], 2)
    words = (
        RowDescription.both("the limit of LARM_JOINT3", "rad/s", 5.0),
        RowDescription.both("the distance left forearm - desk", "m/s", 4.0),
        RowDescription.both("left palm", "m/s", 10.0),
    )
    text = str(explain(h, solve(h).v, words))
    assert text == (
        "left palm is 3.2 cm short: blocked by the distance left forearm - desk (3.2 cm), "
        "while limits holds."
    )
    details = explain(h, solve(h).v, words).details()
    assert "would have to give 32 cm/s (8.0 cm)" in details
    assert "left palm is 32 cm/s short" in str(
        explain(h, solve(h).v, (*words[:2], RowDescription.both("left palm", "m/s")))
    )


def test_a_blocker_of_next_to_nothing_is_not_named() -> None:
    """Shares go with the squares of what the rows pull with: here 1 to 0.0025."""
    walls = [
        block(name, row[None], np.array([-np.inf]), np.array([1.0]))
        for name, row in zip(("wall", "veil"), np.eye(2), strict=True)
    ]
    task = equalities("task", np.array([[1.0, 0.05]]), np.array([4.0]))
    h = Hierarchy.stack([walls, [task]], 2)
    s = explain(h, solve(h).v).of("task")
    assert dict(s.shares) == pytest.approx(
        {"wall/wall0": 1 / 1.0025, "veil/veil0": 0.0025 / 1.0025}
    )
    assert "blocked by wall/wall0 (" in str(s)
    assert "veil" not in str(s)
    assert "veil" in s.details()


def test_if_all_blockers_are_small_the_largest_are_named_with_their_shares() -> None:
    def blocker(i: int, share: float) -> Blocker:
        words = RowDescription.both(f"bound {i}", "m/s")
        return Blocker(i, f"wall/{i}", 0, words, share, share, 1.0, 0.0)

    own = tuple(
        (RowDescription.both(phrase, "m/s"), 0.5) for phrase in ("x", "y")
    )  # told in per cent
    shares = [0.004] * 250
    many = Shortfall("task", 1, own, tuple(blocker(*of) for of in enumerate(shares)), (), 0.0)
    assert "by bound 0 (0.4%), by bound 1 (0.4%)" in str(many)
    assert "246 more" in str(many)
    some = (blocker(250, 0.5), blocker(251, 0.496), blocker(252, 0.004))
    few = Shortfall("task", 1, own, some, (), 0.0)
    assert str(few).endswith("blocked by bound 250 (50%) and by bound 251 (50%).")


def test_met_tasks_are_said_to_be_met() -> None:
    h = random_hierarchy("feasible", 1)
    solution = solve(h)
    assert str(explain(h, solution.v)) == "Every task is met."
    assert str(explain(h, solution.v, tasks=["l0"])) == "l0 is met."


def test_an_answer_that_is_no_optimum_is_not_explained_away() -> None:
    h = random_hierarchy("infeasible", 60, n=15)
    v = solve(h).v
    assert explain(h, v).optimal
    assert "not the optimum" in str(explain(h, v + 0.1))


def test_nonsense_is_refused_by_name() -> None:
    h = random_hierarchy("infeasible", 60, n=15)
    with pytest.raises(NonFiniteError, match="no answer to explain"):
        explain(h, np.full(h.n, np.nan))
    with pytest.raises(NameNotFoundError, match="Known: l0, l1"):
        explain(h, np.zeros(h.n), tasks=["L1"])


def test_the_explanation_is_the_same_in_other_units() -> None:
    """Who blocks, and with which share, does not depend on the unit of all speeds."""
    h = random_hierarchy("infeasible", 77, n=10)
    c = 2.0**-12
    scaled = Hierarchy(h.A, h.lower * c, h.upper * c, h.ends, h.blocks)
    one, other = explain(h, solve(h).v), explain(scaled, solve(scaled).v)
    for a, b in zip(one.shortfalls, other.shortfalls, strict=True):
        assert [x.row for x in a.blockers] == [x.row for x in b.blockers]
        assert np.allclose([x.share for x in a.blockers], [x.share for x in b.blockers])
