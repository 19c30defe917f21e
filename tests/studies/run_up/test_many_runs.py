"""Many run-ups in one result."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.hand_made import with_answer
from tests.refusals import check_refusal, refused

from wucht import RunUp
from wucht.files.catalogue import load_machine
from wucht.studies.runner import draw, run

MACHINE = "drozdetskaya-2020/table-5.1"
STARTS = ({"psi": 0.0, "delta": 0.5}, {"psi": 1.0, "delta": 2.0})


def asked(**changes: Any) -> RunUp:
    return RunUp(**({"until": 200.0, "along": "u", "values": (1.0, 5.0), "starts": STARTS} | changes))


def test_each_case_is_what_it_is_alone() -> None:
    result = run(asked(), load_machine(MACHINE))
    cases = result.wucht.summary["cases"]
    assert result.sizes["case"] == 4
    assert [c["value"] for c in cases] == [1.0, 1.0, 5.0, 5.0]
    assert [c["start"] for c in cases] == [dict(s) for s in STARTS] * 2
    for k, case in enumerate(cases):
        alone = run(RunUp(until=200.0, start=case["start"]), load_machine(MACHINE, {"u": case["value"]}))
        own = {key: v for key, v in case.items() if key not in ("label", "start", "value")}
        assert own == alone.wucht.summary
        inside = np.isfinite(result.time.values[k])
        # The same grid, but that it is as dense as the fastest case needs.
        assert float(result.speed.values[k][0][inside][-1]) == float(alone.speed.values[0][-1])


def test_the_names_of_the_cases_say_what_differs() -> None:
    machine = load_machine(MACHINE)
    by_value = run(asked(starts=(), start=STARTS[0], until=50.0), machine)
    assert list(by_value.case.values) == ["u = 1", "u = 5"]
    by_start = run(asked(along=None, values=(), until=50.0), machine)
    assert list(by_start.case.values) == ["psi = 0, delta = 0.5", "psi = 1, delta = 2"]


@pytest.mark.parametrize(("over", "name"), [("time", "time"), ("phi", "angle of the rotor"), ("psi", "mean phase")])
def test_the_figure_has_a_line_a_case(over: str, name: str) -> None:
    drawn = draw(run(asked(over=over, until=50.0), load_machine(MACHINE)))
    speed, amplitude = drawn.axes
    assert len([line for line in speed.get_lines() if not str(line.get_label()).startswith("no-load")]) == 4
    assert name in amplitude.get_xlabel()


def test_amplitudes_that_are_small_early_have_a_shorter_time() -> None:
    """The speeds settle in 100 s, amplitudes are small after 4 s: drawn until 6 s, and the whole runs below."""
    result = run(asked(until=50.0, values=(1.0, 5.0), starts=(), start=STARTS[0]), load_machine(MACHINE))
    time = np.linspace(0.0, 400.0, result.sizes["sample"])
    made = result.copy()
    made["time"] = (result.time.dims, np.broadcast_to(time, result.time.shape).copy(), result.time.attrs)
    at = made.time.values
    made["amplitude"] = (result.amplitude.dims, np.where(at <= 4.0, 1.0, 0.04), result.amplitude.attrs)
    last = float(time[time <= 4.0][-1])
    cases = [case | {"settling_time": 100.0, "amplitude_settling_time": None} for case in made.wucht.summary["cases"]]
    figure = draw(with_answer(made, cases=cases))
    speed, amplitude, strip = figure.axes
    assert [axis.get_xlim()[1] for axis in (speed, amplitude, strip)] == pytest.approx([150.0, 1.5 * last, 400.0], rel=0.2)
    assert speed.get_xlabel() == amplitude.get_xlabel() != "" and strip.get_xlabel().startswith("whole runs, ")
    made["amplitude"] = (result.amplitude.dims, np.where(at <= 60.0, 1.0, 0.04), result.amplitude.attrs)
    speed, amplitude, _ = draw(with_answer(made, cases=cases)).axes
    assert speed.get_xlim() == amplitude.get_xlim(), "not where they are large for long"


def _stop_within_the_third(share: float, _what: str) -> None:
    if share > 0.6:
        raise KeyboardInterrupt


def test_an_interrupted_result_is_continued_and_comes_out_the_same(tmp_path: Path) -> None:
    machine = load_machine(MACHINE)
    whole = run(asked(until=60.0), machine)
    partial = run(asked(until=60.0), machine, folder=tmp_path, progress=_stop_within_the_third)
    assert (partial.attrs["finished"], partial.sizes["case"]) == (0, 2)
    again = run(asked(until=60.0), machine, folder=tmp_path, resume=True)
    assert again.wucht.summary == whole.wucht.summary
    np.testing.assert_array_equal(again.speed.values, whole.speed.values)


def test_a_result_of_another_question_is_not_continued(tmp_path: Path) -> None:
    machine = load_machine(MACHINE)
    run(asked(until=60.0), machine, folder=tmp_path, progress=_stop_within_the_third)
    with refused("--resume", given=None, code="other-question"):
        run(asked(until=60.0, values=(1.0, 4.0)), machine, folder=tmp_path, resume=True)


@pytest.mark.parametrize(
    "table",
    [
        {"values": [1.0]},
        {"along": "u"},
        {"along": "x", "values": [1.0]},
        {"along": "u", "values": ["1 kg"]},
        {"along": "u", "values": 1.0},
        {"starts": {"psi": 1}},
        {"starts": [{"psi": 1.0}], "start": {"psi": 1.0}},
        {"along": "u", "values": [1.0] * 501},
        {"over": "speed"},
    ],
)
def test_what_is_refused(table: dict[str, Any]) -> None:
    case = str(table) if len(str(table)) < 100 else "501 values"
    question = {"kind": "run-up", "until": 10.0} | table
    check_refusal(f"run-up, many: {case}", lambda: run(RunUp.from_table(question), load_machine(MACHINE)))
