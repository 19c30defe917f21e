"""``python -m tests.same_answers BASE [PATTERN...] [--changed]``: are the answers those of a commit, bit for bit?

Every template and catalogue file, questions of other studies to them, and study files with errors are run in both source trees,
a process each, and all that a user gets is compared: exit code, text, error, summary, every variable and attribute, the numbers
that figures draw, and the result of a study that was interrupted and resumed. There is no tolerance. Answers are kept in
``build/same-answers`` by source tree: of a commit they are computed once.

What differs on purpose stands in ``same_answers.toml`` with its reason; an entry that nothing needs any more fails as well.
"""

from __future__ import annotations

import argparse
import fnmatch
import io
import json
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import tomllib
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from tests.answering import ANSWER, DRAWN, OUT, RESUMED

_ROOT = Path(__file__).parents[1]
_KEPT = _ROOT / "build" / "same-answers"
_EXPECTED = Path(__file__).with_suffix(".toml")
LEFT_OUT = frozenset({"created", "elapsed_s", "versions", "version", "lines", "checksums"})  # checksums: of these as well
_HOSTILE = 60  # study files with errors
_TIMED = re.compile(r'to go, at the pace|^running |^  "elapsed_s": ')  # lines that depend on the machine's speed
_ANSWERING = Path(__file__).with_name("answering.py")


@dataclass(frozen=True)
class Case:
    """A question. kind: "template", "catalogue" or "hostile". file: a kind of study, a catalogue name, or a path. words: after
    it on the command line. is_interrupted: it is asked a second time, interrupted and resumed."""

    kind: str
    file: str
    words: tuple[str, ...] = ()
    is_interrupted: bool = False

    @property
    def name(self) -> str:
        return " ".join([Path(self.file).name if self.kind == "hostile" else self.file, *self.words])

    @property
    def folder(self) -> str:
        return re.sub(r"[^\w.=-]+", "_", self.name)[:150]


@dataclass(frozen=True)
class Tree:
    """A source tree. hash: git's, of the folder src. answers: the name of the folder of its answers. is_fused: whether machine
    code may compute a product and a sum in one instruction."""

    hash: str
    answers: str = "answers"
    is_fused: bool = True

    @classmethod
    def of(cls, commit: str | None) -> Tree:
        """The tree of a commit, or the working tree with all that is not committed."""
        if commit is not None:
            return cls(_git("rev-parse", f"{commit}:src"))
        with tempfile.TemporaryDirectory() as folder:
            index = {"GIT_INDEX_FILE": str(Path(folder, "index"))}
            _git("read-tree", "HEAD", env=index)
            _git("add", "-A", "src", env=index)
            return cls(_git("rev-parse", f"{_git('write-tree', env=index)}:src"))

    @property
    def folder(self) -> Path:
        return _KEPT / self.hash

    def written(self) -> Tree:
        """Write its files, if they are not there."""
        if not (self.folder / "src").exists():
            archive = subprocess.run(["git", "archive", self.hash], cwd=_ROOT, check=True, capture_output=True).stdout
            unpacked = self.folder / "unpacked"
            shutil.rmtree(unpacked, ignore_errors=True)
            with tarfile.open(fileobj=io.BytesIO(archive)) as tar:
                tar.extractall(unpacked, filter="data")
            unpacked.rename(self.folder / "src")
        return self

    def answer(self, case: Case) -> Path:
        """The folder with its answer to a case, which is computed if it is not there."""
        folder = self.folder / self.answers / case.folder
        if not (folder / ANSWER).exists():
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir(parents=True)
            question = asdict(case) | {"is_fused": self.is_fused}
            process = subprocess.run(
                [sys.executable, str(_ANSWERING), json.dumps(question)],
                cwd=folder,
                env=self._environment(),
                capture_output=True,
                text=True,
                check=False,
            )
            if not (folder / ANSWER).exists():  # a crash is an answer, too
                given = {"crash": process.returncode, "errors": process.stderr.splitlines()[-30:]}
                (folder / ANSWER).write_text(json.dumps({"given": given, "sources": None}), encoding="utf-8")
        return folder

    def _environment(self) -> dict[str, str]:
        own = {
            "PYTHONPATH": str(self.folder / "src"),
            "WUCHT_CACHE_DIR": str(self.folder / ("cache" if self.is_fused else "cache-unfused")),
            "MPLBACKEND": "Agg",
        }
        return os.environ | own | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "COLUMNS": "132", "PYTHONHASHSEED": "0"}


