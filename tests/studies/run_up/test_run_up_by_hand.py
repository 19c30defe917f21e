"""Numbers of a run-up from motions that are made by hand: the limits of its end, few samples, both models, many cases."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from tests.refusals import refused

from wucht.dynamics.run_ups.deviations import ComparedMotion
from wucht.dynamics.run_ups.run_up import RunUpCase
from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.dynamics.work import Work
from wucht.results.quantities import Quantity, StudyResult
from wucht.studies.run_up import combined_runs, computation, dataset
from wucht.studies.run_up.computation import _machine_plan, numbers
from wucht.studies.run_up.dataset import _MotionLimits, _observe_limits, _sampling_warnings
from wucht.studies.run_up.figure import _limits, _orbit, mean_phase
from wucht.studies.run_up.report import _bearing_forces, _bearings
from wucht.studies.run_up.spec import RunUp

TIME = np.linspace(0.0, 10.0, 11)


# --- the numbers at the end ---


def ended(
    speed: Any, monkeypatch: pytest.MonkeyPatch, limits: _MotionLimits | None = None, largest: float = 1e-2, **verdict: Any
) -> dict[str, Any]:
    """The summary of a run whose final window is from 8 to 10 s; natural_frequencies: the time at which the machine is."""
    monkeypatch.setattr(dataset, "natural_frequencies", lambda machine: {"x": machine})
    monkeypatch.setattr(dataset, "dimensionless_numbers", lambda machine: {})
    units = SimpleNamespace(speed="rad/s", time="s")
    names = SimpleNamespace(rotor=SimpleNamespace(name="drum"), units=units, orbit_unit="m")
    machine: Any = SimpleNamespace(**vars(names), at=lambda time: _Timed(time, names))
    result = xr.Dataset(
        {"speed": (("body", "time"), [np.full(11, 999.0), np.asarray(speed, float)]), "amplitude": ("time", 1e-3 * TIME),
         "energy_residual": ("time", 1e-9 * TIME)},
        {"body": ["other", "drum"], "time": TIME},
    )  # fmt: skip
    numbers_of_verdict = {
        "evidence": SimpleNamespace(turning=True, resonance=7.0), "modulation": None, "window": (8.0, 10.0), "amplitudes": None,
        "speed": 5.0, "phases": {}, "residual": 0.5, "settling_time": 3.0, "amplitude_settling_time": 4.0, "advice": None,
        "needed_time": None, "unbalance_factor": None, "locking": None, "rotors": {}, "outcome": Outcome.PASSED,
    }  # fmt: skip
    some: Any = SimpleNamespace(**numbers_of_verdict | verdict)
    motion: Any = SimpleNamespace(
        case=SimpleNamespace(machine=machine), verdict=some, observation=SimpleNamespace(largest=largest)
    )
    return {q.name: q.value for q in dataset._summary(motion, result, limits, Noise.of(1e-9))}


class _Timed(float):
    """A machine at a time, as a number."""

    def __new__(cls, time: float, machine: Any) -> _Timed:
        made = super().__new__(cls, time)
        made.__dict__.update(vars(machine))
        return made


@pytest.mark.parametrize("sense", [1, -1])
def test_a_rotor_of_either_sense(sense: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its mean speed has its sense; a modulation between 4 and 6 rad/s is one of a fifth to either side."""
    modulation = SimpleNamespace(low=4.0, high=6.0, period=2.0, period_angle=10.0)
    s = ended(sense * np.array([0, 1, 2, 3, 4, 5, 6, 7, 4.5, 5.0, 5.5]), monkeypatch, modulation=modulation)
    assert (s["final_speed"], s["modulation_depth"]) == (sense * 5.0, pytest.approx(0.2))
    assert sorted(abs(s[f"{end}_speed"]) for end in ("min", "max")) == [4.5, 5.5] and s["min_speed"] < s["max_speed"]
    assert (s["final_amplitude"], s["min_amplitude"], s["max_amplitude"]) == pytest.approx((9e-3, 8e-3, 10e-3))
    assert (s["settling_time"], s["amplitude_settling_time"], s["resonance_speed"]) == (3.0, 4.0, 7.0)
    assert s["energy_residual"] == pytest.approx(1e-8) and s["natural_frequencies"] == {"x": 10.0}, "of the machine at the end"


