"""Many run-ups in one result."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from wucht.errors import InputError
from wucht.machines.catalogue import load_machine
from wucht.plots import draw
from wucht.studies.run_up.study import RunUp, run_up, summary

MACHINE = "drozdetskaya-2020/table-5.1"
STARTS = ({"psi": 0.0, "delta": 0.5}, {"psi": 1.0, "delta": 2.0})


def asked(**changes: Any) -> RunUp:
    return RunUp(**({"until": 200.0, "along": "u", "values": (1.0, 5.0), "starts": STARTS} | changes))


def test_each_case_is_what_it_is_alone() -> None:
    result = run_up(load_machine(MACHINE), asked())
    cases = summary(result)["cases"]
    assert result.sizes["case"] == 4
    assert [c["value"] for c in cases] == [1.0, 1.0, 5.0, 5.0]
    assert [c["start"] for c in cases] == [dict(s) for s in STARTS] * 2
    for k, case in enumerate(cases):
        alone = run_up(load_machine(MACHINE, {"u": case["value"]}), RunUp(until=200.0, start=case["start"]))
        own = {key: v for key, v in case.items() if key not in ("label", "start", "value")}
        assert own == summary(alone)
        inside = np.isfinite(result.time.values[k])
        # The same grid, but that it is as dense as the fastest case needs.
        assert float(result.speed.values[k][0][inside][-1]) == float(alone.speed.values[0][-1])


def test_the_names_of_the_cases_say_what_differs() -> None:
    machine = load_machine(MACHINE)
    by_value = run_up(machine, asked(starts=(), start=STARTS[0], until=50.0))
    assert list(by_value.case.values) == ["u = 1", "u = 5"]
    by_start = run_up(machine, asked(along=None, values=(), until=50.0))
    assert list(by_start.case.values) == ["psi = 0, delta = 0.5", "psi = 1, delta = 2"]


@pytest.mark.parametrize(("over", "name"), [("time", "time"), ("phi", "angle of the rotor"), ("psi", "mean phase")])
def test_the_figure_has_a_line_a_case(over: str, name: str) -> None:
    drawn = draw(run_up(load_machine(MACHINE), asked(over=over, until=50.0)))
    speed, amplitude = drawn.axes
    assert len([line for line in speed.get_lines() if not str(line.get_label()).startswith("no-load")]) == 4
    assert name in amplitude.get_xlabel()


def test_an_interrupted_result_is_continued_and_comes_out_the_same() -> None:
    machine, kept = load_machine(MACHINE), []

    def stop_after_two(result: Any) -> None:
        kept.append(result)

    whole = run_up(machine, asked(until=60.0), checkpoint=stop_after_two)
    partial = kept[1]
    assert (partial.attrs["finished"], partial.sizes["case"]) == (0, 2)
    again = run_up(machine, asked(until=60.0), resume=partial)
    assert json.loads(again.attrs["summary"]) == json.loads(whole.attrs["summary"])
    np.testing.assert_array_equal(again.speed.values, whole.speed.values)


def test_a_result_of_another_question_is_not_continued() -> None:
    machine, kept = load_machine(MACHINE), []
    run_up(machine, asked(until=60.0), checkpoint=kept.append)
    with pytest.raises(InputError, match="--resume"):
        run_up(machine, asked(until=61.0), resume=kept[0])


@pytest.mark.parametrize(
    ("table", "where", "allowed"),
    [
        ({"values": [1.0]}, "study.along", "belong together"),
        ({"along": "u"}, "study.values", "belong together"),
        ({"along": "x", "values": [1.0]}, "study.along", "unknown parameter"),
        ({"along": "u", "values": ["1 kg"]}, "study.values[0]", "allowed is"),
        ({"along": "u", "values": 1.0}, "study.values", "a list"),
        ({"starts": {"psi": 1}}, "study.starts", "a list of tables"),
        ({"starts": [{"psi": 1.0}], "start": {"psi": 1.0}}, "study.starts", "either start or starts"),
        ({"along": "u", "values": [1.0] * 501}, "study.values", "500 runs"),
        ({"over": "speed"}, "study.over", "time, phi, psi"),
    ],
)
def test_what_is_refused(table: dict[str, Any], where: str, allowed: str) -> None:
    with pytest.raises(InputError, match="study") as said:
        RunUp.read({"kind": "run-up", "until": 10.0} | table, load_machine(MACHINE))
    assert said.value.where == where
    assert allowed in said.value.allowed
