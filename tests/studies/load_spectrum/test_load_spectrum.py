"""Load spectra of records in several kinds of files, and of a machine's run-up against its own trajectory."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import pyuff
from pylife.stress.rainflow import FourPointDetector, LoopValueRecorder
from scipy.interpolate import CubicHermiteSpline
from scipy.io import wavfile
from tests.refusals import refused

import wucht
from interrupting import assert_same
from wucht import draw, report
from wucht.fatigue.counting import rainflow
from wucht.studies.study_file import read_study

HISTORY = np.array([-2, 1, -3, 5, -1, 3, -4, 4, -2], dtype=float)
START = {"p1": 0.3, "p2": -0.5}
AT_RESONANCE = "drozdetskaya-2020/load-spectrum-at-resonance"


def write(folder: Path, values: np.ndarray, heading: str = "time [s],force [kN]", step: float = 1.0) -> None:
    rows = "\n".join(f"{step * i!r},{x!r}" for i, x in enumerate(values.tolist()))
    (folder / "record.csv").write_text(f"{heading}\n{rows}\n", encoding="utf-8")


def counted(folder: Path, **keys):
    signal = keys.pop("signal", {"file": "record.csv", "column": "force"})
    return wucht.run(wucht.LoadSpectrum(signal=signal, **keys), wucht.Records(folder))


def ranges(summary) -> dict[float, float]:
    return {round(row["range"], 9): row["count"] for row in summary["spectrum"]}


def test_the_example_of_the_standard(tmp_path):
    write(tmp_path, HISTORY, "time [s],force [N]")
    s = counted(tmp_path).wucht.summary
    assert ranges(s) == {3: 0.5, 4: 1.5, 6: 0.5, 8: 1.0, 9: 0.5}
    assert (s["cycles"], s["damage"], s["unit"], s["largest_range"], s["min"], s["max"]) == (4.0, None, "N", 9.0, -4.0, 5.0)
    assert s["spectrum"][-1] == {"range": 9.0, "mean": 0.5, "count": 0.5}


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        ({"residue": "repeat"}, {3: 1, 4: 1, 7: 1, 9: 1}),
        ({"residue": "drop"}, {4: 1}),
        ({"counting": "range-pair"}, {3: 1, 4: 1, 6: 1, 8: 1}),
        # 5, 4, 3, 1 with -4, -3, -1; 1 is left, 3 from the mean
        ({"counting": "peaks"}, {9: 1, 7: 1, 4: 1, round(1 - HISTORY.mean(), 9): 0.5}),
        ({"counting": "peaks", "reference": "0 N"}, {9: 1, 7: 1, 4: 1, 1: 0.5}),
    ],
)
def test_other_countings(tmp_path, keys, expected):
    write(tmp_path, HISTORY, "time [s],force [N]")
    s = counted(tmp_path, **keys).wucht.summary
    assert ranges(s) == expected and s["cycles"] == sum(row["count"] for row in s["spectrum"])


def test_units_of_a_record(tmp_path):
    write(tmp_path, HISTORY)
    plain = counted(tmp_path).wucht.summary
    assert (plain["unit"], plain["largest_range"]) == ("N", 9000.0)
    scaled = counted(tmp_path, signal={"file": "record.csv", "column": "force", "unit": "MPa", "scale": 2.0}).wucht.summary
    assert (scaled["unit"], scaled["largest_range"]) == ("Pa", pytest.approx(18e6))
    odd = counted(tmp_path, signal={"file": "record.csv", "unit": "increments"}).wucht.summary
    assert (odd["unit"], odd["largest_range"]) == ("increments", 9.0)
    gravity = counted(tmp_path, signal={"file": "record.csv", "unit": "g"}).wucht.summary
    assert (gravity["unit"], gravity["largest_range"]) == ("m/s^2", pytest.approx(9 * 9.80665))


def test_sound_and_universal_files(tmp_path):
    samples = (HISTORY / 8 * 2**15).astype(np.int16)
    wavfile.write(tmp_path / "record.wav", 8000, samples)
    s = counted(tmp_path, signal={"file": "record.wav"}).wucht.summary
    assert (s["unit"], s["largest_range"]) == ("of full scale", pytest.approx(9 / 8))
    s = counted(tmp_path, signal={"file": "record.wav", "unit": "kN", "scale": 8}).wucht.summary
    assert (s["unit"], ranges(s)) == ("N", {3000: 0.5, 4000: 1.5, 6000: 0.5, 8000: 1.0, 9000: 0.5})
    told = {
        "binary": 0, "func_type": 1, "rsp_node": 1, "rsp_dir": 1, "ref_node": 1, "ref_dir": 1, "id1": "strain", "id2": "NONE",
        "id3": "NONE", "id4": "NONE", "id5": "NONE", "ord_data_type": 4, "abscissa_spacing": 1, "abscissa_min": 0.0,
        "abscissa_inc": 0.25, "abscissa_spec_data_type": 17, "abscissa_axis_units_lab": "s", "ordinate_spec_data_type": 0,
        "orddenom_spec_data_type": 0, "z_axis_spec_data_type": 0, "ordinate_axis_units_lab": "NONE", "num_pts": len(HISTORY),
        "x": np.arange(len(HISTORY)) * 0.25, "data": HISTORY,
    }  # fmt: skip
    pyuff.UFF(str(tmp_path / "record.uff")).write_sets(pyuff.prepare_58(**told), "add")
    s = counted(tmp_path, signal={"file": "record.uff", "column": "strain"}).wucht.summary
    assert (s["unit"], ranges(s), s["end"]) == ("", {3: 0.5, 4: 1.5, 6: 0.5, 8: 1.0, 9: 0.5}, 2.0)


@pytest.mark.parametrize(("miner", "below"), [("original", 0.0), ("elementary", 0.5**3), ("haibach", 0.5**5), (None, 0.5**3)])
def test_damage_at_constant_amplitude(tmp_path, miner, below):
    """Exactly n/N above the knee, and by the rule below it."""
    write(tmp_path, np.array([2.0, -2.0] * 500 + [2.0]))
    line = {"k": 3, "ND": 1e6, "SD": "1 kN"} | ({} if miner is None else {"miner": miner})
    s = counted(tmp_path, woehler=line).wucht.summary
    assert (s["cycles"], s["damage"]) == (500.0, pytest.approx(500 * 2**3 / 1e6, rel=1e-12))
    assert s["repetitions"] == pytest.approx(250.0) and s["life"] == pytest.approx(250.0 * 1000)
    low = counted(tmp_path, woehler=line | {"SD": "4 kN"}).wucht.summary
    assert low["damage"] == pytest.approx(500 * below / 1e6, rel=1e-12)
    assert (low["life"] is None) == (below == 0)
    own = {"k": 3, "ND": 1e6, "SD": 4000.0, "k2": 7}
    assert counted(tmp_path, woehler=own).wucht.summary["damage"] == pytest.approx(500 * 0.5**7 / 1e6, rel=1e-12)


def test_counting_begins_after_a_time(tmp_path):
    write(tmp_path, np.concatenate([HISTORY, [1.0, -1.0] * 10]), "time [s],force [N]")
    s = counted(tmp_path, after="9 s").wucht.summary
    assert (ranges(s), s["begin"]) == ({2: 9.5}, 9.0)
    assert s["convergence"]["spectrum"] < 0.1


def test_many_ranges_are_put_into_classes(tmp_path):
    values = np.random.default_rng(4).standard_normal(6000)
    write(tmp_path, values, "time [s],force [N]")
    line = {"k": 4, "ND": 1e6, "SD": 1.0}
    result = counted(tmp_path, woehler=line)
    s, cycles = result.wucht.summary, rainflow(values)
    assert len(s["spectrum"]) <= 100 and s["class_width"] == pytest.approx(s["largest_range"] / 100)
    assert s["cycles"] == pytest.approx(cycles.total) == pytest.approx(sum(row["count"] for row in s["spectrum"]))
    assert s["damage"] == pytest.approx(float((cycles.counts * (cycles.ranges / 2) ** 4).sum()) / 1e6, rel=1e-12)
    assert result["damage"].values.sum() == pytest.approx(s["damage"])
    assert any("more than 1000 different ranges" in w for w in result.wucht.warnings)
    assert any("samples a cycle" in w for w in result.wucht.warnings)
    at_levels = counted(tmp_path, counting="level-crossing")
    assert len(at_levels.wucht.warnings) == 1, "levels have a distance, which nobody is warned of"
    assert result["cumulative"].values[0] == pytest.approx(s["cycles"])
    assert result["matrix"].values.sum() == pytest.approx(s["cycles"])


def test_a_run_up_counts_as_its_own_trajectory_does():
    """The run-up's samples, joined by cubics through displacement and velocity, and counted by pyLife."""
    until, start = 6.0, START
    machine = wucht.load_machine("drozdetskaya-2020/r1")
    run = wucht.run(wucht.RunUp(until=until, start=start), machine)
    x, v = (run[name].sel(direction="x").values for name in ("displacement", "velocity"))
    fine = np.linspace(0.0, until, 40 * len(run.time))
    recorder = LoopValueRecorder()
    FourPointDetector(recorder=recorder).process(CubicHermiteSpline(run.time.values, x, v)(fine))
    expected = np.sort(np.abs(np.array(recorder.values_from) - np.array(recorder.values_to)))
    s = wucht.run(wucht.LoadSpectrum(until=until, start=start, residue="drop"), machine).wucht.summary
    found = np.array([row["range"] for row in s["spectrum"]])
    # The rotor starts at rest: its first ranges are rounding.
    found, expected = (of[of > 1e-3 * expected[-1]] for of in (found, expected))
    assert found == pytest.approx(expected, rel=5e-5)
    assert s["max"] == pytest.approx(float(x.max()), rel=2e-3)


