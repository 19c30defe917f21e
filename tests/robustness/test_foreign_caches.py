"""Caches that are damaged, or somebody else's: a run is that without them, says so once, and runs nothing of what they hold."""

from __future__ import annotations

import hmac
import os
import pickle
import random
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
import xarray as xr
from tests.conftest import STUDY
from tests.interrupting import assert_same
from tests.robustness import damage

from wucht.numerics.flow.compiled.machine_code import compiled_object
from wucht.results.output_folder import load_result

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="where the folders of a user lie is set by XDG's variables")
NOTE = "entries that were not written with your key"
CHANGES = {'"1e5 N/m"': '"100 kN/m"', 'until = "0.5 s"': 'until = "0.02 s"'}  # a unit that only Pint knows
EXIT_CODE = 42
# What crafted machine code is: it does anything when it is called.
CRAFTED = f"""
declare void @_exit(i32)
define void @rates() {{ call void @_exit(i32 {EXIT_CODE}) ret void }}
define void @event_values() {{ call void @_exit(i32 {EXIT_CODE}) ret void }}
"""


class Evil:
    """What a crafted pickle is: it calls any function when it is loaded."""

    def __init__(self, target: Path) -> None:
        self.target = target

    def __reduce__(self) -> tuple[Callable[..., object], tuple[object, ...]]:
        return Path.touch, (self.target,)


def of(user: Path) -> dict[str, str]:
    """The environment of a user with these folders."""
    environment = {k: v for k, v in os.environ.items() if k != "WUCHT_CACHE_DIR"}
    return environment | {"XDG_CACHE_HOME": str(user / "cache"), "XDG_STATE_HOME": str(user / "state"), "HOME": str(user)}


def python(user: Path, code: str) -> None:
    subprocess.run([sys.executable, "-c", code], env=of(user), check=True)


def run(user: Path, study: Path, out: str) -> tuple[xr.Dataset, list[str]]:
    """The result of a run of a user, and the lines on stderr that are about a cache."""
    command = [sys.executable, "-m", "wucht", "run", str(study), "-o", out]
    done = subprocess.run(command, env=of(user), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    return load_result(Path(out)), [line for line in done.stderr.splitlines() if "the cache" in line]


def entries(user: Path) -> list[Path]:
    return sorted((user / "cache/wucht").glob("derived-*/*"))


@pytest.fixture(scope="module")
def owner(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A user who has run a study, with all caches filled, and its result."""
    user, text = tmp_path_factory.mktemp("owner"), STUDY
    for before, after in CHANGES.items():
        text = text.replace(before, after)
    (user / "study.toml").write_text(text, encoding="utf-8")
    run(user, user / "study.toml", str(user / "result"))
    return user


@pytest.fixture(scope="module")
def crafted() -> bytes:
    """An entry with crafted machine code."""
    return b"b" + compiled_object(CRAFTED, ("rates", "event_values"))


@pytest.fixture
def expected(owner: Path) -> xr.Dataset:
    return load_result(owner / "result")


def signed(path: Path, content: bytes, owner: Path) -> bytes:
    """An entry with a content, and the code that its owner would give it. path: in any copy of the owner's cache."""
    key, name = (owner / "state/wucht/cache-key").read_bytes(), "/".join(path.parts[-2:])
    return hmac.digest(key, name.encode() + b"\0" + content, "sha256") + content


@pytest.mark.slow
def test_a_whole_cache_folder_of_somebody_else(here: Path, owner: Path, crafted: bytes, expected: xr.Dataset) -> None:
    """Unpacked from an archive: every entry of it, and the files of Pint beside them, would run a program."""
    me, target = here / "me", here / "written"
    shutil.copytree(owner / "cache", me / "cache")
    python(me, "import pint; pint.UnitRegistry(cache_folder=':auto:')")
    evil = pickle.dumps(Evil(target))
    for path in (me / "cache/pint").glob("*.pickle"):
        path.write_bytes(evil)
    python(me, "import pint; pint.UnitRegistry(cache_folder=':auto:')")
    assert target.exists(), "Pint itself runs it, so that the test can fail"
    target.unlink()
    kinds = {path.name.partition("-")[0].rpartition(".")[2] for path in entries(me)}
    assert kinds >= {"object_file", "_stepper_file", "_lower", "_source", "_pint_factor", "system"}
    for number, path in enumerate(entries(me)):
        path.write_bytes(signed(path, (evil, crafted, path.read_bytes()[32:])[number % 3], owner))
    result, said = run(me, owner / "study.toml", "result")
    assert not target.exists()
    assert [NOTE in line for line in said] == [True]
    assert_same(result, expected)
    assert run(me, owner / "study.toml", "again")[1] == []


@pytest.mark.slow
def test_who_has_the_key_can_run_programs(here: Path, owner: Path, crafted: bytes) -> None:
    """So that the test above can fail: a machine code that is authenticated is loaded, whatever it does."""
    me = here / "me"
    for name in ("cache", "state"):
        shutil.copytree(owner / name, me / name)
    (path,) = [p for p in entries(me) if "object_file" in p.name]
    path.write_bytes(signed(path, crafted, owner))
    command = [sys.executable, "-m", "wucht", "run", str(owner / "study.toml"), "-o", "out"]
    assert subprocess.run(command, env=of(me), capture_output=True, check=False).returncode == EXIT_CODE


@pytest.mark.slow
@pytest.mark.parametrize("count", [1, 8])
def test_a_damaged_cache(here: Path, owner: Path, expected: xr.Dataset, count: int) -> None:
    """Some entries changed, exchanged or removed: each time the same result, and one note at most.

    There is none where a run does not need those that were changed, as they are parts of others that it reads.
    """
    me, notes = here / "me", 0
    shutil.copytree(owner / "state", me / "state")
    for seed in range(count):
        shutil.copytree(owner / "cache", me / "cache")
        chance = random.Random(seed)
        contents = {path: path.read_bytes() for path in entries(me)}
        for path, other in zip(chance.sample([*contents], 6), chance.sample([*contents], 6), strict=True):
            whole = contents[path]
            how = chance.choice(("bytes", "exchanged", "removed"))
            content = damage.bytes_changed(whole, seed) if how == "bytes" else contents[other]
            path.unlink() if how == "removed" else path.write_bytes(content)
        result, said = run(me, owner / "study.toml", "result")
        assert [NOTE in line for line in said] in ([], [True]), seed
        notes += len(said)
        assert_same(result, expected)
        shutil.rmtree("result")
        shutil.rmtree(me / "cache")
    assert notes > 0.7 * count
