"""The page of a running simulation in a real browser: what is clicked reaches loop and log.

EQUIPOISE_SCREENSHOTS names a folder in which the pictures are kept, to be looked at.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("viser", reason="needs the extra 'viewer': pip install -e '.[viewer]'")
pytest.importorskip("selenium", reason="needs selenium: pip install -e '.[dev]'")

from browser import CHROMIUM, DRIVER, picture, start_chromium, until, wait_for_robot
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from steered_runs import simulation

from equipoise.runlog import load_run
from equipoise.simulation.loop import Ending, RunOutcome, run_simulation
from equipoise.simulation.operator import OperatorRequest
from equipoise.viewer.bridge import Bridge

pytestmark = pytest.mark.skipif(
    CHROMIUM is None or DRIVER is None,
    reason="needs Chromium and its driver: apt-get install chromium chromium-driver",
)
PUSHED, ALPHA = 30.0, 7.5


class LivePage:
    """A simulation that runs in a thread, and the browser that looks at it."""

    def __init__(self, browser: Any, folder: Path) -> None:
        self.browser, self.folder = browser, folder
        self.made = simulation(600.0)  # far longer than the test: it is stopped by hand
        self.bridge = Bridge(self.made, "127.0.0.1", 0)
        self.made.operate(self)
        self.reached = 0.0  # [s], by the loop
        self.outcome: RunOutcome | None = None
        self.thread = threading.Thread(target=self._run, daemon=True)

    def _run(self) -> None:
        self.bridge.wait_for_page(lambda _: None)
        self.outcome = run_simulation(self.made, self.folder)

    @property
    def paused_s(self) -> float:
        """How long [s] the run has stood."""
        return self.bridge.paused_s

    def before_tick(self, t: float) -> OperatorRequest | None:
        """Ask the page's side."""
        return self.bridge.before_tick(t)

    def after_tick(self, t: float, values: Mapping[str, np.ndarray]) -> None:
        """Tell the page's side, and remember the time."""
        self.reached = t
        self.bridge.after_tick(t, values)

    @property
    def t(self) -> float:
        """The time [s] that the page shows."""
        field = until(lambda: self.box("Time"))
        return float(field.get_attribute("value").removesuffix(" s"))

    def box(self, label: str) -> Any:
        """Return the field to type into that stands beside a label."""
        way = f"//label[normalize-space()='{label}']/following::input[not(@type='hidden')]"
        found = self.browser.find_elements(By.XPATH, way)
        return next((field for field in found if field.get_attribute("type") != "range"), None)

    def click(self, text: str) -> None:
        """Click what carries that text."""
        found = until(lambda: self.browser.find_elements(By.XPATH, f"//*[text()='{text}']"))
        self.browser.execute_script("arguments[0].click()", found[0])

    def type(self, label: str, value: float, end: str = Keys.ENTER) -> None:
        """Type a number into the field beside a label, and end it by a key."""
        field = until(lambda: self.box(label))
        self.browser.execute_script("arguments[0].scrollIntoView({block: 'center'})", field)
        field.send_keys(Keys.CONTROL, "a")
        field.send_keys(f"{value:g}", end)

    def stands(self) -> float:
        """Wait until the loop stands and the page says where, and return that time."""
        until(lambda: not self.bridge._running)
        until(lambda: abs(self.t - self.reached) < 1e-9)
        return self.t


@pytest.fixture
def page(tmp_path: Path) -> Iterator[LivePage]:
    browser = start_chromium(tmp_path / "profile", (1200, 1000))
    page = LivePage(browser, tmp_path / "run")
    page.thread.start()
    try:
        browser.get(page.bridge.url)
        wait_for_robot(browser)
        yield page
    finally:
        page.bridge._take("stop", None)
        page.thread.join(timeout=120.0)
        browser.quit()
        page.bridge.close()


def test_a_run_is_watched_steered_and_stopped_from_the_page(page: LivePage, tmp_path: Path) -> None:
    began = until(lambda: page.t)
    until(lambda: page.t > began)
    page.click("Pause")
    stood = page.stands()
    page.click("1 tick")
    until(lambda: abs(page.t - stood - page.made.dt) < 1e-9)
    assert abs(page.stands() - stood - page.made.dt) < 1e-9

    page.type("x", PUSHED)
    page.click("Gains")
    page.type("alpha [1/s]", ALPHA, Keys.TAB)
    page.click("Go on")
    until(lambda: page.t > stood + 0.1)
    picture(page.browser, _shots(tmp_path) / "live.png")
    assert "supervisor" in page.browser.find_element(By.ID, "equipoise-status").text

    page.click("Stop the run")
    page.thread.join(timeout=120.0)
    assert page.outcome is not None
    assert page.outcome.ending is Ending.INTERRUPTED
    told = [change.partition(" s: ")[2] for change in page.outcome.changes]
    # nothing of what stood there while it was typed: 3 N, an alpha of 7
    assert [change for change in told if "push" in change] == [f"push ({PUSHED:g}, 0, 0) N at BODY"]
    assert [change for change in told if "alpha" in change] == [f"gain alpha: {ALPHA:g}"]
    _check_log(page, stood)
    page.bridge.finish(page.folder)
    until(lambda: page.browser.find_elements(By.XPATH, "//*[text()='Play']"))


def _check_log(page: LivePage, stood: float) -> None:
    """What was stopped is a whole log, and says tick by tick what was changed."""
    run = load_run(page.folder)
    assert run.complete
    assert np.allclose(np.diff(run.t), page.made.dt)
    before, after = run.t < stood, run.t > stood + 0.05
    assert (run["push"][before] == 0.0).all()
    assert (run["push"][after] == (PUSHED, 0.0, 0.0)).all()
    assert np.isfinite(run["push_point"][after]).all()
    alpha = run["gains"][:, run.channels["gains"].labels.index("alpha")]
    assert (alpha[before] != ALPHA).all()
    assert (alpha[after] == ALPHA).all()


def _shots(default: Path) -> Path:
    place = os.environ.get("EQUIPOISE_SCREENSHOTS")
    folder = Path(place) if place else default
    folder.mkdir(parents=True, exist_ok=True)
    return folder
