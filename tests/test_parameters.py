"""No function asks for more than a person can keep apart: eight parameters, a kernel's twelve."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import equipoise

ROOT = Path(equipoise.__file__).parent
MOST, MOST_OF_ENTRANCE = 8, 12
KERNELS = {"compiled", "inlined"}  # called by kernels alone, which have no objects to pass


def functions(node: ast.AST, prefix: str) -> Iterator[tuple[str, ast.FunctionDef]]:
    """Yield every function below a node, named by where it stands."""
    for child in ast.iter_child_nodes(node):
        name = f"{prefix}.{getattr(child, 'name', '')}".rstrip(".")
        if isinstance(child, ast.FunctionDef):
            yield name, child
        yield from functions(child, name)


def parameters_of(function: ast.FunctionDef) -> int:
    """Return how many parameters a caller thinks about: all but `self` and `cls`."""
    given = function.args
    named = [a.arg for a in (*given.posonlyargs, *given.args, *given.kwonlyargs)]
    bound = named[:1] in (["self"], ["cls"])
    return len(named) - bound + (given.vararg is not None) + (given.kwarg is not None)


def templates(tree: ast.AST) -> set[str]:
    """Return the functions that become entrances by `specialised`."""
    return {
        call.args[0].id
        for call in ast.walk(tree)
        if isinstance(call, ast.Call) and getattr(call.func, "id", "") == "specialised"
    }


def limit_of(function: ast.FunctionDef, entrances: set[str]) -> float:
    marks = {mark.id for mark in function.decorator_list if isinstance(mark, ast.Name)}
    if marks & KERNELS:
        return float("inf")
    is_entrance = "entrance" in marks or function.name in entrances
    return MOST_OF_ENTRANCE if is_entrance else MOST


def found_above() -> dict[str, int]:
    above = {}
    for path in ROOT.rglob("*.py"):
        module = ".".join(path.relative_to(ROOT).with_suffix("").parts)
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for name, function in functions(tree, module):
            if parameters_of(function) > limit_of(function, templates(tree)):
                above[name] = parameters_of(function)
    return above


def test_no_function_has_more_parameters_than_allowed():
    assert not found_above(), "group these parameters"


def test_parameters_are_counted_as_a_caller_does():
    tree = ast.parse("class A:\n    def f(self, a, /, b, *c, d, **e): ...\ndef g(a): ...")
    counts = {name: parameters_of(function) for name, function in functions(tree, "m")}
    assert counts == {"m.A.f": 5, "m.g": 1}