def test_signals_of_a_steady_rotation():
    """An unbalanced rotor of prescribed speed: displacement, force on the carrier and acceleration in closed form."""
    parts, w, mass, e, c, b = wucht.parts, 60.0, 10.0, 1e-3, 1e5, 200.0
    machine = wucht.Machine(
        parts.Carrier(stiffness=c, damping=b, mass=2.0),
        [parts.Rotor(name="drum", mass=mass, eccentricity=e, inertia=0.1)],
        drives=[parts.ConstantSpeed(speed=w)],
    )
    total = mass + 2.0
    size = mass * e * w**2 / abs(c - total * w**2 + 1j * b * w)
    expected = {
        "displacement": size,
        "acceleration": size * w**2,
        "bearing-force": abs(mass * w**2) * abs(size * _phasor(total, w, c, b) + e),
    }
    for signal, amplitude in expected.items():
        line = {"k": 1, "ND": 1.0, "SD": amplitude}
        spec = wucht.LoadSpectrum(signal=signal, until=8.0, after=6.0, woehler=line)
        s = wucht.run(spec, machine).wucht.summary
        assert s["cycles"] == pytest.approx(2.0 * w / (2 * math.pi), abs=1.0)
        assert s["largest_range"] / 2 == pytest.approx(amplitude, rel=3e-5), signal
        assert s["damage"] == pytest.approx(s["cycles"], abs=0.5)  # the last range is not a whole one


