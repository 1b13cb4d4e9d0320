"""Takes the screenshot and the animation of the viewer that the documentation shows.

    python tools/picture_viewer.py RUN docs/images

It opens the viewer on RUN in a headless Chromium (apt-get install chromium chromium-driver) and
writes viewer.png and viewer.gif.
"""

from __future__ import annotations

import sys
import tempfile
import time
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from selenium.webdriver.common.by import By

from equipoise.viewer.longlog import LongLog
from equipoise.viewer.replay import Replay
from equipoise.viewer.server import ViewerServer

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "viewer"))
from browser import start_chromium, until, wait_for_robot

SIZE = (1280, 860)
FRAMES = 24
ANIMATION_WIDTH = 640


def main(run: str, folder: str) -> None:
    """Write both pictures."""
    out = Path(folder)
    out.mkdir(parents=True, exist_ok=True)
    server = ViewerServer(port=0)
    replay = Replay(LongLog(run), server)
    replay.start()
    browser = start_chromium(Path(tempfile.mkdtemp()), SIZE)
    try:
        browser.get(server.url)
        wait_for_robot(browser)
        until(lambda: replay.display.progressive.opened)  # ghost, arrows, lines and trails
        close_notice(browser)
        span = replay.clock.last - replay.clock.first
        shown(replay, browser, replay.clock.first + 0.6 * span).save(out / "viewer.png")
        times = np.linspace(replay.clock.first, replay.clock.last, FRAMES)
        frames = [small(shown(replay, browser, float(t))) for t in times]
        frames[0].save(
            out / "viewer.gif",
            save_all=True,
            append_images=frames[1:],
            duration=round(1000.0 * span / FRAMES),
            loop=0,
            optimize=True,
        )
    finally:
        browser.quit()
        replay.stop()
        server.stop()


def close_notice(browser: Any) -> None:
    """Close the browser's notice that it draws in software."""
    for button in browser.find_elements(By.CSS_SELECTOR, ".mantine-Notification-closeButton"):
        browser.execute_script("arguments[0].click()", button)


def shown(replay: Replay, browser: Any, t: float) -> Image.Image:
    """Return what the page shows at time `t` [s] of the run."""
    replay.clock.seek(t)
    slider = replay.timeline._slider
    until(lambda: abs(slider.value - t) < 1e-3)
    time.sleep(1.0)  # for the page to draw what was sent
    return Image.open(BytesIO(browser.get_screenshot_as_png())).convert("RGB")


def small(image: Image.Image) -> Image.Image:
    """Return a frame of the animation."""
    height = round(image.height * ANIMATION_WIDTH / image.width)
    return image.resize((ANIMATION_WIDTH, height)).quantize(96)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
