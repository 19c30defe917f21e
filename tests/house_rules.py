"""``python -m tests.house_rules [FOLDER]``: what ruff and mypy do not know of the house of docs/design.md.

Each rule reads the modules of a package as text, and yields the places where it is broken, ``module:line: what``.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

SOURCE = Path(__file__).parents[1] / "src" / "wucht"
FLOORS = [
    "earlier_names", "errors", "environment", "disk_cache", "schema", "file_names", "machine_shape", "piecewise",
    "function_trace", "function_call", "system", "kinds", "results", "numerics", "fatigue", "mechanics", "machines", "files",
    "analysis",
    "measurements", "cams", "dynamics", "plots", "studies", "extending_0_1", "reports", "web", "extending", "cli",
]  # fmt: skip
_DRAWING = ("plots", "studies", "reports", "web", "cli", "extending", "extending_0_1", "")
_LONGEST_LINE = 128


@dataclass(frozen=True)
class Module:
    """A module of the package, whose folder is ``source``, by its name with dots."""

    name: str
    path: Path
    source: Path

    @property
    def floor(self) -> str:
        """The folder or file below the package in which it lies, empty for the package itself."""
        return self.name.split(".")[1] if "." in self.name else ""

    @cached_property
    def text(self) -> str:
        return self.path.read_text(encoding="utf-8")

    @cached_property
    def nodes(self) -> list[ast.AST]:
        return list(ast.walk(self.tree))

    @cached_property
    def tree(self) -> ast.Module:
        return ast.parse(self.text)

    @cached_property
    def imports(self) -> list[tuple[ast.Import | ast.ImportFrom, bool]]:
        """All imports, and whether each stands within a function."""
        found, pending = [], [(node, False) for node in self.tree.body]
        while pending:
            node, inside = pending.pop()
            if isinstance(node, ast.Import | ast.ImportFrom):
                found.append((node, inside))
            inside = inside or isinstance(node, ast.FunctionDef)
            children = [c for c in ast.iter_child_nodes(node) if isinstance(c, ast.stmt | ast.excepthandler | ast.match_case)]
            pending += [(child, inside) for child in children]  # type: ignore[misc]
        return found

    def imported(self, names: Collection[str], inside: bool = False) -> dict[str, int]:
        """The modules that it imports, of any package, with their lines; of ours to the file, whose names are given."""
        found = {}
        for node, within in self.imports:
            if inside and not within:
                continue
            if isinstance(node, ast.Import):
                found |= {alias.name: node.lineno for alias in node.names}
            else:
                whole = {alias.name: f"{node.module}.{alias.name}" for alias in node.names}
                found |= {full if full in names else str(node.module): node.lineno for full in whole.values()}
        return found


Modules = Mapping[str, Module]
Rule = Callable[[Modules], Iterator[str]]


def modules_in(source: Path) -> dict[str, Module]:
    """The modules of a package by their names with dots."""
    found = {}
    for path in sorted(source.rglob("*.py")):
        name = path.relative_to(source.parent).with_suffix("").as_posix().replace("/", ".").removesuffix(".__init__")
        found[name] = Module(name, path, source)
    return found


def _source(modules: Modules) -> Path:
    return next(iter(modules.values())).source


def _ours(module: Module, modules: Modules, inside: bool = False) -> dict[str, int]:
    return {n: line for n, line in module.imported(modules, inside).items() if n.split(".")[0] == "wucht"}


def _floor(name: str) -> str:
    return name.split(".")[1] if "." in name else ""


def floors(modules: Modules) -> Iterator[str]:
    """Each floor knows only those below it; engines know no result; figures know Datasets alone; below them nothing draws."""
    for module in modules.values():
        allowed = set(FLOORS[: FLOORS.index(module.floor) + 1]) if module.floor in FLOORS else set(FLOORS)
        allowed -= {"results"} if module.floor == "dynamics" else set()
        if module.floor == "plots":
            allowed = {"plots", "results", "file_names", "machine_shape", "errors"}
        for name, line in _ours(module, modules).items():
            if _floor(name) not in allowed | {""}:
                yield f"{module.name}:{line}: {module.floor} must not know {name}"
        if module.floor not in _DRAWING:
            for name, line in module.imported(modules).items():
                if name.split(".")[0] == "matplotlib":
                    yield f"{module.name}:{line}: {module.floor} must not draw"


def circles(modules: Modules) -> Iterator[str]:
    """No files import each other in a circle, and no import within a function hides one."""
    edges = {name: set(_ours(module, modules)) & set(modules) - {name} for name, module in modules.items()}
    try:
        TopologicalSorter(edges).prepare()
    except CycleError as error:
        yield f"{error.args[1][0]}:1: a circle of imports: {' <- '.join(error.args[1])}"
    for module in modules.values():
        if module.floor not in ("", "cli", "__main__"):
            yield from (
                f"{module.name}:{line}: {n} is to be imported at the top" for n, line in _ours(module, modules, True).items()
            )


def studies_apart(modules: Modules) -> Iterator[str]:
    """No study imports another: what two of them need lies below. Nothing outside the studies knows one, nor its kind."""
    folder = _source(modules) / "studies"
    kinds = {p.parent.name for p in folder.glob("*/template.toml")} | {p.stem for p in folder.glob("*.toml")}
    for module in modules.values():
        own = module.name.split(".")[2] if module.floor == "studies" and module.name.count(".") > 1 else ""
        if own in kinds:
            for name, line in _ours(module, modules).items():
                if _floor(name) == "studies" and name.count(".") > 1 and name.split(".")[2] in kinds - {own}:
                    yield f"{module.name}:{line}: a study imports {name}"
        elif module.floor not in ("studies", ""):
            for kind in kinds:
                if f"studies.{kind}" in module.text or f'"{kind.replace("_", "-")}"' in module.text:
                    yield f"{module.name}:1: knows the study {kind}"


def one_name_one_thing(modules: Modules) -> Iterator[str]:
    """No two modules bear one name, and no public name stands for two things; but for what each study has, and commands."""
    of_each_study = {
        "study",
        "answer",
        "figure",
        "export",
        "__init__",
        "spec",
        "prepare",
        "run",
        "dataset",
        "report",
        "computation",
    }
    protocol = {"Findings", "Plan", "dataset", "export", "figure", "numbers", "prepare", "report", "run"}
    stems: dict[str, str] = {}
    definitions: dict[str, str] = {}
    for module in modules.values():
        if module.floor == "cli":
            continue
        stem = module.path.stem
        if stem not in of_each_study and stems.setdefault(stem, module.name) != module.name:
            yield f"{module.name}:1: has the name of {stems[stem]}"
        for node in module.tree.body:
            if not isinstance(node, ast.FunctionDef | ast.ClassDef) or node.name.startswith("_") or node.name in protocol:
                continue
            if definitions.setdefault(node.name, module.name) != module.name:
                yield f"{module.name}:{node.lineno}: {node.name} stands in {definitions[node.name]} as well"


def shares_with_a_space(modules: Modules) -> Iterator[str]:
    """A share is printed with a space before its sign: formats of Python print 1.28% without one."""
    for module in modules.values():
        formats = [node for node in module.nodes if isinstance(node, ast.FormattedValue) and node.format_spec is not None]
        for node in formats:
            if ast.unparse(node.format_spec or node).rstrip("\"'").endswith("%"):
                yield f"{module.name}:{node.lineno}: a share without a space before its sign"


def lines_of_the_page(modules: Modules) -> Iterator[str]:
    """No line of TypeScript or CSS is longer than those of Python."""
    web = _source(modules) / "web"
    for path in sorted([*web.glob("*.ts"), *web.glob("*.css")]):
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            if len(line) > _LONGEST_LINE:
                yield f"web/{path.name}:{number}: longer than {_LONGEST_LINE}"


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


def reason_against(name: str, is_function: bool) -> str:
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


def _names_in(module: Module) -> Iterator[tuple[str, bool, int]]:
    """All names that a module defines, whether of a function or class, and their lines."""
    for node in module.nodes:
        match node:
            case ast.FunctionDef(name=name) | ast.ClassDef(name=name):
                yield name, True, node.lineno
            case ast.arg(arg=name) | ast.Name(id=name, ctx=ast.Store()) | ast.alias(asname=str(name)):
                yield name, False, node.lineno
            case ast.ExceptHandler(name=str(name)) | ast.MatchAs(name=str(name)) | ast.MatchStar(name=str(name)):
                yield name, False, node.lineno


def _names_by_others() -> set[str]:
    """Keys of files, which their users know, and outcomes."""
    from wucht.dynamics.verdicts.outcomes import Outcome
    from wucht.schema import TableModel
    from wucht.studies.registry import studies, study_of

    for study in studies():
        _ = study_of(study).study
    pending, names = [TableModel], {outcome.name for outcome in Outcome} | _NAMED_BY_OTHERS
    while pending:
        model = pending.pop()
        names |= set(model.model_fields)
        pending += model.__subclasses__()
    return names


def names(modules: Modules) -> Iterator[str]:
    """Names say what a thing is: no participle, pronoun or question word alone; functions begin with what they return or do."""
    exempt = _names_by_others()
    for module in modules.values():
        for name, is_function, line in _names_in(module):
            if name not in exempt and (reason := reason_against(name, is_function)):
                yield f"{module.name}:{line}: {name} is {reason}"


RULES: tuple[Rule, ...] = (floors, circles, studies_apart, one_name_one_thing, shares_with_a_space, lines_of_the_page, names)


def violations(source: Path = SOURCE) -> list[str]:
    """All places of a package where a rule is broken."""
    modules = modules_in(source)
    return [place for rule in RULES for place in rule(modules)]


if __name__ == "__main__":
    places = violations(*map(Path, sys.argv[1:]))
    sys.stdout.writelines(f"{place}\n" for place in places)
    sys.exit(bool(places))
