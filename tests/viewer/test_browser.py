"""The viewer in a real browser: it shows the robot, obeys, and tells strangers nothing.

EQUIPOISE_SCREENSHOTS names a folder in which the pictures are kept, to be looked at.
"""

from __future__ import annotations

import os
import shutil
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("viser", reason="needs the extra 'viewer': pip install -e '.[viewer]'")
pytest.importorskip("selenium", reason="needs selenium: pip install -e '.[dev]'")

from browser import (
    CHROMIUM,
    DRIVER,
    picture,
    scene,
    share_changed,
    share_of_ink,
    start_chromium,
    steady_picture,
    until,
    wait_for_robot,
)
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

from equipoise.analysis.report.page import make_report
from equipoise.robots import get_robot
from equipoise.viewer.longlog import LongLog
from equipoise.viewer.playing.live import LiveSession
from equipoise.viewer.playing.page import Play
from equipoise.viewer.playing.walking import WalkingSession
from equipoise.viewer.replay import Replay
from equipoise.viewer.server import ViewerServer
from equipoise.walking import Stick

SMOOTHED = """
return [...document.querySelectorAll("canvas")].map((canvas) => canvas.getContext("webgl2"))
  .filter((gl) => gl).map((gl) => gl.getContextAttributes().antialias);
"""
PUSH_BUTTON = "//button[contains(., 'Push for')]"
pytestmark = pytest.mark.skipif(
    CHROMIUM is None or DRIVER is None,
    reason="needs Chromium and its driver: apt-get install chromium chromium-driver",
)


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    browser = start_chromium(tmp_path_factory.mktemp("profile"))
    yield browser
    browser.quit()


