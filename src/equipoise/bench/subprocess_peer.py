"""A peer in a Python of its own: its robot and targets in files, its ticks over a pipe."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import tempfile
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from equipoise.bench.interleave import TURN
from equipoise.bench.problem import FEET, HANDS, Problem
from equipoise.errors import InputError

WORKERS = Path(__file__).parent / "workers"
_DRAWN = ("visual", "collision", "transmission", "gazebo", "material")


class ApartPeer:
    """A worker process that runs ticks when it is told to, and answers with their times."""

    turn = TURN

    def __init__(self, problem: Problem, name: str, python: str, ticks: int) -> None:
        self.row = f"peer/{name}/{problem.name}"
        self.failures = {self.row: 0}
        self._name, self._python = name, python
        self._folder = tempfile.TemporaryDirectory(prefix="equipoise-bench-")
        place = Path(self._folder.name)
        write_task(problem, place, ticks)
        self._errors = (place / "errors.txt").open("w+", encoding="utf-8")
        try:
            self._process = subprocess.Popen(
                [python, str(WORKERS / f"{name}_worker.py"), str(place)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._errors,
                text=True,
                env=os.environ | {"PYTHONPATH": "", "PYTHONSAFEPATH": ""},
            )
        except OSError as error:
            self.close()
            raise self._trouble(f"cannot be started: {error}") from None
        self.remarks = {self.row: self._answer()["about"]}

    def run(self, first: int, count: int) -> dict[str, list[int]]:
        """Let the worker run its ticks; it times each itself."""
        with contextlib.suppress(OSError):  # then its last words say why, see below
            print(first, count, file=self._process.stdin, flush=True)
        answer = self._answer()
        self.failures[self.row] += answer["failures"]
        return {self.row: answer["ns"]}

    def close(self) -> None:
        """End the worker and remove its files."""
        process = getattr(self, "_process", None)
        if process is not None:
            process.stdin.close()
            process.stdout.close()
            try:
                process.wait(timeout=5.0)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self._errors.close()
        self._folder.cleanup()

    def _answer(self) -> dict[str, Any]:
        """Return the worker's next answer; what its library prints besides is passed over."""
        assert self._process.stdout is not None
        for line in self._process.stdout:
            if line.startswith("{"):
                return json.loads(line)
        self._errors.seek(0)
        said = self._errors.read().strip().splitlines()
        self.close()
        raise self._trouble(f"ended: {said[-1] if said else 'it said nothing'}")

    def _trouble(self, why: str) -> InputError:
        return InputError(
            f"the worker of peer {self._name!r} {why}",
            given=f"{self._name}={self._python}",
            remedy=f"Name a Python that can `import {self._name}`; see docs/benchmarks.md",
        )


def write_task(problem: Problem, place: Path, ticks: int) -> None:
    """Write the robot (a plain URDF) and what it is to follow into the folder."""
    robot = problem.robot
    _write_plain_urdf(robot.urdf_path, robot.joint_names, place / "robot.urdf")
    links, targets = {}, {}
    for name, task in problem.frame_tasks().items():
        link, T_frame_link = _link_of(robot.model, robot.frame_id(task.frame))
        links[name] = link
        poses = [task.target.at(k * problem.dt).T_world_target * T_frame_link for k in range(ticks)]
        targets[name] = np.array([T.homogeneous for T in poses])
    np.savez(place / "targets.npz", **targets)  # type: ignore[arg-type]  # none is `allow_pickle`
    described = {
        "urdf": str(place / "robot.urdf"),
        "dt": problem.dt,
        "links": links,
        "feet": list(FEET),
        "hands": list(HANDS),
        "soles": _corners(problem),
        "joints": list(robot.joint_names),
        "velocity_max": robot.v_max.tolist(),
        "q_start": problem.q_start.tolist(),
        "q_posture": robot.q_half_sitting.tolist(),
    }
    (place / "task.json").write_text(json.dumps(described), encoding="utf-8")


def _link_of(model: pin.Model, frame_id: int) -> tuple[str, pin.SE3]:
    """Return the link that a frame is fixed to, and `T_frame_link`."""
    frame = model.frames[frame_id]
    for link in model.frames:
        if link.parentJoint == frame.parentJoint and link.type == pin.FrameType.BODY:
            return link.name, frame.placement.actInv(link.placement)
    raise InputError("no link stands behind the frame", given=frame.name)


def _corners(problem: Problem) -> dict[str, list[list[float]]]:
    """Return the corners (4, 3) of each foot's sole, in the axes of its link."""
    found = {}
    tasks = problem.frame_tasks()
    for foot in FEET:
        frame = tasks[foot].frame
        _, T_frame_link = _link_of(problem.robot.model, problem.robot.frame_id(frame))
        sole = next(sole for sole in problem.robot.soles if sole.frame == frame)
        found[foot] = [T_frame_link.actInv(corner).tolist() for corner in sole.corners]
    return found


def _write_plain_urdf(source: Path, moved: tuple[str, ...], path: Path) -> None:
    """Write a URDF without shapes, its other joints fixed: nothing else need be found."""
    root = ET.parse(source).getroot()
    for parent in [root, *root.iter("link")]:
        for child in [child for child in parent if child.tag in _DRAWN]:
            parent.remove(child)
    for joint in root.iter("joint"):
        if joint.get("type") != "fixed" and joint.get("name") not in moved:
            joint.set("type", "fixed")
        if joint.get("type") == "fixed":
            for child in [c for c in joint if c.tag not in ("origin", "parent", "child")]:
                joint.remove(child)
    ET.ElementTree(root).write(path)
