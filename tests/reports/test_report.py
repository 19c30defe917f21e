"""``wucht report``: one page of HTML that loads nothing, escapes everything, and is the same to the last byte."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest

import wucht as package
from wucht.results.output_folder import load_result
from wucht.results.store import save

Command = Callable[..., Any]
Study = Callable[..., Path]
Refused = Callable[..., str]

_EMPTY = {"meta", "br", "hr", "img", "link", "input"}
_TRAP = '<script>alert("1")</script> & 振動 — ü'


class Page(HTMLParser):
    """The elements of a page; fails where one is not closed."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.words: list[str] = []
        self._open: list[str] = []
        self.feed(text)
        self.close()
        assert self._open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        if tag not in _EMPTY:
            self._open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self._open.pop() == tag

    def handle_data(self, data: str) -> None:
        if "style" not in self._open:
            self.words.append(data)

    @property
    def text(self) -> str:
        return " ".join(" ".join(self.words).split())


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Results of three studies, in one folder."""
    folder = tmp_path_factory.mktemp("results")
    drum = {"study.until": 0.3}
    package.run_file("practice/grinder-4-balls", drum, folder=folder / "grinder")
    package.run_file("practice/screen", {"study.kind": "torque-balance"}, folder=folder / "screen")
    package.run_file("kaltofen-cam/dwell-and-return", {"study.kind": "cam-law"}, folder=folder / "cam")
    return folder


def _page(wucht: Command, *arguments: str) -> str:
    assert wucht("report", *arguments, "-o", "report.html").code == 0
    return Path("report.html").read_text(encoding="utf-8")


def _changed(source: Path, target: Path, **attributes: Any) -> Path:
    """A copy of a result with other attributes, in a folder of its own."""
    result = load_result(source)
    target.mkdir(parents=True)
    save(result.assign_attrs(attributes), target / "result.nc")
    return target


@pytest.mark.slow
def test_one_result_has_verdict_figure_machine_numbers_and_study_file(wucht: Command, here: Path, results: Path) -> None:
    page = Page(_page(wucht, str(results / "screen")))
    said = package.report(package.load(results / "screen"))
    assert said[1].removeprefix("verdict: ") in page.text
    svgs = [attrs for tag, attrs in page.elements if tag == "svg"]
    assert [attrs["aria-label"] for attrs in svgs] == [
        "drawing of Vibratory screen with two exciters whose induction motors differ slightly",
        "torque-balance of Vibratory screen with two exciters whose induction motors differ slightly",
    ]
    assert "Mount 1, stiffness in y 110 N/mm" in page.text
    assert "Voltage of a phase 230 V" in page.text
    assert "Steady speeds at which the torques balance" in page.text
    assert "155.2 rad/s (1482 rpm)" in page.text
    assert page.text.count("Report on") == 0
    start = next(k for k, words in enumerate(page.words) if words.startswith("[study]"))
    document = tomllib.loads(page.words[start])
    assert document == json.loads(load_result(results / "screen").attrs["document"])


@pytest.mark.slow
def test_several_results_have_a_chapter_each_and_a_table_of_contents(wucht: Command, here: Path, results: Path) -> None:
    text = _page(
        wucht, str(results / "screen" / "result.nc"), str(results), str(results / "screen"), "--title", "For a customer"
    )
    page = Page(text)
    assert [attrs["id"] for tag, attrs in page.elements if tag == "section"] == ["r1", "r2", "r3"]
    links = [attrs["href"] for tag, attrs in page.elements if tag == "a"]
    assert links == ["#r1", "#r2", "#r3"]
    assert text.index("For a customer") < text.index("<nav>") + 60
    assert [text.count(f"<h1>{title}") for title in ("For a customer", "Vibratory screen", "Angle grinder")] == [1, 1, 1]


@pytest.fixture(scope="module")
def of_one_machine(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Results about one machine, in another order than that of their names; in the last one its unbalance is another."""
    folder = tmp_path_factory.mktemp("screen")
    questions: list[dict[str, Any]] = [
        {"study.kind": "torque-balance"}, {"study.kind": "synchronous-states", "study.full": False}, {"study.kind": "response"},
        {"study.kind": "torque-balance", "e2.unbalance": 0.5},
    ]  # fmt: skip
    for k, question in enumerate(questions):
        package.run_file("practice/screen", question, folder=folder / str(9 - k))
    return [folder / str(9 - k) for k in range(len(questions))]


