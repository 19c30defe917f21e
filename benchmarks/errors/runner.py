"""``python -m benchmarks errors [NUMBER...] [--slow] [-- PYTEST...]``: which test notices each error of this folder first.

Each error is put into a worktree of its own, of HEAD or another commit, and the tests are run there as ``make test`` runs them,
until one fails: those that bear the changed file's name first, then those of its folder and of its importers' folders. A test
that fails without the error, too, or not by itself, does not count.
``table.csv`` has a row for each error and kind of tests; a row is kept as long as its error and what is tested are the same.
``--slow`` runs the slow tests for errors that the others do not notice. With arguments for pytest (files, ``-k``), in the place
of all tests, the row is one of its own.
"""

from __future__ import annotations

import argparse
import csv
import hashlib
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, fields
from pathlib import Path

_ROOT, _HERE = Path(__file__).parents[2], Path(__file__).parent
_TABLE = _HERE / "table.csv"
_TESTED = ("src", "tests", "docs", "examples", "pyproject.toml")  # what a result depends on, of a commit
_BUILT = Path("src", "wucht", "web", "built")
_KINDS = {"fast": "not slow", "slow": "slow"}
_FIRST_FAILURES = 4
_NO_TESTS = 5  # pytest's exit status where it selects none
_NOTICED, _UNNOTICED, _NOT_APPLIED = "noticed", "not noticed", "does not apply"


@dataclass(frozen=True)
class WrittenError:
    """An error: its number, name and patch, the sentence that it makes wrong, and the file that it changes."""

    number: int
    name: str
    path: Path
    sentence: str
    file: str

    @classmethod
    def read(cls, path: Path) -> WrittenError:
        number, _, name = path.stem.partition("-")
        text = path.read_text(encoding="utf-8")
        sentence, file = re.search(r"^Sentence: (.+)$", text, re.MULTILINE), re.search(r"^\+\+\+ b/(.+)$", text, re.MULTILINE)
        if sentence is None or file is None:
            sys.exit(f"{path}: a patch has a line `Sentence: ...` and a unified diff")
        return cls(int(number), name, path, sentence[1], file[1])

    @property
    def digest(self) -> str:
        return hashlib.sha256(self.path.read_bytes()).hexdigest()[:12]


@dataclass(frozen=True)
class Row:
    """A row of the table. by: the test that failed first. base: the commit. tested: digest of what is tested of it."""

    number: str
    name: str
    tests: str
    outcome: str
    by: str
    base: str
    tested: str
    patch: str
    seconds: str


@dataclass(frozen=True)
class Tests:
    """How tests are run. chosen: arguments for pytest in the place of all tests of the kind. limit: of a run, in s."""

    kind: str
    chosen: tuple[str, ...]
    workers: int
    limit: float

    @property
    def name(self) -> str:
        return shlex.join(self.chosen) or self.kind

    def stages(self, error: WrittenError, tree: Path, are_near: bool) -> list[list[str]]:
        """Return the arguments of each run: for the tests of the changed file's name and of its folder, or for all others."""
        kind = ["-m", _KINDS[self.kind]]
        if self.chosen:
            return [] if are_near else [[*self.chosen, *([] if "-m" in self.chosen else kind)]]
        stages, before = list[list[str]](), list[str]()
        for find in (_tests_called_like, _tests_of_folder, _tests_of_importers):
            if paths := [path for path in find(error.file, tree) if f"--ignore={path}" not in before]:
                stages.append(["-x", *kind, *paths, *before])
                before += [f"--ignore={path}" for path in paths]
        # An error that far tests notice is noticed by several; all are run where the first failures are by chance.
        return stages if are_near else [[f"--maxfail={count}", *kind, *before] for count in (_FIRST_FAILURES, 0)]

    def run(self, tree: Path, words: list[str]) -> subprocess.CompletedProcess[str]:
        """Run pytest in a tree, as the Makefile does. Raises ``TimeoutExpired``."""
        command = [sys.executable, "-m", "pytest", "--tb=no", "-p", "no:cacheprovider", "-n", str(self.workers)]
        variables = {
            "PYTHONPATH": str(tree / "src"),
            "PYTHONDONTWRITEBYTECODE": "",
            "WUCHT_CACHE_DIR": str(tree / "build/cache"),
        }
        return subprocess.run(
            [*command, "--dist", "loadfile", *words],
            cwd=tree, env=os.environ | variables, capture_output=True, text=True, check=False, timeout=self.limit,
        )  # fmt: skip


