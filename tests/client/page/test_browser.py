"""The page in a headless Chromium: what it draws, by its pixels, and that it can be used without a pointer."""
from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

from browser import PROGRAM, Browser

SCENES = {"tumbling_spacecraft": 1200, "envisat": 20_000, "moser_veselov": 500, "rigid_body_8": 200, "stiefel": 100,
          "ellipsoid": 200, "double_bracket": 100, "right_rigid_body": 100, "discrete_stiefel": 100}
WITHOUT_BODY = {"double_bracket"}
IN_SPACE = {"tumbling_spacecraft", "envisat", "moser_veselov"}


def test_the_browser_is_installed():
    assert PROGRAM, "the package chromium is missing: run docker/packages.sh browser"


@pytest.fixture
def opened(report):
    browsers = []

    def opened(name, to):
        page = report(name, to)
        browsers.append(Browser())
        browsers[-1].open(page.path)
        return browsers[-1], page
    yield opened
    for browser in browsers:
        browser.__exit__()


def picture(browser, panel):
    """Returns the pixels of a panel's canvas, as (rows, columns, 3)."""
    pixels = np.asarray(Image.open(io.BytesIO(browser.screenshot())).convert("RGB")).astype(int)
    x, y, width, height = browser.value(f"""(r => [r.x + scrollX, r.y + scrollY, r.width, r.height])(
        document.querySelector('#{panel} canvas').getBoundingClientRect())""")
    return pixels[round(y):round(y + height), round(x):round(x + width)]


def ink(pixels):
    """Returns the part of the pixels that are not nearly white."""
    return float((pixels.min(axis=2) < 200).mean())


def centre_of(pixels, colour):
    """Returns the mean place (column, row) of the pixels of a colour."""
    near = (abs(pixels - colour).max(axis=2) < 12).nonzero()
    assert len(near[0]) > 20
    return np.array([near[1].mean(), near[0].mean()])


def focus(browser, selector):
    browser.value(f"document.querySelector('{selector}').focus()")


#: Draws the page at five times and returns each text that reaches over the edge of its canvas.
CUT = """(() => {
  const cut = [], write = CanvasRenderingContext2D.prototype.fillText;
  CanvasRenderingContext2D.prototype.fillText = function (text, x, y) {
    const size = this.measureText(text), matrix = this.getTransform();
    for (const [X, Y] of [[x - size.actualBoundingBoxLeft, y - size.actualBoundingBoxAscent], [x + size.actualBoundingBoxRight, y + size.actualBoundingBoxDescent]]) {
      const corner = matrix.transformPoint(new DOMPoint(X, Y));
      if (corner.x < -1 || corner.y < -1 || corner.x > this.canvas.width + 1 || corner.y > this.canvas.height + 1)
        cut.push(`${this.canvas.parentElement.id}: ${text}`);
    }
    write.apply(this, arguments);
  };
  for (const part of [0, .2, .4, .6, .8, 1]) { go(part * (count - 1)); drawAll(); }
  CanvasRenderingContext2D.prototype.fillText = write;
  go(0);
  return cut;
})()"""


@pytest.mark.parametrize("name", SCENES)
def test_every_panel_is_drawn(opened, name):
    browser, page = opened(name, SCENES[name])
    assert browser.faults == [] and browser.requests == [page.path.resolve().as_uri()]
    shown = set(browser.value("[...document.querySelectorAll('figure')].filter(f => !f.hidden).map(f => f.id)"))
    expected = {"rates", "drift", "error"} | (set() if name in WITHOUT_BODY else {"body"})
    expected |= ({"polhode"} if name in IN_SPACE else set()) | ({"front"} if page.data["tradeoff"] else set())
    assert shown == expected
    for panel in shown:
        if browser.value(f"!document.querySelector('#{panel} canvas').hidden"):
            assert ink(picture(browser, panel)) > 0.004, panel
    for width in (1300, 800):
        browser.resize(width, 1000)
        assert browser.value(CUT) == [], width
    assert browser.value("document.querySelectorAll('#invariants tr').length") == 1 + len(page.data["drift"]["families"])
    assert browser.value("document.getElementById('scene').textContent").startswith("{")
    assert f"stiefel report {name}.json --to {SCENES[name]}" in browser.value("document.getElementById('again').textContent")