def _git(*words: str, env: dict[str, str] | None = None) -> str:
    return subprocess.run(
        ["git", *words], cwd=_ROOT, check=True, capture_output=True, text=True, env=os.environ | (env or {})
    ).stdout.strip()


def cases() -> Iterator[Case]:
    """All questions: of the catalogue and the templates, of other studies to machines of the catalogue, and with errors."""
    from tests.robustness import hostile_files
    from tests.studies.test_results_as_stated import QUESTIONS, SHORT

    from wucht.files.catalogue import names
    from wucht.studies.registry import studies

    yield from (Case("template", kind, is_interrupted=True) for kind in studies())
    yield from (Case("catalogue", name) for name in names())
    for name, kinds in QUESTIONS.items():
        for kind in kinds:
            settings = {"study.kind": kind} | SHORT.get(kind, {})
            yield Case("catalogue", name, tuple(w for key, value in settings.items() for w in ("--set", f"{key}={value}")))
    hostile = _KEPT / "hostile"
    hostile.mkdir(parents=True, exist_ok=True)
    for seed in range(_HOSTILE):
        written = hostile_files.case(seed)
        file = hostile / f"hostile-{seed}.toml"
        file.write_bytes(written.text)
        yield Case("hostile", f"../../../{hostile.name}/{file.name}", tuple(written.words))  # from the folder of an answer


def differences(base: Path, new: Path) -> Iterator[str]:
    """What two answers, each a folder, have not in common: a line each."""
    given, other = (json.loads((folder / ANSWER).read_text(encoding="utf-8"))["given"] for folder in (base, new))
    for key in given | other:
        if without_times(given.get(key)) != without_times(other.get(key)):
            yield f"{key}: {_short(given.get(key), other.get(key))}"
    summaries = (_json(folder / OUT / "summary.json") for folder in (base, new))
    yield from (f"summary{d}" for d in _values_that_differ(*summaries))
    for file in (f"{OUT}/result.nc", f"{OUT}/result.partial.nc", f"{RESUMED}/result.nc"):
        yield from (f"{file}: {d}" for d in _dataset_differences(base / file, new / file))
    if all((folder / DRAWN).exists() for folder in (base, new)):
        with np.load(base / DRAWN) as drawn, np.load(new / DRAWN) as drawn_there:
            for key in sorted({*drawn, *drawn_there}):
                if key not in drawn or key not in drawn_there or not _same_array(drawn[key], drawn_there[key]):
                    yield f"figure {key}"


def without_times(value: Any) -> Any:
    return [line for line in value if not _TIMED.search(line)] if isinstance(value, list) else value


def _short(*values: Any) -> str:
    """The first places at which two values differ."""
    a, b = values
    if isinstance(a, list) and isinstance(b, list):
        a, b = next(((x, y) for x, y in zip([*a, None], [*b, None], strict=False) if x != y), (a[len(b) :], b[len(a) :]))
    return f"{a!r:.300} != {b!r:.300}"


