"""The hierarchy as a table: how each task stands, and what a task that is short is short by.

Word and number are those of `equipoise explain` for the same moment.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

import numpy as np
import viser

from equipoise.hqp.explanation import AT_BOUND, LEFT_OVER, MET, SHORT
from equipoise.hqp.row_names import quantity
from equipoise.kinematics import Kinematics, KinematicsEvaluator
from equipoise.robots import Robot
from equipoise.spatial import Array
from equipoise.tasks import Task
from equipoise.tasks.standing import Standing, standing_of
from equipoise.trajectories import Fade
from equipoise.viewer.layer import Moment

OFF = "off"
_ORDER = (
    SHORT,
    AT_BOUND,
    LEFT_OVER,
    MET,
    OFF,
)  # what a level is called after, the first that occurs


class HierarchyPanel:
    """An HTML table that is written anew for each moment it is shown.

    `fades` are those of tasks that come and go.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        robot: Robot,
        levels: Sequence[Sequence[Task]],
        fades: Mapping[str, Fade],
    ) -> None:
        self._levels, self._fades = levels, fades
        self._evaluator = KinematicsEvaluator(robot)
        self._html = gui.add_html("")
        gui.add_markdown(
            "*Short: a task that fails its user; the number is the error that is not worked off, "
            "as in* `equipoise explain`*. At its bound: it holds, by its bound. Left over: what "
            "the lowest wish did not get.*"
        )

    def show(self, moment: Moment) -> None:
        """Write the table of that moment."""
        slack = moment.values.get("slack")
        rows = []
        for i, (level, stands) in enumerate(zip(self._levels, self.standings(moment), strict=True)):
            rows.append(_level_row(i, slack, stands))
            rows += [_task_row(task, one) for task, one in zip(level, stands, strict=True)]
        self._html.content = _PAGE.format(rows="".join(rows))

    def standings(self, moment: Moment) -> list[list[Standing]]:
        """Return level by level how each task stands; nothing is known without a reference."""
        q, v = moment.values.get("q_ref"), moment.values.get("v_ref")
        if q is None or v is None or not (np.isfinite(q).all() and np.isfinite(v).all()):
            return [[Standing("")] * len(level) for level in self._levels]
        kin = self._evaluator.at(q, v, moment.t)
        return [
            [self._standing(task, kin, v, moment.t) for task in level] for level in self._levels
        ]

    def _standing(self, task: Task, kin: Kinematics, v: Array, t: float) -> Standing:
        fade = self._fades.get(task.name)
        if fade is not None and fade.weight(t) == 0.0:
            return Standing(OFF)
        return standing_of(task, kin, v, t)


def _level_row(index: int, slack: Array | None, stands: Sequence[Standing]) -> str:
    words = {one.word for one in stands}
    word = next((word for word in _ORDER if word in words), "")
    value = f"slack {float(slack[index]):.1e}" if slack is not None and index < len(slack) else ""
    return f'<tr class="level"><td>Level {index}</td><td>{value}</td><td>{_mark(word)}</td></tr>'


def _task_row(task: Task, stands: Standing) -> str:
    where = f' <span class="where">{escape(stands.where)}</span>' if stands.where else ""
    sizes = " and ".join(quantity(*amount) for amount in stands.amounts)
    return (
        f"<tr><td>{escape(task.name)}{where}</td><td>{escape(sizes)}</td>"
        f"<td>{_mark(stands.word)}</td></tr>"
    )


def _mark(word: str) -> str:
    return f'<span class="{word.replace(" ", "-")}">{word}</span>' if word else ""


_PAGE = """<style>
.hierarchy {{ width: 100%; border-collapse: collapse; font-size: 0.8em; margin: 0 0.6em; }}
.hierarchy td {{ padding: 0.12em 0.3em; }} .hierarchy td:nth-child(2) {{ text-align: right; }}
.hierarchy td:nth-child(3) {{ white-space: nowrap; }}
.hierarchy .level td:nth-child(2) {{ white-space: nowrap; }}
.hierarchy .level td {{ font-weight: 700; border-top: 1px solid #ccc; }}
.hierarchy .met {{ color: #1a7f37; }} .hierarchy .short {{ color: #b00020; font-weight: 700; }}
.hierarchy .at-its-bound {{ color: #8a6100; }}
.hierarchy .left-over, .hierarchy .off {{ color: #777; }}
.hierarchy .where {{ color: #888; font-size: 0.85em; }}
</style><table class="hierarchy" id="equipoise-hierarchy">{rows}</table>"""
