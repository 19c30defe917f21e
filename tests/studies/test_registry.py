"""Studies of one's own and of other packages: what is wrong with one is said before anything is computed."""

from __future__ import annotations

import doctest
import os
import subprocess
import sys
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from tests.refusals import rejected

import wucht.extending
from wucht import Response, TorqueBalance, load, report, run
from wucht.extending import Answer, Study
from wucht.files.building import machine_from
from wucht.studies.registry import StudyEntry, studies

STUDY = """
from typing import ClassVar

from wucht.extending import new_figure, si
from wucht.extending_0_1 import Quantity, Spec, result_dataset


class Counting(Spec):
    \"\"\"Count the bodies of a machine.\"\"\"

    kind: ClassVar[str] = "{kind}"

    most: float | None = si("s", "time", default=None, gt=0)


def prepare(spec, machine):
    print("prepared")
    return machine


def run(plan, work):
    {run}


def dataset(plan, findings):
    return result_dataset([Quantity("bodies", findings, "number of bodies")], f"{{findings}} bodies")


def figure(result):
    return new_figure(1, result.attrs["title"], result.attrs["sentence"], 2.0)[0]


def {report}(result):
    return [result.attrs["sentence"]]
"""
COUNTS = "yield len(plan.bodies)"


@pytest.fixture
def counting(here: Path) -> Iterator[Callable[..., tuple[str, ...]]]:
    """Writes a study of one's own, in a module that no other test imports; it has no kind any more when the test is done."""
    name = f"of_{here.name}".replace("-", "_")

    def written(kind: str = "count", run: str = COUNTS, report: str = "report") -> tuple[str, ...]:
        Path(f"{name}.py").write_text(STUDY.format(kind=kind, run=run, report=report), encoding="utf-8")
        return ("--import", f"{name}.py", "--set", f"study.kind={kind}")

    yield written
    sys.modules[name].Counting.kind = ""


ONE_CLASS = """
from wucht.extending import Answer, Study, new_figure


class Counting(Study):
    \"\"\"Count the bodies of a machine.\"\"\"

    kind = "{kind}"

    def solve(self, machine, prepared, work):
        a = Answer(machine.units)
        a.number("bodies", len(machine.bodies), "number of bodies")
        a.sentence = "counted"
        a.line("bodies", "{{bodies:.3g}}")
        {end} a

    def {draw}(self, result):
        return new_figure(1, result.attrs["title"], result.attrs["sentence"], 2.0)[0]
"""


@pytest.fixture
def module(here: Path) -> Iterator[Callable[..., str]]:
    """Writes a module with a study of one class; it has no kind any more when the test is done."""
    name = f"class_of_{here.name}".replace("-", "_")

    def written(kind: str = "count", end: str = "yield", draw: str = "draw") -> str:
        Path(f"{name}.py").write_text(ONE_CLASS.format(kind=kind, end=end, draw=draw), encoding="utf-8")
        return name

    yield written
    if name in sys.modules:
        sys.modules[name].Counting.kind = ""


@pytest.mark.slow
def test_a_study_is_one_class(wucht: Callable[..., Any], module: Callable[..., str]) -> None:
    name = module()
    done = wucht("run", "practice/laundry-drum", "--import", f"{name}.py", "--set", "study.kind=count", "-o", "out")
    assert (done.code, "  bodies       7" in done.out.splitlines()) == (0, True)
    shown = wucht("report", "out", "--import", f"{name}.py", "-o", "page.html")
    assert shown.code == 0