def test_many_results_begin_with_the_answers_and_tell_the_machine_once(
    wucht: Command, here: Path, of_one_machine: list[Path]
) -> None:
    text = _page(wucht, *map(str, of_one_machine))
    page = Page(text)
    loaded = [package.load(place).wucht for place in of_one_machine]
    first_page = text[text.index("<nav>") : text.index("</nav>") + 6]
    for k, result in enumerate(loaded, 1):
        assert f'href="#r{k}"' in first_page and result.sentence.split(";")[0] in Page(first_page).text
    assert "155.2 rad/s (1482 rpm)" in first_page, "a main number"
    headings = [words for words in page.words if re.match(r"\d\. [a-z]", words)]
    assert [words.split()[1].rstrip(":") for words in headings] == [result.study for result in loaded], "in the order given"
    assert [attrs["aria-label"] for tag, attrs in page.elements if tag == "svg"].count(f"drawing of {loaded[0].title}") == 1
    assert page.text.count("Mount 1, stiffness in y") == 1
    assert len(re.findall(r"circuit of the nameplate", page.text)) == len({note.partition(": ")[2] for note in loaded[0].notes})
    assert page.text.count("[machine.carrier]") == 1, "its file"
    assert page.text.count("Different in this machine") == 1
    different = text[text.index("Different in this machine") :]
    assert "e2: Unbalance" in Page(different[different.index("<table") : different.index("</table>") + 8]).text
    assert "Report on" not in page.text and f"<h1>{loaded[0].title}" in text


@pytest.mark.slow
def test_one_among_results_of_another_machine_has_its_own_drawing(
    wucht: Command, here: Path, of_one_machine: list[Path], results: Path
) -> None:
    page = Page(_page(wucht, str(of_one_machine[0]), str(results / "grinder"), str(of_one_machine[1])))
    assert sum(str(attrs.get("aria-label")).startswith("drawing of") for tag, attrs in page.elements if tag == "svg") == 2
    assert "Machine of 1, 3: Vibratory screen" in page.text
    assert "Report on 3 results" in page.text


