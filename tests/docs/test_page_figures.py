"""Figures, notebooks, links and words of the pages: what the site makes of them, without making the whole site."""

from __future__ import annotations

import json
import math
import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
from docs.site import __main__ as site
from docs.site import gallery, gallery_pages, notebooks, page_figures, reference_pages
from docs.site.page_figures import MARK, figures_of, with_figures
from docs.site.paper_links import with_paper_links
from docs.site.title_link import on_post_page
from page_blocks import PAGES, blocks

from wucht.schema import keys_of
from wucht.studies.registry import studies

TEXTS = {name: page.read_text(encoding="utf-8") for name, page in PAGES.items()}
FIGURES = [pytest.param(name, k, id=f"{name}-{k}") for name, text in TEXTS.items() for k in range(len(figures_of(text)))]
STEEL = 7850.0  # kg/m^3


def test_many_pages_have_a_figure() -> None:
    """Tutorials, guides, outcomes, machines to try: no page of a study is counted, which has one from the gallery."""
    with_one = {name for name, text in TEXTS.items() if MARK.search(text)}
    assert len(with_one) >= 15
    assert {f"docs/tutorials/{name}.md" for name in ("engineer", "researcher", "student")} <= with_one
    assert {name for name in TEXTS if name.startswith("docs/practice/") and not name.endswith("README.md")} <= with_one
    for name, text in TEXTS.items():
        if name != "docs/design.md":
            assert text.count("<!-- figure") == len(MARK.findall(text)), f"{name}: a mark that is none"


@pytest.mark.parametrize(("name", "number"), FIGURES)
def test_a_figure_is_of_a_study_that_can_be_read(name: str, number: int, tmp_path: Path) -> None:
    page_figures.write_files(TEXTS[name], tmp_path)
    figure = figures_of(TEXTS[name])[number]
    assert figure.study(tmp_path).spec.kind in studies()
    assert figure.file not in gallery.EXPENSIVE, "a page has no figure that takes minutes"


def test_only_settings_may_follow_the_file_of_a_figure() -> None:
    mark = MARK.search("<!-- figure: practice/screen --json | A screen -->")
    assert mark is not None
    with pytest.raises(ValueError, match="--set"):
        page_figures.PageFigure.from_mark(mark)


