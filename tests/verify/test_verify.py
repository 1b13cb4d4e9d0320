"""The table of certificates: rows for everything, honest verdicts, exit codes, JSON."""

from __future__ import annotations

import json
import re
from pathlib import Path
from pkgutil import resolve_name

import pytest
from click.testing import CliRunner
from verify_mutations import MUTATIONS

import equipoise
from equipoise.cli import cli
from equipoise.errors import NameNotFoundError
from equipoise.verify import GROUPS, Check, Measured, verify
from equipoise.verify.table import as_text

KEYS = " ".join(check.key for group in GROUPS.values() for check in group)


def test_every_equation_has_a_row():
    missing = set(range(1, 30)) - {int(n) for n in re.findall(r"\((\d+)\)", KEYS)}
    assert not missing


@pytest.mark.parametrize(
    "claim",
    ["skew", "redundancy", "base wrench", "model-free", "boundedness", "passivity", "sliding",
     "reaching", "delta < k", "posture promise", "force promise", "continuity"],
)  # fmt: skip
def test_every_claim_has_a_row(claim):
    assert claim in KEYS


@pytest.mark.parametrize(
    "check", [c for group in GROUPS.values() for c in group], ids=lambda c: c.key
)
def test_the_code_that_a_row_names_exists(check):
    for name in check.code.split(", "):
        if "*" not in name and not name.startswith("."):
            assert resolve_name(f"equipoise.{name}") is not None


@pytest.mark.slow
@pytest.mark.parametrize("group", GROUPS)
def test_all_rows_hold(group):
    verdicts = verify([group])
    assert {v.check.key: v.measured for v in verdicts if not v.holds} == {}


def row(residual: float) -> Check:
    return Check("(0)", "a claim", "nowhere", 1.0, "m", lambda evidence: Measured(residual))


@pytest.mark.parametrize(
    ("residual", "holds"),
    [(0.5, True), (1.0, True), (1.1, False), (float("nan"), False), (float("inf"), False)],
)
def test_a_row_holds_only_for_a_number_within_tolerance(residual, holds):
    assert row(residual).judge(None).holds is holds


def test_an_error_on_the_way_is_a_row_that_fails_and_says_why():
    def broken(evidence):
        raise ZeroDivisionError("nothing to divide")

    verdict = Check("(0)", "a claim", "nowhere", 1.0, "", broken).judge(None)
    assert not verdict.holds
    assert "nothing to divide" in verdict.measured.note
    document = json.loads(as_text([verdict]))
    assert document["holds"] is False
    assert document["rows"][0]["residual"] is None


def test_the_command_prints_json_and_exits_with_the_verdict(monkeypatch):
    for residual, code in ((0.5, 0), (2.0, 1)):
        monkeypatch.setitem(GROUPS, "geometry", (row(residual),))
        done = CliRunner().invoke(cli, ["verify", "--json", "geometry"])
        assert done.exit_code == code
        assert json.loads(done.stdout)["rows"][0]["tolerance"] == 1.0


def test_an_unknown_group_is_refused_by_name():
    with pytest.raises(NameNotFoundError, match="geometry"):
        verify(["geomtry"])


@pytest.mark.parametrize("mutation", MUTATIONS, ids=lambda m: m.equation)
def test_each_mutation_still_finds_its_place(mutation):
    """The list of mutations stays alive: its text is in the code (run_verify_mutations uses it)."""
    text = (Path(equipoise.__file__).parent / mutation.file).read_text(encoding="utf-8")
    assert mutation.before in text
    assert mutation.before != mutation.after
    assert mutation.group in GROUPS
