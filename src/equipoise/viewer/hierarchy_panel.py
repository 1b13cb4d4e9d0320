"""The hierarchy as a table: each level's slack, each task's error in its unit, met or short."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np
import viser

from equipoise.spatial import Array
from equipoise.tasks import Task
from equipoise.viewer.layer import Moment

MET = {"m": 1e-3, "rad": 1e-3}  # an error below counts as met; said in the panel
SLACK_MET = 1e-6
_SHOWN = {"m": (1e3, "mm"), "rad": (1e3, "mrad")}


class HierarchyPanel:
    """An HTML table that is written anew for each moment it is shown."""

    def __init__(self, gui: viser.GuiApi, levels: Sequence[Sequence[Task]]) -> None:
        self._levels = levels
        self._html = gui.add_html("")
        gui.add_markdown(
            f"*Slack is |w| of the level's rows (velocities), short above {SLACK_MET:g}. "
            "A task's error is its largest component, short above 1 mm or 1 mrad.*"
        )

    def show(self, moment: Moment) -> None:
        """Write the table of that moment."""
        slack = moment.values.get("slack")
        rows = []
        for i, level in enumerate(self._levels):
            rows.append(_level_row(i, slack))
            rows += [_task_row(task, moment) for task in level]
        self._html.content = _PAGE.format(rows="".join(rows))


def worst_error(task: Task, moment: Moment) -> tuple[float, str, str]:
    """Return the task's largest error by what counts as met, its unit and its component's name."""
    error = np.abs(np.asarray(task.error(moment.kin, moment.t), dtype=float))
    if not error.size:
        return 0.0, "", ""
    worst = int(np.argmax(error / np.array([MET.get(unit, 1.0) for unit in task.units])))
    return float(error[worst]), task.units[worst], task.labels[worst]


def _level_row(index: int, slack: Array | None) -> str:
    if slack is None or index >= len(slack):
        return f'<tr class="level"><td>Level {index}</td><td></td><td></td></tr>'
    value = float(slack[index])
    return (
        f'<tr class="level"><td>Level {index}</td><td>slack {value:.1e}</td>'
        f"<td>{_mark(value <= SLACK_MET)}</td></tr>"
    )


def _task_row(task: Task, moment: Moment) -> str:
    value, unit, label = worst_error(task, moment)
    scale, shown = _SHOWN.get(unit, (1.0, unit))
    met = value <= MET.get(unit, 0.0)
    where = f' <span class="where">{escape(label)}</span>' if not met else ""
    return (
        f"<tr><td>{escape(task.name)}{where}</td><td>{_short(value * scale)} {escape(shown)}</td>"
        f"<td>{_mark(met)}</td></tr>"
    )


def _short(value: float) -> str:
    return f"{value:.3g}" if value >= 1e-3 else "&lt; 0.001"


def _mark(met: bool) -> str:
    return '<span class="met">met</span>' if met else '<span class="short">short</span>'


_PAGE = """<style>
.hierarchy {{ width: 100%; border-collapse: collapse; font-size: 0.8em; margin: 0 0.6em; }}
.hierarchy td {{ padding: 0.12em 0.3em; }} .hierarchy td:nth-child(2) {{ text-align: right; }}
.hierarchy .level td {{ font-weight: 700; border-top: 1px solid #ccc; }}
.hierarchy .met {{ color: #1a7f37; }} .hierarchy .short {{ color: #b00020; font-weight: 700; }}
.hierarchy .where {{ color: #888; font-size: 0.85em; }}
</style><table class="hierarchy" id="equipoise-hierarchy">{rows}</table>"""
