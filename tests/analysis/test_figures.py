"""The figures of a run: there, not blank, and no crash where something is missing."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from figure_runs import made_run, tray_places
from matplotlib.image import imread

from equipoise.analysis.figures.balance import balance_figure, inset
from equipoise.analysis.figures.distance import curves_of, distances_figure
from equipoise.analysis.figures.error import errors_figure, regulated_rows
from equipoise.analysis.figures.joints import joints_figure, torques_figure
from equipoise.analysis.figures.make import make_figures
from equipoise.analysis.joint_groups import joint_groups_of
from equipoise.analysis.run_context import RunContext
from equipoise.contacts import SupportPolygon
from equipoise.errors import RunLogError

ALL = {"joints", "errors", "torques", "distances", "balance", "snapshots"}


MAKERS = {
    "joints": joints_figure,
    "errors": errors_figure,
    "torques": torques_figure,
    "distances": distances_figure,
    "balance": balance_figure,
}


def names(paths) -> set[str]:
    assert all(path.is_file() and path.suffix == ".png" for path in paths)
    return {path.stem for path in paths}


def test_every_figure_is_written_and_shows_something(tmp_path):
    paths = make_figures(made_run(400), tmp_path / "figures")
    assert names(paths) == ALL
    for path in paths:
        image = imread(path)
        colours = np.unique((image[:, :, :3] * 100.0).astype(int) @ [1, 1000, 1000000])
        assert len(colours) > 100, path.name
        assert (image[:, :, :3].min(axis=2) < 0.9).mean() > 0.02, path.name


def test_a_run_of_one_tick_has_figures_too(tmp_path):
    assert names(make_figures(made_run(1), tmp_path)) == ALL


@pytest.mark.parametrize("scale", [1.0, 1e-4, 10.0])
def test_nothing_leaves_the_figure_or_meets_what_is_beside_it(scale):
    """Margins are known beforehand, whatever the numbers at the axes."""
    run = made_run(500)
    arrays = {name: scale * values for name, values in run.arrays.items()}
    arrays["q"] = run["q"]
    context = RunContext.of(replace(run, arrays=arrays), tray_places())
    for make in MAKERS.values():
        figure = make(context)
        figure.canvas.draw()
        page = figure.bbox
        boxes = [axes.get_tightbbox() for axes in figure.axes]
        boxes.append(figure._suptitle.get_window_extent())
        for k, box in enumerate(boxes):
            assert page.x0 <= box.x0, make.__name__
            assert page.y0 <= box.y0, make.__name__
            assert box.x1 <= page.x1, make.__name__
            assert box.y1 <= page.y1, make.__name__
            for other in boxes[:k]:
                shared = type(box).intersection(box, other)
                assert shared is None or min(shared.width, shared.height) < 1.0, make.__name__


def test_a_run_without_ticks_has_none(tmp_path):
    assert make_figures(made_run(0), tmp_path) == []


def drawn(run) -> set[str]:
    """Return the names of the figures that would be written."""
    context = RunContext.of(run)
    kept = {name for name, make in MAKERS.items() if make(context) is not None}
    return kept | ({"snapshots"} if context.drawable else set())


def test_figures_without_their_channels_are_left_out():
    run = made_run(2, without=("tau", "distance", "q", "q_ref", "v"))
    assert drawn(run) == {"errors", "balance"}
    bare = ("com", "com_margin", "margin/left_sole", "margin/right_sole", "dq", "lam/grasp")
    run = made_run(2, without=(*bare, "lam_ref/grasp", "error/left_hand", "error/right_hand"))
    assert drawn(run) == ALL - {"errors", "balance"}
    assert drawn(made_run(2, without=("q_ref", "v_ref", "lam_ref/grasp", "com"))) == ALL


def test_a_scenario_that_cannot_be_read_costs_only_what_needs_it():
    run = made_run(2, scenario="name: 3\n")
    assert drawn(run) == {"joints", "errors", "distances", "balance"}


def test_numbers_that_are_not_finite_are_no_reason_to_crash(tmp_path):
    run = made_run(60)
    for array in run.arrays.values():
        array[40:] = np.nan
    run.arrays["margin/left_sole"][10, 2] = -np.inf
    run.arrays["tau"][12] = np.inf
    assert names(make_figures(run, tmp_path)) == ALL


def test_a_folder_that_cannot_be_made_is_refused(tmp_path):
    (tmp_path / "taken").write_text("a file")
    with pytest.raises(RunLogError, match="taken"):
        make_figures(made_run(1), tmp_path / "taken")


def test_importing_the_figures_does_not_import_matplotlib():
    code = (
        "import sys, equipoise, equipoise.analysis.figures.make;"
        "import equipoise.analysis.figures.snapshots;"
        "print('matplotlib' in sys.modules)"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "False"


def test_limbs_hold_every_joint_once_and_know_their_side(hrp2):
    joint_groups = joint_groups_of(hrp2, hrp2.joint_names)
    titles = ["Left leg", "Right leg", "Torso and head", "Left arm", "Right arm"]
    assert sorted(limb.title for limb in joint_groups) == sorted(titles)
    assert sorted(j for limb in joint_groups for j in limb.joints) == list(range(hrp2.na))
    for limb in joint_groups:
        prefix = {"Left leg": "LLEG", "Right leg": "RLEG", "Left arm": "LARM", "Right arm": "RARM"}
        for joint in limb.joints:
            assert hrp2.joint_names[joint].startswith(prefix.get(limb.title, ("CHEST", "HEAD")))
    assert joint_groups[0].short_names(hrp2.joint_names)[0] == "JOINT0"


def test_limbs_without_a_robot_are_cut_to_a_readable_size():
    made = (*(f"arm_{i}" for i in range(19)), "head_1")
    joint_groups = joint_groups_of(None, made)
    assert sorted(j for limb in joint_groups for j in limb.joints) == list(range(20))
    assert max(len(limb.joints) for limb in joint_groups) <= 8
    assert joint_groups[-1].short_names(made) == ["head_1"]


def test_joint_curves_carry_the_run_and_its_reference():
    run = made_run(100)
    figure = joints_figure(RunContext.of(run))
    lines = [line.get_ydata() for axes in figure.axes for line in axes.lines]
    curves = {tuple(part[:100]) for y in lines for part in np.split(y, range(101, len(y), 101))}
    for name, skip in (("q", 7), ("q_ref", 7), ("v", 6), ("v_ref", 6)):
        for column in run[name][:, skip:].T:
            assert tuple(column) in curves


def test_torques_are_shares_of_the_limits():
    run = made_run(100)
    limit = tray_places().robot.tau_max
    run.arrays["tau"][:] = 0.2 * limit
    run.arrays["tau"][70, 3] = -0.9 * limit[3]
    figure = torques_figure(RunContext.of(run))
    assert "90 %, HEAD_JOINT1 at 0.07 s" in figure.get_suptitle()
    labels = [text.get_text() for axes in figure.axes for text in axes.texts]
    assert "HEAD_JOINT1: \N{MINUS SIGN}90 %" in labels


def test_force_error_is_achieved_minus_wanted():
    run = made_run(50)
    (row,) = regulated_rows(RunContext.of(run))
    assert row[0] == "grasp fz"
    np.testing.assert_array_equal(row[1], run["lam_ref/grasp"][:, 0])
    np.testing.assert_array_equal(row[2], run["lam/grasp"][:, 2])
    figure = errors_figure(RunContext.of(run))
    curves = [line.get_ydata() for axes in figure.axes for line in axes.lines]
    error = run["lam/grasp"][:, 2] - run["lam_ref/grasp"][:, 0]
    assert any(len(y) == 50 and np.array_equal(y, error) for y in curves)


def test_palm_errors_are_in_millimetres_and_degrees():
    run = made_run(50)
    run.arrays["error/left_hand"][:] = [0.003, 0.0, 0.004, 0.0, np.pi / 6.0, 0.0]
    figure = errors_figure(RunContext.of(run))
    shown = {
        axes.get_ylabel(): line.get_ydata()
        for axes in figure.axes
        for line in axes.lines
        if line.get_label() == "left hand"
    }
    np.testing.assert_allclose(shown["position error [mm]"], 5.0)
    np.testing.assert_allclose(shown["orientation error [deg]"], 30.0)


def test_equal_distances_become_one_curve_the_closest_first():
    t = np.linspace(0.0, 1.0, 50)
    distances = np.column_stack([0.3 + t, 0.1 + t, 0.1 + t + 5e-4, 0.1 + 1.1 * t])
    curves = curves_of(("a - z", "left - desk", "right - desk", "b - z"), distances)
    assert [c.label for c in curves] == ["left, right - desk", "b - z", "a - z"]
    assert curves[0].least == pytest.approx(0.1)


def test_distance_figure_names_the_smallest_and_draws_the_security_distance():
    run = made_run(50)
    run.arrays["distance"][:] = 0.2
    run.arrays["distance"][30, 1] = 0.0123
    figure = distances_figure(RunContext.of(run))
    assert "12.300 mm, LARM_LINK5 - desk at 0.03 s" in figure.get_suptitle()
    (axes,) = figure.axes
    flat = [line.get_ydata()[0] for line in axes.lines if len(line.get_ydata()) == 2]
    assert 15.0 in flat


def test_inset_polygon_keeps_its_margin():
    corners = np.array([[0.0, 0.0], [0.4, 0.0], [0.5, 0.2], [0.2, 0.4], [0.0, 0.3]])
    polygon = SupportPolygon.of_points(corners)
    inner = inset(polygon, 0.05)
    assert [polygon.margin(corner) for corner in inner] == pytest.approx([0.05] * len(inner))
    assert inset(polygon, 0.3) is None


def test_balance_shows_the_path_and_every_margin():
    run = made_run(50)
    run.arrays["com"][:, :2] = np.column_stack([np.linspace(0.0, 0.1, 50), np.zeros(50)])
    figure = balance_figure(RunContext.of(run))
    every = [axes for axes in figure.findobj(lambda a: hasattr(a, "get_xlabel"))]
    paths = [line.get_xydata() for axes in every for line in axes.lines]
    assert any(len(p) == 50 and np.array_equal(p, run["com"][:, :2]) for p in paths)
    pressure = 1e3 * run["margin/right_sole"][:, 2]
    assert any(len(p) == 50 and np.array_equal(p[:, 1], pressure) for p in paths)