def _phasor(total, w, c, b):
    """The displacement's direction to the unbalance."""
    h = 1 / (c - total * w**2 + 1j * b * w)
    return h / abs(h)


def test_the_catalogue_file_gives_its_numbers():
    """Amplitudes from cases.md: the axis goes from 8.81 to 10.97 mm, the mean speed of the modulated motion is 94.3 rad/s."""
    study = read_study(AT_RESONANCE)
    result = wucht.run(study.spec, study.subject)
    s = result.wucht.summary
    assert s["outcome"] == "captured-modulated"
    assert s["largest_range"] / 2 == pytest.approx(10.97e-3, rel=1e-3)
    closed = [row["range"] / 2 for row in s["spectrum"] if row["count"] >= 1]
    assert min(closed) == pytest.approx(8.81e-3, rel=1e-2)
    assert s["cycles"] == pytest.approx(751.0, abs=0.6)
    assert s["damage"] == pytest.approx(1.294247e-3, rel=1e-4)
    assert abs(s["convergence"]["damage"]) < 0.01 and s["convergence"]["spectrum"] < 0.02
    assert result.wucht.warnings == []


def test_a_dimensionless_machine_and_its_averaged_equations():
    """One cycle a turn of the pendulums, which slip behind the rotor and move the carrier more than it does.

    The averaged equations have the amplitudes as far as they do in the run-up itself."""
    given, largest = {"study.until": 1500}, list[float]()
    run = read_study("drozdetskaya-2020/table-5.1", given | {"study.model": "both"})
    turned = wucht.run(run.spec, run.subject)
    angle = np.interp([500.0, 1500.0], turned.time.values, turned.angle.values[1])
    for model, name in (("full", "displacement"), ("slow", "slow_amplitude")):
        asked = given | {"study.kind": "load-spectrum", "study.after": 500, "study.model": model}
        study = read_study("drozdetskaya-2020/table-5.1", asked)
        result = wucht.run(study.spec, study.subject)
        s = result.wucht.summary
        largest.append(s["largest_range"] / 2)
        assert s["unit"] == "" and result.course_time.attrs["units"] == ""
        _, _, signal, *told = report(result)
        assert signal.endswith(" to 1500") and not [line for line in told if line.split()[0] in ("damage", "life")]
        if model == "full":
            assert s["cycles"] == pytest.approx(float(np.ptp(angle)) / (2 * math.pi), abs=1.0)
        peak = np.abs(turned[name].values[..., turned.time.values > 500]).max()
        assert largest[-1] == pytest.approx(float(peak), rel=1e-2)
    assert largest[1] == pytest.approx(largest[0], rel=0.25)


