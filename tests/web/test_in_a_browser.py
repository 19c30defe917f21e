"""The page in a real browser. One test is quick."""

from __future__ import annotations

import json
import re
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import unquote

import pytest
from tests.web.conftest import Browsing, OpenPage

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = pytest.mark.skipif(find_spec("playwright") is None, reason="playwright, which drives a browser, is not installed")
R1 = {"study.until": 6}
SPEED = "section[aria-label='speed over time'] canvas"
SLOPE = "input[type=text][aria-label^='slope']"


def set_field(shown: OpenPage, selector: str, text: str) -> None:
    before = shown.courses()
    shown.page.fill(selector, text)
    shown.page.press(selector, "Enter")
    shown.wait_for_course(before)


def test_first_page_shows_curves_and_a_slider_moves_them(browsing: Browsing) -> None:
    """The verdict of the file is gone once anything has moved, and back with the file's values."""
    shown = browsing.open(browsing.file("drozdetskaya-2020/r1", **R1))
    page = shown.page
    assert page.inner_text("h1") == "R1, u = 20"
    assert page.get_attribute("html", "data-previews") == "1"  # the first picture came before the fine run
    assert page.locator(".panel").count() == 5
    verdict = page.inner_text(".verdict")
    assert not verdict.startswith("not judged")
    first, drawing = shown.pixels(SPEED), shown.pixels("canvas.drawing")
    before = shown.courses()
    page.locator("input[type=range][aria-label^='slope']").press("ArrowRight")
    shown.wait_for_course(before)
    assert page.inner_text(".verdict").startswith("not judged")
    assert shown.pixels(SPEED) != first
    before = shown.courses()
    page.click("text=Reset to the file")
    shown.wait_for_course(before)
    assert page.inner_text(".verdict") == verdict
    assert shown.pixels(SPEED) == first
    page.keyboard.press("End")
    assert shown.pixels("canvas.drawing") != drawing


@pytest.mark.slow
def test_a_wrong_value_is_refused_by_a_sentence(browsing: Browsing) -> None:
    shown = browsing.open(browsing.file("drozdetskaya-2020/r1", **R1))
    page, curves = shown.page, shown.pixels(SPEED)
    for text, sentence in (
        ("-1", "slope of the torque-speed curve: given “-1”, must be at least 0"),
        ("fast", "given “fast”, must be a number in N·m·s"), ("1e999", "must be at most 1e+30 N·m·s"),
        ("1,900", "given “1,900”, must be written without a comma before three digits"),
    ):  # fmt: skip
        page.fill(SLOPE, text)
        page.press(SLOPE, "Enter")
        refusal = page.locator(".refusal:not(:empty)").inner_text().replace("\u00a0", " ")
        assert sentence in refusal.replace("Slope", "slope")
        assert refusal.endswith("0.0195 N·m·s is kept.")
        assert page.get_attribute(SLOPE, "aria-invalid") == "true"
    assert (shown.courses(), shown.pixels(SPEED)) == (1, curves)
    set_field(shown, SLOPE, "0,03")
    assert page.locator(".refusal:not(:empty)").count() == 0


@pytest.mark.slow
def test_a_link_restores_everything(browsing: Browsing) -> None:
    path = browsing.file("drozdetskaya-2020/r1", **R1)
    shown = browsing.open(path)
    page = shown.page
    set_field(shown, SLOPE, "0.0300000000000001")
    page.keyboard.press("Home")
    page.locator("body").click(position={"x": 700, "y": 8})
    for _ in range(37):
        page.keyboard.press("ArrowRight")
    before = shown.courses()
    page.click("button.switch")
    shown.wait_for_course(before)
    page.check("text=rotate the view with the rotor")
    page.click("text=Copy link")
    link = page.evaluate("location.hash")
    stored = json.loads(unquote(link[1:]))
    assert stored["parameters"] == {"drive.slope": 0.0300000000000001}
    assert stored["changes"] == [{"time": stored["time"], "parameters": {"drive.switch": 0}}]
    pixels = [shown.pixels(SPEED), shown.pixels("canvas.drawing")]
    again = browsing.open(path, link)
    assert again.page.get_attribute("button.switch", "aria-checked") == "false"
    again.page.click("text=Copy link")
    assert again.page.evaluate("location.hash") == link
    assert [again.pixels(SPEED), again.pixels("canvas.drawing")] == pixels


@pytest.mark.slow
def test_a_motor_slider_frees_a_captured_rotor_while_it_runs(browsing: Browsing) -> None:
    """From now on: what was before stays as it was."""
    shown = browsing.open(browsing.file("drozdetskaya-2020/r1", **R1))
    page = shown.page
    speed = page.locator("section[aria-label='speed over time'] output")
    page.keyboard.press("End")
    captured = float(speed.inner_text().split()[0])
    assert captured < 1300
    for _ in range(60):
        page.keyboard.press("ArrowLeft")
    early = speed.inner_text()
    page.check("text=from the time shown")
    set_field(shown, SLOPE, "0.078")
    assert speed.inner_text() == early
    page.locator("body").click(position={"x": 700, "y": 8})
    page.keyboard.press("End")
    assert float(speed.inner_text().split()[0]) > 1800


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("size", [(1280, 720), (390, 844)])
def test_nothing_lies_outside_the_page(browsing: Browsing, size: tuple[int, int], scheme: str) -> None:
    path = browsing.file("practice/laundry-drum", **{"study.until": 3})
    viewport = {"width": size[0], "height": size[1]}
    shown = browsing.open(path, viewport=viewport, color_scheme=scheme)
    page = shown.page
    assert page.evaluate("document.documentElement.scrollWidth") == size[0]
    if size[0] > 1000:
        assert page.evaluate("document.documentElement.scrollHeight") == size[1]
    colours = page.evaluate("[getComputedStyle(document.documentElement)].map((s) => [s.color, s.backgroundColor])[0]")
    ink, surface = (sum(map(int, re.findall(r"\d+", colour)[:3])) for colour in colours)
    assert (ink > surface) == (scheme == "dark")


@pytest.mark.slow
def test_a_script_that_is_not_of_the_page_is_not_run(browser: Browser, browsing: Browsing, tmp_path: Path) -> None:
    """Nor the code of an attribute; those of the page are allowed by their hashes."""
    traps = "<script>document.title = 'run'</script><img src=x: onerror=\"document.title = 'run'\">"
    path = tmp_path / "page.html"
    text = browsing.file("drozdetskaya-2020/r1", **R1).read_text(encoding="utf-8")
    path.write_text(text.replace("<body>", f"<body>{traps}").replace("</body>", f"{traps}</body>"), encoding="utf-8")
    page = browser.new_context().new_page()
    page.goto(path.as_uri())
    page.wait_for_selector("html[data-courses]", state="attached", timeout=20_000)
    assert page.title() == "R1, u = 20"
    page.context.close()
