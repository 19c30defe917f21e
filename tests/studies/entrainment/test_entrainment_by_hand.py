"""Entrainment of three clockwise exciters, and of a shaken rotor, made by hand: every quantity, every line drawn."""

from __future__ import annotations

import math
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.hand_made import drawn, five_functions, titled
from tests.refusals import refused

from wucht.dynamics.entrainment.entrainment_case import EntrainmentCase
from wucht.dynamics.entrainment.existence import Edge, Existence, ExistenceBranch, StableRange
from wucht.dynamics.entrainment.locked_motions import LockedMotion
from wucht.dynamics.entrainment.runs_from_start import CaptureBand, RunFromStart, RunsFromStart
from wucht.dynamics.work import Work
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.numerics.orbits import PeriodicOrbit
from wucht.plots.style import COLOURS, GREY
from wucht.studies.entrainment import computation, figure
from wucht.studies.entrainment.computation import Findings
from wucht.studies.entrainment.dataset import band_in_words
from wucht.studies.entrainment.spec import Entrainment

STUDY = five_functions("entrainment")
ORBIT: PeriodicOrbit = None  # type: ignore[assignment]  # of which nothing is said
ROTOR = {"kind": "rotor", "mass": 0.1, "eccentricity": 0.01, "inertia": 2e-5}
NAMES = ("e1", "e2", "e3")


def case_of(machine: Any, **asked: Any) -> EntrainmentCase:
    case: EntrainmentCase = STUDY.prepare(Entrainment.from_table(asked), machine)
    return case


@pytest.fixture(scope="module")
def three() -> EntrainmentCase:
    """Along the no-load speed of the first motor, at -12 rad/s."""
    carrier = {"mass": 0.8, "directions": "x", "stiffness": 355.0, "damping": 0.4}
    drives = [{"on": on, "kind": "linear", "slope": 3e-5, "no_load_speed": -12.0} for on in NAMES]
    machine = machine_from({"carrier": carrier, "bodies": [ROTOR | {"name": n} for n in NAMES], "drives": drives})
    return case_of(machine, range=[-14.0, -10.0])


@pytest.fixture(scope="module")
def shaken() -> EntrainmentCase:
    return case_of(load_machine("sperling-vibration/figure-2a"), range=[5.0, 7.0])


def ended(case: EntrainmentCase, k: int, value: float, is_entrained: bool, **other: Any) -> RunFromStart:
    """Its numbers are unlike those of other runs."""
    speeds = {r.name: -12.0 - k - 0.25 * i for i, r in enumerate(case.machine.rotors)}
    common = {
        "free_speed": value - 1.0, "is_entrained": is_entrained, "mean_speed": -12.0 - k, "window": (50.0 + k, 100.0 + k),
        "speeds": speeds, "phases": {"e2": 1.0 + k / 8, "e3": 2.0 + k / 8}, "creep": 0.001 * k,
    }  # fmt: skip
    return RunFromStart(value, 200.0 + k, 300.0 + k, k + np.arange(float(len(case.machine.state_names))), **common | other)


def runs_of_three(case: EntrainmentCase) -> tuple[RunFromStart, ...]:
    ends = enumerate([(-14.0, False), (-12.5, True), (-12.0, True), (-10.0, False)])
    return tuple(ended(case, k, value, ok) for k, (value, ok) in ends)


def branch(values: list[float], first: float, stable: list[bool]) -> ExistenceBranch:
    at, n = np.array(values), len(values)
    states = np.stack([first + 0.1 * np.arange(n), first + 1.0 + 0.1 * np.arange(n), 11.0 + first + 0.25 * np.arange(n)])
    return ExistenceBranch(at, states, np.array(stable), ("",) * n, np.zeros(n, complex), False)


BRANCHES = (branch([-13.0, -12.5, -12.0, -11.0], 0.5, [False, True, True, True]), branch([-12.0, -11.5], 3.0, [True, False]))


