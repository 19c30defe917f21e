"""Findings of ``entrainment`` that are made by hand: the words of the Dataset and of the report, and the stages of its run."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.hand_made import five_functions, titled, warnings_of, with_answer

from wucht.dynamics.entrainment.entrainment_case import EntrainmentCase
from wucht.dynamics.entrainment.existence import Edge, Existence, StableRange
from wucht.dynamics.entrainment.locked_motions import LockedMotion, LockedMotions
from wucht.dynamics.entrainment.runs_from_start import CaptureBand, RunFromStart, RunsFromStart
from wucht.dynamics.work import Work
from wucht.errors import InputError, WuchtError
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.numerics.orbits import PeriodicOrbit
from wucht.studies.entrainment.computation import Findings
from wucht.studies.entrainment.spec import Entrainment

STUDY = five_functions("entrainment")
ROTOR = {"kind": "rotor", "mass": 0.1, "eccentricity": 0.01, "inertia": 2e-5}
ORBIT: PeriodicOrbit = None  # type: ignore[assignment]  # of which nothing is said


@pytest.fixture(scope="module")
def shaken() -> EntrainmentCase:
    """Of one rotor on a carrier that is shaken; along the no-load speed of its drive, at 5.5 rad/s or so."""
    case: EntrainmentCase = STUDY.prepare(
        Entrainment.from_table({"range": [5.0, 7.0]}), load_machine("sperling-vibration/figure-2a")
    )
    return case


@pytest.fixture(scope="module")
def pair() -> EntrainmentCase:
    """Of two exciters, along their detuning, at 0.5 rad/s."""
    carrier = {"mass": 0.8, "directions": "x", "stiffness": 355.0, "damping": 0.4}
    drives = [{"on": on, "kind": "linear", "slope": 3e-5, "no_load_speed": w} for on, w in (("e1", 12.0), ("e2", 12.5))]
    machine = machine_from({"carrier": carrier, "bodies": [ROTOR | {"name": "e1"}, ROTOR | {"name": "e2"}], "drives": drives})
    case: EntrainmentCase = STUDY.prepare(Entrainment.from_table({"range": [-1.0, 1.0]}), machine)
    return case


def ended(case: EntrainmentCase, value: float | None = None, **other: Any) -> RunFromStart:
    """A run that ends entrained."""
    common = {
        "is_entrained": True, "mean_speed": -6.28, "window": (50.0, 100.0), "phases": {"vibration": 3.5}, "creep": 0.01,
        "speeds": {r.name: -6.28 for r in case.machine.rotors},
    }  # fmt: skip
    value = case.parameter.nominal_value if value is None else value
    return RunFromStart(value, 100.0, 100.0, np.zeros(len(case.machine.state_names)), **common | other)


def dataset(case: EntrainmentCase, findings: Findings) -> xr.Dataset:
    made: xr.Dataset = titled(STUDY.dataset(case, findings))
    return made


def lines(made: xr.Dataset) -> list[str]:
    told: list[str] = STUDY.report(made)
    return told


# --- the Dataset ---


def test_the_phase_of_a_run_is_that_to_the_vibration_or_those_to_the_main_rotor(
    shaken: EntrainmentCase, pair: EntrainmentCase
) -> None:
    to_vibration = dataset(shaken, Findings(ended(shaken), complete=True)).wucht.summary
    assert to_vibration["phases"] == {"rotor": pytest.approx(3.5 - 2 * math.pi)}
    assert to_vibration["phase"] == pytest.approx(3.5 - 2 * math.pi)
    assert to_vibration["mean_speed"] == -6.28
    to_rotor = dataset(pair, Findings(ended(pair, phases={"e2": 3.5}), complete=True)).wucht.summary
    assert (to_rotor["phases"], to_rotor["phase"], to_rotor["outcome"]) == ({"e2": 3.5}, 3.5, "synchronised")
    apart = dataset(pair, Findings(ended(pair, is_entrained=False), complete=True)).wucht.summary
    assert (apart["phases"], apart["phase"], apart["outcome"]) == ({}, None, "not-synchronised")


def test_the_phase_and_the_speed_of_a_locked_motion_come_before_those_of_its_run(shaken: EntrainmentCase) -> None:
    own = ended(shaken)
    motions = tuple(LockedMotion(own.value + d, np.array([2.0 + d]), 6.2 + d, 0.9 + d, ORBIT) for d in (-0.25, 0.0, 0.25))
    made = dataset(shaken, Findings(own, motions=motions, ends=(5.0, None), complete=True))
    s = made.wucht.summary
    assert (s["phase"], s["mean_speed"], s["multiplier"], s["stable"]) == (2.0, -6.2, 0.9, True)
    assert s["existence_band_full"] == [5.0, None]
    assert made.orbit_value.values == pytest.approx([own.value - 0.25, own.value, own.value + 0.25])
    assert made.orbit_phase.values.tolist() == [[1.75, 2.0, 2.25]]
    assert made.orbit_stable.values.tolist() == [1, 1, 0]


def test_warnings(shaken: EntrainmentCase) -> None:
    band = CaptureBand(((5.25, 5.0), (6.0, 6.25)), ((6.5, 6.75), (6.875, 7.0)))
    moving, still = ended(shaken, 5.75, creep=0.0201), ended(shaken, 5.5, creep=0.02)
    failed = ended(shaken, 7.0, is_entrained=False, failure="it stopped", creep=0.5)
    found = Findings(still, band=band, runs=(still, moving, failed), no_motion="none here", existing=Existence(warnings=("w",)))
    unit = "rad/s"
    assert warnings_of(dataset(shaken, found)) == [
        "w",
        "at drive.no_load_speed = 7: it stopped",
        "none here",
        "3 runs from the start are finished, but the search is not",
        f"from the start it is also reached outside the band: 6.5 to 6.75, 6.875 to 7 {unit}; finer points may show more",
        f"at drive.no_load_speed = 5.75 {unit} the phase still moves at the end of the run: give a longer study.until",
    ]
    s = dataset(shaken, found).wucht.summary
    assert s["band_from_rest"] == [5.125, 6.125] and s["islands"] == [[6.5, 6.75], [6.875, 7.0]]
    assert warnings_of(dataset(shaken, Findings(still, runs=(still,), complete=True))) == []


def test_sentences(shaken: EntrainmentCase) -> None:
    own = ended(shaken)
    nowhere, interrupted = (dataset(shaken, Findings(own, complete=c)).wucht.summary["sentence"] for c in (True, False))
    assert nowhere.endswith("; it is not reached from the start anywhere in the range")
    assert interrupted.endswith("; the study was interrupted before its band was determined")
    band = CaptureBand((None, (6.0, 6.25)), ())
    s = dataset(shaken, Findings(own, band=band, complete=True)).wucht.summary["sentence"]
    assert s.endswith("; this is reached from the start below drive.no_load_speed = 6.125 rad/s")


# --- the report ---


def test_the_lines_of_all_that_can_be_known(shaken: EntrainmentCase) -> None:
    own = ended(shaken)
    motion = LockedMotion(own.value, np.array([2.0]), 6.28125, 0.91234, ORBIT)
    stable = StableRange(0, Edge(5.25, "fold"), Edge(6.75, "hopf"), np.array([0, 1]))
    existing = Existence(band=stable, phases={"rotor": 1.5})
    band = CaptureBand(((5.5, 5.0), (6.0, 6.25)), ((6.5, 6.75),))
    found = Findings(own, (5.0, 7.0), 0.015, existing, (own,), band, (motion,), (5.125, None), None, 2.5e-4, complete=True)
    made = dataset(shaken, found)
    assert lines(made) == [
        "A machine",
        f"verdict: ENTRAINED: {made.wucht.summary['sentence']}",
        f"  parameter    drive.no_load_speed = {own.value:.6g} rad/s",
        "  existence    between 5.25 and 6.75 rad/s (averaged equations, ends: fold, hopf)",
        "               above 5.125 rad/s (full equations)",
        "  from start   between 5.25 and 6.125 rad/s, edges to 1.5e-02 rad/s",
        "  also         6.5 to 6.75 rad/s",
        "  phase        rotor: 2 rad (114.6°), averaged equations 1.5 rad (85.94°)",
        "  mean speed   -6.2812 rad/s (-60 rpm)",
        "  stability    stable: largest multiplier of a period 0.9123",
        "  threshold    the vibration must be larger than 0.25 mm (averaged equations)",
    ]


def test_what_is_not_known_has_no_line(pair: EntrainmentCase) -> None:
    made = dataset(pair, Findings())
    assert lines(made) == [
        "A machine",
        f"verdict: UNIDENTIFIED: {made.wucht.summary['sentence']}",
        "  parameter    detuning = 0.5 rad/s",
    ]


def test_ends_at_the_range_are_no_ends_and_an_unstable_motion_is_called_so(shaken: EntrainmentCase) -> None:
    own = ended(shaken)
    motion = LockedMotion(own.value, np.array([2.0]), 6.0, 1.5, ORBIT)
    for kinds, how in ((("range", "range"), ""), (("fold", "range"), ", ends: fold"), (("fold", "fold"), ", ends: fold")):
        edges = (Edge(5.25, kinds[0]), Edge(6.75, kinds[1]))
        existing = Existence(band=StableRange(0, *edges, np.array([0, 1])))
        made = dataset(shaken, Findings(own, existing=existing, motions=(motion,), ends=(None, None), complete=True))
        low, high = (None if e.kind == "range" else e.value for e in edges)
        assert made.wucht.summary["existence_band"] == [low, high]
        words = {2: "in the whole range", 1: "above 5.25 rad/s", 0: "between 5.25 and 6.75 rad/s"}[kinds.count("range")]
        assert lines(made)[3:6] == [
            f"  existence    {words} (averaged equations{how})",
            "               in the whole range (full equations)",
            "  phase        rotor: 2 rad (114.6°)",
        ]
        assert lines(made)[-1] == "  stability    not stable: largest multiplier of a period 1.5"


def test_a_dimensionless_machine_has_no_units(shaken: EntrainmentCase) -> None:
    made = titled(dataset(shaken, Findings(ended(shaken), complete=True)), dimensionless=True)
    made = with_answer(made, along_unit="", phases={"rotor": 1.25}, phases_slow={"other": 2.0}, mean_speed=6.25)
    assert lines(made)[2:] == [
        f"  parameter    drive.no_load_speed = {made.wucht.summary['value']:.6g}",
        "  phase        rotor: 1.25",
        "  mean speed   6.25",
    ]


# --- the stages of the run ---


def stages(monkeypatch: pytest.MonkeyPatch, case: EntrainmentCase, inside: tuple[float, float], seed: Any) -> list[Findings]:
    """With runs that end entrained between two values, and a locked motion (or why there is none) at the end of one."""

    def run(self: RunsFromStart, value: float, progress: Any) -> RunFromStart:
        return ended(case, value, is_entrained=inside[0] <= value <= inside[1])

    def motion(self: LockedMotions, value: float, state: np.ndarray, speed: float) -> LockedMotion:
        if isinstance(seed, str):
            raise WuchtError(seed)
        return LockedMotion(value, np.array([1.0]), speed, 0.5, ORBIT)

    def follow(self: LockedMotions, first: Any, goals: list[float], resolution: float, work: Work) -> Iterator[Any]:
        followed_to.append(goals)
        yield [LockedMotion(v, np.array([1.0]), 6.0, 0.5, ORBIT) for v in goals], goals[-1] + 0.5

    followed_to: list[list[float]] = []
    monkeypatch.setattr(RunsFromStart, "__call__", run)
    monkeypatch.setattr(LockedMotions, "__init__", lambda self, *_: None)
    monkeypatch.setattr(LockedMotions, "motion", motion)
    monkeypatch.setattr(LockedMotions, "follow", follow)
    monkeypatch.setattr("wucht.studies.entrainment.computation.existence", no_averaged_equations)
    monkeypatch.setattr("wucht.studies.entrainment.computation.threshold", lambda *_: 1e-3)
    found = list(STUDY.run(case, Work()))
    assert found[-1].complete and not any(f.complete for f in found[:-1])
    return found


def no_averaged_equations(*_: Any) -> Existence:
    raise InputError("machine.bodies", None, "must be others")


def test_without_averaged_equations_the_runs_remain(monkeypatch: pytest.MonkeyPatch, shaken: EntrainmentCase) -> None:
    *_, last = stages(monkeypatch, shaken, (5.2, 6.3), "no convergence")
    assert last.existing == Existence(warnings=("the averaged equations are left out: must be others",))
    assert last.band is not None and last.band.edges == pytest.approx((5.2, 6.3), abs=2e-5)
    assert last.motions == () and last.threshold == 1e-3
    assert last.no_motion == f"at drive.no_load_speed = {shaken.parameter.nominal_value:.6g}: no convergence"


def test_without_an_entrained_run_there_is_no_locked_motion(monkeypatch: pytest.MonkeyPatch, shaken: EntrainmentCase) -> None:
    *_, last = stages(monkeypatch, shaken, (8.0, 9.0), "not asked")
    assert (last.band, last.motions, last.no_motion) == (None, (), None)


def test_locked_motions_are_followed_to_the_ends_of_the_range(monkeypatch: pytest.MonkeyPatch, shaken: EntrainmentCase) -> None:
    *_, last = stages(monkeypatch, shaken, (5.2, 6.3), None)
    own, values = shaken.parameter.nominal_value, [m.value for m in last.motions]
    expected = [*np.linspace(5.0, own, 9), *np.linspace(own, 7.0, 9)[1:]]
    assert values == pytest.approx(expected)
    assert last.ends == (5.5, 7.5) and last.no_motion is None