def test_limits_of_the_motion_take_the_place_of_few_samples(monkeypatch: pytest.MonkeyPatch) -> None:
    limits = _MotionLimits((4.0, 7.0), (2e-3, 1e-3, 3e-3))
    s = ended(np.full(11, 5.0), monkeypatch, limits)
    assert (s["min_speed"], s["max_speed"]) == (4.0, 7.0)
    assert (s["final_amplitude"], s["min_amplitude"], s["max_amplitude"]) == (2e-3, 1e-3, 3e-3)
    s = ended(np.full(11, 5.0), monkeypatch, limits, amplitudes=(5e-3, 4e-3, 6e-3))
    assert (s["final_amplitude"], s["min_amplitude"], s["max_amplitude"]) == (5e-3, 4e-3, 6e-3)


def test_an_amplitude_or_a_residual_below_the_noise_is_zero(monkeypatch: pytest.MonkeyPatch) -> None:
    """1e-7 of the largest amplitude, and of the rotor's unbalance."""
    limits = _MotionLimits((4.0, 7.0), (1.1e-8, 0.9e-8, 3e-8))
    s = ended(np.full(11, 5.0), monkeypatch, limits, largest=0.1, residual=0.9e-7)
    assert (s["final_amplitude"], s["min_amplitude"], s["max_amplitude"]) == (1.1e-8, 0.0, 3e-8)
    assert s["final_residual_unbalance"] == 0.0
    assert ended(np.full(11, 5.0), monkeypatch, residual=1.1e-7)["final_residual_unbalance"] == 1.1e-7


def test_a_rotor_that_swings_has_the_mean_of_its_speed(monkeypatch: pytest.MonkeyPatch) -> None:
    still = SimpleNamespace(turning=False, resonance=None)
    s = ended([9.0] * 8 + [-1.0, 0.5, 1.0], monkeypatch, evidence=still)
    assert -0.2 < s["final_speed"] < 0.6
    assert s["modulation_depth"] is None


def observed(begin: float, end: float, turn_times: Any) -> _MotionLimits:
    """Spans of 1 s with speeds k to k + 0.5, and distances of 10 + k; turns at given times with as many amplitudes."""
    k = np.arange(5.0)
    spans = SimpleNamespace(
        time=k, least_speed=k, greatest_speed=k + 0.5, least_distance=k, greatest_distance=10.0 + np.array([0, 1, 5, 2, 3])
    )

    class Turns:
        def __init__(self, time: np.ndarray) -> None:
            self.time = time

        def part(self, selection: Any) -> Turns:
            return Turns(self.time[selection])

        @property
        def amplitudes(self) -> tuple[float, ...]:
            return tuple(self.time.tolist())

    whole = SimpleNamespace(whole=Turns(np.array(turn_times)))
    observation = SimpleNamespace(main=SimpleNamespace(last=lambda share: spans), rotors={"drum": whole})
    motion: Any = SimpleNamespace(
        case=SimpleNamespace(machine=SimpleNamespace(rotor=SimpleNamespace(name="drum"))),
        verdict=SimpleNamespace(window=(begin, end)),
        observation=observation,
    )
    return _observe_limits(motion)


def test_limits_are_those_of_the_final_window() -> None:
    found = observed(2.0, 4.0, [0.5, 1.9, 2.1, 3.0, 3.9])
    assert found.speeds == (2.0, 4.5) and found.amplitudes == (2.1, 3.0, 3.9), "turns that end within it"
    found = observed(2.0, 4.0, [0.5, 1.0])
    assert found.amplitudes == pytest.approx((10 + 10 / 3, 12.0, 15.0)), "without turns: mean, least and greatest distance"
    assert observed(9.0, 9.5, [0.5]).speeds == (4.0, 4.5), "the last span where none lies in it"