def findings(case: EntrainmentCase) -> Findings:
    # The rows of the phases are not in the order of the bodies.
    equations: Any = SimpleNamespace(speed=lambda states: 2.0 * states[2], phase_rows={"e3": 0, "e2": 1})
    stable = StableRange(0, Edge(-12.75, "fold"), Edge(-10.0, "range"), np.array([1, 2, 3]))
    existing = Existence(equations, (), BRANCHES, stable, 0.5, {"e2": 1.5, "e3": 7.0})
    runs = runs_of_three(case)
    motions = tuple(
        LockedMotion(value, np.array([4.0 + k, -0.5 - k]), 11.5 + k, 0.5 + 0.75 * k, ORBIT)
        for k, value in enumerate((-12.5, -12.0))
    )
    band = CaptureBand(((-12.5, -14.0), (-12.0, -10.0)), ())
    return Findings(runs[2], (-14.0, -10.0), 0.125, existing, runs, band, motions, (-12.625, None), complete=True)


@pytest.fixture(scope="module")
def result(three: EntrainmentCase) -> xr.Dataset:
    made: xr.Dataset = titled(STUDY.dataset(three, findings(three))).assign_attrs(finished=1)
    return made


# --- the Dataset ---


def test_points_of_all_branches(result: xr.Dataset) -> None:
    assert result.body.values.tolist() == ["e2", "e3"]
    assert result.value.values.tolist() == [-13.0, -12.5, -12.0, -11.0, -12.0, -11.5]
    assert result.branch.values.tolist() == [0, 0, 0, 0, 1, 1] and result.stable.values.tolist() == [0, 1, 1, 1, 1, 0]
    assert result.phase.values == pytest.approx(np.array([[1.5, 1.6, 1.7, 1.8, 4.0, 4.1], [0.5, 0.6, 0.7, 0.8, 3.0, 3.1]]))
    assert result.speed.values == pytest.approx([23.0, 23.5, 24.0, 24.5, 28.0, 28.5])


def test_locked_motions_are_in_one_turn(result: xr.Dataset) -> None:
    assert result.orbit_value.values.tolist() == [-12.5, -12.0] and result.orbit_speed.values.tolist() == [11.5, 12.5]
    turn = 2 * math.pi
    assert result.orbit_phase.values == pytest.approx(np.array([[4.0, 5.0], [turn - 0.5, turn - 1.5]]))
    assert result.orbit_stable.values.tolist() == [1, 0] and result.orbit_multiplier.values.tolist() == [0.5, 1.25]


def test_runs_of_clockwise_rotors(three: EntrainmentCase, result: xr.Dataset) -> None:
    runs = runs_of_three(three)
    assert result.run_value.values.tolist() == [-14.0, -12.5, -12.0, -10.0]
    assert result.run_taken.values.tolist() == [0, 1, 1, 0]
    assert result.run_speed.values.tolist() == [12.0, 13.0, 14.0, 15.0]
    assert result.run_mean_speed.values.tolist() == [-12.0, -13.0, -14.0, -15.0]
    assert result.run_drift.values == pytest.approx([0.0, 1e-3, 2e-3, 3e-3])
    assert result.run_until.values.tolist() == [200.0, 201.0, 202.0, 203.0]
    assert result.run_end_time.values.tolist() == [300.0, 301.0, 302.0, 303.0]
    assert result.run_window.values.tolist() == [[50.0, 51.0, 52.0, 53.0], [100.0, 101.0, 102.0, 103.0]]
    assert result.run_rotor_speed.values.tolist() == [[-12.0 - k - 0.25 * i for k in range(4)] for i in range(3)]
    phases = result.run_rotor_phase.values
    assert np.isnan(phases[0]).all() and phases[1:] == pytest.approx(np.array([[1.0], [2.0]]) + np.arange(4) / 8)
    assert result.run_end_state.values == pytest.approx(np.stack([r.end_state for r in runs], axis=1))
    assert result.free_speed.values.tolist() == [-15.0, -13.5, -13.0, -11.0]
    assert result.run_failed.values.tolist() == [""] * 4


