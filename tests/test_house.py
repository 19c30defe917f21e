"""The house of docs/design.md: each floor knows only those below it, there is no circle, and importing wucht loads nothing."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

from wucht.schema import TableModel
from wucht.studies.registry import studies, study_of

SOURCE = Path(__file__).parent.parent / "src" / "wucht"
FLOORS = [
    "earlier_names", "errors", "environment", "disk_cache", "schema", "file_names", "machine_shape", "piecewise", "system",
    "kinds", "results", "numerics", "fatigue", "mechanics", "machines", "files", "analysis", "measurements", "cams", "dynamics",
    "plots", "studies", "extending_0_1", "reports", "web", "extending", "cli",
]  # fmt: skip
ALLOWED = {floor: set(FLOORS[: FLOORS.index(floor) + 1]) for floor in FLOORS}
MODULES = {path.relative_to(SOURCE.parent).with_suffix("").as_posix().replace("/", ".").removesuffix(".__init__"): path
           for path in sorted(SOURCE.rglob("*.py"))}  # fmt: skip
# Studies are folders, or single modules with a template beside them.
STUDIES = sorted(
    [p.parent.name for p in (SOURCE / "studies").glob("*/template.toml")]
    + [p.stem for p in (SOURCE / "studies").glob("*.toml")]
)


@cache
def _nodes(path: Path) -> tuple[list[ast.AST], list[ast.AST]]:
    """The imports of a file: all of them, and those within functions."""
    every: list[ast.AST] = []
    inside: list[ast.AST] = []
    pending: list[tuple[ast.AST, bool]] = [(ast.parse(_text(path)), False)]
    while pending:
        node, within = pending.pop()
        within = within or isinstance(node, ast.FunctionDef)
        if isinstance(node, ast.Import | ast.ImportFrom):
            every.append(node)
            inside += [node] * within
        pending += [
            (child, within)
            for child in ast.iter_child_nodes(node)
            if isinstance(child, ast.stmt | ast.excepthandler | ast.match_case)
        ]
    return every, inside


def _imports(path: Path, in_functions: bool = False) -> set[str]:
    """The modules of wucht that a file imports, whether for types, in functions or at the top."""
    names: set[str] = set()
    for node in _nodes(path)[in_functions]:
        if isinstance(node, ast.Import):
            names |= {a.name for a in node.names}
        elif isinstance(node, ast.ImportFrom):
            names |= {
                f"{node.module}.{a.name}" if f"{node.module}.{a.name}" in MODULES else str(node.module) for a in node.names
            }
    return {n for n in names if n.split(".")[0] == "wucht"}


@cache
def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8")


def _floor(module: str) -> str:
    return module.split(".")[1] if "." in module else ""


@pytest.mark.parametrize("module", MODULES)
def test_each_floor_knows_only_those_below(module: str) -> None:
    if _floor(module) in ("", "__main__"):
        return
    assert {_floor(m) for m in _imports(MODULES[module])} - {""} <= ALLOWED[_floor(module)]


@pytest.mark.parametrize("module", [m for m in MODULES if _floor(m) == "dynamics"])
def test_engines_know_no_spec_and_no_figure(module: str) -> None:
    assert {m for m in _imports(MODULES[module]) if _floor(m) in ("results", "studies", "cli")} == set()


def test_no_files_import_each_other_in_a_circle() -> None:
    edges = {m: {i for i in _imports(path) if i in MODULES and i != m} for m, path in MODULES.items()}
    reach: dict[str, set[str]] = {}
    for module in MODULES:
        seen, pending = set[str](), [module]
        while pending:
            for other in edges[pending.pop()] - seen:
                seen.add(other)
                pending.append(other)
        reach[module] = seen
    assert [m for m in MODULES if m in reach[m]] == []


@pytest.mark.parametrize("module", [m for m in MODULES if _floor(m) not in ("", "cli", "__main__")])
def test_no_import_within_a_function_hides_a_circle(module: str) -> None:
    """All of ours is imported at the top."""
    assert _imports(MODULES[module], in_functions=True) == set()


@pytest.mark.parametrize("module", [m for m in MODULES if _floor(m) == "plots"])
def test_plots_know_datasets_alone(module: str) -> None:
    assert {_floor(m) for m in _imports(MODULES[module])} <= {"plots", "results", "file_names", "machine_shape", "errors"}


DRAWING_FLOORS = "plots", "studies", "reports", "web", "cli", "extending", "extending_0_1", ""


@pytest.mark.parametrize("module", [m for m in MODULES if _floor(m) not in DRAWING_FLOORS])
def test_what_lies_below_the_plots_draws_nothing(module: str) -> None:
    names = {a.name for node in _nodes(MODULES[module])[0] if isinstance(node, ast.Import) for a in node.names}
    names |= {str(node.module) for node in _nodes(MODULES[module])[0] if isinstance(node, ast.ImportFrom)}
    assert not {n for n in names if n.split(".")[0] == "matplotlib"}


@cache
def _definitions(module: str) -> dict[str, ast.stmt]:
    """What a module defines or imports at its top, by name."""
    found: dict[str, ast.stmt] = {}
    body = ast.parse(_text(MODULES[module])).body
    for node in [inner for one in body for inner in (one.body if isinstance(one, ast.If) else [one])]:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            found[node.name] = node
            methods = node.body if isinstance(node, ast.ClassDef) else []
            found |= {f"{node.name}.{m.name}": m for m in methods if isinstance(m, ast.FunctionDef)}
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
                found |= {n.id: node for n in ast.walk(target) if isinstance(n, ast.Name)}
        elif isinstance(node, ast.Import | ast.ImportFrom):
            found |= {(a.asname or a.name).split(".")[0]: node for a in node.names}
    return found


def _used_by(module: str, name: str, own: str) -> set[str]:
    """The modules of wucht that a function uses, whatever it calls in the modules of ``own`` on its way."""
    modules, done, pending = set[str](), set[tuple[str, str]](), [(module, name)]
    while pending:
        where, what = pending.pop()
        node = _definitions(where).get(what)
        if node is None or (where, what) in done:
            continue
        done.add((where, what))
        if not isinstance(node, ast.Import | ast.ImportFrom):
            pending += [(where, n.id) for n in ast.walk(node) if isinstance(n, ast.Name)]
        elif isinstance(node, ast.ImportFrom) and str(node.module).startswith("wucht"):
            inside = f"{node.module}.{what}"
            if inside in MODULES:
                modules.add(inside)
            elif str(node.module) == own or str(node.module).startswith(f"{own}."):
                pending.append((str(node.module), what))
            else:
                modules.add(str(node.module))
    return modules


def test_what_a_function_uses_is_followed_into_what_it_calls() -> None:
    """The next test would not notice much, were it not so."""
    module = "wucht.studies.torque_balance"
    assert "wucht.dynamics.work" in _used_by(module, "TorqueBalance.solve", module)
    assert "wucht.analysis.working_points" in _used_by(module, "TorqueBalance.prepare", module)
    assert "wucht.results.formatting" in _used_by(module, "TorqueBalance.draw", module)


@pytest.mark.parametrize("study", STUDIES)
def test_a_figure_knows_the_dataset_alone(study: str) -> None:
    cls = studies()[study.replace("_", "-")].study
    whole, drawing, module = f"wucht.studies.{study}", f"{cls.__name__}.draw", cls.__module__
    assert drawing in _definitions(module)
    used = _used_by(module, drawing, whole)
    assert used
    assert {m for m in used if _floor(m) not in ("plots", "results", "errors")} == set()


@pytest.mark.parametrize("study", STUDIES)
def test_no_study_imports_another(study: str) -> None:
    """What two of them need is an engine, or shared keys, and lies below them."""
    others = {
        f"{module} imports {name}"
        for module, path in MODULES.items()
        if f"{module}.".startswith(f"wucht.studies.{study}.")
        for name in _imports(path)
        if name.startswith("wucht.studies.") and name.split(".")[2] in set(STUDIES) - {study}
    }
    assert others == set()


@pytest.mark.parametrize("study", STUDIES)
def test_a_study_is_a_module_or_a_folder_of_what_it_needs(study: str) -> None:
    """It has its class and a template, and nothing outside the studies knows it."""
    kind = study.replace("_", "-")
    assert studies()[kind].study.kind == kind
    assert f'kind = "{kind}"' in studies()[kind].template
    words = (f"studies.{study}", f'"{kind}"')
    elsewhere = {m for m, path in MODULES.items() if f".studies.{study}" not in m and any(w in _text(path) for w in words)}
    assert {m for m in elsewhere if _floor(m) != "studies" and m != "wucht"} == set(), "nothing outside the studies knows it"


_OF_THE_EARLIER_FORM = ("spec", "prepare", "run", "dataset", "report", "computation")


def test_no_two_modules_bear_one_name() -> None:
    of_every_study = {"study", "answer", "figure", "export", "__init__", *_OF_THE_EARLIER_FORM}
    names = [path.stem for m, path in MODULES.items() if path.stem not in of_every_study and _floor(m) != "cli"]
    assert sorted({n for n in names if names.count(n) > 1}) == []


@pytest.mark.parametrize("name", ["parts", "RunUp", "Machine"])
def test_a_name_of_the_package_is_there_whatever_was_loaded_before(name: str) -> None:
    code = f"import wucht; print(wucht.{name}.__name__)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip().rpartition(".")[2] == name


def test_a_study_is_loaded_without_what_draws_and_stores() -> None:
    """`wucht list` loads all of them."""
    code = "import sys; from wucht.studies.registry import studies; [s.study for s in studies().values()]; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not {"matplotlib", "xarray", "pandas"} & set(done.stdout.split())


def test_importing_wucht_loads_nothing_heavy() -> None:
    heavy = {"numpy", "sympy", "llvmlite", "xarray", "pint", "matplotlib", "pydantic"}
    code = f"import sys, wucht; print(sorted({heavy} & set(sys.modules)))"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"


LONGEST_LINE = 128


@pytest.mark.parametrize(
    "path", sorted([*(SOURCE / "web").glob("*.ts"), *(SOURCE / "web").glob("*.css")]), ids=lambda p: p.name
)
def test_no_line_of_the_page_is_too_long(path: Path) -> None:
    assert [number for number, line in enumerate(_text(path).splitlines(), 1) if len(line) > LONGEST_LINE] == []


# --- names ---


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


_PARTICIPLES = _words(
    "become begun bent bound built cut drawn felt given gone held kept known led lost made met put sent shown "
    "sought spun stood struck swept taken thrown torn worn written"
)
_PRONOUNS = _words("all any both each either neither none other others some such that these they this those")
_QUESTIONS = _words("how what when where whether which who whom whose why")
_PREPOSITIONS = _words(
    "above across after against along among around as before behind below beside between beyond by down for in into "
    "near off on onto out over per through under until up within"
)
_LOOSE = _words("asked found own said seen told")
_NOT_PARTICIPLES = _words("bed exceed embed feed need seed shed speed")
# Labels that are printed, what `wucht list --json` and a summary write by these names, and names in public use.
_NAMED_BY_OTHERS = _words(
    "prepared Prepared averaged separated strongly_damped needed allowed what recovered rounded only_seen tiled UNDECIDED "
    "FIXED GIVEN SETTLED STOPPED FAILED"
)


def _reason_against(name: str, is_function: bool) -> str:
    """The reason why a name says nothing of the thing, or an empty string."""
    words = [w.lower() for w in re.split(r"_+", re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name)) if w]
    if not words or name.startswith("__"):
        return ""
    if _LOOSE & set(words):
        return "a loose word"
    if words[0] in _QUESTIONS:
        return "a question"
    if len(words) == 1 and words[0] in _PRONOUNS:
        return "a pronoun"
    if len(words) == 1 and (words[0] in _PARTICIPLES or (words[0].endswith("ed") and words[0] not in _NOT_PARTICIPLES)):
        return "a participle"
    return "a preposition" if is_function and len(words) > 1 and words[0] in _PREPOSITIONS else ""


def _names_in(tree: ast.AST) -> Iterator[tuple[str, bool, int]]:
    """All names that a module defines, whether of a function or class, and their lines."""
    for node in ast.walk(tree):
        match node:
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name):
                yield name, True, node.lineno
            case ast.arg(arg=name) | ast.Name(id=name, ctx=ast.Store()) | ast.alias(asname=str(name)):
                yield name, False, node.lineno
            case ast.ExceptHandler(name=str(name)) | ast.MatchAs(name=str(name)) | ast.MatchStar(name=str(name)):
                yield name, False, node.lineno


@pytest.mark.parametrize(
    ("name", "is_function", "reason"),
    [
        ("found", False, "a loose word"), ("_own_values", True, "a loose word"), ("why", False, "a question"),
        ("what_fits", True, "a question"), ("Tried", True, "a participle"), ("_kept", False, "a participle"),
        ("others", False, "a pronoun"), ("_between", True, ""), ("after_resonance", True, "a preposition"),
        ("after_resonance", False, ""), ("closed_curve", True, ""), ("speed", False, ""), ("__add__", True, ""),
        ("with_values", True, ""), ("ObserverState", True, ""),
    ],
)  # fmt: skip
def test_what_is_no_name(name: str, is_function: bool, reason: str) -> None:
    assert _reason_against(name, is_function) == reason


@pytest.mark.parametrize("module", MODULES)
def test_names_say_what_a_thing_is(module: str) -> None:
    """No participle, pronoun or question word alone; functions begin with what they return or do. Keys of files are exempt."""
    allowed = _NAMED_BY_OTHERS | _outcome_names() | _keys_of_files()
    bad = [
        f"{name} ({reason}, line {line})"
        for name, is_function, line in _names_in(ast.parse(_text(MODULES[module])))
        if name not in allowed and (reason := _reason_against(name, is_function))
    ]
    assert not bad


@cache
def _outcome_names() -> frozenset[str]:
    from wucht.dynamics.verdicts.outcomes import Outcome

    return frozenset(outcome.name for outcome in Outcome)


@cache
def _keys_of_files() -> frozenset[str]:
    """The keys of all tables in files: fields of studies, parts and what is inside."""
    for study in studies():
        _ = study_of(study).study
    pending, keys = [TableModel], set[str]()
    while pending:
        model = pending.pop()
        keys |= set(model.model_fields)
        pending += model.__subclasses__()
    return frozenset(keys)


# What a study consists of, by the same names in each.
_PROTOCOL = _words("Findings Plan dataset export figure numbers prepare report run")


def test_no_public_name_stands_for_two_things() -> None:
    """Functions and classes of modules; but for what each study has, and commands, which are called as what they run."""
    modules: dict[str, list[str]] = {}
    for module, path in MODULES.items():
        for node in ast.parse(_text(path)).body:
            if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_") and _floor(module) != "cli":
                modules.setdefault(node.name, []).append(module)
    assert {name: places for name, places in modules.items() if len(places) > 1 and name not in _PROTOCOL} == {}


@pytest.mark.parametrize("module", MODULES)
def test_a_share_is_printed_with_a_space_before_its_sign(module: str) -> None:
    """Formats of Python print 1.28% without one. Fields of report lines, which print it, are no f-strings."""
    formats = [node for node in ast.walk(ast.parse(_text(MODULES[module]))) if isinstance(node, ast.FormattedValue)]
    specs = [ast.unparse(node.format_spec) for node in formats if node.format_spec is not None]
    assert [spec for spec in specs if spec.rstrip("\"'").endswith("%")] == []