@pytest.mark.parametrize(("wrong", "says"), [({"end": "return"}, "solve"), ({"draw": "drwa"}, "draw")])
def test_a_class_without_what_a_study_needs_is_refused_when_it_is_made(
    refused: Callable[..., str], module: Callable[..., str], wrong: dict[str, str], says: str
) -> None:
    words = ("run", "practice/laundry-drum", "--import", f"{module(**wrong)}.py", "--set", "study.kind=count")
    refused(*words, says=("--import", "Counting, a study of the kind 'count', must have a method", says))


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"kind": 3}, "its kind must be a text, not 3"),
        ({"solve": lambda self, subject: (yield Answer())}, r"must have a method solve\(self, subject, prepared, work\)"),
        ({"draw": lambda self: None}, r"must have a method draw\(self, result\)"),
        ({"prepare": lambda self: None}, r"must have a method prepare\(self, subject\)"),
        ({"prepare": lambda self, subject, other: None}, r"must have a method prepare\(self, subject\)"),
    ],
)
def test_a_class_whose_methods_have_other_parameters_is_refused(wrong: dict[str, Any], says: str) -> None:
    def solve(self: Study, subject: Any, prepared: Any, work: Any) -> Iterator[Answer]:
        yield Answer()

    right = {"kind": "own", "solve": solve, "draw": lambda self, result: None, "__module__": __name__}
    with pytest.raises(TypeError, match=says):
        type(Study)("Own", (Study,), right | wrong)


@pytest.mark.parametrize(
    ("end", "says"), [("yield 3 or", "yield an Answer, not 3"), ("return\n        yield", "yield at least once")]
)
def test_what_is_no_answer_is_refused(wucht: Callable[..., Any], module: Callable[..., str], end: str, says: str) -> None:
    name = module(end=end)
    done = wucht("run", "practice/laundry-drum", "--import", f"{name}.py", "--set", "study.kind=count")
    assert (done.code, f"the study 'count' ({name})" in done.err) == (1, True)
    assert f"'solve' must {says}" in done.err


def test_two_classes_of_one_module_with_one_kind_are_refused(refused: Callable[..., str], module: Callable[..., str]) -> None:
    file = Path(f"{module()}.py")
    file.write_text(f"{file.read_text(encoding='utf-8')}\n\nclass Other(Counting):\n    kind = 'count'\n", encoding="utf-8")
    words = ("run", "practice/laundry-drum", "--import", str(file), "--set", "study.kind=count")
    refused(*words, says=(f"given 'count'; not allowed: {file.stem}:", "has a study of this kind"))
    sys.modules[file.stem].Other.kind = ""


def test_the_figure_of_a_result_needs_the_module_of_its_study(
    refused: Callable[..., str], wucht: Callable[..., Any], module: Callable[..., str]
) -> None:
    name = module()
    assert wucht("run", "practice/laundry-drum", "--import", f"{name}.py", "--set", "study.kind=count", "-o", "out").code == 0
    known_lines = report(load("out"))
    sys.modules[name].Counting.kind = ""
    refused("plot", "out", says=(f"it is in the module {name}, to be imported first: --import {name}",))
    assert report(load("out")) == known_lines, "its lines are data"


@pytest.mark.parametrize(("place", "warns"), [("{}:Counting", False), ("{}", True)])
def test_an_entry_point_names_a_class_or_a_module_with_one(
    module: Callable[..., str], monkeypatch: pytest.MonkeyPatch, here: Path, place: str, warns: bool
) -> None:
    name = module()
    monkeypatch.syspath_prepend(here)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        assert StudyEntry("count", place.format(name)).study.__name__ == "Counting"
    assert [f"name its class, {name}:Counting" in str(w.message) for w in caught] == [True] * warns