def test_bands_and_the_motion_of_the_machine(result: xr.Dataset) -> None:
    s = result.wucht.summary
    assert (s["outcome"], s["along"], s["along_unit"], s["value"]) == (
        "synchronised",
        "drives.e1.no_load_speed",
        "rad/s",
        -12.0,
    )
    assert (s["range"], s["resolution"], s["islands"]) == ([-14.0, -10.0], 0.125, [])
    assert s["existence_band"] == [-12.75, None] and s["existence_edges"] == ["fold", "range"] and s["branch"] == 0
    assert (s["existence_band_full"], s["band_from_rest"]) == ([-12.625, None], [-13.25, -11.0])
    assert s["phases"] == {"e2": pytest.approx(5.0), "e3": pytest.approx(2 * math.pi - 1.5)} == s["phase"]
    assert s["phases_slow"] == {"e2": 1.5, "e3": pytest.approx(7.0 - 2 * math.pi)} == s["phase_slow"]
    assert (s["mean_speed"], s["stable"], s["multiplier"], s["window"]) == (-12.5, False, 1.25, [52.0, 102.0])
    assert s["existence_band_from"] == "averaged equations" and s["threshold_amplitude"] is None
    assert "frequency" not in result.attrs


def test_only_the_run_of_the_machine_is_there_before_others(three: EntrainmentCase) -> None:
    own = runs_of_three(three)[2]
    made = STUDY.dataset(three, Findings(own))
    assert made.run_value.values.tolist() == [-12.0] and made.sizes["point"] == made.sizes["orbit"] == 0
    assert made.phase.dims == ("body", "point") and made.wucht.summary["existence_band"] is None
    failed = STUDY.dataset(three, Findings(ended(three, 0, -12.0, False, failure="it burst", free_speed=None)))
    assert failed.wucht.summary["outcome"] == "failed" and failed.attrs["sentence"] == "it burst" == failed.attrs["failure"]
    assert failed.run_failed.values.tolist() == ["it burst"] and np.isnan(failed.free_speed.values).all()
    nothing = STUDY.dataset(three, Findings())
    assert nothing.wucht.summary["outcome"] == "unidentified" and nothing.sizes["run"] == 0


def test_a_motion_counts_only_where_the_run_of_the_machine_is_entrained(three: EntrainmentCase) -> None:
    motion = LockedMotion(-12.0, np.array([1.0, 2.0]), 12.0, 0.5, ORBIT)
    apart = Findings(ended(three, 0, -12.0, False), motions=(motion,))
    assert apart.nominal_motion is None and STUDY.dataset(three, apart).wucht.summary["mean_speed"] == -12.0
    assert Findings(ended(three, 0, -12.0, True), motions=(motion,)).nominal_motion is motion
    assert Findings(ended(three, 0, -12.5, True), motions=(motion,)).nominal_motion is None
    assert Findings(motions=(motion,)).nominal_motion is None


@pytest.mark.parametrize(
    ("phase", "wrapped"), [(math.pi, math.pi), (-math.pi, math.pi), (3.5, 3.5 - 2 * math.pi), (-7, 2 * math.pi - 7)]
)
def test_phases_to_the_vibration_are_in_half_a_turn_to_either_side(
    shaken: EntrainmentCase, phase: float, wrapped: float
) -> None:
    own = shaken.parameter.nominal_value
    made = STUDY.dataset(shaken, Findings(ended(shaken, 0, own, True, phases={"vibration": phase})))
    assert made.wucht.summary["phase"] == pytest.approx(wrapped)
    assert made.attrs["frequency"] == pytest.approx(shaken.machine.shaking_frequency)
    assert made.run_rotor_phase.values.tolist() == [[phase]] and made.wucht.summary["outcome"] == "entrained"
    apart = STUDY.dataset(shaken, Findings(ended(shaken, 0, own, False)))
    assert apart.wucht.summary["outcome"] == "not-entrained"