def test_a_mark_becomes_a_picture_beside_the_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a file of the page itself, with a setting; kept from one call to the next, and left out where it is not there."""
    monkeypatch.setattr(gallery, "KEPT", tmp_path)
    mark = "<!-- figure: mine.toml --set set.mu=0.25 | Two fixed points -->"
    source = 'use = "drozdetskaya-2020/figure-2.7"'
    monkeypatch.setattr(page_figures, "read_study", lambda name, settings: _asked(name, settings, asked))
    asked: list[tuple[str, Any]] = []
    page = f'# Page\n\n```toml title="mine.toml"\n{source}\n```\n\n{mark}\n\nText.\n'
    without, none = with_figures("guide/one.md", page, compute=False)
    assert none == {}
    assert "Two fixed points" not in without
    text, pictures = with_figures("guide/one.md", page)
    assert list(pictures) == ["guide/one-1.png"]
    assert pictures["guide/one-1.png"].read_bytes().startswith(b"\x89PNG")
    assert "![Two fixed points](one-1.png)" in text
    assert text.replace("\n", " ").count("<figcaption>Two fixed points</figcaption>") == 1
    assert Path(asked[0][0]).name == "mine.toml"
    assert asked[0][1] == {"set.mu": 0.25}
    again, kept = with_figures("guide/one.md", page, compute=False)
    assert (again, kept) == (text, pictures)


def _asked(name: str, settings: Any, asked: list[tuple[str, Any]]) -> Any:
    from wucht.studies.study_file import read_study

    assert Path(name).read_text(encoding="utf-8") == 'use = "drozdetskaya-2020/figure-2.7"\n'
    asked.append((name, settings))
    return read_study("drozdetskaya-2020/figure-2.7")


def test_a_thumbnail_has_one_panel(tmp_path: Path) -> None:
    """The first one with its second scale: neither the panels below, nor legends, nor titles; wide enough to be read."""
    from matplotlib.figure import Figure
    from PIL import Image

    figure = Figure(figsize=(6, 12), layout=None)
    above, below = figure.subplots(2, height_ratios=(1, 5))
    above.plot([0, 1], [0, 1], color=(1, 0, 0), linewidth=4)
    above.twinx().plot([0, 1], [1, 0], color=(0, 1, 0), linewidth=4)
    below.plot([0, 1], [0, 1], color=(0, 0, 1), linewidth=4)
    above.legend([above.plot([], [], color=(1, 0, 1), linewidth=4)[0]], ["a line"])
    figure.suptitle("A title")
    gallery._save_panel(figure, tmp_path / "panel.png")
    with Image.open(tmp_path / "panel.png") as image:
        colours = {colour for _, colour in image.convert("RGB").getcolors(1 << 20) or []}
        assert 1.2 < image.width / image.height < 2.0
    assert {(255, 0, 0), (0, 255, 0)} <= colours
    assert not {(0, 0, 255), (255, 0, 255)} & colours


def test_papers_are_linked_where_their_numbers_stand() -> None:
    sentence = "As 002 (4.60)-(4.62) and `001 (20)` say, 12 000 N; [001 (60)](x.md). 000 Table 1."
    page = f"# 002 (4.60) in a heading\n\n{sentence}\n\n```text\n001 (20)\n```\n"
    linked = with_paper_links("practice/one.md", page)
    assert "[002 (4.60)-(4.62)](../sources.md#paper-002)" in linked
    assert "[000 Table 1](../sources.md#paper-000)." in linked
    assert linked.count("](") == 3, "code, headings and links stay as they are"
    sources = TEXTS["docs/sources.md"]
    for paper in ("000", "001", "002", "004"):
        assert f'<span id="paper-{paper}"></span>**{paper}**' in sources
    assert with_paper_links("sources.md", sources) == sources
    assert sum(with_paper_links("guide.md", text).count("#paper-") for text in TEXTS.values()) > 20


def test_the_title_leads_to_the_first_page() -> None:
    """By name: a page that is opened as a file has no server to find it. The second text is the title of the page."""

    class Page:
        url = "gallery/practice/screen.html"

    head = '<span class="md-ellipsis">\n wucht\n </span><span class="md-ellipsis"> Screen </span>'
    shown = on_post_page(head, page=Page(), config={"extra": {"homepage": "index.html"}})
    assert '<a class="site-title" href="../../index.html">wucht</a>' in shown
    assert shown.count("<a ") == 1
    assert "homepage: index.html" in (site.HERE / "mkdocs.yml").read_text(encoding="utf-8")


def test_pages_are_listed_by_their_titles_and_the_machines_to_try_come_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A path without a title: MkDocs takes the first heading of the page. Folders have words of their own."""
    monkeypatch.setattr(site, "PAGES", tmp_path)
    for name in ("drozdetskaya-2020/figure-2.10", "drozdetskaya-2020/figure-2.9", "practice/screen", "index"):
        file = tmp_path / "gallery" / f"{name}.md"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text("# A title\n", encoding="utf-8")
    listed = site._listed("gallery/*")
    assert listed == [
        "gallery/index.md",
        {"Machines of our own, with plausible data": ["gallery/practice/screen.md"]},
        {
            gallery_pages.COLLECTIONS["drozdetskaya-2020"]: [
                "gallery/drozdetskaya-2020/figure-2.9.md",
                "gallery/drozdetskaya-2020/figure-2.10.md",
            ]
        },
    ]


def test_every_key_of_a_page_is_explained() -> None:
    """In two words at least, to the end: no bracket or quotation mark is left open, and no comma stands last."""
    tables: dict[str, Any] = {f"studies/{kind}": study.study for kind, study in studies().items()}
    tables |= {place: cls for place, (_, cls, _) in reference_pages.parts()}
    wrong = []
    for place, table in tables.items():
        for key in keys_of(table):
            what = key.what.strip()
            open_brackets = what.count("(") - what.count(")") or what.count("`") % 2
            if (
                len(what.split()) < 2
                or what.endswith((",", ":", ";", "-", "...", " of", " the", " a", " and", " or"))
                or open_brackets
            ):
                wrong.append((place, key.name, what))
    assert wrong == []


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


@pytest.mark.parametrize("words", ["inch", "Excel", "notebook", "Jupyter", "motor failure", "horsepower", "stuck", "mains dip"])
def test_a_search_finds_a_page(words: str) -> None:
    """Each of the words stands in one page, as it is typed."""
    assert [name for name, text in TEXTS.items() if all(re.search(rf"(?i)\b{word}", text) for word in words.split())]


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


def test_there_are_two_notebooks_and_the_pages_lead_to_them() -> None:
    assert len(NOTEBOOKS) == 2
    for file in NOTEBOOKS:
        assert f"notebooks/{file.stem}.md" in TEXTS["docs/index.md"]


def test_every_study_has_a_question() -> None:
    """On the page of questions, but for those that compare results or draw equations alone."""
    text = TEXTS["docs/which-question.md"]
    assert {kind for kind in studies() if f"`{kind}`" not in text} <= {"comparison", "phase-portrait", "stability-map"}
