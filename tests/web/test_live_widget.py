"""`wucht.live`: traits without a browser; in one, the page in a frame of its own, which computes and tells what it shows."""

from __future__ import annotations

import json
import re
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from tests.web.built_page import needs_page

import wucht
from wucht import Machine, parts
from wucht.errors import InputError
from wucht.web import live_widget
from wucht.web.live_page import built_file

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

pytestmark = [
    needs_page,
    pytest.mark.skipif(find_spec("anywidget") is None, reason="anywidget, of the extra notebook, is not installed"),
]


def drum() -> Machine:
    rotor = parts.Rotor(name="drum", mass="9 kg", eccentricity="1 mm", inertia="0.03 kg m^2")
    ball = parts.Pendulum(name="ball", about="drum", mass="125 g", length="104 mm", damping="0.17 N m s")
    motor = parts.LinearDrive(slope="0.04 N m s", no_load_speed="200 rad/s")
    carrier = parts.Carrier(mass="1 kg", stiffness="1e5 N/m", damping="200 N s/m")
    return Machine(carrier, [rotor, ball], [motor], title="A drum")


def text_of(page: str) -> dict[str, Any]:
    text: dict[str, Any] = json.loads(re.search(r"^const page = (.*);$", page, re.M)[1])["text"]  # type: ignore[index]
    return text


def test_a_machine_that_is_in_no_file_has_a_study_file_from_its_parts() -> None:
    text = text_of(wucht.live(drum(), start={"ball": 0.3}, until=3.0).page)
    assert text["reason"] == ""
    assert text["verdict"][0]
    assert 'kind = "pendulum"' in text["machine"]


def test_what_is_shown_can_be_run_on() -> None:
    widget = wucht.live(drum(), until=0.2)
    with pytest.raises(InputError, match="no study file was received from the page yet"):
        widget.question()
    text = text_of(widget.page)
    widget.study = f'{text["machine"]}\n[machine.set]\n"drive.slope" = 0.05\n{text["study"]}until = 0.3\n'
    spec, machine = widget.question()
    assert machine.values["drive.slope"] == 0.05
    assert wucht.run(spec, machine).time.values[-1] == pytest.approx(0.3)
    widget.study = "[machine]\nuse = '/etc/passwd'"
    with pytest.raises(InputError, match=r"machine\.use"):
        widget.question()


@pytest.mark.parametrize(
    ("machine", "options", "sentence"),
    [
        ("nothing", {}, "given 'nothing'; must be a study or machine file, or a catalogue name"),
        ("drozdetskaya-2020/r1", {"until": -1}, "study.until"),
        ("drozdetskaya-2020/r1", {"start": 3}, "study.start"),
    ],
)
def test_bad_input_is_one_sentence(machine: Any, options: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        wucht.live(machine, **options)


def test_without_anywidget_it_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    live_widget._widget_class.cache_clear()
    monkeypatch.setitem(sys.modules, "anywidget", None)
    with pytest.raises(InputError, match=r"live: this needs the extra: pip install wucht\[notebook\]"):
        wucht.live("drozdetskaya-2020/r1")


_CELL = """<!doctype html><meta charset="utf-8"><body><script type="module">
const values = { page: PAGE, height: 700, study: "" };
window.studies = [];
const model = {
  get: (name) => values[name],
  set: (name, value) => { values[name] = value; },
  save_changes: () => window.studies.push(values.study),
  on() {}, off() {},
};
const module = await import(URL.createObjectURL(new Blob([WIDGET], { type: "text/javascript" })));
window.leave = module.default.render({ model, el: document.body });
</script>"""


def cell(browser: Browser, file: Path, page: str) -> Page:
    """A notebook in short: a model, and the widget's own script."""
    contents = {"PAGE": page, "WIDGET": built_file("widget.js")}
    html = _CELL
    for name, text in contents.items():
        html = html.replace(name, json.dumps(text).replace("<", "\\u003c"))
    file.write_text(html, encoding="utf-8")
    shown = browser.new_context(viewport={"width": 1280, "height": 720}).new_page()
    shown.goto(file.as_uri())
    shown.frame_locator("iframe").locator("html[data-courses]").wait_for(state="attached", timeout=20_000)
    return shown


@pytest.mark.slow
def test_in_a_frame_of_its_own_the_page_computes_and_tells_what_it_shows(browser: Browser, tmp_path: Path) -> None:
    widget = wucht.live(drum(), start={"ball": 0.3}, until=3.0)
    page = cell(browser, tmp_path / "cell.html", widget.page)
    frame = page.frame_locator("iframe")
    assert page.get_attribute("iframe", "sandbox") == "allow-scripts allow-downloads"
    page.wait_for_function("studies.length > 0")
    widget.study = page.evaluate("studies.at(-1)")
    assert widget.question()[1].values == drum().values
    slope = frame.locator("input[type=text][aria-label^='slope']")
    slope.fill("0.05")
    slope.press("Enter")
    page.wait_for_function("studies.length > 1")
    widget.study = page.evaluate("studies.at(-1)")
    spec, machine = widget.question()
    assert machine.values == drum().values | {"drive.slope": 0.05}
    assert spec.until == 3.0
    assert frame.locator("text=Copy link").count() == 0, "a frame has no address"
    assert page.evaluate("document.querySelector('iframe').contentDocument") is None, "neither reaches the other"
    frame.locator("text=Copy study file").click()
    frame.locator(".message:not(:empty)").wait_for()
    assert "Study file copied" in frame.locator(".message").inner_text() or frame.locator("textarea").is_visible()
    page.evaluate("postMessage({ wucht: 'study', study: 'of another page' }, '*')")
    page.evaluate("leave()")
    slope.fill("0.06")
    slope.press("Enter")
    page.wait_for_timeout(500)
    assert page.evaluate("studies.length") == 2
    page.context.close()