def test_bands_in_words() -> None:
    assert band_in_words((1.0, 2.5), "Hz", "f = ") == "between f = 1 and 2.5 Hz"
    assert band_in_words((None, 2.5), "", "f = ") == "below f = 2.5" and band_in_words((1.0, None), "Hz") == "above 1 Hz"
    assert band_in_words((None, None), "Hz") == "in the whole range"
    assert band_in_words((1.23456789, None), "", digits=3) == "above 1.23"


# --- the stages of the run ---


def followed(case: EntrainmentCase, patch: pytest.MonkeyPatch, runs: list[RunFromStart], band: Any = None) -> tuple[Any, ...]:
    """The solver that follows locked motions ends half a step beyond its goals: goals, the seed's time, the last findings."""
    goals: list[list[float]] = []
    made: list[Any] = []

    class Solver:
        def __init__(self, _case: Any, senses: Any, end_time: float) -> None:
            made.append(end_time)

        def motion(self, value: float, state: np.ndarray, speed: float) -> LockedMotion:
            made.append((value, speed))
            return LockedMotion(value, np.zeros(2), speed, 0.5, ORBIT)

        def follow(self, seed: LockedMotion, to: list[float], resolution: float, part: Work) -> Iterator[Any]:
            goals.append(to)
            yield [LockedMotion(to[-1], np.zeros(2), 1.0, 0.5, ORBIT)], to[-1] + 0.5

    patch.setattr(computation, "LockedMotions", Solver)
    start = Findings(runs[0], (-14.0, -10.0), 0.1, Existence(band=band), tuple(runs))
    steps = computation._follow_motions(case, {}, start, Work())
    try:
        while True:
            next(steps)
    except StopIteration as end:
        return goals, made, end.value


def test_motions_begin_at_the_entrained_run_nearest_to_the_machine(
    monkeypatch: pytest.MonkeyPatch, three: EntrainmentCase
) -> None:
    runs = [ended(three, 0, -13.0, True), ended(three, 1, -12.0, False), ended(three, 2, -11.5, True)]
    goals, made, last = followed(three, monkeypatch, runs)
    assert made == [302.0, (-11.5, 14.0)], "its speed as a size"
    assert goals[0] == pytest.approx([*np.linspace(-11.5, -14.0, 9)[1:-1], -14.0])
    assert goals[1] == pytest.approx([*np.linspace(-11.5, -10.0, 9)[1:-1], -10.0])
    assert last.ends == (-13.5, -9.5) and [m.value for m in last.motions] == [-14.0, -11.5, -10.0]


def test_motions_are_dense_inside_the_band_of_existence(monkeypatch: pytest.MonkeyPatch, three: EntrainmentCase) -> None:
    """They go on to the ends of the range; of a band that is wider than the range only what is within counts."""
    runs = [ended(three, 0, -12.0, True)]
    band = StableRange(0, Edge(-13.0, "fold"), Edge(-9.0, "fold"), np.array([0]))
    goals, _, _ = followed(three, monkeypatch, runs, band)
    assert goals[0] == pytest.approx([*np.linspace(-12.0, -13.0, 9)[1:-1], -14.0])
    assert goals[1] == pytest.approx([*np.linspace(-12.0, -10.0, 9)[1:-1], -10.0])


@pytest.mark.parametrize(("factor", "again"), [(1.4, False), (1.6, True)])
def test_a_run_that_was_too_short_is_made_again(
    monkeypatch: pytest.MonkeyPatch, shaken: EntrainmentCase, factor: float, again: bool
) -> None:
    own, made = shaken.parameter.nominal_value, list[float]()

    def run(self: RunsFromStart, value: float, progress: Any) -> RunFromStart:
        made.append(value)
        return ended(shaken, len(made), value, False)

    def lasting(self: RunsFromStart, case: Any, senses: Any = None, rate: float | None = None) -> None:
        self.case, self.duration = case, 301.0 if senses is None else 301.0 * factor

    def left_out(*_: Any) -> Existence:
        return Existence(slowest_rate=0.5)

    monkeypatch.setattr(RunsFromStart, "__init__", lasting)
    monkeypatch.setattr(RunsFromStart, "__call__", run)
    monkeypatch.setattr(computation, "existence", left_out)
    monkeypatch.setattr(computation, "threshold", lambda *_: None)
    *_, last = STUDY.run(shaken, Work())
    assert made[:2] == [own, own if again else 5.0] and made.count(own) == 1 + again
    values = [r.value for r in last.runs]
    assert values == sorted(values) and values[0] == 5.0 and values[-1] == 7.0 and own in values
    assert last.resolution == pytest.approx(2e-5) and len(last.runs) == 25 + (own not in np.linspace(5.0, 7.0, 25))


