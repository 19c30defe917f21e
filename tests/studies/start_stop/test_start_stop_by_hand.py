"""A cycle of a clockwise main rotor and a second one that is made by hand: its numbers, sentences, report and figure."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.hand_made import drawn, titled, warnings_of

from wucht.dynamics.run_ups.motion_courses import MotionCourse
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.dynamics.work import Work
from wucht.fatigue.counting import TurningPoints, rainflow
from wucht.fatigue.damage import WoehlerLine
from wucht.files.building import machine_from
from wucht.machines.machine import SUPPLIED_WORK, Machine
from wucht.machines.schedules import SCHEDULE_WORK
from wucht.numerics.observers.turns import LargestTurn
from wucht.studies.start_stop import computation
from wucht.studies.start_stop import dataset as module
from wucht.studies.start_stop.computation import Findings, Plan
from wucht.studies.start_stop.spec import StartStop

LINE = WoehlerLine(3.0, 100.0, 1.0, 3.0)
LIFE = 7200.0
UP = np.array([[0.0, 1.0, 2.0, 3.0, 4.0], [0.0, 5.0, -1.0, 1.0, -1.0]])  # time and value of turning points, from 2 s on steady
DOWN = np.array([[4.5, 5.5, 9.0], [4.0, -6.0, 0.0]])
COURSES = (
    MotionCourse(np.array([1.0, 3.0]), np.array([[-40.0, -150.0], [41.0, 160.0]]), np.array([4e-3, 1e-3])),
    MotionCourse(np.array([1.5, 4.0]), np.array([[-90.0, -60.0], [90.0, 60.0]]), np.array([2e-3, 5e-3])),
)


def machine(**more: Any) -> Machine:
    rotors = [{"kind": "rotor", "name": n, "mass": 1.0, "unbalance": 1e-3, "inertia": 0.1} for n in ("a", "b")]
    drives = [
        {"on": n, "kind": "linear", "slope": 0.1, "no_load_speed": w} for n, w in (("a", -160.0), ("b", 160.0))
    ]  # fmt: skip
    carrier = {"mass": 8.0, "directions": "x", "stiffness": 25e3, "damping": 10.0}  # 50 rad/s
    return machine_from({"carrier": carrier, "bodies": rotors, "drives": drives} | more)


TWO = machine()


def planned(line: WoehlerLine | None = LINE, life: float | None = LIFE, of: Machine = TWO) -> Plan:
    keys = {} if line is None else {"woehler": {"k": 3, "ND": 100, "SD": 1.0}, "target_life": life}
    signal: Any = None if line is None else SimpleNamespace(name="spring force", unit="N")
    case: Any = SimpleNamespace(machine=of)
    return Plan(StartStop(**keys), of, case, signal, line)


def points(rows: np.ndarray) -> TurningPoints:
    return replace(TurningPoints(), time=rows[0], values=rows[1])


def observed(largest: float, speed: float) -> Any:
    """The largest amplitude, and the mean speed over the turn about it."""
    return SimpleNamespace(largest=largest, rotors={TWO.rotor.name: SimpleNamespace(largest_turn=LargestTurn(largest, speed))})


def way(k: int, end: float, **other: Any) -> Any:
    """The way up (0) or down (1)."""
    quadratures = {SUPPLIED_WORK: np.array([0.0, 2.0, 3.0]), "circuit_heat": np.array([0.0, 1.0, 1.5])}
    loads = SimpleNamespace(
        observation=observed((4.5e-3, 5.5e-3)[k], (-40.0, 60.0)[k]), points=points((UP, DOWN)[k]),
        bearing_forces={"a": (30.0, 20.0)[k], "b": (10.0, 25.0)[k]}, travels={"mount 1": (1e-3, 3e-3)[k], "mount 2": 2e-3},
    )  # fmt: skip
    verdict = SimpleNamespace(
        outcome=(Outcome.PASSED, Outcome.STOPPED)[k], amplitudes=(1e-3, 2e-4, 3e-4), speed=150.0, settling_time=2.5,
        window=(2.0, 4.0), advice=None, sentence="passed",
    )  # fmt: skip
    trajectory = SimpleNamespace(
        time=np.array([0.0, 2.0, end]), end_time=end, quadratures=quadratures, failure=None, stopped_by="the rotors are slow"
    )
    case = SimpleNamespace(machine=TWO, horizon=SimpleNamespace(warnings=()), models=[SimpleNamespace(warnings=())])
    return SimpleNamespace(case=case, trajectory=trajectory, loads=loads, verdict=verdict, **other)


@pytest.fixture(autouse=True)
def _courses_by_hand(monkeypatch: pytest.MonkeyPatch) -> None:
    of_largest = {4.5e-3: COURSES[0], 5.5e-3: COURSES[1]}
    monkeypatch.setattr(MotionCourse, "from_turns", lambda _machine, _trajectory, seen: of_largest[seen.largest])


def answered(plan: Plan | None = None, up: Any = None, down: Any = None, stopped: bool = True) -> xr.Dataset:
    findings = Findings(up or way(0, 4.0), (down or way(1, 5.0)) if stopped else None)
    return titled(module.dataset(plan or planned(), findings))


def test_each_phase_has_its_peak_and_the_speed_there_in_magnitude() -> None:
    s = answered().wucht.summary
    assert (s["peak_amplitude_up"], s["peak_speed_up"]) == (4.5e-3, 40.0)
    assert (s["peak_amplitude_down"], s["peak_speed_down"]) == (5.5e-3, 60.0)
    assert (s["operating_amplitude"], s["operating_speed"], s["settling_time"]) == (1e-3, 150.0, 2.5)
    assert (s["switch_off_time"], s["down_time"]) == (4.0, 5.0)
    half = answered(stopped=False).wucht.summary
    assert [half[key] for key in ("peak_amplitude_down", "peak_speed_down", "down_time")] == [None] * 3


def test_loads_of_each_rotor_and_mount_are_the_larger_of_both_phases() -> None:
    s = answered().wucht.summary
    assert s["bearing_forces"] == {"a": 30.0, "b": 25.0}
    assert s["mount_travel"] == {"mount 1": 3e-3, "mount 2": 2e-3}


def test_the_way_down_follows_the_way_up() -> None:
    """The drives take nothing from the supply any more: energy and work stay until the end of the cycle."""
    result = answered()
    assert result.time.values.tolist() == [1.0, 3.0, 5.5, 8.0]
    assert result.rotor_speed.values.tolist() == [[-40.0, -150.0, -90.0, -60.0], [41.0, 160.0, 90.0, 60.0]]
    assert result.amplitude.values.tolist() == [4e-3, 1e-3, 2e-3, 5e-3]
    assert result.energy_time.values.tolist() == [0.0, 2.0, 4.0, 9.0]
    assert result.supplied_energy.values.tolist() == [0.0, 3.0, 4.5, 4.5]
    assert result.shaft_work_course.values.tolist() == [0.0, 2.0, 3.0, 3.0]
    assert (result.wucht.summary["energy"], result.wucht.summary["shaft_work"]) == (4.5, 3.0)
    half = answered(stopped=False)
    assert half.energy_time.values.tolist() == [0.0, 2.0, 4.0] and half.time.values.tolist() == [1.0, 3.0]


def test_the_damage_is_that_of_both_phases_and_of_operation_that_of_its_window() -> None:
    result = answered()
    s, values = result.wucht.summary, np.concatenate([UP[1], DOWN[1]])
    damage = float(LINE.damages(rainflow(values, "repeat")).sum())
    rate = 0.01 * 1.0 / 2.0  # one cycle of amplitude 1 in 2 s
    assert s["damage"] == pytest.approx(damage) and s["cycles"] == pytest.approx(1 / damage)
    assert s["operation_damage"] == pytest.approx(rate) and result.wucht.unit_at("operation_damage") == "1/s"
    assert s["largest_range"] == 11.0 and s["signal"] == "spring force"
    assert s["allowed_cycles"] == 0.0, "operation alone is too much"
    enough = answered(planned(life=100.0)).wucht.summary
    assert enough["allowed_cycles"] == pytest.approx((1 - 100 * rate) / (damage - 4.0 * rate))
    assert result.damage_time.values.tolist() == [*UP[0].tolist(), *DOWN[0].tolist()]
    assert result.damage_course.values[4] == pytest.approx(LINE.damages(rainflow(UP[1])).sum())
    assert result.damage_course.values[-1] == pytest.approx(LINE.damages(rainflow(values)).sum())


def test_without_a_way_down_the_damage_of_a_cycle_is_not_known() -> None:
    s = answered(planned(life=100.0), stopped=False).wucht.summary
    assert [s[key] for key in ("damage", "cycles", "allowed_cycles")] == [None] * 3
    assert s["operation_damage"] == pytest.approx(0.005)


@pytest.mark.parametrize("outcome", [Outcome.UNIDENTIFIED, Outcome.FAILED])
def test_operation_that_is_not_known_has_no_damage(outcome: Outcome) -> None:
    up = way(0, 4.0)
    up.verdict.outcome, up.verdict.advice = outcome, "run twice as long"
    result = answered(up=up)
    assert result.wucht.summary["operation_damage"] is None and result.wucht.summary["allowed_cycles"] is None
    first, second = warnings_of(result)
    assert first == "at the switch-off the machine does not run steadily yet: run twice as long"
    assert "how many cycles the target life allows" in second
    assert len(warnings_of(answered(planned(life=None), up=up))) == 1


def test_a_failure_of_either_phase_is_that_of_the_cycle() -> None:
    up, down = way(0, 4.0), way(1, 5.0)
    down.trajectory.failure = "it burst"
    result = answered(up=up, down=down)
    assert result.attrs["failure"] == "it burst" and "it burst" in warnings_of(result)
    up.case.horizon.warnings, up.case.models[0].warnings = ("far too short",), ("of the model",)
    assert warnings_of(answered(up=up)) == ["far too short", "of the model"]


def test_schedules_end_at_the_switch_off() -> None:
    points = {"parameter": "drives.b.no_load_speed", "points": [[0.0, 0.0], [1.0, 160.0]]}
    scheduled, up = planned(of=machine(schedules=[points])), way(0, 4.0)
    assert not any("schedules end" in w for w in warnings_of(answered(scheduled, up)))
    up.trajectory.quadratures[SCHEDULE_WORK] = np.zeros(3)
    assert any("schedules end" in w for w in warnings_of(answered(scheduled, up)))


def test_sentences() -> None:
    def told(stopped: bool = True, **changes: Any) -> str:
        down = way(1, 5.0)
        down.trajectory = SimpleNamespace(**vars(down.trajectory) | changes)
        return str(answered(down=down, stopped=stopped).wucht.sentence)

    assert told() == "up: passed; down in 5 s"
    assert told(stopped=False) == "up: passed"
    assert told(stopped_by="") == f"up: passed; down: {Outcome.STOPPED.sentence} after 5 s"


def test_all_drives_that_are_known_by_their_torque_are_named() -> None:
    assert answered().wucht.assumed == [
        "the energy from the supply is the work on the shaft of a and b, whose torque alone is known"
    ]


def test_the_lines_of_the_report() -> None:
    assert module.report(answered(planned(life=100.0)))[2:] == [
        "  up           4.5 mm at most, at 40 rad/s (382 rpm)",
        "  operation    1 mm at 150 rad/s (1432 rpm); switched off at 4 s",
        "  down         5.5 mm at most, at 60 rad/s (573 rpm)",
        "  bearings     a 30 N, b 25 N at most, of each rotor on the carrier",
        "  travel       mount 1 3 mm, mount 2 2 mm at most from rest",
        "  energy       4.5 J from the supply, 3 J of it as work on the shafts",
        *_lines_of_damage("100 s"),
    ]


def _lines_of_damage(life: str) -> list[str]:
    damage = float(LINE.damages(rainflow(np.concatenate([UP[1], DOWN[1]]), "repeat")).sum())
    number = math.floor(0.5 / (damage - 4.0 * 0.005))
    return [
        f"  damage       {damage:.4g} a cycle; the part endures {1 / damage:.4g} cycles",
        "  in operation damage 0.005 1/s",
        f"  target life  {life} of operation allow {number} cycles",
    ]


def test_a_long_target_life_is_in_hours() -> None:
    for life, words in ((3599.0, "3599 s"), (3600.0, "1 h"), (7200.0, "2 h")):
        assert module.report(answered(planned(life=life)))[-1] == f"  target life  {words} of operation allow 0 cycles"
    plain = module.report(answered(planned(None)))
    assert len(plain) == 8 and not any("damage" in line for line in plain)


def test_what_each_panel_shows() -> None:
    figure = drawn("start-stop", answered())
    speeds, amplitude, energy, damage = figure.axes[:4]
    lines = {str(x.get_label()): np.asarray(x.get_ydata(), float).tolist() for x in speeds.get_lines()}
    assert lines["a"] == [40.0, 150.0, 90.0, 60.0] and lines["b"] == [41.0, 160.0, 90.0, 60.0], "forwards"
    assert "natural frequency" in lines, "50 rad/s, once"
    for axis in (speeds, amplitude, energy, damage):
        assert np.asarray(axis.get_lines()[0].get_xdata()).tolist() == [4.0, 4.0], "where the drives are switched off"
    peaks = {str(x.get_label()): (float(x.get_xdata()[0]), float(x.get_ydata()[0])) for x in amplitude.get_lines()[2:]}
    assert peaks == {"largest on the way up": (1.0, pytest.approx(4.0)), "largest on the way down": (8.0, pytest.approx(5.0))}
    drawn_energy = {str(x.get_label()): np.asarray(x.get_ydata()).tolist() for x in energy.get_lines()[1:]}
    assert drawn_energy == {"from the supply": [0.0, 3.0, 4.5, 4.5], "work on the shafts": [0.0, 2.0, 3.0, 3.0]}
    assert (energy.get_ylabel(), amplitude.get_ylabel()) == ("energy (J)", "amplitude of the axis (mm)")
    assert np.asarray(damage.get_lines()[1].get_xdata()).tolist() == [*UP[0].tolist(), *DOWN[0].tolist()]
    assert damage.get_xlim() == (0.0, 8.0) and damage.get_xlabel() == "time (s)"


def test_large_energies_are_in_kj_and_a_rotor_that_creeps_is_not_drawn() -> None:
    result = answered()
    result.supplied_energy.values[:] *= 4000.0
    result.rotor_speed.values[:] = [[-40.0, -150.0, -90.0, -7.0], [41.0, 160.0, 90.0, 7.9]]
    axes = drawn("start-stop", result).axes
    assert axes[2].get_ylabel() == "energy (kJ)"
    assert np.asarray(axes[2].get_lines()[1].get_ydata()).tolist() == [0.0, 12.0, 18.0, 18.0]
    assert np.asarray(axes[2].get_lines()[2].get_ydata()) == pytest.approx([0.0, 2e-3, 3e-3, 3e-3])
    assert axes[3].get_xlim() == (0.0, 5.5), "slower than 5 % of 160 rad/s"


def test_after_a_way_up_that_fails_there_is_none_down(monkeypatch: pytest.MonkeyPatch) -> None:
    up, asked = way(0, 4.0), list[Any]()
    monkeypatch.setattr(computation, "loaded_runs", lambda *_: iter([up]))
    monkeypatch.setattr(computation, "stop_case", lambda *given: asked.append(given))
    for failure, calls in (("it burst", 0), (None, 1)):
        up.trajectory.failure = failure
        (only,) = computation.run(planned(), Work())
        assert (only.up, only.down, len(asked)) == (up, None, calls)
