"""Designs: known parameters found again from spectra of both models; the command, stopping, the catalogue."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import wucht
from wucht import run_file
from wucht.dynamics.exciters.slow_beats import beat_of
from wucht.fatigue.counted_cycles import LoadCycles
from wucht.fatigue.cumulative_spectra import amplitude_distance

Command = Callable[..., Any]
KNOWN = {"drive.slope": 9e-4, "p1.mass": 1.2}
RANGES = {"drive.slope": ["2e-4 N m s", "3e-3 N m s"], "p1.mass": ["0.3 kg", "3 kg"]}
TINY = {
    "reach": 4,
    "evaluations": 4,
    "population": 4,
    "candidates": 1,
    "polish": 12,
    "corrections": 1,
    "beats": 8,
    "samples": 4,
}


@pytest.fixture(scope="module")
def machine() -> wucht.Machine:
    return wucht.load_machine("practice/exciter")


def table_of(cycles: LoadCycles, count: float = 1e6) -> list[list[float]]:
    """Amplitude and cumulative cycles, at the middle of the step that each range makes; all of them have the smallest one."""
    rows, _ = cycles.group_by_range()
    above = np.cumsum(rows.counts[::-1])[::-1] - rows.counts / 2
    amplitudes = np.append((1 - 1e-9) * rows.ranges[0], rows.ranges) / 2
    return np.transpose([amplitudes, count * np.append(rows.total, above) / rows.total]).tolist()


def in_full(machine: wucht.Machine, values: dict[str, float], after: float, until: float) -> LoadCycles:
    asked = wucht.LoadSpectrum(until=until, after=after, class_width=1e-6)
    result = wucht.run(asked, machine.with_values(values))
    return LoadCycles(*(result[name].values for name in ("range", "mean", "count")))


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_known_parameters_are_found_from_a_spectrum_of_the_averaged_equations(machine: wucht.Machine, seed: int) -> None:
    """Each search from other random points, and three local searches in each, from places that are apart.

    Where a local search begins does not matter: the three end where the machine was.
    """
    known = beat_of(machine.with_values(KNOWN), "displacement", None, {}, True, 1e-9)
    asked = wucht.ExciterDesign(
        target=table_of(known.cycles), vary=RANGES, seed=seed, reach=48, evaluations=64, corrections=0, samples=0
    )
    summary = wucht.run(asked, machine).wucht.summary
    assert len(summary["polished"]) == 3
    for found in summary["polished"]:
        assert found["drive.slope"] == pytest.approx(KNOWN["drive.slope"], rel=2e-4)
        assert found["p1.mass"] == pytest.approx(KNOWN["p1.mass"], rel=4e-4)
        assert found["distance"] < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_known_parameters_are_found_from_a_spectrum_of_the_full_equations(machine: wucht.Machine, seed: int) -> None:
    """The averaged equations alone miss them by 1 % and 2.5 %; corrected they are met, and so is a run of another length."""
    target = in_full(machine, KNOWN, 20.0, 150.0)
    asked = wucht.ExciterDesign(
        target=table_of(target), vary=RANGES, seed=seed, reach=32, evaluations=48, population=8, candidates=1, polish=80,
        corrections=4, samples=0, beats=60,
    )  # fmt: skip
    summary = wucht.run(asked, machine).wucht.summary
    first, design = summary["runs"][0], summary["parameters"]
    assert abs(first["parameters"]["p1.mass"] / KNOWN["p1.mass"] - 1) > 0.02
    assert first["full"] > 3 * summary["distance"]
    assert design["drive.slope"] == pytest.approx(KNOWN["drive.slope"], rel=2e-3)
    assert design["p1.mass"] == pytest.approx(KNOWN["p1.mass"], rel=4e-3)
    held_out = in_full(machine, design, 40.0, 300.0)
    assert amplitude_distance(held_out, target) < 2e-3


@pytest.mark.slow
def test_the_catalogue_file_gives_its_numbers() -> None:
    """Amplitudes to 0.7 % of the largest in the full equations; what stands in the summary is what such an exciter does."""
    result = run_file("practice/exciter-design")
    s = result.wucht.summary
    assert s["distance"] < 0.01
    assert s["damage_ratio"] == pytest.approx(1.0, abs=0.02)
    assert s["outcome"] == "captured-modulated"
    runs = [run["full"] for run in s["runs"]]
    assert min(runs[2:]) < 0.7 * min(runs[:2])  # the corrections
    assert sum(row["count"] for row in s["spectrum"]) == pytest.approx(2e6)
    assert s["motions"]["steady"] > 20 and s["motions"]["failed"] == 0
    assert s["tolerances"]["modulated"] == 1.0
    assert s["tolerances"]["q05"] < s["tolerances"]["median"] < s["tolerances"]["q95"] < 0.02
    assert s["reach"]["ratio"][0] < 0.2 and s["reach"]["ratio"][1] > 0.85
    low, high = s["target"]["ratio"] * s["target"]["upper"], s["target"]["upper"]
    assert [low, high] == pytest.approx([0.7e-3, 1.9e-3], rel=1e-2)
    held_out = in_full(wucht.load_machine("practice/exciter"), s["parameters"], 50.0, 250.0)
    wanted = LoadCycles(2 * result.amplitude_wanted.values, 0 * result.share.values, np.diff(result.share.values, prepend=0.0))
    assert amplitude_distance(held_out, wanted) == pytest.approx(s["distance"], abs=2e-3)


@pytest.mark.slow
def test_stopped_and_resumed(tmp_path: Path, machine: wucht.Machine) -> None:
    spec = wucht.ExciterDesign(target={"shape": "normal", "largest": "2 mm", "cycles": 1e6, "ratio": 0.4}, vary=RANGES, **TINY)
    whole = wucht.run(spec, machine)

    def stop(share: float, what: str) -> None:
        if share > 0.5:
            raise KeyboardInterrupt

    part = wucht.run(spec, machine, folder=tmp_path, progress=stop)
    assert not part.wucht.finished and part.wucht.summary["candidates"] > 0 and part.wucht.summary["distance"] is None
    shares = list[float]()
    again = wucht.run(spec, machine, folder=tmp_path, resume=True, progress=lambda share, what: shares.append(share))
    assert again.wucht.finished and again.wucht.summary == whole.wucht.summary
    assert min(shares) > 0.2  # what was done before is not done again
    for name in whole.data_vars:
        assert np.array_equal(again[name].values, whole[name].values, equal_nan=True), name


def test_where_nothing_beats_it_says_so(machine: wucht.Machine) -> None:
    """Beyond 3.06e-3 N m s the motor passes the resonance."""
    spec = wucht.ExciterDesign(
        target=[["1 mm", 1e5], ["2 mm", 1e3]], vary={"drive.slope": [4e-3, 8e-3]}, **(TINY | {"reach": 4, "evaluations": 4})
    )
    result = wucht.run(spec, machine)
    s = result.wucht.summary
    assert (s["parameters"], s["distance"], s["spectrum"]) == (None, None, [])
    assert s["motions"] == {"modulated": 0, "steady": 8, "unsettled": 0, "failed": 0, "not-allowed": 0}
    assert s["reach"]["modulated"] == 0.0
    assert result.attrs["sentence"] == "none of the candidates beats"
    assert any("no candidate beats: 8 steady" in w for w in result.wucht.warnings)
    assert wucht.report(result) and wucht.draw(result).axes
