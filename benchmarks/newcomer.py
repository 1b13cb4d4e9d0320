"""A newcomer's ten minutes, timed: clone, `make demo`, a robot in the browser, a dragged hand.

    python benchmarks/newcomer.py [--folder EMPTY] [--json FILE]

Does what README.md says, one command after the other, in a fresh clone with a fresh environment,
nothing compiled, nothing kept by pip. The browser is Chromium with software WebGL; the environment
that runs this needs selenium and matplotlib (extra `dev`).
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "viewer"))
EQUIPOISE = ".venv/bin/equipoise"
SIZE = (1200, 800)
ADDRESS = re.compile(r"http://\S+")
HAND = """
const tree = window.__viserSceneTree.getState();
return Object.keys(tree).filter((name) => name.startsWith("/handles/"));
"""
MOVED = 0.002  # share of the picture that tells that the robot has moved


class Clock:
    """Keeps what each step took [s] and says it."""

    def __init__(self) -> None:
        self.began = time.perf_counter()
        self.steps: dict[str, float] = {}

    def take(self, what: str, since: float) -> None:
        """Note the time that something took."""
        self.steps[what] = time.perf_counter() - since
        all_in_all = time.perf_counter() - self.began
        print(f"{self.steps[what]:7.1f} s  {what}  (since the beginning {all_in_all:.0f} s)")


def main() -> None:
    """Time it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folder", type=Path)
    parser.add_argument("--json", type=Path)
    asked = parser.parse_args()
    place = Path(tempfile.mkdtemp()) if asked.folder is None else asked.folder
    clone, clock = place / "equipoise", Clock()
    env = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    env |= {"XDG_CACHE_HOME": str(place / "cache"), "PIP_NO_CACHE_DIR": "1"}
    since = time.perf_counter()
    subprocess.run(["git", "clone", "-q", str(ROOT), str(clone)], check=True)
    clock.take("git clone, from this disk", since)
    since = time.perf_counter()
    subprocess.run(["make", ".venv/installed"], cwd=clone, env=env, check=True)
    clock.take("make demo: install", since)
    for which in ("make demo: run, kernels compiled", "make demo once more"):
        since = time.perf_counter()
        subprocess.run(["make", "demo"], cwd=clone, env=env, check=True, stdout=subprocess.DEVNULL)
        clock.take(which, since)
    look(clone, env, clock, place)
    play(clone, env, clock, place, "play, the first time")
    play(clone, env, clock, place, "play once more")
    if asked.json is not None:
        asked.json.write_text(json.dumps(clock.steps, indent=1) + "\n")


def look(clone: Path, env: dict[str, str], clock: Clock, place: Path) -> None:
    """Time `equipoise view` until the robot is drawn."""
    from browser import start_chromium, wait_for_robot

    browser = start_chromium(place / "profile", SIZE)
    since = time.perf_counter()
    server, address = serve([str(clone / EQUIPOISE)], ["view"], clone, env)
    try:
        clock.take("view: address told", since)
        opened = time.perf_counter()
        browser.get(address)
        wait_for_robot(browser)
        clock.take("view: page opened, robot drawn", opened)
    finally:
        browser.quit()
        stop(server)


def play(clone: Path, env: dict[str, str], clock: Clock, place: Path, what: str) -> None:
    """Time `equipoise play` until a hand that was dragged has moved."""
    from browser import picture, scene, share_changed, start_chromium, until, wait_for_robot
    from selenium.webdriver import ActionChains

    browser = start_chromium(place / "profile", SIZE)
    since = time.perf_counter()
    server, address = serve([str(clone / EQUIPOISE)], ["play"], clone, env)
    try:
        clock.take(f"{what}: address told", since)
        opened = time.perf_counter()
        browser.get(address)
        wait_for_robot(browser)
        until(lambda: len(browser.execute_script(HAND)) > 1)
        clock.take(f"{what}: page opened, robot and handles drawn", opened)
        before = scene(picture(browser))
        dragged = time.perf_counter()
        x, y = arrow_up(browser)
        mouse = ActionChains(browser, duration=100)
        mouse.move_by_offset(x, y).click_and_hold().move_by_offset(0, -30)
        mouse.move_by_offset(0, -50).release().perform()
        until(lambda: share_changed(scene(picture(browser)), before) > MOVED, 300.0)
        clock.take(f"{what}: handle dragged, hand seen to move", dragged)
    finally:
        browser.quit()
        stop(server)


def arrow_up(browser: Any) -> tuple[int, int]:
    """Return the pixel of the arrow of a hand that points up: the bluest thing in the scene."""
    import numpy as np
    from browser import picture

    image = picture(browser)
    height, width = image.shape[:2]
    blue = (image[:, :, 2] > 0.75) & (image[:, :, 0] < 0.35) & (image[:, :, 1] < 0.7)
    blue[:, : int(0.3 * width)] = blue[:, int(0.75 * width) :] = False
    rows, columns = np.nonzero(blue)
    assert len(rows), "no handle is seen"
    at = len(rows) // 8  # well above the middle of a handle, and not at the very tip
    ratio = browser.execute_script("return window.innerHeight;") / height
    return int(columns[at] * ratio), int(rows[at] * ratio)


def serve(
    program: list[str], words: list[str], clone: Path, env: dict[str, str]
) -> tuple[Any, str]:
    """Start a page; return the process and the address that it tells."""
    command = [*program, *words, "--no-browser", "--port", "0"]
    server = subprocess.Popen(
        command, cwd=clone, env=env | {"PYTHONUNBUFFERED": "1"}, stdout=subprocess.PIPE, text=True
    )
    assert server.stdout is not None
    for line in server.stdout:
        found = ADDRESS.search(line)
        if found:
            return server, found.group()
    raise RuntimeError(f"{' '.join(words)} ended without an address")


def stop(server: Any) -> None:
    """End a page that was started here."""
    server.terminate()
    server.wait(timeout=20)


if __name__ == "__main__":
    main()
