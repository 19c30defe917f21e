"""How many errors the fast tests notice: random ones, put into the source one at a time.

``python -m benchmarks.noticed record`` runs the fast tests once in a copy of the tree with coverage, a context a test, into
``build/noticed`` (``pip install pytest-cov``). Tests that fail in the copy, as those of workers that load the installed
package, count for no error. ``python -m benchmarks.noticed COUNT [SEED]`` puts in COUNT errors, in lines drawn evenly, and
runs the fast tests that came to the line. Each error is printed with the test that notices it. Some that go unnoticed change
nothing (a bound never met exactly, the seed of a random start): who reads the list takes those off.

``python -m benchmarks.noticed FILE.json`` puts in the errors of a list: ``[{"file": ..., "old": ..., "new": ...}, ...]``, texts
that occur once in their file.
"""

from __future__ import annotations

import ast
import copy
import json
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from itertools import islice
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parent.parent
RECORD = ROOT / "build" / "noticed"
_MOST_TESTS, _LONGEST_S = 400, 420.0
_FIRST = 25  # tests that are run before the others
_OTHER = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.In: ast.NotIn,
    ast.NotIn: ast.In, ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div,
    ast.Div: ast.Mult, ast.And: ast.Or, ast.Or: ast.And,
}  # fmt: skip
_NAMES = (
    ("x", "y"), ("low", "high"), ("min", "max"), ("argmin", "argmax"), ("sin", "cos"), ("real", "imag"), ("first", "last"),
    ("begin", "end"), ("any", "all"), ("floor", "ceil"), ("least", "greatest"), ("left", "right"),
)  # fmt: skip
_SWAPPED = dict(_NAMES) | {b: a for a, b in _NAMES}


@dataclass(frozen=True)
class Error:
    """An error in a line of a file. source: the whole file with it."""

    file: str
    line: int
    before: str
    after: str
    source: str


def _changed(node: ast.AST) -> Iterator[dict[str, Any]]:
    """The fields of a node as an error would have them, one error at a time."""
    match node:
        case ast.Compare(ops=[op, *others]) if type(op) in _OTHER:
            yield {"ops": [_OTHER[type(op)](), *others]}
        case ast.BinOp(op=op) | ast.BoolOp(op=op) | ast.AugAssign(op=op) if type(op) in _OTHER:
            yield {"op": _OTHER[type(op)]()}
        case ast.Constant(value=bool(value)):
            yield {"value": not value}
        case ast.Constant(value=int(value)):
            yield {"value": value + 1}
        case ast.Constant(value=float(value)):
            yield {"value": 2 * value or 1.0}
        case ast.Attribute(attr=name) if name in _SWAPPED:
            yield {"attr": _SWAPPED[name]}
        case ast.If(test=test):
            yield {"test": ast.UnaryOp(ast.Not(), test)}
        case ast.IfExp(body=body, orelse=orelse):
            yield {"body": orelse, "orelse": body}
        case ast.Call(args=[one, two, *others]) if ast.dump(one) != ast.dump(two):
            yield {"args": [two, one, *others]}


def _places(node: ast.AST, within: bool = False) -> Iterator[ast.AST]:
    """The nodes in functions, but for annotations, refusals and texts."""
    if isinstance(node, ast.Raise | ast.Assert | ast.JoinedStr):
        return
    within = within or isinstance(node, ast.FunctionDef)
    if within and hasattr(node, "lineno"):
        yield node
    for name, value in ast.iter_fields(node):
        if name not in ("annotation", "returns", "decorator_list"):
            for inner in value if isinstance(value, list) else [value]:
                if isinstance(inner, ast.AST):
                    yield from _places(inner, within)


def errors(seed: int) -> Iterator[Error]:
    """Random errors without end, in lines that are drawn evenly."""
    draw, files = random.Random(seed), sorted((ROOT / "src").rglob("*.py"))
    sources = {file: file.read_text(encoding="utf-8") for file in files}
    weights = [source.count("\n") for source in sources.values()]
    while True:
        (file,) = draw.choices(files, weights)
        tree = ast.parse(sources[file])
        by_line: dict[int, list[tuple[ast.AST, dict[str, Any]]]] = {}
        for node in _places(tree):
            for fields in _changed(node):
                by_line.setdefault(node.lineno, []).append((node, fields))  # type: ignore[attr-defined]
        if by_line:
            line = draw.choice(sorted(by_line))
            node, fields = draw.choice(by_line[line])
            before = ast.unparse(copy.deepcopy(node)).partition("\n")[0]
            for name, value in fields.items():
                setattr(node, name, value)
            after = ast.unparse(ast.fix_missing_locations(node)).partition("\n")[0]
            if after != before:
                yield Error(str(file.relative_to(ROOT)), line, before, after, ast.unparse(ast.fix_missing_locations(tree)))