@pytest.fixture
def with_installed(here: Path) -> Callable[..., Callable[..., subprocess.CompletedProcess[str]]]:
    """``with_installed(broken="module")(...)``: the command line where a package is installed that has these studies."""

    def installed(**studies: str) -> Callable[..., subprocess.CompletedProcess[str]]:
        metadata = here / "modules" / "theirs-1.0.dist-info"
        metadata.mkdir(parents=True)
        (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: theirs\nVersion: 1.0\n", encoding="utf-8")
        entries = "\n".join(f"{kind.replace('_', '-')} = {place}" for kind, place in studies.items())
        (metadata / "entry_points.txt").write_text(f"[wucht.studies]\n{entries}\n", encoding="utf-8")
        found = os.pathsep.join([str(metadata.parent), os.environ.get("PYTHONPATH", "")])

        def command(*words: str) -> subprocess.CompletedProcess[str]:
            environment = os.environ | {"PYTHONPATH": found}
            return subprocess.run(
                [sys.executable, "-m", "wucht", *words], env=environment, capture_output=True, text=True, check=False
            )

        return command

    return installed


@pytest.mark.slow
def test_a_study_that_cannot_be_loaded_is_a_line(with_installed: Callable[..., Callable[..., Any]]) -> None:
    """And it is none of those that several machines compute."""
    command = with_installed(broken="no_such_package.study")
    listed = command("list")
    assert listed.returncode == 0
    (line,) = [one for one in listed.stdout.splitlines() if "no_such_package" in one]
    assert line.split()[0] == "broken" and "cannot be loaded: No module named 'no_such_package'" in line
    assert "run-up" in listed.stdout and "catalogue:" in listed.stdout
    with rejected("not-loaded"):
        _ = StudyEntry("broken", "no_such_package.study").study
    refusal = command("run", "practice/fan-on-belt", "--scheduler", "tcp://localhost:1")
    named = refusal.stderr.strip().split("several machines can compute ")[1].split(", ")
    assert refusal.returncode == 2 and named == [kind for kind, entry in studies().items() if entry.study.tiled]


def test_a_misspelt_function_is_refused_before_anything_is_computed(
    wucht: Callable[..., Any], counting: Callable[..., tuple[str, ...]]
) -> None:
    done = wucht("run", "practice/laundry-drum", *counting(report="reprot"))
    assert done.code != 0
    assert "has no function 'report'" in done.err
    assert "prepared" not in done.out


def test_a_kind_that_is_taken_is_refused(wucht: Callable[..., Any], counting: Callable[..., tuple[str, ...]]) -> None:
    done = wucht("run", "practice/laundry-drum", *counting(kind="run-up"))
    assert done.code == 2
    assert "given 'run-up'" in done.err and "wucht.studies.run_up" in done.err


def test_what_has_no_template_has_one_of_its_keys(wucht: Callable[..., Any], counting: Callable[..., tuple[str, ...]]) -> None:
    imported = counting()[:2]
    assert wucht("new", "count", *imported).code == 0
    text = Path("count.toml").read_text(encoding="utf-8")
    assert "Count the bodies of a machine." in text
    assert "# most = ...                     # time; in s; > 0" in text
    assert "7 bodies" in wucht("run", "count.toml", *imported).out


def test_the_example_of_the_public_module() -> None:
    assert doctest.testmod(wucht.extending).failed == 0


def test_an_entry_without_a_study_is_a_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "module_without_a_study", ModuleType("module_without_a_study"))
    study = StudyEntry("own", "module_without_a_study")
    assert study.line == "the study 'own' (module_without_a_study) has no class of that kind"
    assert study.has_tiles is False


@pytest.mark.parametrize("spec", [TorqueBalance(), Response()], ids=lambda spec: spec.kind)
def test_a_long_preparation_reports_its_progress(spec: Study) -> None:
    """The configurations of several rotors are searched before the study runs, and Ctrl-C ends that."""
    rotor = {"kind": "rotor", "mass": 5.0, "unbalance": 0.01, "inertia": 0.01}
    drive = {"kind": "linear", "slope": 0.1, "no_load_speed": 100.0}
    machine = machine_from({
        "carrier": {"mass": 100.0, "stiffness": [1e5, 2e5], "damping": [100.0, 100.0]},
        "bodies": [rotor | {"name": f"e{k}"} for k in range(3)], "drives": [drive | {"on": f"e{k}"} for k in range(3)],
    })  # fmt: skip
    labels = list[str]()

    def stop(_: float, label: str) -> None:
        labels.append(label)
        if len(labels) == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(spec, machine, progress=stop)
    assert labels == ["preparation"] * 3, "before the equations are averaged, and during the search"
