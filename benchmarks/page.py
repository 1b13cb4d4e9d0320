"""How soon a page shows its robot, and how many pictures a second a browser without a card draws.

    python benchmarks/page.py [--robot hrp2] [--times 3] [--json FILE]

Chromium with software WebGL draws a page of `play` (the law in the engine rigid) that is served by
another process: robot, floor, handles, plots. Then hands are led on circles, so that every picture
is another one. Needs selenium (extra `dev`) and Linux. What others
run on the same cores counts, so the load is told beside every figure, and the core time of browser
and server, which the load does not change much.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tests" / "viewer"), str(ROOT / "benchmarks")]
SIZE = (1200, 800)
RADIUS, TURN = 0.06, 1.5  # [m], [rad/s] of the circles
SECONDS = 8.0  # of counting
SETTLE = 3.0  # [s] in which panels and lines may come
COUNT = """
window.__equipoiseCount = 0;
const count = () => { window.__equipoiseCount += 1; requestAnimationFrame(count); };
requestAnimationFrame(count);
"""
DRAWN = """
const info = (window.__viserTestpoints || {}).rendererInfo;
return [window.__equipoiseCount, info.render.frame, info.render.calls, info.render.triangles];
"""


def lead_hands(robot: str, *, reference_only: bool) -> None:
    """Serve a page of `play` on which hands are led on circles, for ever."""
    from equipoise.robots import get_robot
    from equipoise.viewer.playing.live import LiveSession
    from equipoise.viewer.playing.page import Play
    from equipoise.viewer.playing.reference import ReferenceSession
    from equipoise.viewer.server import ViewerServer

    known = get_robot(robot)
    session = ReferenceSession(known) if reference_only else LiveSession(known, "rigid")
    server = ViewerServer(port=0)
    Play(session, server).start()
    print(f"Served at {server.url}", flush=True)
    start = {hand: place.copy() for hand, place in session.targets.items()}
    while True:
        angle = time.perf_counter() * TURN
        for hand, place in start.items():
            aside = RADIUS * np.array([np.sin(angle), 0.0, 1.0 + np.cos(angle)])
            session.drag(hand, place + aside)
        time.sleep(0.05)


def core_time(root: int) -> float:
    """Return the core time [s] that a process and all its children have used."""
    parents: dict[int, int] = {}
    used: dict[int, float] = {}
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            fields = (folder / "stat").read_text().rpartition(")")[2].split()
        except OSError:  # it has ended
            continue
        parents[int(folder.name)] = int(fields[1])
        used[int(folder.name)] = (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    total, family = 0.0, {root}
    grown = True
    while grown:
        more = {one for one, parent in parents.items() if parent in family} - family
        family |= more
        grown = bool(more)
    for one in family:
        total += used.get(one, 0.0)
    return total


def main() -> None:
    """Measure, and print a line each time."""
    from browser import start_chromium, wait_for_robot
    from newcomer import serve, stop

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robot", default="hrp2")
    parser.add_argument("--serve", metavar="ROBOT", help="only serve a page, until it is ended")
    parser.add_argument("--reference-only", action="store_true")
    parser.add_argument("--times", type=int, default=3)
    parser.add_argument("--json", type=Path)
    asked, _ = parser.parse_known_args()
    if asked.serve is not None:
        lead_hands(asked.serve, reference_only=asked.reference_only)
    found = []
    for _ in range(asked.times):
        began = time.perf_counter()
        program = [sys.executable, str(Path(__file__).resolve())]
        server, address = serve(
            program,
            ["--serve", asked.robot, *(["--reference-only"] if asked.reference_only else [])],
            ROOT,
            dict(os.environ),
        )
        told = time.perf_counter() - began
        browser = start_chromium(Path(tempfile.mkdtemp()), SIZE)
        try:
            opened = time.perf_counter()
            browser.get(address)
            wait_for_robot(browser)
            ready = time.perf_counter() - opened
            chromium = browser.service.process.pid
            to_ready = core_time(chromium)
            time.sleep(SETTLE)
            browser.execute_script(COUNT)
            _, before, *_ = browser.execute_script(DRAWN)
            began, used, served = time.perf_counter(), core_time(chromium), core_time(server.pid)
            time.sleep(SECONDS)
            asked_for, after, calls, triangles = browser.execute_script(DRAWN)
            took = time.perf_counter() - began
            used, served = core_time(chromium) - used, core_time(server.pid) - served
        finally:
            browser.quit()
            stop(server)
        found.append(
            {
                "robot": asked.robot,
                "moved_by": "reference" if asked.reference_only else "law",
                "address_s": told,
                "robot_drawn_s": ready,
                "drawn_per_s": (after - before) / took,
                "asked_per_s": asked_for / took,
                "browser_cores": used / took,
                "browser_core_s_per_picture": used / max(after - before, 1),
                "server_cores": served / took,
                "browser_core_s_until_robot": to_ready,
                "draw_calls": calls,
                "triangles": triangles,
                "load": os.getloadavg()[0],
            }
        )
        print({k: round(v, 2) if isinstance(v, float) else v for k, v in found[-1].items()})
    if asked.json is not None:
        asked.json.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