def test_crossings_of_levels(tmp_path):
    """Rising ones above the reference and falling ones below it; each level is one unit of a cycle."""
    write(tmp_path, HISTORY, "time [s],force [N]")
    result = counted(tmp_path, counting="level-crossing", class_width=1.0, reference=-0.5)
    upward = [int(((HISTORY[:-1] < x) & (HISTORY[1:] > x)).sum()) for x in result.level.values]
    downward = [int(((HISTORY[:-1] > x) & (HISTORY[1:] < x)).sum()) for x in result.level.values]
    assert result.level.values.tolist() == [x - 3.5 for x in range(9)]
    assert result.crossings.values.tolist() == [*downward[:3], *upward[3:]]
    (line,) = draw(result).axes[3].lines
    assert np.asarray(line.get_xdata()).tolist() == result.crossings.values.tolist()
    rows = result.wucht.summary["spectrum"]
    assert sum(row["range"] * row["count"] for row in rows) == pytest.approx(sum(result.crossings.values))


def test_stopped_and_resumed(tmp_path):
    machine, spec = wucht.load_machine("drozdetskaya-2020/r1"), wucht.LoadSpectrum(until=10.0, after=1.0, start=START)
    whole = wucht.run(spec, machine)

    def stop(share: float, _what: str) -> None:
        if share > 0.4:
            raise KeyboardInterrupt

    part = wucht.run(spec, machine, folder=tmp_path, progress=stop)
    assert not part.wucht.finished and 1.0 < part.wucht.summary["end"] < 10.0
    assert 0 < part.wucht.summary["cycles"] < whole.wucht.summary["cycles"]
    shares = list[float]()
    again = wucht.run(spec, machine, folder=tmp_path, resume=True, progress=lambda share, _: shares.append(share))
    assert again.wucht.finished and min(shares) > 0.1, "what was done before is not done again"
    assert_same(again, whole)


def test_a_changed_record_is_another_question(tmp_path):
    results, spec = tmp_path / "results", wucht.LoadSpectrum(signal={"file": "record.csv"})
    write(tmp_path, HISTORY)
    first = wucht.run(spec, wucht.Records(tmp_path), folder=results)
    assert wucht.run(spec, wucht.Records(tmp_path), folder=results, resume=True).attrs["input"] == first.attrs["input"]
    write(tmp_path, HISTORY + 1.0)
    with refused("--resume", given=None, code="other-question"):
        wucht.run(spec, wucht.Records(tmp_path), folder=results, resume=True)