def test_after_a_failed_run_nothing_is_searched(monkeypatch: pytest.MonkeyPatch, shaken: EntrainmentCase) -> None:
    def run(self: RunsFromStart, value: float, progress: Any) -> RunFromStart:
        return ended(shaken, 0, value, False, failure="it burst")

    monkeypatch.setattr(RunsFromStart, "__init__", lambda self, case: vars(self).update(case=case, duration=1.0))
    monkeypatch.setattr(RunsFromStart, "__call__", run)
    stages = list(STUDY.run(shaken, Work()))
    assert len(stages) == 2 and stages[-1].failure == "it burst" and not stages[-1].complete


@pytest.mark.parametrize("points", [4, 2001])
def test_numbers_of_runs_that_are_refused(points: int) -> None:
    with refused("study.points", given=points):
        Entrainment(points=points)
    assert Entrainment(points=5).points == 5 and Entrainment(points=2000).points == 2000


# --- the figure ---


def lines_of(axis: Any) -> dict[str, Any]:
    return {str(x.get_label()): x for x in axis.get_lines() if not str(x.get_label()).startswith("_")}


def test_phases_and_speeds_of_three_exciters(result: xr.Dataset) -> None:
    phase, speed = drawn("entrainment", result).axes
    shown = lines_of(phase)
    deg = 180 / math.pi
    for i, name in enumerate(("e2", "e3")):
        stable, unstable = (shown[f"{name}: averaged, {kind}"] for kind in ("stable", "unstable"))
        assert stable.get_xdata() == pytest.approx([-13.0, -12.5, -12.0, -11.0])
        drawn_stable = np.array(stable.get_ydata())
        assert np.isnan(drawn_stable[0]) and drawn_stable[1:] == pytest.approx(deg * result.phase.values[i, 1:4])
        assert np.array(unstable.get_ydata())[:2] == pytest.approx(deg * result.phase.values[i, :2]), "the two lines meet"
        assert np.isnan(np.array(unstable.get_ydata())[2:]).all()
        assert (stable.get_linestyle(), unstable.get_linestyle()) == ("-", "--")
        orbit = shown[f"{name}: full, periodic"]
        assert list(orbit.get_xdata()) == [-12.5, -12.0]
        assert orbit.get_ydata() == pytest.approx(deg * result.orbit_phase.values[i] - 360.0), "the panel is cut at 180 degrees"
        others = shown[f"{name}: others, stable"]
        assert others.get_color() == GREY and others.get_ydata()[0] == pytest.approx(
            deg * result.phase.values[i, 4] - (360.0 if i == 0 else 0.0)
        )
    assert phase.get_ylabel() == "phase (°)" and phase.get_ylim() == pytest.approx((-180.0, 180.0))
    fast = lines_of(speed)
    main = fast["averaged equations, stable"]
    assert main.get_color() == COLOURS[0] and list(main.get_xdata()) == [-13.0, -12.5, -12.0, -11.0]
    assert np.isnan(main.get_ydata()[0]) and main.get_ydata()[1:] == pytest.approx([23.5, 24.0, 24.5])
    assert list(fast["run: entrained"].get_xdata()) == [-12.5, -12.0]
    assert list(fast["run: entrained"].get_ydata()) == [13.0, 14.0]
    assert list(fast["run: not entrained"].get_xdata()) == [-14.0, -10.0]
    assert list(fast["speed without vibration"].get_ydata()) == [15.0, 13.5, 13.0, 11.0]


