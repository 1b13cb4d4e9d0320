"""The envelope of curves against brute force, and the line at the present time."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from viewer_logs import SPIKE, tray_places

pytest.importorskip("viser", reason="needs the extra 'viewer': pip install -e '.[viewer]'")

from equipoise.runlog import load_run
from equipoise.viewer.curves import Curve, plots_of
from equipoise.viewer.envelope import Envelope
from equipoise.viewer.longlog import LongLog
from equipoise.viewer.plot_panel import with_line, without_gaps

CURVES = [Curve(f"c{i}", lambda arrays, i=i: arrays["x"][:, i]) for i in range(3)]


def gathered(t: np.ndarray, x: np.ndarray, order: np.ndarray, stretches: int) -> Envelope:
    envelope = Envelope(CURVES, t[0], t[-1], stretches)
    pieces = np.array_split(np.arange(len(t)), 13)
    for k in order:
        envelope.add({"t": t[pieces[k]], "x": x[pieces[k]]})
    return envelope


def test_extremes_are_those_of_each_stretch_in_any_order(rng: np.random.Generator) -> None:
    t = np.linspace(2.0, 5.0, 1000)
    x = rng.normal(size=(1000, 3)).cumsum(axis=0)
    shown_t, shown = gathered(t, x, np.arange(13), 20).of([0, 1, 2])
    _, shuffled = gathered(t, x, rng.permutation(13), 20).of([0, 1, 2])
    assert np.array_equal(shown, shuffled)
    place = np.minimum(((t - 2.0) / 3.0 * 20).astype(int), 19)
    for k in range(20):
        inside = x[place == k]
        pair = shown[2 * k : 2 * k + 2]
        assert np.array_equal(pair.min(axis=0), inside.min(axis=0))
        assert np.array_equal(pair.max(axis=0), inside.max(axis=0))
        first = np.minimum(inside.argmin(axis=0), inside.argmax(axis=0))
        assert np.array_equal(pair[0], inside[first, range(3)])
    assert (np.diff(shown_t) > 0.0).all()


def test_what_is_not_finite_hides_nothing_else(rng: np.random.Generator) -> None:
    t, x = np.linspace(0.0, 1.0, 100), rng.normal(size=(100, 3))
    x[10:20, 1], x[50, 2] = np.nan, np.inf
    _, shown = gathered(t, x, np.arange(13), 100).of([0, 1, 2])
    assert np.isfinite(shown[:, 0]).all()
    assert np.isfinite(without_gaps(np.arange(len(shown)), shown)).all()


def test_a_spike_of_one_tick_is_seen_after_all_pieces(sway: Path) -> None:
    log, setup = LongLog(sway), tray_places()
    plot = plots_of(log.run.channels, setup)["Torques"]
    envelope = Envelope(plot.curves, log.t_first, log.t_last, 40)
    for _, arrays in log.pieces((8, 1)):
        envelope.add(arrays)
    _, shown = envelope.of(range(len(plot.curves)))
    wanted = 100.0 * SPIKE / setup.robot.tau_max[0]
    assert shown.max() == pytest.approx(wanted)


def test_every_plot_can_be_computed(sway: Path) -> None:
    run = load_run(sway)
    plots = plots_of(run.channels, tray_places())
    wanted = {"Posture error", "Contact forces", "Torques", "Distances", "Slack of the levels"}
    assert wanted <= set(plots)
    arrays = {"t": run.t, **run.arrays}
    for plot in plots.values():
        for curve in plot.curves:
            assert curve.compute(arrays).shape == run.t.shape


@pytest.mark.parametrize("now", [-1.0, 0.0, 0.25, 1.0, 3.0])
def test_the_line_stands_at_the_present_and_leaves_curves_alone(now: float) -> None:
    t = np.linspace(0.0, 1.0, 5)
    values = np.column_stack([2.0 * t + 1.0, -t])
    times, rows, line = with_line(t, values, now)
    assert (np.diff(times) >= 0.0).all()
    assert (times == now).sum() >= 3
    assert (line > 1.0).sum() == 1
    assert times[line.argmax()] == now
    if 0.0 <= now <= 1.0:
        assert np.allclose(rows, np.column_stack([2.0 * times + 1.0, -times]))
