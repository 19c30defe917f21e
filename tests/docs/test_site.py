"""The site: pages of schemas, figures, live machines, notebooks; papers' numbers are met, nothing is loaded from elsewhere."""

from __future__ import annotations

import json
import math
import re
import tomllib
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
from docs.site import __main__ as site
from docs.site import gallery, gallery_pages, live_machines, notebooks, page_figures, reference_pages
from docs.site.gallery import Entry
from docs.site.published import at, compared, contradicted, published
from page_blocks import PAGES, blocks

from wucht import run
from wucht.dynamics.live_machine import export_obstacles
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


@pytest.mark.slow
def test_figures_and_live_machines_of_pages_are_of_files_that_can_be_read(tmp_path: Path) -> None:
    for name, page in PAGES.items():
        text, folder = page.read_text(encoding="utf-8"), tmp_path / name
        folder.mkdir(parents=True)
        page_figures.write_files(text, folder)
        for figure in page_figures.figures_of(text):
            assert figure.study(folder).spec.kind in studies(), name
        for file, _ in live_machines.MARK.findall(text):
            of_page = folder / file
            assert export_obstacles(read_study(str(of_page) if of_page.is_file() else file).subject) == (), (name, file)


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


TEXTS = {name: page.read_text(encoding="utf-8") for name, page in PAGES.items()}
STEEL = 7850.0  # kg/m^3


@pytest.mark.parametrize("name", [n for n in TEXTS if n.startswith("docs/tutorials/")])
def test_balls_of_steel_weigh_what_steel_weighs(name: str) -> None:
    """Rollers with the shape factor of a ball, to half of the last digit that is given."""
    for block in blocks(PAGES[name]):
        if block.language != "toml":
            continue
        for body in tomllib.loads(block.text).get("machine", {}).get("bodies", []):
            if body["kind"] == "roller" and body["shape_factor"] == 0.4:
                radius, mass = 1e-3 * float(body["radius"].removesuffix(" mm")), float(body["mass"].removesuffix(" kg"))
                assert mass == pytest.approx(STEEL * 4 / 3 * math.pi * radius**3, rel=0.02), body["name"]


NOTEBOOKS = sorted(notebooks.FOLDER.glob("*.ipynb"))


@pytest.mark.parametrize("file", NOTEBOOKS, ids=lambda file: file.stem)
def test_a_notebook_is_stored_without_output(file: Path) -> None:
    cells = json.loads(file.read_text(encoding="utf-8"))["cells"]
    assert "".join(cells[0]["source"]).startswith("# ")
    for cell in cells:
        if cell["cell_type"] == "code":
            assert (cell["outputs"], cell["execution_count"]) == ([], None)


@pytest.mark.slow
@pytest.mark.parametrize("file", NOTEBOOKS, ids=lambda file: file.stem)
def test_a_notebook_runs(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    known: dict[str, Any] = {}
    for cell in json.loads(file.read_text(encoding="utf-8"))["cells"]:
        if cell["cell_type"] == "code":
            lines = [line for line in cell["source"] if not line.startswith("%")]
            exec(compile("".join(lines), file.name, "exec"), known)
    printed = capsys.readouterr().out
    expected = {
        "run-up-to-verdict": ("verdict: PASSED", "edge at 0.004933 N m s", "captured\n", "compensated\n"),
        "equations-to-basin": ("hopf at D = 0.165042: jump", "at D = 0.161696", "of these starts end in the oscillation"),
    }
    assert [text for text in expected[file.stem] if text not in printed] == []


needs_page = pytest.mark.skipif(not live_machines.is_built(), reason="npm had no network when wucht was installed")


@needs_page
@pytest.mark.slow
def test_every_machine_of_the_catalogue_but_those_with_releases_has_its_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(gallery, "KEPT", tmp_path)
    pages = live_machines.live_files()
    machines = {name for name in names() if "machine" in load_document(name)[0]}
    shared = {page.removeprefix("live/").removesuffix(".html") for page in pages}
    assert machines - shared == {f"sperling-vibration/{n}" for n in ("figure-4", "figure-4-y-blocked", "table-1")}
    assert max(page.stat().st_size for page in pages.values()) < 250_000
    entry = gallery.Entry("practice/screen", read_study("practice/screen"), {}, None, tmp_path, tmp_path)
    page = gallery_pages.pages([entry], pages)["gallery/practice/screen.md"]
    assert 'class="md-button" href="../../live/practice/screen.html"' in page