def _tests_called_like(file: str, tree: Path) -> list[str]:
    """Return the tests that bear a file's name."""
    return sorted(str(path.relative_to(tree)) for path in (tree / "tests").rglob(f"test_{Path(file).stem}*.py"))


def _tests_of_folder(file: str, tree: Path) -> list[str]:
    """Return the folder of tests that mirrors a file's, if there is one."""
    folder = Path(file).relative_to("src/wucht").parent
    while folder.name and not (tree / "tests" / folder).is_dir():
        folder = folder.parent
    return [str(Path("tests") / folder)] if folder.name else []


def _tests_of_importers(file: str, tree: Path) -> list[str]:
    """Return the folders of tests that mirror those of the modules which import a file's."""
    module, folders = ".".join(Path(file).with_suffix("").parts[1:]), set[str]()
    for path in (tree / "src").rglob("*.py"):
        if f"from {module} import" in path.read_text(encoding="utf-8"):
            folders.update(_tests_of_folder(str(path.relative_to(tree)), tree))
    return sorted(folders)


def _git(*words: str) -> str:
    done = subprocess.run(["git", *words], cwd=_ROOT, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"git {shlex.join(words)}: {done.stderr.strip()}")
    return done.stdout.strip()


@contextmanager
def _worktree(base: str) -> Iterator[Path]:
    """A temporary worktree of a commit, with the live machine's page as it is built here."""
    with tempfile.TemporaryDirectory(prefix="wucht-errors-") as folder:
        tree = Path(folder, "wucht")
        _git("worktree", "add", "--quiet", "--detach", str(tree), base)
        try:
            if (_ROOT / _BUILT).is_dir():
                shutil.copytree(_ROOT / _BUILT, tree / _BUILT)
            yield tree
        finally:
            _git("worktree", "remove", "--force", str(tree))


def _build_page(tree: Path) -> str:
    """Build the live machine's page of a tree, as pip does (``hatch_build.py``); return what the build says where it fails."""
    command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "-w", str(tree / "build"), str(tree)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if (tree / _BUILT / "live.js").is_file():
        return ""
    if "npm run" in done.stderr + done.stdout:
        return "the build of the page"
    sys.exit(f"the page of the live machine cannot be built here:\n{done.stdout}{done.stderr}")


def _fails(test: str, tree: Path, tests: Tests) -> bool:
    """True if a test fails by itself."""
    return tests.run(tree, ["-n", "0", test]).returncode != 0


def _refuse_arguments(words: list[str], clean: Path, tests: Tests) -> None:
    """End the program where pytest cannot even collect the tests of the commit."""
    collected = tests.run(clean, ["--collect-only", "-q", *words])
    if collected.returncode not in (0, _NO_TESTS):
        sys.exit(f"pytest cannot collect these tests:\n{collected.stdout}{collected.stderr}")


def _noticed_by(error: WrittenError, tree: Path, clean: Path, tests: Tests, are_near: bool) -> str:
    """Return the first test that fails in a tree with an error; nothing where there is none.

    It fails by itself, too, and does not in the tree without the error: others depend on those before them, or on chance.
    """
    if error.file.endswith(".ts") and (fault := _build_page(tree)):
        return fault
    for words in tests.stages(error, tree, are_near):
        try:
            done = tests.run(tree, words)
        except subprocess.TimeoutExpired:
            return f"no end within {tests.limit / 60:g} min"
        if done.returncode in (0, _NO_TESTS):
            if are_near:
                continue
            return ""
        failed = re.findall(r"^(?:FAILED|ERROR) (.+?)(?: - .*)?$", done.stdout, re.MULTILINE)
        if not failed:
            _refuse_arguments(words, clean, tests)
            return "the start of the tests"
        noticing = (test for test in failed if _fails(test, tree, tests) and not _fails(test, clean, tests))
        if (test := next(noticing, None)) is not None:
            return test
    return ""


def _read_table(path: Path) -> dict[tuple[str, str], Row]:
    if not path.exists():
        return {}
    with path.open(encoding="utf-8", newline="") as file:
        return {(entry["number"], entry["tests"]): Row(**entry) for entry in csv.DictReader(file)}