# --- few samples ---


@pytest.mark.parametrize(("fast", "few"), [(70.0, False), (-70.0, False), (90.0, True), (-90.0, True)])
def test_samples_a_turn_of_the_fastest_body_where_they_are_fewest(
    fast: float, few: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """2 pi/8 = 0.785 rad between two samples, 0.01 s apart, in either sense: 78.5 rad/s of any body at any time."""
    speeds = {"slow": np.array([0.0, 1.0, 1.0, 1.0]), "fast": np.array([0.0, 0.0, fast, 0.0])}
    monkeypatch.setattr(dataset, "motion_of", lambda machine, record, b: (None, speeds[b]))
    motion: Any = SimpleNamespace(
        machine_motion=SimpleNamespace(time=np.array([0.0, 0.005, 0.015, 0.02])),
        case=SimpleNamespace(machine=SimpleNamespace(bodies=list(speeds)), horizon=SimpleNamespace(most=4)),
    )
    warnings = _sampling_warnings(motion)
    assert bool(warnings) == few
    if few:
        assert warnings[0].startswith(f"only {2 * math.pi / 0.9:.1f} samples a turn") and "below 4 samples" in warnings[0]


# --- bearings ---


class Lines(dict[str, str]):
    """The lines of a report by their names."""

    def add(self, name: str, text: str, **words: str) -> None:
        self[name] = text.format(**words)


def test_bearing_forces_are_listed_of_several_rotors_or_with_a_life() -> None:
    one, two = {"a": 100.0}, {"a": 100.0, "b": 300.0}
    for forces, more, listed in ((one, {}, False), (two, {}, False), (two, {"machine_number": 2.0}, True), ({}, {}, False)):
        lines: Any = Lines()
        s = {"steady_bearing_forces": forces, "bearing_forces": forces, "peak_bearing_forces": forces} | more
        _bearings(lines, s, lambda *keys: "")
        assert ("bearings" in lines) == listed


def test_of_many_bearings_the_most_loaded_are_named() -> None:
    steady = {f"r{k}": 100.0 + k for k in range(8)}
    largest = {f"r{k}": 1000.0 - k for k in range(8)}
    text = _bearing_forces(steady, largest, largest | {"r7": 5000.0})
    assert [f"r{k} " in text for k in range(8)] == [True] * 6 + [False] * 2
    assert "; 2 smaller ones; 5 kN at most in the whole run" in text


# --- both models ---


def test_deviations_are_full_less_slow(monkeypatch: pytest.MonkeyPatch) -> None:
    """Speeds 2 and 1.5, distances 3 and 5; at equal phase, that of the bodies lagging by two turns, speeds 4 and 1."""
    angle = np.linspace(0.0, 20.0, 41)
    flat = np.ones(41)
    courses = iter(
        [
            ComparedMotion(angle, np.array([2.0 * flat]), 3.0 * flat, -angle),
            ComparedMotion(angle, np.array([1.5 * flat]), 5.0 * flat, -angle),
        ]
    )
    monkeypatch.setattr(combined_runs, "compared_motion", lambda motion: next(courses))
    quantities = [
        Quantity("time", TIME, "time", "s", "time"),
        Quantity("speed", [TIME], "speed", "rad/s", "body time"),
        Quantity("radius", TIME, "distance", "mm", "time"),
        Quantity("energy", TIME, "energy", "J", "time"),
    ]
    short = [Quantity(q.name, np.asarray(q.value)[..., :-2], q.long_name, q.unit, q.dimensions) for q in quantities]
    motions: Any = [None, None]
    both = combined_runs.join_models(motions, [StudyResult(quantities, ""), StudyResult(short, "")])
    by_name = {q.name: q for q in both.quantities}
    assert by_name["speed_deviation"].value == pytest.approx(np.full(41, 0.5)) and by_name["speed_deviation"].unit == "rad/s"
    assert by_name["radius_deviation"].value == pytest.approx(np.full(41, -2.0)) and by_name["radius_deviation"].unit == "mm"
    assert by_name["compared"].value == pytest.approx(angle)
    for at in ("at_equal_angle", "at_equal_phase"):
        assert by_name["deviations"].value[at] == pytest.approx({"speed": 0.5, "amplitude": 2.0})
    assert np.asarray(by_name["slow_speed"].value)[0] == pytest.approx([*TIME[:-2], math.nan, math.nan], nan_ok=True)
    assert "slow_energy" not in by_name


def test_a_failure_of_any_run_is_that_of_all() -> None:
    time = [Quantity("time", TIME, "time", "s", "time"), Quantity("speed", [TIME], "speed", "rad/s", "body time")]
    time += [Quantity("outcome", "passed", "outcome")]
    cases = [SimpleNamespace(label=f"{k}", start={}, value=None) for k in range(2)]
    units = SimpleNamespace(time="s")
    plan: Any = SimpleNamespace(
        cases=cases, spec=SimpleNamespace(over="time", along=None), machine=SimpleNamespace(units=units)
    )
    fails, runs = StudyResult(time, "", failure="it burst"), StudyResult(time, "")
    for answers in ([fails, runs], [runs, fails]):
        assert combined_runs.gather_runs(plan, answers, 2).wucht.failure == "it burst"


# --- the question ---


def test_each_case_has_its_value_and_its_start(monkeypatch: pytest.MonkeyPatch) -> None:
    starts = ({"psi": 0.0}, {"psi": 1.0})
    asked = RunUp(until=50.0, along="u", values=(1.0, 5.0), starts=starts)
    ready: list[Any] = []
    monkeypatch.setattr(
        RunUpCase, "of", lambda machine, start, settings: ready.append(settings) or SimpleNamespace(machine=machine)
    )
    machine = SimpleNamespace(
        rotor=None, bodies=(), parameters={"u": SimpleNamespace(value_text=lambda value: f"u = {value:g}")},
        with_values=lambda values: SimpleNamespace(**vars(machine) | {"values": values}),
    )  # fmt: skip
    monkeypatch.setattr(computation, "parameter_of", lambda machine, path: path)
    monkeypatch.setattr(computation, "values_of", lambda machine, parameter, values: values)
    monkeypatch.setattr(computation, "start_states", lambda machine: {})
    plan = _machine_plan(asked, machine)  # type: ignore[arg-type]
    assert [(c.value, c.run.machine.values["u"], dict(c.start)) for c in plan.cases] == [
        (value, value, start) for value in (1.0, 5.0) for start in starts
    ]
    assert [c.label for c in plan.cases] == ["u = 1; psi = 0", "u = 1; psi = 1", "u = 5; psi = 0", "u = 5; psi = 1"]
    assert plan.several and {settings.runs for settings in ready} == {4}, "they share the memory"


def test_stored_numbers_are_those_of_all_models_of_all_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(computation, "numbers_per_sample", lambda machine: machine)
    runs = [
        SimpleNamespace(horizon=SimpleNamespace(samples=n), models=[None] * m, machine=k) for n, m, k in ((10, 2, 3), (5, 1, 7))
    ]
    assert numbers(SimpleNamespace(cases=[SimpleNamespace(run=one) for one in runs])) == 60 + 35  # type: ignore[arg-type]


# --- the figure ---


def test_the_mean_phase_is_that_of_the_bodies_to_the_rotor() -> None:
    angle = np.array([[1.0, 2.0], [1.5, 2.25], [7.0, 9.0], [2.0, 3.75]])
    phase = np.where(np.array([0, 1, 0, 1])[:, None], 0.5, np.nan) * np.ones((1, 2))
    result = xr.Dataset({"slow_angle": (("body", "time"), angle), "phase": (("body", "time"), phase)})
    assert mean_phase(result, "slow_") == pytest.approx([0.75, 1.0])


def test_limits_are_drawn_over_the_spans_that_begin_in_the_panel() -> None:
    ends = np.array([1.0, 2.0, 3.0, 4.0])
    result = xr.Dataset(
        {"span_end": ("span", ends), "least_speed": ("span", ends), "greatest_speed": ("span", 10.0 + ends)}, {"time": TIME}
    )
    view: Any = SimpleNamespace(result=result, has_spans=True, has_time_axis=True, until=1.5)
    axis = Figure().add_subplot()
    _limits(axis, view, "speed", 2.0)
    (band,) = axis.collections
    corners = np.array([path.vertices for path in band.get_paths()])[0]
    assert (corners[:, 0].min(), corners[:, 0].max()) == (0.0, 2.0)
    assert (corners[:, 1].min(), corners[:, 1].max()) == (2.0, 24.0)


@pytest.mark.parametrize("sense", [1, -1])
def test_the_orbit_is_that_of_the_last_turn_and_of_each_mount(sense: int) -> None:
    """The deck moves on a circle of 1 mm and rocks by a hundredth; a mount goes round its centre of mass. Before, it rests."""
    turns = np.linspace(0.0, 12.0, 2401)
    angle, late = sense * 2 * math.pi * turns, turns >= 10.9
    motion = lambda angle: np.array([1e-3 * np.cos(angle), 1e-3 * np.sin(angle), 1e-2 * np.sin(angle)])  # noqa: E731
    x, y, rock = late * motion(angle)
    result = xr.Dataset(
        {"angle": (("body", "time"), [angle]), "displacement": (("direction", "time"), [x, y, rock]),
         "mount_x": ("mount", [0.5, -0.25]), "mount_y": ("mount", [0.1, 0.3]),
         "amplitude": ("time", x, {"units": "m", "long_name": "amplitude"})},
        {"direction": ["x", "y", "r"], "time": turns},
    )  # fmt: skip
    axis = Figure().add_subplot()
    _orbit(axis, SimpleNamespace(result=result))  # type: ignore[arg-type]
    for line, place in zip(axis.get_lines(), (0.0, 0.5 + 0.1j, -0.25 + 0.3j), strict=True):
        drawn = np.asarray(line.get_xdata()) + 1j * np.asarray(line.get_ydata())
        x, y, rock = motion(sense * 2 * math.pi * np.linspace(11.0, 12.0, len(drawn)))
        moved = 1e3 * (x + 1j * y + place * np.exp(1j * rock))
        assert drawn == pytest.approx(moved - moved.mean(), abs=1e-5)


# --- the run ---


def test_partial_runs_are_reported_of_the_first_case_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of later ones they would count as finished."""
    monkeypatch.setattr(computation, "run_up", lambda case, part: iter([(f"{case} half",), (f"{case} whole",)]))
    monkeypatch.setattr(computation, "neighbour_of", lambda motion, part: None)
    monkeypatch.setattr(computation, "check_contacts", lambda motion, part: None)
    runs = [type("Run", (str,), {"machine": SimpleNamespace(tracks=())})(name) for name in "ab"]
    plan: Any = SimpleNamespace(cases=[SimpleNamespace(run=run) for run in runs], several=True)
    found = [(f.motions, f.finished_count) for f in computation.run(plan, Work())]
    a, b = ("a whole",), ("b whole",)
    assert found == [((("a half",),), 0), ((a,), 0), ((a,), 1), ((a, b), 2)]


@pytest.mark.parametrize(("dimensionless", "labels", "allowed"), [
    (False, ("x", "y"), True), (True, ("x", "y"), False), (False, ("x", "r"), False),
])  # fmt: skip
def test_a_deck_is_that_of_a_machine_with_units_that_moves_up_and_down(
    dimensionless: bool, labels: tuple[str, ...], allowed: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(RunUpCase, "of", lambda machine, start, settings: SimpleNamespace(machine=machine))
    machine: Any = SimpleNamespace(dimensionless=dimensionless, labels=labels)
    if allowed:
        assert computation._case(RunUp(until=1.0, deck=0.1), machine, {}, None).label == ""
        return
    with refused("study.deck", given=0.1):
        computation._case(RunUp(until=1.0, deck=0.1), machine, {}, None)
