"""Studies that are killed at moments at random, without a word of warning, and resumed: the result is the uninterrupted one."""

from __future__ import annotations

import os
import random
import shutil
import signal
import time
from pathlib import Path

import pytest
from tests.interrupting import assert_same
from tests.robustness import children

from wucht.results.output_folder import load_result
from wucht.studies.registry import studies

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="what is killed is a fork")
KILLS = 4
KINDS = [kind for kind, study in studies().items() if study.template]
QUICK = "coast-down"


def was_killed(seconds: float, words: tuple[str, ...], folder: Path) -> bool:
    """Whether a command was killed after a time; else it was done before."""
    child, until = children.start(children.wucht(*words), folder), time.perf_counter() + seconds
    while time.perf_counter() < until:
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended:
            assert os.waitstatus_to_exitcode(status) == 0, (folder / "stderr").read_text(encoding="utf-8")
            return False
        time.sleep(0.002)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return True


@pytest.mark.usefixtures("no_figures")
@pytest.mark.parametrize("kind", [kind if kind == QUICK else pytest.param(kind, marks=pytest.mark.slow) for kind in KINDS])
def test_killed_and_resumed(kind: str, tmp_path: Path) -> None:
    children.load_everything()
    chance, begun = random.Random(kind), time.perf_counter()
    assert children.call(children.wucht("new", kind), tmp_path).code == 0
    whole = children.call(children.wucht("run", f"{kind}.toml", "-o", "whole"), tmp_path)
    assert whole.code == 0, whole.err
    killed, seconds, words = 0, whole.seconds, ("run", f"{kind}.toml", "-o", "killed")
    for _ in range(KILLS):
        there = (tmp_path / "killed").exists()
        if was_killed(chance.uniform(0.1, 0.9) * seconds, (*words, *["--resume"] * there), tmp_path):
            killed += 1
        elif killed == 0:  # faster than the first run, which filled the caches: once more from the beginning, killed earlier
            shutil.rmtree(tmp_path / "killed")
            seconds /= 2
    assert killed > 0, f"in {time.perf_counter() - begun} s"
    resumed = children.call(children.wucht(*words, "--resume"), tmp_path)
    assert resumed.code == 0, resumed.err
    assert_same(load_result(tmp_path / "killed"), load_result(tmp_path / "whole"))
    files = [sorted(path.name for path in (tmp_path / name).iterdir()) for name in ("killed", "whole")]
    assert files[0] == files[1], "and nothing else is left"