def listed_errors(path: Path) -> Iterator[Error]:
    """The errors of a list in a file.

    Raises
    ------
    ValueError
        A text that is to be replaced does not occur exactly once.
    """
    for entry in json.loads(path.read_text(encoding="utf-8")):
        source = (ROOT / entry["file"]).read_text(encoding="utf-8")
        if source.count(entry["old"]) != 1:
            raise ValueError(f"{entry['file']}: {entry['old']!r} does not occur once")
        pairs = enumerate(zip(entry["old"], entry["new"], strict=False))
        equal = next((i for i, (a, b) in pairs if a != b), min(len(entry["old"]), len(entry["new"])))
        line = source[: source.index(entry["old"]) + equal].count("\n") + 1
        yield Error(entry["file"], line, entry["old"], entry["new"], source.replace(entry["old"], entry["new"]))


@contextmanager
def _copied_tree() -> Iterator[Path]:
    """A copy of the tree, in which errors are put."""
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder) / "wucht"
        shutil.copytree(ROOT, tree, ignore=shutil.ignore_patterns(".git", ".venv", "build", ".*_cache"))
        yield tree


@cache
def _failing() -> frozenset[str]:
    """The tests that fail in a copy without an error."""
    path = RECORD / "cache" / "v" / "cache" / "lastfailed"
    return frozenset(json.loads(path.read_text(encoding="utf-8")) if path.exists() else ())


@cache
def _recorded() -> Any:
    from coverage import CoverageData

    data = CoverageData(str(RECORD / ".coverage"))
    data.read()
    return data


def tests_of(error: Error) -> list[str]:
    """The tests that came to the line; of a line that runs at import those of the whole file, most of its lines first."""
    file = next((f for f in _recorded().measured_files() if f.endswith(error.file)), "")
    lines = _recorded().contexts_by_lineno(file)
    own = Counter(c.partition("|")[0] for c in lines.get(error.line, []) if c)
    every = Counter(c.partition("|")[0] for contexts in lines.values() for c in contexts if c)
    chosen, path = [test for test, _ in (own or every).most_common() if test not in _failing()], Path(error.file)
    # Those that are written for the file before the others of its folder, and these before all others.
    chosen.sort(key=lambda test: (f"test_{path.stem}" not in test, f"/{path.parent.name}/" not in test))
    return chosen[:_MOST_TESTS]


def _modules(error: Error, tests: list[str]) -> list[str]:
    """Whole files of tests: those of tests that came to the line, and those of the folder that mirrors the error's.

    What a fixture of a module runs, or a function that keeps its results, is recorded for the first test alone that needs it.
    """
    mirrored = ROOT / "tests" / Path(error.file).relative_to("src/wucht").parent
    beside = sorted(str(path.relative_to(ROOT)) for path in mirrored.glob("test_*.py")) if mirrored.name != "tests" else []
    return list(dict.fromkeys([*(test.partition("::")[0] for test in tests), *beside]))


def noticing_test(error: Error, tree: Path) -> str | None:
    """The test that fails first, in a copy of the tree; None where none does."""
    file, tests = tree / error.file, tests_of(error)
    before = file.read_text(encoding="utf-8")
    file.write_text(error.source, encoding="utf-8")
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", "-m", "not slow"]
    try:
        deselected = [f"--deselect={test}" for test in sorted(_failing())]
        for some in (tests[:_FIRST], tests[_FIRST:], _modules(error, tests)):
            if some:
                environment = os.environ | {"PYTHONPATH": str(tree / "src")}
                options: dict[str, Any] = {
                    "cwd": tree,
                    "env": environment,
                    "capture_output": True,
                    "text": True,
                    "timeout": _LONGEST_S,
                }
                ended = subprocess.run([*command, *deselected, *some], check=False, **options)
                if ended.returncode not in (0, 5):
                    named = re.search(r"^(?:FAILED|ERROR) (\S+)", ended.stdout, re.MULTILINE)
                    return named[1] if named else "the start of the tests"
    except subprocess.TimeoutExpired:
        return f"no end within {_LONGEST_S:g} s"
    finally:
        file.write_text(before, encoding="utf-8")
    return None


def record() -> None:
    """Run the fast tests once in a copy, with coverage and a context a test."""
    shutil.rmtree(RECORD, ignore_errors=True)
    RECORD.mkdir(parents=True)
    options = ["--cov=wucht", "--cov-context=test", "--cov-report=", "-o", f"cache_dir={RECORD / 'cache'}"]
    command = [sys.executable, "-m", "pytest", "-q", "-n", "2", "--dist", "loadfile", "-m", "not slow", *options]
    with _copied_tree() as tree:
        environment = os.environ | {"COVERAGE_FILE": str(RECORD / ".coverage"), "PYTHONPATH": str(tree / "src")}
        subprocess.run(command, cwd=tree, env=environment, check=False)


def main() -> None:
    if sys.argv[1] == "record":
        record()
        return
    if sys.argv[1].endswith(".json"):
        drawn = list(listed_errors(Path(sys.argv[1])))
    else:
        drawn = list(islice(errors(int(sys.argv[2]) if len(sys.argv) > 2 else 1), int(sys.argv[1])))
    missed = 0
    with _copied_tree() as tree:
        for error in drawn:
            test = noticing_test(error, tree)
            missed += test is None
            print(f"{error.file}:{error.line}  {error.before}  ->  {error.after}\n    {test or 'unnoticed'}", flush=True)
    print(f"{len(drawn) - missed} of {len(drawn)} errors were noticed")


if __name__ == "__main__":
    main()