def _json(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else None


def _values_that_differ(a: Any, b: Any, path: str = "") -> Iterator[str]:
    if isinstance(a, dict) and isinstance(b, dict):
        for key in a | b:
            if key not in LEFT_OUT:
                yield from _values_that_differ(a.get(key), b.get(key), f"{path}/{key}")
    elif repr(a) != repr(b):
        yield f"{path}: {a!r:.200} != {b!r:.200}"


def _dataset_differences(base: Path, new: Path) -> Iterator[str]:
    if base.exists() != new.exists():
        yield "exists once"
    if not (base.exists() and new.exists()):
        return
    with xr.open_dataset(base) as a, xr.open_dataset(new) as b:
        if list(a.variables) != list(b.variables):
            yield f"variables {sorted({*map(str, a.variables)} ^ {*map(str, b.variables)}) or 'in another order'}"
        for name in a.variables.keys() & b.variables.keys():
            x, y = a[name], b[name]
            if x.dims != y.dims or not _same_array(x.values, y.values):
                yield f"variable {name}"
            yield from (f"variable {name}{d}" for d in _values_that_differ(_plain(x.attrs), _plain(y.attrs)))
        yield from (f"attribute {d}" for d in _values_that_differ(_plain(a.attrs), _plain(b.attrs)))


def _plain(attributes: dict[str, Any]) -> dict[str, Any]:
    """Attributes with those of JSON read."""
    return {key: _read(value) for key, value in attributes.items()}


def _read(value: Any) -> Any:
    if isinstance(value, str) and value[:1] in "{[":
        try:
            return json.loads(value)
        except json.JSONDecodeError:
            return value
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value


def _same_array(a: np.ndarray, b: np.ndarray) -> bool:
    """True for equal bits."""
    if a.dtype != b.dtype or a.shape != b.shape:
        return False
    return bool((a == b).all()) if a.dtype.kind in "OUS" else a.tobytes() == b.tobytes()


@dataclass
class Expected:
    """A difference that is meant. case, difference: patterns as of file names."""

    case: str
    difference: str
    reason: str
    is_used: bool = False

    def covers(self, case: Case, difference: str) -> bool:
        covers = fnmatch.fnmatch(case.name, self.case) and fnmatch.fnmatch(difference, self.difference)
        self.is_used |= covers
        return covers


def _is_reached(case: Case, base: Path, changed: Sequence[str]) -> bool:
    """True if a change of these files can change the answer to a case, which was made from files that its answer names."""
    sources = json.loads((base / ANSWER).read_text(encoding="utf-8"))["sources"]
    return sources is None or not set(sources).isdisjoint(changed)


def _say(first: str, *further: str) -> None:
    sys.stdout.write("\n        ".join([first, *further]) + "\n")
    sys.stdout.flush()


def main() -> int:
    """Compare, print each difference, and return 1 if there is one that is not expected."""
    parser = argparse.ArgumentParser(prog="python -m tests.same_answers", description=__doc__)
    parser.add_argument("base", help="a commit")
    parser.add_argument("patterns", nargs="*", help="of cases, such as 'practice/*'; default: all")
    parser.add_argument("--changed", action="store_true", help="only those whose source files the change touches")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    options = parser.parse_args()
    base, new = Tree.of(options.base).written(), Tree.of(None).written()
    if new == base:  # each answer is computed a second time: do they depend on the source alone?
        new = replace(new, answers="answers-again")
        shutil.rmtree(new.folder / new.answers, ignore_errors=True)
    chosen = [c for c in cases() if not options.patterns or any(fnmatch.fnmatch(c.name, p) for p in options.patterns)]
    if not chosen:
        parser.error(f"no case is called like {', '.join(options.patterns)}")
    expected = [Expected(**one) for one in tomllib.loads(_EXPECTED.read_text(encoding="utf-8")).get("expected", [])]
    changed = _git("diff", "--name-only", "--no-renames", base.hash, new.hash).splitlines()
    changed = [f"src/{path}" for path in changed]

    def compare(case: Case) -> list[str] | None:
        of_base = base.answer(case)
        if options.changed and not _is_reached(case, of_base, changed):
            return None
        return list(differences(of_base, new.answer(case)))

    compared, failed = 0, 0
    with ThreadPoolExecutor(options.workers) as pool:
        for case, found in zip(chosen, pool.map(compare, chosen), strict=True):
            if found is None:
                continue
            compared += 1
            unexpected = [d for d in found if not sum(e.covers(case, d) for e in expected)]
            failed += bool(unexpected)
            _say(f"{'DIFFERS' if unexpected else 'same   '} {case.name}", *unexpected[:20])
    unused = [e for e in expected if not e.is_used] if not options.patterns and not options.changed else []
    for one in unused:
        _say(f"{_EXPECTED.name}: nothing differs as expected of {one.case!r} ({one.reason}): remove the entry")
    _say(f"{compared} of {len(chosen)} cases compared with {options.base}: {failed} differ")
    return int(bool(failed or unused))


if __name__ == "__main__":
    sys.exit(main())
