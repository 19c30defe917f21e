"""Live machines in the pages of the docs: every page about a machine has one, and what a mark becomes."""

from __future__ import annotations

from pathlib import Path

import pytest
from docs.site import gallery, gallery_pages, live_machines, live_pictures, page_figures
from docs.site.live_machines import MARK, with_live_machines
from page_blocks import PAGES

from wucht.dynamics.live_machine import export_obstacles
from wucht.files.catalogue import load_document, names
from wucht.studies.study_file import read_study

TEXTS = {name: page.read_text(encoding="utf-8") for name, page in PAGES.items()}
MARKS = [pytest.param(name, mark[1], id=f"{name}-{mark[1]}") for name, text in TEXTS.items() for mark in MARK.finditer(text)]
WITHOUT = {"docs/practice/README.md", "docs/practice/carton-pusher.md"}  # the list of the others; a cam, which has no machine
needs_page = pytest.mark.skipif(not live_machines.is_built(), reason="npm had no network when wucht was installed")


def test_each_machine_of_practice_and_each_tutorial_has_its_live_machine() -> None:
    expected = {name for name in TEXTS if name.startswith(("docs/practice/", "docs/tutorials/"))} - WITHOUT
    assert {param.values[0] for param in MARKS} >= expected
    for name, text in TEXTS.items():
        assert text.count("<!-- live:") == len(MARK.findall(text)), f"{name}: a mark that is none"


@pytest.mark.parametrize(("name", "file"), MARKS)
def test_its_file_can_be_shared(name: str, file: str, tmp_path: Path) -> None:
    page_figures.write_files(TEXTS[name], tmp_path)
    of_page = tmp_path / file
    assert export_obstacles(read_study(str(of_page) if of_page.is_file() else file).subject) == ()


@needs_page
def test_a_mark_becomes_a_frame_with_the_page_of_the_machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a file of the page and of the catalogue; each is made once, and again where the file or the code changes."""
    monkeypatch.setattr(gallery, "KEPT", tmp_path)
    made = list[str]()

    def shared_page(name: str, verdict: bool | None) -> str:
        made.append(Path(name).name)
        return f"page of {Path(name).name}"

    monkeypatch.setattr(live_machines, "shared_page", shared_page)
    page = (
        '# Page\n\n```toml title="mine.toml"\n[machine]\nuse = "drozdetskaya-2020/r1"\n```\n\n'
        "<!-- live: mine.toml | My machine -->\n\n<!-- live: practice/screen | A screen -->\n"
    )
    text, pages = with_live_machines("guide/one.md", page)
    assert {name: file.read_text(encoding="utf-8") for name, file in pages.items()} == {
        "live/guide/one-mine.html": "page of mine.toml", "live/practice/screen.html": "page of screen",
    }  # fmt: skip
    assert '<iframe src="../live/guide/one-mine.html" title="My machine" loading="lazy"></iframe>' in text
    assert '<iframe src="../live/practice/screen.html" title="A screen"' in text and "<!-- live" not in text
    assert with_live_machines("guide/one.md", page) == (text, pages)
    assert made == ["mine.toml", "screen"]
    monkeypatch.setattr(gallery, "digest", lambda: "other code")
    with_live_machines("guide/one.md", page)
    assert made == ["mine.toml", "screen"] * 2
    with pytest.raises(ValueError, match=r"guide/one\.md: kaltofen-cam/dwell-and-return cannot be shared"):
        with_live_machines("guide/one.md", "<!-- live: kaltofen-cam/dwell-and-return | A cam -->")


def test_without_the_built_page_a_sentence_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(live_machines, "is_built", lambda: False)
    text, pages = with_live_machines("one.md", "<!-- live: practice/screen | A screen -->")
    assert "npm had no network" in text and pages == {} and live_machines.live_files() == {}


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


def test_screens_are_of_the_catalogue_and_their_pictures_are_there() -> None:
    for name, screen in live_pictures.SCREENS.items():
        assert screen.file in names() and (live_pictures.FOLDER / f"{name}.webp").is_file()