def _write_table(path: Path, rows: dict[tuple[str, str], Row]) -> None:
    part = path.with_suffix(".part")
    with part.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, [field.name for field in fields(Row)], lineterminator="\n")
        writer.writeheader()
        writer.writerows(asdict(rows[key]) for key in sorted(rows, key=lambda key: (int(key[0]), key[1])))
    part.replace(path)


def _results(errors: list[WrittenError], base: str, tests: Tests) -> Iterator[tuple[WrittenError, str, str, float]]:
    """Yield each error with its outcome, the test that notices it, and how long that took in s.

    First those that the tests near the changed file notice, which takes seconds; the others then need all tests.
    """
    pending = errors
    for are_near in (True, False):
        later = []
        with _worktree(base) as clean:
            for error in pending:
                begin = time.monotonic()
                with _worktree(base) as tree:
                    if subprocess.run(["git", "apply", str(error.path)], cwd=tree, capture_output=True, check=False).returncode:
                        outcome, by = _NOT_APPLIED, ""
                    else:
                        by = _noticed_by(error, tree, clean, tests, are_near)
                        outcome = _NOTICED if by else _UNNOTICED
                if outcome == _UNNOTICED and are_near:
                    later.append(error)
                else:
                    yield error, outcome, by, time.monotonic() - begin
        pending = later


def _is_current(row: Row | None, error: WrittenError, tested: str) -> bool:
    return row is not None and (row.patch, row.tested) == (error.digest, tested)


def _options(words: list[str]) -> tuple[argparse.Namespace, Tests]:
    own, chosen = (words[: words.index("--")], words[words.index("--") + 1 :]) if "--" in words else (words, [])
    parser = argparse.ArgumentParser("python -m benchmarks errors", description=__doc__.splitlines()[0])
    parser.add_argument("numbers", metavar="NUMBER", nargs="*", type=int, help="of errors; by default all")
    parser.add_argument("--slow", action="store_true", help="run the slow tests, for errors that the others do not notice")
    parser.add_argument("--base", default="HEAD", help="the commit into which they are put (default: HEAD)")
    parser.add_argument("--workers", default=2, type=int, help="processes of the tests (default: 2)")
    parser.add_argument("--limit", default=60.0, type=float, help="minutes after which a run of tests is ended (default: 60)")
    parser.add_argument("--table", default=_TABLE, type=Path, help="the table (default: table.csv beside the patches)")
    options = parser.parse_args(own)
    return options, Tests("slow" if options.slow else "fast", tuple(chosen), options.workers, 60 * options.limit)


def _chosen_errors(numbers: list[int]) -> list[WrittenError]:
    errors = {error.number: error for error in map(WrittenError.read, sorted(_HERE.glob("*.patch")))}
    if unknown := [number for number in numbers if number not in errors]:
        sys.exit(f"benchmarks errors: there is no error {unknown[0]}; they are 1 to {max(errors)}")
    return [errors[number] for number in numbers or errors]


def main(words: list[str]) -> None:
    """Run the tests on the errors that have no current row; print a line for each of them, and how many of all are noticed."""
    options, tests = _options(words)
    errors, rows = _chosen_errors(options.numbers), _read_table(options.table)
    base = _git("rev-parse", "--verify", f"{options.base}^{{commit}}")
    tested = hashlib.sha256(_git("rev-parse", *(f"{base}:{path}" for path in _TESTED)).encode()).hexdigest()[:12]
    if options.slow and not tests.chosen:  # those alone that the fast tests of the same commit do not notice
        fast = {e.number: rows.get((str(e.number), "fast")) for e in errors}
        errors = [e for e in errors if (row := fast[e.number]) and _is_current(row, e, tested) and row.outcome == _UNNOTICED]
    pending = [e for e in errors if not _is_current(rows.get((str(e.number), tests.name)), e, tested)]
    try:
        for error, outcome, by, seconds in _results(pending, base, tests):
            row = Row(str(error.number), error.name, tests.name, outcome, by, base[:8], tested, error.digest, f"{seconds:.0f}")
            rows[row.number, row.tests] = row
            _write_table(options.table, rows)
            print(f"  {error.number:02d} {error.name:36} {outcome} {by}".rstrip(), flush=True)
    except KeyboardInterrupt:
        sys.exit("benchmarks errors: stopped; the rows so far are kept")
    outcomes = [rows[str(e.number), tests.name].outcome for e in errors]
    print(f"{outcomes.count(_NOTICED)} of {len(errors)} errors are noticed, {outcomes.count(_NOT_APPLIED)} do not apply")
