"""The site: pages from schemas have every key, the papers' numbers are met, and nothing is loaded from elsewhere."""

from __future__ import annotations

import re
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
from docs.site import __main__ as site
from docs.site import gallery, live_pictures, pictures, reference_pages
from docs.site.gallery import Entry
from docs.site.published import at, compared, contradicted, published
from page_blocks import PAGES

from wucht import run
from wucht.files.catalogue import load_document, names
from wucht.kinds import classes_of
from wucht.machines.models import models
from wucht.machines.parts import GROUP, bodies, carriers, drives, loads
from wucht.machines.parts.base import Part
from wucht.schema import keys_of
from wucht.studies.registry import studies
from wucht.studies.study_file import read_study

FEW = ("drozdetskaya-2020/figure-2.7", "sperling-rollers/figure-8", "practice/grinder-2-balls")


@pytest.fixture(scope="module")
def reference() -> dict[str, str]:
    name = FEW[0]
    about, path = load_document(name)
    return reference_pages.pages([Entry(name, read_study(name), about, None, path, path)])


def test_every_study_and_part_has_a_page_with_all_its_keys(reference: dict[str, str]) -> None:
    classes: dict[str, type[Any]] = {f"studies/{kind}.md": study.study for kind, study in studies().items()}
    classes |= {f"parts/{place}.md": cls for place, (_, cls, _) in reference_pages.parts()}
    machines = [cls for kinds in (carriers(), bodies(), drives(), loads(), models()) for cls in kinds.values()]
    assert {cls for cls in classes.values() if issubclass(cls, Part)} >= {*machines, *classes_of(Part, GROUP)}
    for place, cls in classes.items():
        assert [key.name for key in keys_of(cls) if f"| `{key.name}` |" not in reference[place]] == [], place


def test_the_page_of_a_part_has_its_own_states(reference: dict[str, str]) -> None:
    assert "| `lining` | lining travel | m |" in reference["parts/attachments/friction-damper.md"]
    assert "## States" not in reference["parts/attachments/end-stop.md"]


def test_units_defaults_and_limits_stand_there(reference: dict[str, str]) -> None:
    pendulum, run_up = reference["parts/bodies/pendulum.md"], reference["studies/run-up.md"]
    assert "| `length` | distance of the centre of mass from the axis or pivot | m | **needed** | number > 0 |" in pendulum
    assert "body that it turns about | N m s | `0.0` | number >= 0 |" in pendulum
    assert "| `tolerance` | tolerance of the integration |  | `1e-12` | number >= 1e-16, <= 0.01 |" in run_up
    assert '| `model` | equations: `"full"`, averaged' in run_up
    assert "| `woehler.k` | slope of the Woehler line |" in reference["studies/load-spectrum.md"]


def test_the_help_of_a_key_is_in_its_row(reference: dict[str, str]) -> None:
    page = reference["studies/run-up.md"]
    assert "| `speed_limit` | speed beyond which the run ends as `runaway` |" in page
    assert f"](../gallery/{FEW[0]}.md), `{FEW[0]}`" in reference["studies/phase-portrait.md"]


def test_published_numbers_are_of_the_catalogue() -> None:
    assert set(published()) <= set(names())
    for name, about in published().items():
        assert set(about) <= {"shows", "numbers", "given"}, name
        for number in about.get("numbers", ()):
            assert set(number) <= {"quantity", "path", "value", "by", "within", "relative", "unit"}, name


def test_what_differs_is_seen() -> None:
    name = "sperling-rollers/figure-8"
    near, far = ({"final_phases": {"r1": r1, "r2": 4.59}} for r1 in (2.42, 2.6))
    assert [c.agrees for c in compared(name, near)] == [True, True]
    assert [c.agrees for c in compared(name, far)] == [False, True]
    assert contradicted("sperling-vibration/figure-4", {"outcome": "passed"}) != []
    assert at({"a": [{"b": 3}]}, ["a", 0, "b"]) == 3


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(published()))
def test_published_numbers_are_met(name: str) -> None:
    study = read_study(name)
    summary = run(study.study, study.subject).wucht.summary
    assert [c for c in compared(name, summary) if not c.agrees] == []
    assert contradicted(name, summary) == []


def test_pictures_are_there_and_small() -> None:
    files = {p.name for p in pictures.FOLDER.iterdir()}
    screens = {f"{name}.webp" for name in live_pictures.SCREENS}
    assert files == {f"{name}.png" for name in (*pictures.PICTURES, *pictures.DRAWINGS)} | screens
    assert sum((pictures.FOLDER / f).stat().st_size for f in files) < pictures.LARGEST
    shown = set(re.findall(r"docs/pictures/([\w-]+\.png)", PAGES["README.md"].read_text(encoding="utf-8")))
    assert shown == {f"{name}.png" for name in pictures.PICTURES}
    assert set(pictures.PICTURES.values()) <= set(names())


def test_expensive_files_are_of_the_catalogue() -> None:
    assert set(names()) >= gallery.EXPENSIVE


@pytest.mark.slow
def test_an_answer_is_kept_until_question_or_code_change(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gallery, "KEPT", tmp_path)
    name = "drozdetskaya-2020/figure-2.7"
    assert gallery.entry(name, compute=False).result is None
    first = gallery.entry(name)
    assert first.figure.is_file()
    monkeypatch.setattr(gallery, "run_study", lambda *_, **__: pytest.fail("it is there already"))
    again = gallery.entry(name)
    assert again.result.attrs["created"] == first.result.attrs["created"]
    monkeypatch.setattr(gallery, "digest", lambda numbers_alone: "other code")
    assert gallery.entry(name, compute=False).result is None


@pytest.mark.slow
@pytest.mark.skipif(any(find_spec(n) is None for n in site.NEEDED), reason="needs the extra docs: pip install 'wucht[docs]'")
def test_the_site_is_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With a few files of the catalogue. A link that leads nowhere, a reference to nothing, is an error."""
    for module, name in ((gallery, "KEPT"), (site, "PAGES"), (site, "SITE")):
        monkeypatch.setattr(module, name, tmp_path / name)
    entries = [gallery.entry(n) for n in FEW]
    site.write(entries)
    site.build()
    html = {p.relative_to(site.SITE).as_posix(): p.read_text(encoding="utf-8") for p in site.SITE.rglob("*.html")}
    assert {f"gallery/{n}.html" for n in FEW} | {"index.html", "api.html", "errata.html", "theory.html"} <= set(html)
    assert all((site.SITE / f"gallery/{n}.png").is_file() for n in FEW)
    loaded = [u for text in html.values() for u in re.findall(r'<(?:script|link|img|iframe)[^>]*(?:src|href)="([^"]*)"', text)]
    assert [u for u in loaded if re.match(r"(?:https?:)?//", u)] == []
    assert "<math" in html["theory.html"]
    assert "<math" in html["errata.html"]
    assert not [page for page, text in html.items() if 'class="arithmatex"' in text or "<!-- equations" in text]
    assert "139°" in html["gallery/sperling-rollers/figure-8.html"]
    assert "periodic_orbit" in html["api.html"]