def expected_dot(page, sample, width, height):
    """Returns where the dot of the momentum must be on the polhode's canvas, computed from the samples alone."""
    M = page.array("fields", "M")[sample]
    u = np.array([M[1, 0], M[0, 2], M[2, 1]])  # the axes of the moments 500, 900, 1200 are z, y, x
    u = u / np.linalg.norm(u)
    azimuth, elevation = 0.6, 0.9
    c, s, C, S = np.cos(azimuth), np.sin(azimuth), np.cos(elevation), np.sin(elevation)
    right, up, depth = -s * u[0] + c * u[1], C * u[2] - S * (c * u[0] + s * u[1]), S * u[2] + C * (c * u[0] + s * u[1])
    radius = 0.42 * min(width, height)
    return np.array([width / 2 + radius * right, height / 2 - radius * up]), depth


def test_the_dot_is_where_the_momentum_is(opened):
    browser, page = opened("tumbling_spacecraft", 1200)
    tested = 0
    for sample in range(0, len(page.array("time")), 40):
        browser.value(f"(s => {{ s.value = {sample}; s.dispatchEvent(new Event('input')); }})(document.getElementById('time'))")
        pixels = picture(browser, "polhode")
        place, depth = expected_dot(page, sample, pixels.shape[1], pixels.shape[0])
        if depth > 0.05:  # behind the sphere it is pale
            assert np.linalg.norm(centre_of(pixels, [0xd5, 0x5e, 0x00]) - place) < 2, sample
            tested += 1
    assert tested >= 4


def test_the_slider_moves_the_body_by_the_keyboard(opened):
    browser, page = opened("tumbling_spacecraft", 1200)
    start = picture(browser, "body")
    focus(browser, "#time")
    browser.press("ArrowRight")
    assert browser.value("+document.getElementById('time').value") == 1
    one = picture(browser, "body")
    for _ in range(3):
        browser.press("PageUp")
    there = picture(browser, "body")
    moved = [float((abs(other - start).max(axis=2) > 40).mean()) for other in (one, there)]
    assert 0 < 2 * moved[0] < moved[1] and moved[1] > 0.05, "a sample moves the body a little, a third of the run a lot"
    time = page.array("time")[browser.value("+document.getElementById('time').value")]
    assert browser.value("document.getElementById('now').textContent").startswith(f"time {time:g} s")
    browser.press("Home")
    assert np.array_equal(picture(browser, "body"), start)


def test_space_plays_and_stops(opened):
    browser, _ = opened("tumbling_spacecraft", 1200)
    now = "+document.getElementById('time').value"
    focus(browser, "body")
    browser.press(" ")
    assert browser.value("document.getElementById('play').textContent") == "Stop"
    browser.value("new Promise(done => setTimeout(done, 1000))")
    browser.press(" ")
    stopped = browser.value(now)
    assert stopped > 0 and browser.value("document.getElementById('play').textContent") == "Play"
    browser.value("new Promise(done => setTimeout(done, 300))")
    assert browser.value(now) == stopped and browser.faults == []


def test_every_control_is_reached_by_tab(opened):
    browser, _ = opened("rigid_body_8", 200)
    reached = []
    for _ in range(20):
        browser.press("Tab")
        reached.append(browser.value("(e => e.id || e.closest('[id]')?.id)(document.activeElement)"))
    assert reached[:9] == ["play", "time", "speed", "window", "axes", "axes", "axes", "body", "rates"]
    assert {"again", "save", "scene"} <= set(reached)


def test_a_picture_has_no_fault_after_everything_was_pressed(opened):
    browser, _ = opened("stiefel", 100)
    for selector in ("#play", "#time", "#body canvas", "#rates canvas", "#save"):
        focus(browser, selector)
        for key in (" ", "ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown", "Home", "End", "PageUp", "PageDown", "+", "-"):
            browser.press(key)
    browser.resize(500, 700)
    browser.resize(1600, 1000)
    assert browser.faults == []
