"""Whatever stands in a study file: it is refused with a sentence, it works, or the run fails with a sentence."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

import pytest
from tests.robustness import children, hostile_files
from tests.robustness.children import Class

FEW, MANY = range(15), range(10_000, 13_000)  # few: some 8 s of processor time
pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="a case is a fork of a process that has loaded everything")


@pytest.fixture(scope="module")
def loaded() -> None:
    children.load_everything()


def campaign(seeds: Iterable[int], folder: Path) -> tuple[Counter[Class], list[str]]:
    """How many cases end how, and what those said that end badly."""
    counts, bad = Counter[Class](), list[str]()
    for seed in seeds:
        case, place = hostile_files.case(seed), folder / str(seed)
        place.mkdir(parents=True)
        (place / "study.toml").write_bytes(case.text)
        ended = children.call(children.wucht("run", "study.toml", "-o", "out", *case.words), place, children.CTRL_C_AFTER_S)
        found = children.classify(ended, place)
        counts[found] += 1
        if found not in children.GOOD:
            bad.append(f"{found.name} seed {seed}, {case.name} {case.words}: exit code {ended.code}: {ended.sentence[:300]}")
    return counts, bad


@pytest.mark.slow
@pytest.mark.usefixtures("loaded", "unpainted")
def test_few(tmp_path: Path) -> None:
    counts, bad = campaign(FEW, tmp_path)
    assert not bad, "\n".join(bad)
    assert all(counts[known] > len(FEW) / 20 for known in (Class.CLEAR, Class.WORKS)), counts


@pytest.mark.slow
@pytest.mark.usefixtures("loaded")
def test_many(tmp_path: Path) -> None:
    counts, bad = campaign(MANY, tmp_path)
    assert not bad, f"{counts}\n" + "\n".join(bad)