@pytest.mark.slow
def test_candidates_that_were_not_chosen_are_left_out_unless_all_is_asked_for(
    wucht: Command, here: Path, results: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from wucht.studies.cam_law import CamLaw

    summary = load_result(results / "cam").wucht.summary | {"tried": [{"mass of a candidate": 1.5}]}
    _changed(results / "cam", here / "search", summary=json.dumps(summary))
    assert "Mass of a candidate" in _page(wucht, "search")
    monkeypatch.setattr(CamLaw, "trials", ("tried",))
    assert "Mass of a candidate" not in _page(wucht, "search")
    assert "Mass of a candidate" in _page(wucht, "search", "--all")


def test_the_searches_leave_out_their_trials() -> None:
    from wucht.studies.registry import studies

    assert studies()["exciter-design"].study.trials == ("runs", "polished")
    assert studies()["optimise-balancer"].study.trials == ("compared",)
    assert studies()["run-up"].study.trials == ()


@pytest.mark.slow
def test_no_identifier_occurs_twice_and_every_reference_has_its_target(wucht: Command, here: Path, results: Path) -> None:
    text = _page(wucht, str(results))
    ids = re.findall(r'\bid="([^"]+)"', text)
    assert len(ids) == len(set(ids)) > 20
    references = set(re.findall(r'href="#([^"]+)"|url\(#([^)]+)\)', text))
    assert {a or b for a, b in references} <= set(ids)


def test_nothing_is_loaded_from_elsewhere(wucht: Command, here: Path, results: Path) -> None:
    text = _page(wucht, str(results))
    page = Page(text)
    assert {tag for tag, _ in page.elements} & {"script", "link", "iframe", "object", "embed", "base", "form", "img"} == set()
    for tag, attrs in page.elements:
        for name in ("src", "href", "xlink:href", "srcset", "action", "data"):
            value = attrs.get(name)
            assert value is None or value.startswith(("#", "data:image/png;base64,")), (tag, name, value)
        assert not [name for name in attrs if name.startswith("on")]
    assert re.findall(r"https?:|@import|@font-face", text) == []
    assert [u for u in re.findall(r"url\(([^)]*)\)", text) if not u.startswith("#")] == []


@pytest.mark.slow
def test_the_same_results_give_the_same_bytes(
    wucht: Command, here: Path, results: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "0")
    first = _page(wucht, str(results))
    assert "Report of 1970-01-01" in first
    assert _page(wucht, str(results)) == first


@pytest.mark.slow
def test_titles_are_escaped_and_shortened(wucht: Command, here: Path, results: Path) -> None:
    _changed(results / "cam", here / "trap", title=_TRAP, sentence=_TRAP, warnings=json.dumps([_TRAP, "a\x00b\u202e\ud800"]))
    text = _page(wucht, "trap", "--title", _TRAP + "</style><b>")
    page = Page(text)
    assert _TRAP in page.text
    assert not [tag for tag, _ in page.elements if tag in ("script", "b") and tag == "script"]
    assert "</style><b>" not in text
    assert text.count("</style>") == 1
    assert not set("\x00\u202e") & set(text)
    short = len(text)
    _changed(results / "cam", here / "long", title="A long title " * 8000)
    long = _page(wucht, "long")
    assert len(long) < short + 5000
    assert Page(long).text.count("…") >= 2


def test_long_study_files_are_abridged(wucht: Command, here: Path, results: Path) -> None:
    table = {"points": [[k, 2 * k] for k in range(5000)], "note": "x" * 100_000}
    _changed(results / "cam", here / "table", document=json.dumps({"study": {"kind": "cam-law"}, "law": table}))
    page = Page(_page(wucht, "table"))
    assert "4,976 more" in page.text
    assert "99,800 more characters" in page.text
    assert "the result file has all of them" in page.text


def test_a_result_of_version_0_1_has_verdict_and_numbers(wucht: Command, refused: Refused, here: Path, results: Path) -> None:
    """It did not state what a result contains, nor its lines, nor units and words of its numbers."""
    result = load_result(results / "grinder")
    for name in ("contents", "lines", "quantities", "assumed", "notes", "parts"):
        del result.attrs[name]
    save(result, here / "first.nc")
    lines = package.report(load_result(here / "first.nc"))
    assert lines[1] == f"verdict: {result.wucht.sentence}"
    assert "version 0.1" in lines[2]
    assert f"peak amplitude: {result.wucht.summary['peak_amplitude']:.4g}" in "\n".join(lines)
    text = Page(_page(wucht, "first.nc")).text
    assert result.wucht.sentence in text and "of version 0.1 of wucht" in text
    assert "version 0.1" in refused("plot", "first.nc")


@pytest.mark.parametrize(
    ("name", "given"),
    [("versions", "x"), ("document", "[null]"), ("created", "yesterday")],
)
def test_a_report_is_written_without_what_says_how_it_was_computed(
    wucht: Command, here: Path, results: Path, name: str, given: str
) -> None:
    _changed(results / "cam", here / "crafted", **{name: given})
    sentence = rf"crafted/result.nc: {name}: given {re.escape(repr(given))}; this attribute of the result must be a "
    with pytest.warns(UserWarning, match=sentence):
        page = Page(_page(wucht, "crafted"))
    assert ("wucht a version that is not recorded" in page.text) == (name == "versions")
    assert ("Study file" in page.text) == (name != "document")
    assert ("Computed 20" in page.text) == (name != "created")


def test_bad_places(refused: Refused, here: Path, results: Path) -> None:
    (here / "file").write_text("")
    (here / "folder.html").mkdir()
    cam = str(results / "cam")
    refused("report", cam, "-o", "folder.html", says=("-o", "this is a folder"))
    refused("report", cam, "-o", "result.nc", says=("-o", "result.nc", "must be the name of a page of HTML"))
    refused("report", cam, "-o", "file/report.html", says=("-o", "nothing can be written there"))
    refused("report", cam, "-o", "n" * 300 + ".html", says=("-o",))


@pytest.mark.slow
def test_an_earlier_report_survives_a_failure(refused: Refused, wucht: Command, here: Path, results: Path) -> None:
    before = _page(wucht, str(results / "cam"))
    (here / "damaged.nc").write_bytes(b"nothing")
    refused("report", str(results / "cam"), "damaged.nc", "-o", "report.html", says=("damaged.nc",))
    assert Path("report.html").read_text(encoding="utf-8") == before
    assert sorted(path.name for path in here.iterdir()) == ["damaged.nc", "report.html"]


def test_an_incomplete_result_says_so(wucht: Command, here: Path, results: Path) -> None:
    _changed(results / "cam", here / "broken", finished=0, failure="the integration stopped at t = 1 s")
    page = Page(_page(wucht, "broken"))
    assert "This result is incomplete the integration stopped at t = 1 s" in page.text


def test_bad_results(refused: Refused, here: Path, results: Path) -> None:
    (here / "empty").mkdir()
    _changed(results / "cam", here / "unknown", study="no-such-study")
    refused("report", "absent.nc", says=("absent.nc", "there is no such file"))
    refused("report", "empty", says=("empty", "there is no result.nc in this folder"))
    refused("report", "unknown", says=("unknown", "no-such-study"))
    assert not Path("report.html").exists()


def test_columns_that_do_not_fit_are_named(wucht: Command, here: Path, results: Path) -> None:
    rows = [{f"key {k}": k * row for k in range(9)} for row in range(1, 7)]
    summary = load_result(results / "cam").wucht.summary | {"rows": rows}
    _changed(results / "cam", here / "wide", summary=json.dumps(summary))
    page = Page(_page(wucht, "wide"))
    assert "Also in the result file: key 7, key 8." in page.text
    assert "Key 6" in page.text and "Key 7" not in page.text
