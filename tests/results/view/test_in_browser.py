"""The view in a browser: one page, opened from its file."""

import time

import numpy as np
import pytest
from browser import chromium, pixels, settle
from view_scenes import TIMES, write_run

from pellucid.results.view.page import view_of

CANVAS = ".pellucid-view canvas"


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    folder = tmp_path_factory.mktemp("page")
    view = view_of(write_run(folder / "run"), without="Figures follow.")
    (folder / "page.html").write_text(f'<!doctype html><meta charset="utf-8"><main>{view}</main>', encoding="utf-8")
    return (folder / "page.html").as_uri()


@pytest.fixture(scope="module")
def driver(tmp_path_factory):
    with chromium(tmp_path_factory.mktemp("profile")) as found:
        yield found


@pytest.fixture
def view(driver, page):
    driver.get(page)
    deadline = time.monotonic() + 20.0
    while not driver.find_elements("css selector", ".pellucid-view.ready"):
        assert time.monotonic() < deadline, driver.get_log("browser")
        time.sleep(0.02)
    settle(driver)
    return driver


def give(driver, selector, value, event="input"):
    """Set a slider or list to a value."""
    script = "const [place, value, event] = arguments; place.value = value; place.dispatchEvent(new Event(event))"
    driver.execute_script(script, driver.find_element("css selector", selector), value, event)


def tick(driver, name):
    driver.find_element("xpath", f"//label[contains(., '{name}')]/input").click()


def share(picture, test):
    """Of the pixels that pass a test of red, green and blue."""
    return float(np.mean(test(*np.moveaxis(picture, -1, 0))))


def reddish(red, green, blue):
    return (red > 120) & (green < 60) & (blue < 60)


def orange(red, green, blue):
    """The colour of the second body."""
    return (red > green + 30) & (green > blue + 30)


def blueish(red, green, blue):
    """The colour of the first."""
    return (blue > green + 20) & (green > red + 20)


def test_shows_the_bodies_and_says_nothing_wrong(view):
    picture = pixels(view, CANVAS)
    drawn = share(picture, lambda red, green, blue: red + green + blue < 740)
    assert 0.1 < drawn < 0.8
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 200
    assert [entry for entry in view.get_log("browser") if entry["level"] != "INFO"] == []
    assert view.execute_script("return performance.getEntriesByType('resource').length") == 0


def test_legend_and_bar_have_units(view):
    assert "speed [m/s]" in view.find_element("css selector", ".legend").text
    assert view.find_element("css selector", ".bar").text in ("200 mm", "500 mm", "1 m")
    give(view, ".field", "2", "change")
    assert "von Mises stress [Pa]" in view.find_element("css selector", ".legend").text
    assert "some points" in view.find_element("css selector", ".beyond").text


def test_slider_changes_picture_and_time(view):
    last = pixels(view, CANVAS)
    give(view, ".instant", "0")
    assert "t = 0 s" in view.find_element("css selector", ".pellucid-view").text
    assert (pixels(view, CANVAS) != last).any(axis=2).mean() > 0.02


def test_play_goes_through_the_instants(view):
    button = view.find_element("css selector", ".play")
    shown = set()
    button.click()
    deadline = time.monotonic() + 10.0
    while len(shown) < len(TIMES) and time.monotonic() < deadline:
        shown.add(view.find_element("css selector", ".instant").get_attribute("value"))
        time.sleep(0.02)
    button.click()
    assert len(shown) == len(TIMES)
    halted = pixels(view, CANVAS)
    time.sleep(0.3)
    assert (pixels(view, CANVAS) == halted).all()


def test_dragging_turns_and_a_double_click_turns_back(view):
    from selenium.webdriver import ActionChains

    first, canvas = pixels(view, CANVAS), view.find_element("css selector", CANVAS)
    ActionChains(view).click_and_hold(canvas).move_by_offset(120, 40).release().perform()
    assert (pixels(view, CANVAS) != first).any(axis=2).mean() > 0.05
    ActionChains(view).double_click(canvas).perform()
    assert (abs(pixels(view, CANVAS) - first) > 8).any(axis=2).mean() < 0.001


def test_a_finger_turns(view):
    first = pixels(view, CANVAS)
    at = view.find_element("css selector", CANVAS).rect
    x, y = at["x"] + 0.5 * at["width"], at["y"] + 0.5 * at["height"]
    for kind, shift in (("touchStart", 0), ("touchMove", 40), ("touchMove", 120), ("touchEnd", None)):
        points = [] if shift is None else [{"x": x + shift, "y": y}]
        view.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
    assert (pixels(view, CANVAS) != first).any(axis=2).mean() > 0.05


def test_a_cut_shows_what_is_inside(view):
    give(view, ".field", "-1", "change")
    cut = share(pixels(view, CANVAS), blueish)
    give(view, ".axis", "-1", "change")
    whole = share(pixels(view, CANVAS), blueish)
    assert cut > 0.02 > 10 * whole
    block = share(pixels(view, CANVAS), lambda red, green, blue: (green > red + 30) & (green > blue + 10))
    give(view, ".axis", "2", "change")
    give(view, ".cut", "100")
    assert share(pixels(view, CANVAS), lambda red, green, blue: (green > red + 30) & (green > blue + 10)) > 0.5 * block


def test_bodies_can_be_hidden(view):
    give(view, ".field", "-1", "change")
    give(view, ".axis", "-1", "change")
    assert share(pixels(view, CANVAS), orange) > 0.02
    tick(view, "skin")
    picture = pixels(view, CANVAS)
    assert share(picture, orange) < 0.001
    assert share(picture, blueish) > 0.02


def test_failed_points_are_told_apart(view):
    give(view, ".axis", "-1", "change")
    assert share(pixels(view, CANVAS), reddish) > 0.005
    assert "failed points" in view.find_element("css selector", ".legend").text
    tick(view, "failed points")
    assert share(pixels(view, CANVAS), reddish) == 0.0
    tick(view, "failed points")
    give(view, ".instant", "0")
    assert share(pixels(view, CANVAS), reddish) == 0.0


def test_is_dark_where_the_reader_wants_it(view):
    def corner():
        return int(pixels(view, CANVAS)[-40:-30, -40:-30].max())

    assert corner() == 255
    dark = [{"name": "prefers-color-scheme", "value": "dark"}]
    view.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": dark})
    assert corner() < 80
    view.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})


def test_says_where_nothing_can_be_drawn(driver, page):
    source = "HTMLCanvasElement.prototype.getContext = () => null"
    script = driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": source})
    driver.get(page)
    driver.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", script)
    deadline = time.monotonic() + 10.0
    while not driver.find_elements("css selector", ".pellucid-view.failed"):
        assert time.monotonic() < deadline
        time.sleep(0.02)
    text = driver.find_element("css selector", ".pellucid-view").text
    assert "requires WebGL 2" in text
    assert "Figures follow." in text
    assert not driver.find_elements("css selector", ".stage, .row")
