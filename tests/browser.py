"""Chromium without a screen, driven by selenium. Tests that need it are skipped if either is not installed."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest

OPTIONS = (
    "--headless",
    "--no-sandbox",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--window-size=700,700",
)


@contextmanager
def chromium(profile: Path) -> Iterator:
    """Yield the driver of a browser that stores its profile in the folder `profile`; the browser ends with the block."""
    webdriver = pytest.importorskip(
        "selenium.webdriver", reason="selenium is not installed: pip install '.[test]' in the clone of pellucid"
    )
    programs = [shutil.which(name) for name in ("chromium", "chromedriver")]
    if not all(programs):
        pytest.skip("chromium and chromedriver are not installed: apt-get install chromium chromium-driver")
    options = webdriver.ChromeOptions()
    options.binary_location = programs[0]
    for option in (*OPTIONS, f"--user-data-dir={profile}"):
        options.add_argument(option)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(programs[1]))
    try:
        yield driver
    finally:
        driver.quit()


def settle(driver) -> None:
    """Wait until the browser has drawn the page after the last change."""
    driver.execute_async_script("const end = arguments[0]; requestAnimationFrame(() => requestAnimationFrame(() => end()))")


def pixels(driver, selector: str) -> np.ndarray:
    """Return the pixels of an element of the page, by its CSS selector, shape (rows, columns, 3)."""
    from PIL import Image

    settle(driver)
    picture = driver.find_element("css selector", selector).screenshot_as_png
    return np.asarray(Image.open(BytesIO(picture)).convert("RGB")).astype(int)
