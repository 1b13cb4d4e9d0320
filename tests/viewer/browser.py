"""A headless Chromium with software WebGL, and looking at what it shows."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")
DRIVER = shutil.which("chromedriver")
OPTIONS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--disable-dev-shm-usage",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)
STATE = """
const tree = window.__viserSceneTree ? window.__viserSceneTree.getState() : {};
const info = (window.__viserTestpoints || {}).rendererInfo;
return {nodes: Object.keys(tree), triangles: info ? info.render.triangles : 0};
"""


def start_chromium(profile: Path, size: tuple[int, int] = (1200, 600)) -> Any:
    """Return a running browser with a fresh profile in that folder."""
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM or ""
    for option in (*OPTIONS, f"--user-data-dir={profile}", f"--window-size={size[0]},{size[1]}"):
        options.add_argument(option)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    browser = webdriver.Chrome(options=options, service=Service(DRIVER))
    browser.set_page_load_timeout(180)
    return browser


def until(happened: Callable[[], Any], seconds: float = 240.0) -> Any:
    """Wait for something and return it."""
    deadline = time.perf_counter() + seconds
    while not (found := happened()):
        assert time.perf_counter() < deadline, "it did not happen"
        time.sleep(0.1)
    return found


def wait_for_robot(browser: Any) -> None:
    """Wait until the robot's meshes are in the scene and were drawn."""

    def drawn() -> bool:
        state = browser.execute_script(STATE)
        shapes = [name for name in state["nodes"] if name.startswith("/robot/joint")]
        return len(shapes) > 20 and state["triangles"] > 5000

    until(drawn)


def picture(browser: Any, keep: Path | None = None) -> np.ndarray:
    """Return what the browser shows (height, width, 3) in 0..1; `keep` is a file for it."""
    from matplotlib.image import imread

    content = browser.get_screenshot_as_png()
    if keep is not None:
        keep.write_bytes(content)
    return imread(BytesIO(content), format="png")[:, :, :3]


def scene(image: np.ndarray) -> np.ndarray:
    """Return the middle of a picture, where no panel is."""
    height, width = image.shape[:2]
    return image[int(0.25 * height) :, int(0.36 * width) : int(0.7 * width)]


def share_of_ink(image: np.ndarray) -> float:
    """Return the share of pixels that differ from the commonest colour."""
    colours = (255 * image).astype(int).reshape(-1, 3) @ (65536, 256, 1)
    _, counts = np.unique(colours, return_counts=True)
    return 1.0 - counts.max() / counts.sum()


def share_changed(one: np.ndarray, other: np.ndarray) -> float:
    """Return the share of pixels that differ visibly between two pictures."""
    return float((np.abs(one - other).max(axis=2) > 0.1).mean())


def steady_picture(browser: Any) -> np.ndarray:
    """Return what the browser shows once it shows the same twice in a row."""
    last = [picture(browser)]

    def again() -> bool:
        time.sleep(0.5)
        last.append(picture(browser))
        return share_changed(last[-2], last[-1]) < 1e-3

    until(again)
    return last[-1]
