"""Records of a coast-down that are made by hand: plan, ends, every quantity, sentences, report, figure, also clockwise."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.hand_made import drawn, titled, warnings_of

from wucht.dynamics.run_ups.coasting import CarrierStart, Record
from wucht.dynamics.verdicts.observation import Observation
from wucht.files.building import machine_from
from wucht.machines.machine import Machine
from wucht.numerics.flow.trajectory import Trajectory
from wucht.numerics.observers.energy_balance import EnergyBalance
from wucht.numerics.observers.turns import Samples
from wucht.studies import coast_down as module
from wucht.studies.coast_down import CoastDown, Findings, Plan, SingleCoastDown, dataset, prepare, report

# By hand: 20 kg and 2 kg on 8.8e4 N/m and 2.2e5 N/m, so 63.2 rad/s and 100 rad/s.
CARRIER = {"mass": 20.0, "directions": "xy", "stiffness": [8.8e4, 2.2e5], "damping": [60.0, 90.0]}
ROTOR = {"kind": "rotor", "name": "r", "mass": 2.0, "unbalance": 0.01, "inertia": 2.0, "bearing_damping": 1e-4}
SLOW, FAST = math.sqrt(8.8e4 / 22), 100.0


@pytest.fixture(scope="module")
def machine() -> Machine:
    return machine_from({"carrier": CARRIER, "bodies": [ROTOR]})


def planned(machine: Machine, speed: float = -200.0, **asked: Any) -> SingleCoastDown:
    (single_run,) = prepare(CoastDown(**{"until": 8.0, "start": {"r": {"speed": speed}}} | asked), machine).runs
    return single_run


@pytest.fixture(scope="module")
def plan(machine: Machine) -> SingleCoastDown:
    return planned(machine)


def ended(plan: SingleCoastDown, time: float = 8.0, **other: Any) -> Trajectory:
    n = len(plan.machine.state_names)
    return Trajectory(np.array([time]), np.zeros((n, 1)), {}, np.zeros(0), time, np.arange(n + 2.0), **other)


def recorded(
    plan: SingleCoastDown, end: dict[str, Any] | None = None, rows: dict[str, Any] | None = None, **other: Any
) -> Record:
    """Clockwise, from 200 rad/s to 40 rad/s in 8 s."""
    time = np.linspace(0.0, 8.0, 17)
    speed = -np.linspace(200.0, 40.0, 17)
    made = {
        "time": time, "angle": np.append(3.0, 3.0 + np.cumsum(0.25 * (speed[1:] + speed[:-1]))), "speed": speed,
        "min_speed": speed - 3.0, "max_speed": speed + 2.0, "amplitude": 1e-3 * (1 + np.exp(-((time - 5) ** 2))),
        "energy_residual": 1e-12 * np.arange(17)[::-1], "dissipated_work": np.linspace(0.0, 7.0, 17),
    } | (rows or {})  # fmt: skip
    turns = np.array([[0.25, 4.0, 7.75], [-195.0, -120.0, -45.0]])
    halving = np.array([[4.0, 6.0], [-120.0, -80.0]])
    common = {"turns": turns, "halving": halving, "start_speed": -200.0, "stride": 0.5}
    return Record(end=ended(plan, **(end or {})), rows=made, **{"observation": clockwise(plan)} | common | other)


def observed(plan: SingleCoastDown, time: np.ndarray, angle: np.ndarray, speed: np.ndarray, amplitude: Any) -> Observation:
    """What is observed of samples (N,) of the motion."""
    samples, square = Samples.of(time, (angle, speed)), np.broadcast_to(np.square(amplitude), time.shape)
    samples = replace(samples, square=square, rate=np.gradient(square, time))
    return plan.observer.update_from_samples(plan.observer.begin(), samples)


def clockwise(plan: SingleCoastDown) -> Observation:
    """The motion of ``recorded``, its samples finer than its rows."""
    time = np.linspace(0.0, 8.0, 8001)
    amplitude = 1e-3 * (1 + np.exp(-((time - 5) ** 2)))
    return observed(plan, time, 3.0 - 200 * time + 10 * time**2, -200 + 20 * time, amplitude)


def swinging(plan: SingleCoastDown, decay: float) -> Observation:
    """From 200 rad/s to rest in 1 s, and then a swing of 0.5 rad at 3 rad/s, which falls by a rate."""
    time = np.linspace(0.0, 8.0, 8001)
    down, after = np.minimum(time, 1.0), np.maximum(time - 1.0, 0.0)
    swing = 0.5 * np.exp(-decay * after)
    angle = -200 * down + 100 * down**2 + swing * np.sin(3 * after)
    speed = -200 * (1 - down) + swing * (3 * np.cos(3 * after) - decay * np.sin(3 * after)) * (time >= 1.0)
    return observed(plan, time, angle, speed, 0.0)


FLOW: Any = SimpleNamespace(engine_name="compiled", tolerance=1e-12)


def answered(plan: SingleCoastDown, record: Record | None = None) -> xr.Dataset:
    return titled(dataset(Plan((plan,)), Findings(((record or recorded(plan), FLOW),))))


# --- the plan ---


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_steps_are_fine_enough_for_the_fastest_motion(machine: Machine, sense: float) -> None:
    """Of a fast rotor 24 samples a turn of it, of a slow one 24 a period of the fastest natural vibration."""
    for speed, fastest in ((200.0, 200.0), (10.0, FAST)):
        plan = planned(machine, sense * speed)
        assert plan.step == pytest.approx(2 * math.pi / fastest / 24, rel=1e-2) and plan.step <= 2 * math.pi / fastest / 24
        assert 8.0 / plan.step == pytest.approx(round(8.0 / plan.step)), "whole steps up to the end"
        assert plan.start_speed == sense * speed and plan.limit == 8.0 and plan.stride == pytest.approx(8.0 / 4000)
    free = planned(machine, sense * 200.0, until=None)
    assert free.limit == pytest.approx(50_000 * 2 * math.pi / 200) and free.stride == pytest.approx(2 * math.pi / 200)
    short = planned(machine, sense * 200.0, until=0.01)
    assert short.step == pytest.approx(0.01 / 64)
    assert module.numbers(Plan((short,))) == pytest.approx(2 * 0.01 * 200 / (2 * math.pi))


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_reversal_is_that_against_the_sense_of_the_start(machine: Machine, sense: float) -> None:
    first = planned(machine, sense * 200.0).events[0]
    assert (first.name, first.direction) == ("reversal", -int(sense))


# --- the end of the run ---


def has_ended(plan: SingleCoastDown, **other: Any) -> bool:
    return module._has_ended(plan, recorded(plan, **other))


def test_with_a_time_it_ends_there_and_not_before(plan: SingleCoastDown) -> None:
    slow = {"speed": np.full(17, -1e-9), "max_speed": np.zeros(17), "min_speed": np.zeros(17)}
    assert has_ended(plan) and not has_ended(plan, end={"time": 7.999}, rows=slow)
    assert has_ended(plan, end={"time": 8.0 * (1 - 1e-12)})
    for how in ({"stopped_by": "it"}, {"failure": "it burst"}, {"is_interrupted": True}):
        assert has_ended(plan, end={"time": 1.0} | how)


def test_without_a_time_it_ends_at_a_hundredth_or_after_some_swings(plan: SingleCoastDown) -> None:
    free, early = replace(plan, spec=CoastDown(start=plan.spec.start)), {"time": 1.0}
    assert not has_ended(free, end=early)
    for last, over in ((-1.99, True), (-2.01, False)):
        rows = {"speed": np.append(np.full(16, -50.0), last)}
        assert has_ended(free, end=early, rows=rows) == over
        assert not has_ended(free, end=early, rows=rows, turns=np.empty((2, 0))), "a turn at least"
    dying_out, lasting, turning = swinging(free, 0.5), swinging(free, 0.0), clockwise(free)
    reversals = {count: tuple(np.arange(1.0, 1.0 + count) / 100) for count in (1, 19, 20)}
    for count, observation, over in ((19, dying_out, False), (20, dying_out, True), (20, lasting, True), (20, turning, False)):
        assert has_ended(free, end=early, reversals=reversals[count], observation=observation) == over
    for last, over in ((0.019, True), (0.021, False), (-0.021, False)):
        rows = {"max_speed": np.append(np.full(16, 1.0), last)}
        assert has_ended(free, end=early, reversals=reversals[1], rows=rows, observation=dying_out) == over


def ending(plan: SingleCoastDown, **other: Any) -> dict[str, Any]:
    words, quantities = module._ending(plan, recorded(plan, **other))
    return {q.name: q.value for q in quantities} | {"words": words}


def test_the_end_is_judged_by_the_last_tenth(plan: SingleCoastDown) -> None:
    """Rows at 7.5 s and 8 s: from 50 rad/s to 40 rad/s."""
    at_end = ending(plan)
    assert at_end["outcome"] is None and at_end["words"] == "the rotor still turns, at 22.5 % of its speed at the start"
    assert (at_end["min_speed"], at_end["max_speed"]) == (-53.0, -38.0)
    assert at_end["final_speed"] == pytest.approx(-45.0)
    assert ending(plan, turns=np.empty((2, 0)))["words"].endswith("22.5 % of its speed at the start")
    other = ending(plan, turns=np.array([[7.0], [-60.0]]))
    assert other["words"].endswith("at 30 % of its speed at the start") and other["final_speed"] == pytest.approx(-45.0)


def test_the_outcome_is_that_of_the_motion_observed(plan: SingleCoastDown) -> None:
    assert ending(plan, observation=swinging(plan, 0.5))["outcome"] == "stopped"
    assert ending(plan, observation=swinging(plan, 0.0))["outcome"] == "oscillating"
    assert ending(plan, observation=clockwise(plan))["outcome"] is None
    assert ending(plan, observation=swinging(plan, 0.5), end={"failure": "it burst"})["outcome"] == "failed"


def test_the_speed_at_the_end_is_that_since_it_turned_back(plan: SingleCoastDown) -> None:
    back = ending(plan, rows={"angle": np.append(np.full(15, 5.0), [1.0, 2.0])}, reversals=(3.0,))
    assert back["words"] == "the rotor has turned back, at 1 % of its speed at the start" and back["final_speed"] == 2.0
    late = ending(plan, reversals=(7.9,), rows={"angle": np.append(np.full(15, 5.0), [1.0, 2.0])})
    assert late["final_speed"] == 2.0, "two rows at least"


# --- the Dataset ---


def test_every_quantity_of_a_clockwise_coast_down(plan: SingleCoastDown) -> None:
    result, record = answered(plan), recorded(plan)
    s = result.wucht.summary
    for name in ("time", "angle", "speed", "min_speed", "max_speed", "energy_residual", "dissipated_work"):
        assert result[name].values == pytest.approx(record.rows[name]), name
    assert result.turn_time.values.tolist() == [0.25, 4.0, 7.75] and result.mean_speed.values.tolist() == [-195, -120, -45]
    assert (s["start_speed"], s["half_time"], s["reversal_time"], s["end_time"]) == (-200.0, pytest.approx(5.0), None, 8.0)
    assert s["turns"] == pytest.approx(-120.0 * 8.0 / (2 * math.pi))
    assert s["peak_amplitude"] == pytest.approx(2e-3) and s["peak_speed"] == pytest.approx(-100.0, abs=0.1)  # at 5 s
    assert s["energy_residual"] == pytest.approx(1.6e-11) and s["carrier_start"] == "steady"
    assert sorted({round(float(w), 6) for w in result.natural_frequency.values}) == pytest.approx([SLOW, FAST], abs=1e-5)
    assert (result.attrs["engine"], result.attrs["tolerance"], result.attrs["outcome"]) == ("compiled", 1e-12, "")
    expected = "the rotor still turns, at 22.5 % of its speed at the start; the speed has halved after 5 s"
    assert result.attrs["sentence"] == expected and result.end_state.values.tolist() == record.end.end_state.tolist()
    assert warnings_of(result) == [] and result.wucht.assumed == ["the carrier starts in the steady vibration of its speed"]


@pytest.mark.parametrize(("size", "is_noise"), [(0.9, True), (1.1, False)])
def test_work_below_the_noise_of_the_energy_is_none(plan: SingleCoastDown, size: float, is_noise: bool) -> None:
    """1e-7 of the largest energy, 50 J."""
    work = np.linspace(0.0, size * 1e-7 * 50.0, 17)
    s = answered(plan, recorded(plan, rows={"dissipated_work": work}, balance=EnergyBalance(50.0, 50.0)))
    np.testing.assert_array_equal(s.dissipated_work, 0.0 if is_noise else work)


def test_before_the_first_turn_a_steady_vibration_is_as_large_as_in_it(plan: SingleCoastDown) -> None:
    """A turn takes 31.4 ms: of the amplitudes up to there the largest, not the later one."""
    time = np.array([0.0, 0.01, 0.03, 0.032, *np.linspace(1.0, 8.0, 13)])
    rows = {"time": time, "amplitude": np.array([1.0, 2.0, 3.0, 4.0, *[0.5] * 13])}
    assert answered(plan, recorded(plan, rows=rows)).amplitude.values[:4].tolist() == [3.0, 2.0, 3.0, 4.0]
    for start in (CarrierStart.REST, CarrierStart.GIVEN, CarrierStart.FIXED):
        other = answered(replace(plan, carrier=start), recorded(plan, rows=rows))
        assert other.amplitude.values[:4].tolist() == [1.0, 2.0, 3.0, 4.0]


def test_the_reversal_is_the_first(plan: SingleCoastDown) -> None:
    result = answered(plan, recorded(plan, reversals=(6.5, 7.25), halving=np.empty((2, 0))))
    s = result.wucht.summary
    assert (s["reversal_time"], s["half_time"], s["outcome"]) == (6.5, None, None)
    assert result.attrs["sentence"].endswith("of its speed at the start; it turns back at 6.5 s")


def test_without_a_vibration_there_is_no_speed_of_the_largest(plan: SingleCoastDown) -> None:
    still = answered(replace(plan, carrier=CarrierStart.FIXED), recorded(plan, rows={"amplitude": np.zeros(17)}))
    assert (still.wucht.summary["peak_amplitude"], still.wucht.summary["peak_speed"]) == (0.0, None)
    assert still.wucht.assumed == []


def test_warnings_and_assumptions_on_the_start(plan: SingleCoastDown) -> None:
    rest = answered(replace(plan, carrier=CarrierStart.REST))
    assert rest.wucht.assumed == ["the carrier starts at rest"]
    (told,) = warnings_of(rest)
    assert told.endswith("; vibration = 'steady' starts with the vibration of that speed")
    (told,) = warnings_of(answered(replace(plan, carrier=CarrierStart.REST, rest_reason="has a slider")))
    assert told.endswith("; the machine has a slider")
    held: Any = SimpleNamespace(held_reason="they slide", assumptions=lambda phases: ["p is held"])
    one = answered(replace(plan, bodies=held), recorded(plan, end={"failure": "it burst"}))
    assert warnings_of(one) == [
        "it burst", "balancing bodies start as held, because their steady phases are not computed: they slide",
    ]  # fmt: skip
    assert one.attrs["failure"] == "it burst" and one.wucht.assumed[-1] == "p is held"
    assert one.wucht.summary["outcome"] == "failed" == one.attrs["outcome"]


def test_where_several_rotors_start_is_said() -> None:
    pair = machine_from({"carrier": CARRIER, "bodies": [ROTOR, ROTOR | {"name": "q"}]})
    start = {"r": {"angle": 0.5, "speed": 200.0}, "q": {"angle": 2.0, "speed": -200.0}}
    (told,) = module._rotor_assumptions(Plan((planned(pair, start=start, bodies="held"),)))
    assert told.startswith("rotors start at ") and told.index("r") < told.index("q") and "28.65" in told and "114.6" in told


# --- report and figure ---


def test_the_lines_of_the_report(plan: SingleCoastDown) -> None:
    result = answered(plan)
    assert report(result)[1:] == [
        f"verdict: {result.attrs['sentence'].partition(';')[0]}",
        "  speed        -200 rad/s (-1910 rpm) at the start, -45 rad/s (-430 rpm) on average at the end",
        "  halved       after 5 s",
        f"  turned       {-120 * 8 / (2 * math.pi):.5g} times in 8 s",
        "  amplitude    2 mm at most, at -100.02 rad/s (-955 rpm); it starts in the steady vibration of its speed",
        "  energy       balance closed to 1.6e-11",
    ]
    rows = dict.fromkeys(("min_speed", "max_speed", "speed"), np.zeros(17))
    back = report(
        answered(plan, recorded(plan, rows=rows, reversals=(6.5,), halving=np.empty((2, 0)), observation=swinging(plan, 0.5)))
    )
    assert back[1].startswith("verdict: STOPPED: ") and back[3] == "  halved       not within this time"
    assert back[4] == "  turns back   at 6.5 s"


def lines_of(axis: Any) -> dict[str, tuple[list[float], list[float]]]:
    return {str(x.get_label()): (list(x.get_xdata()), list(x.get_ydata())) for x in axis.get_lines()}


def test_the_figure_of_a_clockwise_coast_down(plan: SingleCoastDown) -> None:
    """Natural frequencies are on the side of its speed; half of the start speed is where it has halved."""
    speed, amplitude = drawn("coast-down", answered(plan)).axes
    shown = lines_of(speed)
    levels = [x.get_ydata()[0] for x in speed.get_lines() if x.get_linestyle() == ":"]
    assert sorted(levels) == pytest.approx([-FAST, -SLOW], abs=1e-5)
    assert shown["speed halved"] == ([pytest.approx(5.0)], [-100.0])
    assert shown["mean over a turn"] == ([0.25, 4.0, 7.75], [-195.0, -120.0, -45.0])
    assert "turns back" not in shown and "speed" not in shown
    (band,) = speed.collections
    box = band.get_paths()[0].get_extents()
    assert (box.x0, box.x1, box.y0, box.y1) == (0.0, 8.0, -203.0, -38.0)
    assert amplitude.get_ylim()[0] == 0.0 and amplitude.get_xlim() == (0.0, 8.0)


def test_only_natural_frequencies_that_are_passed_are_marked(machine: Machine, plan: SingleCoastDown) -> None:
    for start, count in ((FAST / 1.04, 2), (FAST / 1.06, 1), (-SLOW / 1.06, 0)):
        made = answered(plan, recorded(plan, start_speed=start))
        axis = drawn("coast-down", made).axes[0]
        levels = [x.get_ydata()[0] for x in axis.get_lines() if x.get_linestyle() == ":"]
        assert len(levels) == count and all(math.copysign(1, v) == math.copysign(1, start) for v in levels)


def test_the_figure_of_one_that_turns_back(plan: SingleCoastDown) -> None:
    still = recorded(plan, rows={"amplitude": np.zeros(17)}, reversals=(6.5, 7.0), turns=np.array([[1.0], [-100.0]]))
    (speed,) = drawn("coast-down", answered(plan, still)).axes
    shown = lines_of(speed)
    assert shown["turns back"] == ([6.5], [0.0]) and shown["speed"][1] == still.rows["speed"].tolist()
    assert [0.0, 0.0] in [list(x.get_ydata()) for x in speed.get_lines()], "a line at standstill"
    after = [x for x in speed.get_lines() if list(x.get_xdata()) == [6.5, 7.0, 7.5, 8.0]]
    assert [list(x.get_ydata()) for x in after] == [still.rows["speed"][13:].tolist()]


def test_between_the_last_whole_turn_and_the_reversal_there_is_no_gap(plan: SingleCoastDown) -> None:
    turns = np.array([[1.0, 3.0, 5.0], [-180.0, -140.0, -100.0]])
    back = recorded(plan, rows={"amplitude": np.zeros(17)}, reversals=(6.5, 7.0), turns=turns)
    (speed,) = drawn("coast-down", answered(plan, back)).axes
    after = [list(x.get_ydata()) for x in speed.get_lines() if x.get_xdata()[0] == 5.0 and len(x.get_xdata()) > 1]
    assert after == [back.rows["speed"][10:].tolist()]


# --- a run from each configuration ---


def several(plan: SingleCoastDown, count: int = 2) -> xr.Dataset:
    """Two runs, the second from 180 rad/s for 12 s; count: of those that have begun."""
    plans = Plan((replace(plan, label="a"), replace(plan, label="b 1°, c 2°", start_speed=-180.0)))
    longer = {"time": np.linspace(0.0, 12.0, 17), "speed": -np.linspace(180.0, 20.0, 17)}
    records = [recorded(plan), recorded(plan, end={"time": 12.0}, rows=longer, start_speed=-180.0)]
    return titled(dataset(plans, Findings(tuple((record, FLOW) for record in records[:count]))))


def test_every_run_is_in_the_summary_and_over_one_time(plan: SingleCoastDown) -> None:
    result = several(plan)
    first, second = result.wucht.summary["configurations"]
    assert first == {
        "configuration": "a", "outcome": None, "reached_from_rest": None,
        "start_speed": -200.0, "half_time": pytest.approx(5.0), "end_time": 8.0,
        "peak_amplitude": pytest.approx(2e-3), "peak_speed": pytest.approx(-100.0, abs=0.1),
    }  # fmt: skip
    assert (second["configuration"], second["start_speed"], second["end_time"]) == ("b 1°, c 2°", -180.0, 12.0)
    assert result.run_time.values.tolist() == np.linspace(0.0, 12.0, 17).tolist()
    assert result.run_speed.values[0, :3] == pytest.approx([-200.0, -185.0, -170.0]), "10 rad/s in 0.5 s"
    assert np.isnan(result.run_speed.values[0, 11:]).all() and result.run_speed.values[1, -1] == -20.0
    assert result.attrs["sentence"].endswith("after 5 s; the first of 2 runs, one from each stable configuration")
    assert result.wucht.assumed[1] == (
        "rotors start in the stable synchronous configuration a (averaged equations); "
        "the other runs start in b 1°, c 2°, from 180 rad/s"
    )
    (line,) = [line for line in report(result) if line.startswith("  other start")]
    assert line == "  other start  b 1°, c 2°: 2 mm at most, from -180 rad/s (-1719 rpm); halved after 5.5 s"
    assert module.numbers(Plan((plan, plan))) == 2 * module.numbers(Plan((plan,)))


def test_of_an_interrupted_study_the_runs_so_far(plan: SingleCoastDown) -> None:
    result = several(plan, 1)
    assert [row["configuration"] for row in result.wucht.summary["configurations"]] == ["a"]
    assert "run_speed" not in result and not [line for line in report(result) if "other start" in line]


def test_the_figure_of_several_runs_names_each(plan: SingleCoastDown) -> None:
    speed, amplitude = drawn("coast-down", several(plan)).axes
    assert {"from a", "from b 1°, c 2°"} <= set(lines_of(speed))
    assert list(lines_of(amplitude)) == ["from a", "from b 1°, c 2°"]
    assert amplitude.get_xlim() == (0.0, 12.0)


def test_of_one_configuration_there_is_one_row_and_no_table_of_runs(plan: SingleCoastDown) -> None:
    result = answered(replace(plan, label="antiphase"))
    assert len(result.wucht.summary["configurations"]) == 1 and "run_speed" not in result
    assert "rotors start in the stable synchronous configuration antiphase (averaged equations)" in result.wucht.assumed
    assert not result.attrs["sentence"].endswith("configuration")