@pytest.fixture(scope="module")
def shots(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = os.environ.get("EQUIPOISE_SCREENSHOTS")
    folder = Path(place) if place else tmp_path_factory.mktemp("shots")
    folder.mkdir(parents=True, exist_ok=True)
    return folder


@pytest.fixture(scope="module")
def replay(sway: Path, browser: Any) -> Iterator[Replay]:
    server = ViewerServer(port=0)
    replay = Replay(LongLog(sway), server)
    replay.start()
    browser.get(server.url)
    wait_for_robot(browser)
    until(lambda: replay.display.progressive.opened)  # the panels come a moment later
    until(lambda: browser.find_elements(By.ID, "equipoise-hierarchy"))
    yield replay
    replay.stop()
    server.stop()


def test_the_robot_is_seen(replay: Replay, browser: Any, shots: Path) -> None:
    image = picture(browser, shots / "replay.png")
    assert share_of_ink(scene(image)) > 0.2
    table = until(lambda: browser.find_element(By.ID, "equipoise-hierarchy").text)
    assert "left_hand" in table
    until(lambda: "Posture error" in browser.page_source)


def test_drawn_in_software_no_edges_are_smoothed(replay: Replay, browser: Any) -> None:
    drawn = browser.execute_script(SMOOTHED)
    assert drawn
    assert not any(drawn)


def test_the_time_line_moves_the_robot(replay: Replay, browser: Any, shots: Path) -> None:
    before = picture(browser)
    way = (By.CSS_SELECTOR, "input.mantine-NumberInput-input")
    boxes = until(lambda: browser.find_elements(*way))
    boxes[0].send_keys(Keys.CONTROL, "a")
    boxes[0].send_keys("0.25", Keys.ENTER)
    until(lambda: abs(replay.clock.t - 0.25) < 1e-9)
    until(lambda: share_changed(scene(before), scene(picture(browser))) > 0.01)
    picture(browser, shots / "replay_later.png")


def test_keys_step_and_play(replay: Replay, browser: Any) -> None:
    replay.clock.seek(0.3)
    browser.execute_script("document.activeElement.blur()")
    page = browser.find_element(By.TAG_NAME, "body")
    page.send_keys(Keys.ARROW_RIGHT)
    until(lambda: abs(replay.clock.t - 0.301) < 1e-9)
    page.send_keys(Keys.ARROW_LEFT)
    until(lambda: abs(replay.clock.t - 0.3) < 1e-9)
    page.send_keys(Keys.SPACE)
    until(lambda: replay.clock.t > 0.35)
    replay.clock.play(False)


def test_layers_are_switched(replay: Replay, browser: Any, shots: Path) -> None:
    replay.clock.seek(0.0)
    for button in browser.find_elements(By.XPATH, "//*[text()='Layers']"):
        browser.execute_script("arguments[0].click()", button)
    boxes = until(lambda: browser.find_elements(By.CSS_SELECTOR, "input[type=checkbox]"))
    labels = {_label(browser, box): box for box in boxes}
    wanted = ["Robot", "Reference (ghost)", "World", "Contact forces"]
    wanted += ["Balance (polygon, CoM, CoP)", "Closest distances", "Trails of the hands"]
    assert set(wanted) <= set(labels)
    with_all = steady_picture(browser)

    def switch_all(on: bool) -> None:
        """Click each box until it stands as wanted: a click can fall between two drawings."""
        for name in wanted:
            box = labels[name]
            while box.is_selected() is not on:
                browser.execute_script("arguments[0].click()", box)
                until(lambda box=box: box.is_selected() is on)
        until(lambda: replay.display._robot._top.visible is on)

    switch_all(False)
    until(lambda: share_changed(scene(with_all), scene(picture(browser))) > 0.1)
    picture(browser, shots / "layers_off.png")
    switch_all(True)
    until(lambda: share_changed(scene(with_all), scene(picture(browser))) < 0.1)


def _label(browser: Any, box: Any) -> str:
    """Return the text that stands beside a check box."""
    return browser.execute_script(
        "let e = arguments[0]; while (e && !e.innerText.trim()) e = e.parentElement;"
        "return e ? e.innerText.trim() : ''",
        box,
    )


EVIL_PAGE = """<!doctype html><title>waiting</title><script>
const tell = [];
const done = what => {{
  tell.push(what);
  if (tell.length === 2) document.title = tell.sort().join();
}};
fetch("{url}").then(r => r.text()).then(() => done("read"), () => done("fetch refused"));
const socket = new WebSocket("{url}".replace("http", "ws"), ["viser-v{version}"]);
socket.onopen = () => done("connected"); socket.onerror = () => done("socket refused");
const frame = document.createElement("iframe"); frame.src = "{url}";
document.documentElement.append(frame);
</script>"""


def test_a_page_from_elsewhere_reads_and_pushes_nothing(replay: Replay, browser: Any) -> None:
    import viser

    page = EVIL_PAGE.format(url=replay.server.url, version=viser.__version__).encode()

    class Evil(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(page)

        def log_message(self, *_: object) -> None:
            pass

    elsewhere = ThreadingHTTPServer(("127.0.0.1", 0), Evil)
    threading.Thread(target=elsewhere.serve_forever, daemon=True).start()
    try:
        clients = len(replay.server.viser.get_clients())
        browser.get(f"http://localhost:{elsewhere.server_port}/")
        until(lambda: browser.title != "waiting")
        assert browser.title == "fetch refused,socket refused"
        said = until(lambda: [e["message"] for e in browser.get_log("browser")])
        assert any("frame" in message and "X-Frame-Options" in message for message in said) or any(
            "frame-ancestors" in message for message in said
        )
        assert len(replay.server.viser.get_clients()) <= clients
    finally:
        elsewhere.shutdown()
        elsewhere.server_close()


def test_a_narrow_page_leaves_the_picture_its_room(
    replay: Replay, tmp_path: Path, shots: Path
) -> None:
    """At 900 pixels the picture has more than half of the width; the plots unfold by a click."""
    browser = start_chromium(tmp_path / "narrow", (900, 700))
    try:
        browser.get(replay.server.url)
        wait_for_robot(browser)
        width = "return document.querySelector('canvas').parentElement.clientWidth"
        until(lambda: browser.execute_script(width) > 450)
        picture(browser, shots / "narrow.png")
        browser.execute_script(
            "document.elementFromPoint(20, 6).closest('[role=button]').click()"
        )  # the plus of the folded panel
        until(lambda: browser.execute_script(width) < 450, seconds=20.0)
    finally:
        browser.quit()


def test_opened_to_the_network_the_token_opens_the_page(browser: Any) -> None:
    server = ViewerServer("0.0.0.0", port=0)
    try:
        server.viser.scene.add_box("/robot/joint1/box")
        browser.get(f"http://127.0.0.1:{server.port}/")
        assert "403" in browser.page_source
        browser.get(f"http://127.0.0.1:{server.port}/?token={server.guard.token}")
        assert "token" not in browser.current_url
        until(lambda: len(server.viser.get_clients()) == 1)
    finally:
        browser.get("about:blank")
        server.stop()


def test_the_report_plays_without_a_network(
    sway: Path, browser: Any, shots: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "sway"
    shutil.copytree(sway, folder)
    (folder / "figures").mkdir()  # drawing them is another test's business
    picture(browser, folder / "figures" / "any.png")
    report = make_report([folder, folder], tmp_path / "report.html")
    browser.get(report.as_uri())
    until(lambda: browser.find_element(By.ID, "shown").text.endswith("s"))
    canvases = browser.find_elements(By.TAG_NAME, "canvas")
    assert len(canvases) == 2
    before = picture(browser, shots / "report.png")
    assert share_of_ink(before) > 0.05
    seek = "const s = document.getElementById('time'); s.value = arguments[0]; s.oninput();"
    browser.execute_script(seek, 0.25)
    assert browser.find_element(By.ID, "shown").text == "0.25 s"
    assert share_changed(before, picture(browser)) > 0.002
    browser.find_element(By.ID, "play").click()
    until(lambda: float(browser.find_element(By.ID, "shown").text[:-2]) > 0.3)


def test_a_robot_is_played_with(browser: Any, shots: Path) -> None:
    """It is seen, a click on the page pushes it, and the forces under its feet are drawn."""
    server = ViewerServer(port=0)
    play = Play(LiveSession(get_robot("hrp2"), "rigid"), server)
    play.start()
    try:
        for width, height in ((1400, 900), (900, 800), (400, 800)):
            browser.set_window_size(width, height)
            browser.get(server.url)
            wait_for_robot(browser)
            if width == 1400:
                until(lambda: browser.find_elements(By.ID, "equipoise-live"))
                until(lambda: browser.find_elements(By.CSS_SELECTOR, ".uplot canvas"))
                found = until(lambda: browser.find_elements(By.XPATH, PUSH_BUTTON))
                browser.execute_script("arguments[0].click()", found[0])
                until(lambda: play.live is not None and play.live.pushed)
            image = picture(browser, shots / f"play_{width}.png")
            assert share_of_ink(scene(image) if width > 900 else image) > 0.1
        assert isinstance(play.session, LiveSession)
        assert not play.session.ended
    finally:
        play.stop()
        server.stop()
        browser.set_window_size(1200, 600)


def test_a_stick_is_held_by_mouse_touch_and_keys_and_lets_go_by_itself(browser: Any) -> None:
    """Dragged and typed it says how fast; where the focus goes, so does what is held."""
    server = ViewerServer(port=0)
    session = WalkingSession(get_robot("hrp2"), "rigid")  # it is not run: what is asked counts
    Play(session, server)
    fastest = session.fastest
    assert fastest is not None
    try:
        browser.set_window_size(900, 900)
        browser.get(server.url)
        pad, strip = until(lambda: browser.find_elements(By.CSS_SELECTOR, "[data-part]"))
        until(lambda: browser.find_elements(By.CSS_SELECTOR, "input.mantine-TextInput-input"))

        def says(wanted: Stick) -> bool:
            return all(
                abs(getattr(session.stick, name) - getattr(wanted, name)) < 0.01 * abs(most) + 1e-3
                for name, most in vars(fastest).items()
            )

        radius = pad.size["height"] / 2.0
        held = ActionChains(browser).move_to_element(pad).click_and_hold()
        held.move_by_offset(0, -round(0.5 * radius)).perform()
        until(lambda: says(Stick(0.5 * fastest.forward)), 20.0)
        ActionChains(browser).release().perform()
        until(lambda: says(Stick()), 20.0)
        keys = {
            "w": Stick(fastest.forward),
            "d": Stick(turn=-fastest.turn),
            Keys.ARROW_LEFT: Stick(turn=fastest.turn),
            "q": Stick(left=fastest.left),
        }
        for key, wanted in keys.items():  # the click gave the pad the focus
            ActionChains(browser).key_down(key).perform()
            until(lambda wanted=wanted: says(wanted), 20.0)
            ActionChains(browser).key_up(key).perform()
            until(lambda: says(Stick()), 20.0)
        frame = strip.rect
        at = {"x": frame["x"] + 0.75 * frame["width"], "y": frame["y"] + 0.5 * frame["height"]}
        for kind, points, wanted in (("touchStart", [at], Stick(left=-0.5 * fastest.left)),
                                     ("touchEnd", [], Stick())):  # fmt: skip
            event = {"type": kind, "touchPoints": points}
            browser.execute_cdp_cmd("Input.dispatchTouchEvent", event)
            until(lambda wanted=wanted: says(wanted), 20.0)
        ActionChains(browser).click(pad).key_down("w").perform()
        until(lambda: says(Stick(fastest.forward)), 20.0)
        browser.execute_script("document.activeElement.blur()")
        until(lambda: says(Stick()), 20.0)
        ActionChains(browser).key_up("w").perform()
        ActionChains(browser).click(pad).key_down("w").perform()
        until(lambda: says(Stick(fastest.forward)), 20.0)
        browser.get("about:blank")  # the page goes, and the stick with it
        until(lambda: says(Stick()), 20.0)
    finally:
        server.stop()
        browser.set_window_size(1200, 600)


def test_on_a_phone_nothing_lies_over_the_robot(browser: Any, shots: Path) -> None:
    """The controls are a sheet over the whole width; folded, the picture gets its place."""
    server = ViewerServer(port=0)
    Play(WalkingSession(get_robot("hrp2"), "rigid"), server)
    phone = {"width": 390, "height": 800, "deviceScaleFactor": 1, "mobile": True}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", phone)

    def frames() -> dict[str, list[float]]:
        return browser.execute_script(
            "return Object.fromEntries([...document.querySelectorAll('[data-equipoise]')].map("
            "(one) => { const r = one.getBoundingClientRect();"
            "return [one.dataset.equipoise, [r.left, r.right, r.top, r.bottom]]; }))"
        )

    def beside() -> bool:
        found = frames()
        if len(found) < 2 or not found["sheet"][3]:
            return False
        sheet, image = found["sheet"], found["picture"]
        return abs(image[3] - sheet[2]) < 2.0 and sheet[:2] == image[:2] == [0.0, 390.0]

    try:
        browser.get(server.url)
        wait_for_robot(browser)
        until(lambda: browser.find_elements(By.CSS_SELECTOR, "[data-part]"))
        until(beside, 30.0)
        before = frames()["picture"][3]
        assert 0.45 * 800 <= before < 0.8 * 800
        picture(browser, shots / "play_390.png")
        browser.find_element(By.XPATH, "//*[text()='Equipoise']").click()
        until(lambda: beside() and frames()["picture"][3] > 0.8 * 800, 30.0)
    finally:
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
        server.stop()
