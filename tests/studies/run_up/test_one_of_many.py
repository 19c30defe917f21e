"""Numbers that hold, and numbers that are one draw of many: against runs with other tolerances, which are other draws."""

from __future__ import annotations

import json
import math
from typing import Any

import pytest
import xarray as xr

import wucht
from wucht.numerics.angles import wrap_to_pi
from wucht.results.quantities import Quantity, StudyResult
from wucht.studies.run_up.chance import ONE_OF_MANY, with_neighbour

# Numbers without a share in the result: rounding, and sentences.
NO_RESULTS = {"energy_residual", "damper_mismatch", "dimensionless", "advice", "sentence", "warnings", ONE_OF_MANY}
TOLERANCES = (1e-9, 1e-12)
# Three times the share that counts as alike for a neighbour: two tolerances may be as far apart as two neighbours are.
ALIKE = 3e-4


def is_alike(a: Any, b: Any, size: float = 0.0) -> bool:
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(is_alike(a[k], b[k], size) for k in a)
    if isinstance(a, list):
        return all(is_alike(x, y, max(map(abs, a))) for x, y in zip(a, b, strict=True))
    if isinstance(a, float) and isinstance(b, float):
        of_angle = abs(float(wrap_to_pi(a - b))) < ALIKE * 2 * math.pi and max(abs(a), abs(b)) <= 2 * math.pi
        return math.isclose(a, b, rel_tol=ALIKE, abs_tol=max(ALIKE * size, 1e-9)) or of_angle
    return bool(a == b)


def differing_keys(results: list[xr.Dataset]) -> tuple[set[str], set[str]]:
    """Return the keys in which two results differ, and those that are marked in one of them."""
    first, second = (r.wucht.summary for r in results)
    common = (first.keys() & second.keys()) - NO_RESULTS
    marked = set(first.get(ONE_OF_MANY, {})) | set(second.get(ONE_OF_MANY, {}))
    return {key for key in common if not is_alike(first[key], second[key])}, marked


def test_what_is_not_marked_agrees_between_tolerances_and_what_does_not_is_marked() -> None:
    """At a border of basins: with delta = 2.61774 the pendulums compensate after a time that the last digits decide."""
    machine, start = wucht.load_machine("drozdetskaya-2020/figure-5.14"), {"psi": 2.0, "delta": 2.61774}
    results = [wucht.run(wucht.RunUp(until=12_000.0, start=start, tolerance=t), machine) for t in TOLERANCES]
    differing, marked = differing_keys(results)
    assert differing <= marked and "settling_time" in marked
    assert not marked & {"outcome", "final_speed", "final_residual_unbalance", "peak_amplitude"}
    report = "\n".join(wucht.report(results[0]))
    assert "settled at" in report and report.count("(one of many)") == 1
    [warning] = [w for w in results[0].wucht.warnings if "one draw of many" in w]
    assert "all other numbers hold" in warning and "time until the speed has settled" in warning


def test_a_run_without_growth_has_no_marks() -> None:
    summary = wucht.run_file("drozdetskaya-2020/r1").wucht.summary
    assert ONE_OF_MANY not in summary


def test_each_line_with_a_number_that_is_chance_is_marked() -> None:
    run = wucht.run_file("practice/screen")
    lines = {
        "stroke": "stroke", "throw_ratio": "stroke", "acceleration": "acceleration", "machine_number": "acceleration",
        "bearing_force": "force", "steady_bearing_forces": "bearings", "mean_speeds": "mean speeds", "rotor_phases": "phase",
    }  # fmt: skip
    for key, line in lines.items():
        summary = run.wucht.summary | {ONE_OF_MANY: {key: run.wucht.summary[key]}}
        report = wucht.report(run.assign_attrs(summary=json.dumps(summary)))
        [marked] = [text.strip() for text in report if "(one of many)" in text]
        assert marked.startswith(f"{line} ")


@pytest.mark.slow
@pytest.mark.parametrize("name", ["practice/laboratory-centrifuge", "practice/grinder-10-balls"])
def test_balls_that_tumble_through_the_resonance(name: str) -> None:
    """Final phases of b1 of 118 and 228 degrees, amplitudes that settle from 32.3 to 37.9 s: two tolerances, two draws."""
    differing, marked = differing_keys([wucht.run_file(name, {"study.tolerance": t}) for t in TOLERANCES])
    assert differing <= marked and {"final_phases", "amplitude_settling_time"} <= marked
    assert not marked & {"outcome", "final_speed", "free_speed", "resonance_speed"}


def result(**values: Any) -> StudyResult:
    units = {"final_phases": "rad", "settling_time": "s", "final_speed": "rad/s"}
    quantities = [Quantity("outcome", values.pop("outcome", "compensated"), "outcome")]
    return StudyResult(quantities + [Quantity(n, v, n, units.get(n, "")) for n, v in values.items()], "")


def test_another_outcome_is_chance_and_an_open_one_says_nothing() -> None:
    passed = with_neighbour(result(settling_time=5.0), result(outcome="passed", settling_time=5.0), 1e4)
    assert passed.summary[ONE_OF_MANY] == {"outcome": "passed"} and passed.warnings[0].startswith("the outcome is chance")
    open_one = with_neighbour(result(settling_time=5.0), result(outcome="unidentified", settling_time=None), 1e4)
    assert ONE_OF_MANY not in open_one.summary
    own_open = with_neighbour(result(outcome="unidentified", speed=5.0), result(outcome="passed", speed=6.0), 1e4)
    assert own_open.summary[ONE_OF_MANY] == {"speed": 6.0} and "1e-6 rad away ends as passed; the run" in own_open.warnings[0]


@pytest.mark.parametrize(
    ("key", "own", "near", "far"),
    [
        ("settling_time", 10.0, 10.0009, 10.0011),
        ("settling_time", None, None, 3.0),
        ("final_phases", {"b1": 0.0002}, {"b1": 2 * math.pi - 0.0002}, {"b1": 2 * math.pi - 0.001}),
        ("final_residual_unbalance", 0.5, 0.50004, 0.50006),
        ("forces", {"r": [1.0, 0.0]}, {"r": [1.0, 0.00009]}, {"r": [1.0, 0.0002]}),
    ],
)
def test_a_ten_thousandth_decides(key: str, own: Any, near: Any, far: Any) -> None:
    unchanged = with_neighbour(result(**{key: own}), result(**{key: near}), 1e4)
    assert ONE_OF_MANY not in unchanged.summary and not unchanged.warnings
    marked = with_neighbour(result(**{key: own}), result(**{key: far}), 3e4)
    assert marked.summary[ONE_OF_MANY] == {key: far} and marked.summary[key] == own
    assert "1e4 times" in marked.warnings[0]
