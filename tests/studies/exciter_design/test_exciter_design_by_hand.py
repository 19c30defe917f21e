"""Designs that are made by hand: the lines of the report, warnings, and the order in which the run corrects its target."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.hand_made import five_functions, titled, warnings_of, with_answer
from tests.refusals import refused

import wucht
from wucht.dynamics.exciters.design_trials import Candidates, CheckedCandidate, DesignTrials, LocalOptimum
from wucht.dynamics.exciters.slow_beats import MOTIONS, Beat
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.fatigue.counted_cycles import LoadCycles
from wucht.fatigue.cumulative_spectra import shift_spectrum
from wucht.files.building import machine_from
from wucht.studies.exciter_design.computation import Findings, MachineInFolder, _best, target_spectrum
from wucht.studies.exciter_design.spec import ExciterDesign, Target

STUDY = five_functions("exciter-design")
RANGES = {"drive.slope": ["2e-4 N m s", "3e-3 N m s"], "p1.mass": ["0.3 kg", "3 kg"]}
TARGET = [["1 mm", 1e6], ["2 mm", 1e3]]
BEAT = Beat("modulated", 0.0, 10.0, np.linspace(0.5, 9.5, 10), np.linspace(1e-3, 2e-3, 10), np.full(10, 4.0))


@pytest.fixture(scope="module")
def machine() -> wucht.Machine:
    return wucht.load_machine("practice/exciter")


def planned(machine: wucht.Machine, **asked: Any) -> Any:
    return STUDY.prepare(ExciterDesign(**{"target": TARGET, "vary": RANGES} | asked), machine)


@pytest.fixture(scope="module")
def plan(machine: wucht.Machine) -> Any:
    return planned(machine)


def design(plan: Any, distance: float = 0.125, **other: Any) -> CheckedCandidate:
    counted = np.array([2e-3, 4e-3]), np.array([150.0, 50.0])
    made = CheckedCandidate(plan.numbers, BEAT, *counted, np.full(3, distance), 50.0, "captured-modulated", True, "")
    return replace(made, **other)


def tried(distances: list[float], motions: list[str] | None = None, upper: float = 2e-3) -> Candidates:
    """Candidates of which all distances are alike."""
    n = len(distances)
    kinds = np.array([MOTIONS.index(m) for m in motions or ["modulated"] * n])  # type: ignore[arg-type]
    return Candidates(
        np.full((n, 2), 1e-3), np.array([distances] * 3).T, kinds, np.full(n, upper), np.full(n, 0.25), np.full(n, 0.5)
    )


def result(plan: Any, *checked: CheckedCandidate, **other: Any) -> xr.Dataset:
    found = Findings(full_runs=checked, complete=True)
    return titled(STUDY.dataset(plan, replace(found, **other)))


# --- the report ---


def test_the_lines_of_a_design(plan: Any) -> None:
    reach = tried([0.1, 0.2, np.nan, 0.4], ["modulated", "modulated", "steady", "modulated"])
    made = result(plan, design(plan), reach=(reach, replace(reach, upper=np.full(4, 1e-3))))
    values = {"distances": {
        "full": {"amplitude": 0.125, "cumulative": 0.25, "damage": 0.375},
        "slow": {"amplitude": 0.0625, "cumulative": 0.5, "damage": 0.75},
    }}  # fmt: skip
    values |= {
        "parameters": {"drive.slope": 1.25e-3, "p1.mass": 1.5},
        "beat": 12.5,
        "cycles_per_beat": 40.0,
        "duration": 7200.0,
    }
    values |= {
        "upper": 2.5e-3,
        "beyond": 123.456,
        "damage_ratio": 0.98765,
        "target": {"cycles": 1e6, "ratio": 0.5, "upper": 2e-3},
    }
    values |= {"tolerances": {"spread": 0.01, "modulated": 0.875, "median": 0.0125, "q95": None}}
    made = with_answer(made, **values)
    assert STUDY.report(made) == [
        "A machine",
        "verdict: the spectrum is met within 12.50 % of its largest amplitude, on average, in the full equations",
        f"  signal       {made.attrs['signal']}",
        "  target       1e+06 cycles, amplitudes 1 mm to 2 mm",
        "  search       8 candidates with the averaged equations: 6 modulated, 2 steady",
        "  reach        75 % of the points beat; largest amplitudes 1 mm to 2 mm, the smallest 0.25 to 0.25 of it",
        "  design       drive.slope = 0.00125 N m s",
        "               p1.mass = 1.5 kg",
        "  beat         12.5 s, 40 cycles; all cycles of the target take 7200 s (2 h)",
        "  amplitudes   mean deviation 12.50 % of the largest (averaged equations 6.25 %)",
        "  counts       largest deviation 25.00 % of all cycles (averaged equations 50.00 %)",
        "  largest      2.5 mm; 123 cycles of the target are larger",
        "  damage       0.988 times that of the target; off by up to 37.50 % of it, counted from above",
        "  tolerances   within 1.0 % 88 % beat; median distance 1.25 %, 95 % quantile none",
    ]
    bare = STUDY.report(with_answer(made.assign_attrs(dimensionless=1), unit="N", tolerances=None, reach=None))
    assert bare[3] == "  target       1e+06 cycles, amplitudes 0.001 N to 0.002 N"
    assert bare[7] == "  beat         12.5, 40 cycles; all cycles of the target take 7200"
    assert bare[-1].startswith("  damage") and bare[5].startswith("  design")


def test_without_a_beat_nothing_is_reached(plan: Any) -> None:
    made = result(plan, reach=(tried([np.nan] * 2, ["steady"] * 2),))
    assert made.wucht.summary["reach"] == {"modulated": 0.0, "upper": None, "ratio": None, "fullness": None}
    assert [line[:13].strip() for line in STUDY.report(made)[2:]] == ["signal", "target", "search"]


# --- warnings ---


def test_warnings_of_runs_and_of_the_design(plan: Any) -> None:
    lost = design(plan, beats=False, outcome="passed")
    near = design(plan, 1e-9)
    at = plan.trials.values(np.array([[0.5, 0.0009], [0.5, 0.0011], [0.9991, 0.0]]))
    assert "do not beat" not in " ".join(warnings_of(result(plan, near)))
    warnings = warnings_of(result(plan, lost, replace(lost, reason="it burst"), design(plan, 1e-9, numbers=at[0])))
    assert warnings[:3] == [
        "2 of 3 candidates do not beat in the full equations: passed",
        "a run of the full equations ended early: it burst",
        "p1.mass lies at an end of the range: a wider one may do better",
    ]
    assert not any("at an end" in w for w in warnings_of(result(plan, design(plan, 1e-9, numbers=at[1]))))
    both = warnings_of(result(plan, design(plan, 1e-9, numbers=at[2])))
    assert "drive.slope, p1.mass lie at an end of the range: a wider one may do better" in both


def test_a_design_that_is_farther_off_in_the_full_equations(plan: Any) -> None:
    slow = result(plan, design(plan)).wucht.summary["distances"]["slow"]["amplitude"]
    far = [w for w in warnings_of(result(plan, design(plan, 1.51 * slow))) if "farther" in w]
    assert far == [
        f"the full equations are farther from the target than the averaged ones, "
        f"{100 * 1.51 * slow:.2f} % and {100 * slow:.2f} %: more "
        "corrections, or smaller unbalances, may help"
    ]
    assert not any("farther" in w for w in warnings_of(result(plan, design(plan, 1.49 * slow))))


def test_cycles_that_are_not_reached(plan: Any) -> None:
    small = design(plan, 1e-9, ranges=np.array([1e-3, 2.5e-3]))
    missed = result(plan, small).wucht.summary["beyond"]
    target = plan.target
    assert missed == pytest.approx(target.counts[target.ranges > 2.5e-3].sum()) and missed > 1e-3 * target.total
    assert f"{missed:.3g} cycles of the target exceed the largest reached amplitude" in warnings_of(result(plan, small))
    assert not any("exceed the largest" in w for w in warnings_of(result(plan, design(plan, 1e-9))))


def test_exciters_within_tolerances_that_do_not_beat(plan: Any) -> None:
    some = tried([0.1, 0.2, 0.3, np.nan])
    made = result(plan, design(plan, 1e-9), tolerances=(some,))
    t = made.wucht.summary["tolerances"]
    assert (t["modulated"], t["q05"], t["median"], t["q95"]) == (0.75, 0.2, 0.3, None)
    assert warnings_of(made)[-1] == f"25 % of the exciters within tolerances of {100 * plan.spec.spread:.1f} % do not beat"
    most = tried([0.1] * 9 + [np.nan])
    assert not any("tolerances" in w for w in warnings_of(result(plan, design(plan, 1e-9), tolerances=(most,))))


# --- the run ---


class Bench:
    """Trials that know by heart how far each candidate is off; full equations that are farther, less so once corrected."""

    def __init__(self, patch: pytest.MonkeyPatch, full: list[float | None]) -> None:
        self.full, self.polished, self.targets, self.asked = iter(full), list[Any](), list[Any](), list[Any]()
        patch.setattr(DesignTrials, "evaluate", lambda _, numbers, target, report: self.evaluate(numbers, target, report))
        patch.setattr(DesignTrials, "optimise", lambda _, *given: self.optimise(*given))
        patch.setattr("wucht.studies.exciter_design.computation.check_candidate", self.check)
        # The comparison with neighbours is in test_design_comparison.py.
        patch.setattr("wucht.studies.exciter_design.computation.compare_designs", lambda *_: ())
        patch.setattr("wucht.studies.exciter_design.computation.end_of_beating", lambda *_: None)

    def evaluate(self, numbers: np.ndarray, target: LoadCycles, report: Any) -> Candidates:
        self.asked.append((len(numbers), target))
        report(0.5)
        n = len(numbers)
        far = np.abs(np.log(numbers[:, 1]))
        return Candidates(numbers, np.array([far] * 3).T, np.zeros(n, int), np.ones(n), np.ones(n), np.ones(n))

    def optimise(self, numbers: np.ndarray, target: LoadCycles, evaluations: int, report: Any) -> LocalOptimum:
        self.polished.append(target)
        report(0.5)
        return LocalOptimum(numbers * 1.01, 0.01)

    def check(self, trials: DesignTrials, numbers: np.ndarray, target: LoadCycles, beats: int, work: Work) -> CheckedCandidate:
        distance = next(self.full)
        self.targets.append(target)
        made = design(self.plan, 9.0 if distance is None else distance, numbers=numbers)
        return replace(made, beats=distance is not None)

    plan: Any


TINY = {
    "reach": 8,
    "evaluations": 8,
    "population": 4,
    "candidates": 1,
    "polish": 12,
    "corrections": 3,
    "beats": 8,
    "samples": 0,
}


@pytest.mark.parametrize(
    ("full", "runs"),
    [
        ([0.5, 0.25, 0.125, 0.0625], 4),  # all corrections help
        ([0.5, 0.25, 0.375], 3),  # the second does not: there is no third
        ([0.5, 0.75], 2),
        ([None], 1),  # nothing beats
    ],
)
def test_corrections_go_on_while_they_help(
    monkeypatch: pytest.MonkeyPatch, machine: wucht.Machine, full: list[float | None], runs: int
) -> None:
    bench = Bench(monkeypatch, full)
    bench.plan = plan = planned(machine, **TINY)
    shares: list[float] = []
    *_, last = STUDY.run(plan, Work(reporter=lambda share, _: shares.append(share)))
    assert last.complete and len(last.full_runs) == runs and len(last.local_optima) == 1
    best = last.design(plan.trials.metric)
    assert (None if best is None else best.distances[0]) == min((d for d in full if d is not None), default=None)
    corrected = shift_spectrum(plan.target, BEAT.cycles, design(plan).cycles)
    assert bench.polished[0] is plan.target
    for target in bench.polished[1:]:
        assert np.array_equal(target.ranges, corrected.ranges) and np.array_equal(target.counts, corrected.counts)
    assert len(bench.polished) == runs and all(target is plan.target for target in bench.targets)
    for k, one in enumerate(last.full_runs[1:]):
        before = min(last.full_runs[: k + 1], key=lambda c: c.distances[0])
        assert one.numbers == pytest.approx(1.01 * before.numbers)
    assert shares == sorted(shares) and shares[-1] == 1.0


def test_without_local_search_the_best_is_tried_itself(monkeypatch: pytest.MonkeyPatch, machine: wucht.Machine) -> None:
    bench = Bench(monkeypatch, [0.5])
    bench.plan = plan = planned(machine, **TINY | {"polish": 0})
    *_, last = STUDY.run(plan, Work())
    (one,) = last.local_optima
    numbers = np.concatenate([b.numbers for b in (*last.reach, *last.search)])
    nearest = numbers[np.abs(np.log(numbers[:, 1])).argmin()]
    assert np.array_equal(one.numbers, nearest) and one.distance == pytest.approx(abs(np.log(nearest[1])))
    assert bench.asked[-1] == (1, plan.target) and bench.polished == [] and len(last.full_runs) == 1


def test_candidates_are_apart(monkeypatch: pytest.MonkeyPatch, machine: wucht.Machine) -> None:
    bench = Bench(monkeypatch, [0.5, 0.25, 0.125])
    bench.plan = plan = planned(machine, **TINY | {"candidates": 3, "corrections": 0, "samples": 8})
    done: list[float] = []
    *_, last = STUDY.run(plan, Work(reporter=lambda share, _: done.append(share)))
    assert done == sorted(done) and done[-1] == 1.0 and len([x for x in done if 0.4 <= x <= 0.55]) >= 6
    shares = np.array([plan.trials.shares(p.numbers / 1.01) for p in last.local_optima])
    apart = np.abs(shares[:, None] - shares[None]).max(axis=2)[np.triu_indices(len(shares), 1)]
    assert len(shares) == 3 and (apart > 0.1).all()
    best = last.design(plan.trials.metric)
    assert best is last.full_runs[2]
    about = np.concatenate([b.numbers for b in last.tolerances]) / best.numbers - 1
    assert about.shape == (8, 2) and np.abs(about).max() <= plan.spec.spread and np.abs(about).max() > plan.spec.spread / 2
    assert (about > 0).any() and (about < 0).any()
    corrected = shift_spectrum(plan.target, BEAT.cycles, design(plan).cycles)
    about_design = [target for _, target in bench.asked if target is not plan.target]
    assert len(about_design) == len(last.tolerances), "against the target of the averaged equations"
    assert all(np.array_equal(target.ranges, corrected.ranges) for target in about_design)


@pytest.mark.parametrize("heaviest", ["3 kg", "0.6 kg"])
def test_the_search_begins_at_the_best_points_and_the_nominal_exciter_if_it_is_in_the_ranges(
    monkeypatch: pytest.MonkeyPatch, machine: wucht.Machine, heaviest: str
) -> None:
    """Those whose mass is nearest to 1 kg; the nominal mass is 0.84 kg."""
    bench = Bench(monkeypatch, [0.5])
    bench.plan = plan = planned(machine, **TINY | {"vary": RANGES | {"p1.mass": ["0.3 kg", heaviest]}, "corrections": 0})
    *_, last = STUDY.run(plan, Work())
    reach = np.concatenate([b.numbers for b in last.reach])
    best = reach[np.argsort(np.abs(np.log(reach[:, 1])))][:4]
    is_inside = plan.numbers[1] <= plan.trials.variables[1].high
    assert is_inside == (heaviest == "3 kg")
    first = np.vstack([best[:3], plan.numbers]) if is_inside else best
    assert last.search[0].numbers == pytest.approx(first)


def test_candidates_are_apart_in_one_variable_at_least() -> None:
    numbers = np.array([[0.5, 0.5], [0.45, 0.55], [0.5, 0.7], [0.9, 0.5]])
    far = np.array([0.1, 0.2, 0.3, 0.4])
    batch = Candidates(numbers, np.array([far] * 3).T, np.zeros(4, int), np.ones(4), np.ones(4), np.ones(4))
    trials = SimpleNamespace(metric=0, shares=lambda row: row)
    for count, chosen in ((3, [0, 2, 3]), (2, [0, 2])):
        plan: Any = SimpleNamespace(trials=trials, spec=SimpleNamespace(candidates=count))
        assert np.array_equal(_best(plan, Findings(reach=(batch,))), numbers[chosen])


# --- refusals, the file of a target ---


def test_a_machine_without_a_pendulum_or_with_a_schedule(machine: wucht.Machine) -> None:
    rotor = {"kind": "rotor", "name": "drum", "mass": 3.0, "unbalance": 1e-2, "inertia": 1.5e-2}
    drive = {"kind": "linear", "slope": 1e-3, "no_load_speed": 100.0}
    alone = machine_from({"carrier": {"stiffness": 1e4, "damping": 20.0}, "bodies": [rotor], "drive": drive})
    with refused("machine.bodies", "drum", given=None):
        STUDY.prepare(ExciterDesign(target=TARGET, vary={"drive.slope": RANGES["drive.slope"]}), alone)
    scheduled = machine.with_fields(schedules=({"parameter": "carrier.stiffness", "points": [(1.0, 1e5), (2.0, 9e4)]},))
    with refused("machine.schedules", given=None):
        planned(scheduled)


def test_targets(plan: Any, machine: wucht.Machine) -> None:
    given = Target(shape="normal", largest="2 mm", cycles=1e6)
    assert ExciterDesign(target=given, vary=RANGES).target is given
    for ratio, least in ((None, 0.0), (0.25, 0.5e-3)):
        spectrum = target_spectrum(Target(shape="straight-line", largest="2 mm", cycles=1e6, ratio=ratio), "m", None)
        assert (spectrum.ranges.min() / 2, spectrum.largest / 2) == pytest.approx((least, 2e-3), abs=2e-5)
        assert spectrum.total == pytest.approx(1e6)
    with refused("study.target.ratio"):
        ExciterDesign(target=Target(table=TARGET, ratio=0.5), vary=RANGES)
    with refused("study.target.table", "more than one cycle"):
        planned(machine, target=[["1 mm", 1.0], ["2 mm", 1.0]])
    assert planned(machine, target=[["1 mm", 1.01], ["2 mm", 1.0]]).target.total == pytest.approx(1.01)


def test_a_changed_file_is_another_question(tmp_path: Path, machine: wucht.Machine) -> None:
    spec, subject = ExciterDesign(target={"file": "t.csv"}, vary=RANGES), MachineInFolder(machine, tmp_path)
    contents = []
    for text in ("a", "b", "a"):
        (tmp_path / "t.csv").write_text(text)
        contents.append(spec.table_for(subject)["target"]["contents"])
    assert contents[0] == contents[2] != contents[1]
    assert "contents" not in spec.table_for(machine)["target"]
    with pytest.raises(InputError, match=r"study\.target\.file: given 't\.csv'"):
        STUDY.prepare(spec, machine)