def test_bands_in_both_panels(result: xr.Dataset) -> None:
    figure_ = drawn("entrainment", result)
    for axis in figure_.axes[:2]:
        (shade,) = axis.patches
        box = shade.get_extents().transformed(axis.transData.inverted())
        assert (box.x0, box.x1) == pytest.approx((-12.75, -10.0)), "an end beyond the range is the end of the range"
        edges = sorted(x.get_xdata()[0] for x in axis.get_lines() if x.get_linestyle() == "-.")
        assert edges == [-13.25, -11.0]
        (own,) = (x for x in axis.get_lines() if x.get_linestyle() == ":" and set(x.get_xdata()) == {-12.0})
        assert own.get_color() == GREY and axis.get_xlim() == pytest.approx((-14.12, -9.88))
    assert list(lines_of(figure_.axes[0])).count("this machine") == 1 and "this machine" not in lines_of(figure_.axes[1])
    assert "exists above -12.75 rad/s (averaged equations)" in figure_.get_suptitle()
    assert "reached from the start between -13.25 and -11 rad/s" in figure_.get_suptitle()


def test_limits_of_an_interrupted_study(three: EntrainmentCase) -> None:
    own = runs_of_three(three)[2]
    one = titled(STUDY.dataset(three, Findings(own))).assign_attrs(finished=0)
    assert figure._limits(one, -12.0) == (-13.0, -11.0) and figure._limits(one, -15.0) == (-15.0, -12.0)
    axis = drawn("entrainment", one).axes[0]
    assert axis.get_xlim() == pytest.approx((-13.06, -10.94)) and not axis.patches


def test_where_the_circle_of_phases_is_cut() -> None:
    """Away from the stable phases of the main branch and from those of locked motions."""

    def cut(phases: list[float], stable: list[int], orbits: list[float]) -> float:
        made = xr.Dataset({
            "phase": (("body", "point"), [phases]), "stable": ("point", stable), "branch": ("point", [0, 0, 1]),
            "orbit_phase": (("body", "orbit"), [orbits]),
        })  # fmt: skip
        return figure._phase_cut(made, 0)

    assert cut([0.1, 3.0, 3.1], [1, 0, 1], []) == math.pi, "around 0"
    assert cut([3.0, 0.1, 0.2], [1, 0, 1], []) == 2 * math.pi, "around 180 degrees"
    assert cut([0.1, 0.1, 0.1], [0, 0, 1], [3.0]) == 2 * math.pi and cut([3.0, 3.0, 3.0], [0, 0, 1], [0.1]) == math.pi
    assert figure._wrap_below(np.array([-math.pi, math.pi, 4.0]), math.pi) == pytest.approx([math.pi, math.pi, 4 - 2 * math.pi])


def test_a_phase_that_wraps_downwards_goes_to_the_border() -> None:
    x, y = np.array([0.0, 1.0, 2.0]), np.array([-2.5, 3.0, 2.0])
    at, shown = figure._stability_part(x, y, np.ones(3, bool), True, math.pi)
    share = (math.pi - 2.5) / (2 * math.pi - 5.5)
    assert at == pytest.approx([0.0, share, share, share, 1.0, 2.0])
    assert shown == pytest.approx([-2.5, -math.pi, math.nan, math.pi, 3.0, 2.0], nan_ok=True)


@pytest.mark.parametrize(
    ("stable", "goes_on"), [([True, True, False], True), ([False, True, True], False), ([True, False, True], False)]
)
def test_a_line_goes_to_the_border_only_where_both_points_beside_it_are_drawn(stable: list[bool], goes_on: bool) -> None:
    x, y = np.array([0.0, 1.0, 2.0]), np.array([3.0, -3.0, -2.0])
    at, shown = figure._stability_part(x, y, np.array(stable), True, math.pi)
    assert at == pytest.approx([0.0, 0.5, 0.5, 0.5, 1.0, 2.0])
    border = [math.pi, math.nan, -math.pi] if goes_on else [math.nan] * 3
    assert shown[1:4] == pytest.approx(border, nan_ok=True)
    assert np.isfinite(shown[[0, 4, 5]]).tolist() == stable
