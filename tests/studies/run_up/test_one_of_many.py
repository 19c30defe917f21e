"""Numbers that hold, and numbers that are one draw of many: against runs with other tolerances, which are other draws."""

from __future__ import annotations

import math
from typing import Any

import pytest
import xarray as xr

import wucht
from wucht.numerics.angles import wrap_to_pi

ONE_OF_MANY = "one_of_many"
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


@pytest.mark.slow
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
    assert "settled at" in next(line for line in wucht.report(results[0]) if "(one of many)" in line)


def test_a_run_without_growth_has_no_marks() -> None:
    summary = wucht.run_file("drozdetskaya-2020/r1").wucht.summary
    assert ONE_OF_MANY not in summary


@pytest.mark.slow
@pytest.mark.parametrize("name", ["practice/laboratory-centrifuge", "practice/grinder-10-balls"])
def test_balls_that_tumble_through_the_resonance(name: str) -> None:
    """Final phases of b1 of 118 and 228 degrees, amplitudes that settle from 32.3 to 37.9 s: two tolerances, two draws."""
    differing, marked = differing_keys([wucht.run_file(name, {"study.tolerance": t}) for t in TOLERANCES])
    assert differing <= marked and {"final_phases", "amplitude_settling_time"} <= marked
    assert not marked & {"outcome", "final_speed", "free_speed", "resonance_speed"}
