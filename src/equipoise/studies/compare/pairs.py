"""Rows of a study brought side by side: the same point and the same noise, one controller each."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from equipoise.spatial import Array
from equipoise.studies.results import Results

SAMPLED = ("sobol", "latin_hypercube")


def paired_rows(results: Results, designs: Sequence[str]) -> dict[str, Array]:
    """Return by controller the rows (n,) of the points that all have run, in the same order."""
    key_columns = list(zip(results["design"], results["point"], results["repeat"], strict=True))
    wanted = np.isin(results["design"].astype(str), list(designs))
    places: dict[str, dict[tuple[str, int, int], int]] = {}
    for name in results.controllers:
        rows = np.flatnonzero(wanted & (results["controller"] == name))
        places[name] = {key_columns[k]: int(k) for k in rows}
    if not places:
        return {}
    common = sorted(set.intersection(*(set(found) for found in places.values())))
    return {
        name: np.array([found[key] for key in common], dtype=int) for name, found in places.items()
    }


def sampled_rows(results: Results) -> dict[str, Array]:
    """Return by controller the rows (n,) of all points that fill the space of the parameters."""
    return paired_rows(results, results.designs(SAMPLED))
