"""The documentation is code that ran: blocks, commands, links, tables."""

from __future__ import annotations

import importlib.util
import pkgutil
import re
import shlex
import subprocess
import sys

import click
import pytest

import equipoise
from doc_pages import (
    PAGES,
    ROOT,
    anchors,
    blocks,
    commands,
    inline_codes,
    links,
    name_of,
    table_after,
)
from equipoise.cli import cli
from equipoise.scenarios import named_scenarios, parse_scenario, read_scenario

EVERY_PAGE = pytest.mark.parametrize("page", PAGES, ids=name_of)
WITH_PYTHON = [page for page in PAGES if blocks(page, "python")]


@pytest.mark.parametrize("page", WITH_PYTHON, ids=name_of)
def test_python_blocks_run(page, tmp_path, monkeypatch):
    """The blocks of a page run one after the other, in one namespace and an empty folder."""
    monkeypatch.chdir(tmp_path)
    namespace = {"__name__": "__main__"}
    for block in blocks(page, "python"):
        if not block.reason:
            padded = "\n" * (block.line - 1) + block.text  # errors show the line of the page
            exec(compile(padded, str(page), "exec"), namespace)


@EVERY_PAGE
def test_blocks_have_a_known_language(page):
    """So that no block escapes the tests by a misspelt language."""
    known = {"", "python", "sh", "console", "yaml", "text", "json", "math", "xml"}
    text = page.read_text(encoding="utf-8")
    opened = re.findall(r"^```([^\n]*)\n", text, re.MULTILINE)[::2]
    assert {kind for kind in opened if not kind.startswith("{")} <= known


@EVERY_PAGE
def test_scenarios_in_yaml_blocks_are_valid(page):
    for block in blocks(page, "yaml"):
        if "# not a scenario" not in block.text and not block.reason:
            parse_scenario(block.text, text_of=lambda n: named_scenarios()[n].read_text())


@EVERY_PAGE
def test_commands_exist(page):
    """Every `equipoise ...` line parses, and what it names is there."""
    for line in commands(page, "equipoise"):
        name, *arguments = shlex.split(line)[1:]
        if name.startswith("-"):
            cli.make_parser(click.Context(cli)).parse_args([name])
            continue
        command = cli.get_command(click.Context(cli), name)
        assert command is not None, f"{line}: there is no such command"
        filled = [_filled(argument) for argument in arguments]
        given = command.make_context(name, filled, resilient_parsing=bool(arguments) is False)
        if name == "run":
            _check_run(line, given.params)


def _filled(argument: str) -> str:
    """Return a value for a placeholder in capitals, as usage lines have them."""
    return "tray" if argument == "SCENARIO" else argument


def _check_run(line: str, params: dict) -> None:
    scenario = params.get("scenario")
    if scenario in named_scenarios():
        read_scenario(scenario, params["single"])
    elif scenario is not None:
        assert scenario.endswith(".yaml"), f"{line}: there is no such scenario"


@EVERY_PAGE
def test_make_targets_exist(page):
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for line in commands(page, "make"):
        target = line.split()[1]
        assert re.search(rf"^{re.escape(target)}:", makefile, re.MULTILINE), line


@EVERY_PAGE
def test_links_lead_somewhere(page):
    for target in links(page):
        path, _, anchor = target.partition("#")
        goal = (page.parent / path).resolve() if path else page
        assert goal.exists(), f"{target}: there is no such file"
        assert ROOT in (goal, *goal.parents), f"{target} leads out of the checkout"
        if anchor:
            assert anchor in anchors(goal), f"{target}: there is no such heading"


@EVERY_PAGE
def test_files_that_are_named_exist(page):
    folders = ("src/", "docs/", "examples/", "tests/", "tools/", "benchmarks/")
    for code in inline_codes(page):
        if code.startswith(folders) and " " not in code and "*" not in code:
            assert (ROOT / code).exists(), f"{code}: there is no such file"


@EVERY_PAGE
def test_measured_blocks_are_filled(page):
    text = page.read_text(encoding="utf-8")
    for name in re.findall(r"<!-- measured:(\w+) -->", text):
        inside = text.split(f"<!-- measured:{name} -->")[1].split(f"<!-- /measured:{name} -->")[0]
        assert inside.count("|") > 10, f"run docs/measure.py: {name} is empty"


def test_generated_tables_are_current():
    spec = importlib.util.spec_from_file_location("keys", ROOT / "docs" / "generate_keys.py")
    keys = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(keys)
    assert keys.TARGET.read_text(encoding="utf-8") == keys.tables(), (
        "docs/scenario_keys.md is old: run python docs/generate_keys.py"
    )


def test_the_table_of_channels_is_what_a_run_logs(tmp_path):
    run = equipoise.run_scenario(
        "tray", out=tmp_path / "run", overrides=["duration=0.002"], figures=False
    )
    rows = table_after(ROOT / "docs" / "runs.md", "channels:")
    named = [name for row in rows for name in re.findall(r"`([^`]+)`", row[0])]
    assert sorted(named) == sorted(run.names)


def test_the_architecture_page_names_every_room():
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    for path in (ROOT / "src" / "equipoise").iterdir():
        if path.suffix in ("", ".py") and not path.name.startswith("_"):
            assert f"`{path.stem}`" in text, f"docs/architecture.md does not name {path.stem}"


def test_the_readme_s_examples_are_short():
    examples = blocks(ROOT / "README.md", "python")
    assert len(examples) == 3
    for example in examples:
        lines = [line for line in example.text.splitlines() if line.strip()]
        assert len([one for one in lines if not one.startswith(("import", "from"))]) <= 12


def test_formulas_are_those_that_the_site_can_write():
    """The site writes them as MathML, so that no page asks a network for anything."""
    convert = pytest.importorskip("latex2mathml.converter").convert
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        found = [block.text for block in blocks(page, "math")]
        found += re.findall(
            r"(?<![\\$`])\$([^$\n`]+)\$", re.sub(r"```.*?```", "", text, flags=re.S)
        )
        for formula in found:
            assert convert(formula).startswith("<math")


def test_what_the_api_page_lists_exists():
    """Without Sphinx, so that a renamed class is noticed by every run of the tests."""
    text = (ROOT / "docs" / "api.md").read_text(encoding="utf-8")
    pattern = r"^\.\. auto\w+:: ([\w.]+)\n(?:   :members: (.+)\n)?"
    listed = re.findall(pattern, text, re.MULTILINE)
    assert len(listed) > 30
    for name, members in listed:
        found = pkgutil.resolve_name(name)
        for member in filter(None, members.split(", ")):
            known = {*dir(found), *getattr(found, "__annotations__", {})}
            assert member in known, f"{name} has no {member}"


@pytest.mark.slow
def test_the_site_builds_without_a_warning(tmp_path):
    for package in ("sphinx", "myst_parser", "furo"):
        pytest.importorskip(package)
    done = subprocess.run(
        [
            *(sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html"),
            *("-d", tmp_path / "trees", ROOT / "docs", tmp_path / "html"),
        ],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    loaded = r"""<(?:script|link|img|iframe)[^>]*(?:src|href)=["'](?:https?:)?//"""
    for page in (tmp_path / "html").rglob("*.html"):
        assert not re.search(loaded, page.read_text(encoding="utf-8")), page.name
