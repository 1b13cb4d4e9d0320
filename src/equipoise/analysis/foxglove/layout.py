"""A layout for Foxglove: the robot beside plots of what this run logged, each curve by its name."""

from __future__ import annotations

import json
from typing import Any

from equipoise.analysis.foxglove.pictures import FORCES, SCENE
from equipoise.runlog import Run
from equipoise.runlog.field_names import field_names
from equipoise.runlog.layout import TOPIC, make_layout

MOST_CURVES = 12  # in one plot
PLOTTED = ("lam", "lam_ref", "error", "distance", "tau", "com_margin")  # kinds of channels


def layout_text(run: Run) -> str:
    """Return the layout of a run as JSON, for Foxglove's "import from file"."""
    panels: dict[str, dict[str, Any]] = {"3D!equipoise": _scene()}
    plots = []
    for kind, paths in _curves(run).items():
        name = f"Plot!{kind}"
        panels[name] = {
            "paths": [
                {"value": path, "enabled": True, "timestampMethod": "receiveTime", "label": label}
                for label, path in paths
            ],
            "showXAxisLabels": True,
            "showYAxisLabels": True,
            "showLegend": True,
            "legendDisplay": "floating",
            "isSynced": True,
            "xAxisVal": "timestamp",
            "foxglovePanelTitle": kind,
        }
        plots.append(name)
    layout: Any = "3D!equipoise"
    if plots:
        column = _column(plots)
        layout = {"direction": "row", "first": layout, "second": column, "splitPercentage": 60}
    return json.dumps(
        {
            "configById": panels,
            "globalVariables": {},
            "userNodes": {},
            "playbackConfig": {"speed": 1},
            "layout": layout,
        },
        indent=1,
    )


def _scene() -> dict[str, Any]:
    return {
        "followTf": "world",
        "followMode": "follow-none",
        "cameraState": {
            "perspective": True,
            "distance": 3.0,
            "phi": 70.0,
            "thetaOffset": 55.0,
            "target": [0.1, 0.0, 0.7],
            "targetOffset": [0.0, 0.0, 0.0],
            "targetOrientation": [0, 0, 0, 1],
            "fovy": 45,
            "near": 0.05,
            "far": 100,
        },
        "scene": {"transforms": {"showLabel": False, "axisScale": 0, "lineWidth": 0}},
        "topics": {SCENE: {"visible": True}, FORCES: {"visible": True}},
        "layers": {
            "floor": {
                "layerId": "foxglove.Grid",
                "instanceId": "floor",
                "label": "Floor",
                "frameId": "world",
                "size": 4,
                "divisions": 16,
                "lineWidth": 1,
                "color": "#8c8c8caa",
                "visible": True,
                "order": 1,
            }
        },
        "foxglovePanelTitle": "Robot",
    }


def _curves(run: Run) -> dict[str, list[tuple[str, str]]]:
    """Return for each kind of channel (label, message path) of its first curves."""
    fields = dict(zip(run.channels, make_layout(tuple(run.channels.values())).fields, strict=True))
    curves: dict[str, list[tuple[str, str]]] = {}
    for name, channel in run.channels.items():
        kind = name.partition("/")[0]
        if kind not in PLOTTED:
            continue
        for label, field in zip(channel.labels, field_names(channel.labels), strict=True):
            curves.setdefault(kind, []).append(
                (f"{name} {label}", f"{TOPIC}.{fields[name]}.{field}")
            )
    return {kind: curves[kind][:MOST_CURVES] for kind in PLOTTED if kind in curves}


def _column(panels: list[str]) -> Any:
    """Return panels above each other, as high each."""
    if len(panels) == 1:
        return panels[0]
    return {
        "direction": "column",
        "first": panels[0],
        "second": _column(panels[1:]),
        "splitPercentage": 100.0 / len(panels),
    }
