"""Relaxation oscillations of ``orbit-branch`` against SciPy's integration with events where a state has its extremes.

Brusselator: I. Prigogine, R. Lefever, J. Chem. Phys. 48 (1968) 1695. Van der Pol's oscillator: B. van der Pol, Phil. Mag. 2
(1926) 978. Oregonator, scaled: R. J. Field, R. M. Noyes, J. Chem. Phys. 60 (1974) 1877. The witness is LSODA at
a relative tolerance of 1e-12. Orbits are required to 1e-7 of the states' sizes between mesh points, a few times that as a mesh
is kept; their periods are far more accurate.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from wucht import OrbitBranch, report, run
from wucht.files.user_system import equations_from

LSODA: dict[str, Any] = {"method": "LSODA", "rtol": 1e-12, "atol": 1e-14}
BRUSSELATOR = {"parameters": {"A": 1.0, "B": 4.0}, "states": {"X": "A + X^2*Y - B*X - X", "Y": "B*X - X^2*Y"}}
VAN_DER_POL = {"parameters": {"mu": 1.0}, "states": {"x": "v", "v": "mu*(1 - x^2)*v - x"}}
OREGONATOR = {
    "parameters": {"e": 0.02, "d": 4e-4, "q": 8e-4, "f": 1.0},
    "states": {"x": "(q*y - x*y + x*(1 - x))/e", "y": "(-q*y - x*y + f*z)/d", "z": "x - z"},
}


def brusselator(value: float) -> Callable[[float, np.ndarray], list[float]]:
    return lambda t, y: [value + y[0] ** 2 * y[1] - 5 * y[0], 4 * y[0] - y[0] ** 2 * y[1]]


def van_der_pol(value: float) -> Callable[[float, np.ndarray], list[float]]:
    return lambda t, y: [y[1], value * (1 - y[0] ** 2) * y[1] - y[0]]


def oregonator(value: float) -> Callable[[float, np.ndarray], list[float]]:
    q, d = 8e-4, 4e-4
    return lambda t, y: [
        (q * y[1] - y[0] * y[1] + y[0] * (1 - y[0])) / value, (-q * y[1] - y[0] * y[1] + y[2]) / d, y[0] - y[2],
    ]  # fmt: skip


def by_integration(
    rates: Callable[[float, np.ndarray], list[float]], start: list[float], period: float
) -> tuple[float, float, float]:
    """Return the period, and the least and largest first state: each extreme is an event. period: an estimate."""

    def slope(t: float, y: np.ndarray) -> float:
        return float(rates(t, y)[0])

    settled = solve_ivp(rates, (0.0, 2 * period), start, **LSODA).y[:, -1]
    motion = solve_ivp(rates, (0.0, 2.2 * period), settled, events=slope, **LSODA)
    times, extremes = motion.t_events[0], motion.y_events[0][:, 0]
    tops = times[extremes > extremes.max() - 1e-3 * np.ptp(extremes)]
    return float(np.diff(tops).mean()), float(extremes.min()), float(extremes.max())


def orbits(described: Mapping[str, Any], **keys: Any) -> Any:
    return run(OrbitBranch(**keys), equations_from(described, "a test"))


def test_extremes_of_a_peak_that_takes_a_ten_thousandth_of_the_period() -> None:
    """Of the table and along the branch; LSODA gives X up to 34.8219 at A = 0.181603, where the period is 243.38872."""
    result = orbits(
        BRUSSELATOR, along="A", range=(0.18, 0.36), at=0.35, values=(0.181603, 0.344808), start={"X": 1.0}, longest=900.0
    )
    table = result.wucht.summary["orbits"]
    assert [o["max_X"] for o in table] == pytest.approx([34.8219, 18.4569], abs=6e-5)
    assert [o["period"] for o in table] == pytest.approx([243.38872, 67.181256], abs=6e-6)
    value, period, low, high = (result[name].values for name in ("value", "period", "min_X", "max_X"))
    k = len(value) // 2
    rows = [*((o["A"], o["period"], o["min_X"], o["max_X"]) for o in table), (value[k], period[k], low[k], high[k])]
    for parameter, *numbers in rows:
        witness = by_integration(brusselator(parameter), [1.0, 4.0], numbers[0])
        assert numbers[0] == pytest.approx(witness[0], rel=1e-8)
        assert numbers[1:] == pytest.approx(witness[1:], abs=1e-6 * witness[2])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("described", "rates", "start", "keys"),
    [
        (
            VAN_DER_POL, van_der_pol, {"x": 2.0, "v": 0.0},
            {"along": "mu", "range": (50.0, 160.0), "at": 60.0, "values": (60.0, 150.0)},
        ),
        (
            OREGONATOR, oregonator, {"x": 0.1, "y": 0.1, "z": 0.1},
            {"along": "e", "range": (5e-3, 0.05), "at": 0.02, "values": (6e-3, 0.04)},
        ),
    ],
    ids=["van der Pol", "Oregonator"],
)  # fmt: skip
def test_extremes_and_periods_of_stiff_oscillators(
    described: Mapping[str, Any], rates: Any, start: dict[str, float], keys: dict[str, Any]
) -> None:
    """Of the table, and of three orbits along the branch; all are as accurate as required."""
    result = orbits(described, **keys, start=start)
    along = str(keys["along"])
    rows = [(o[along], o["period"], o["min_x"], o["max_x"]) for o in result.wucht.summary["orbits"]]
    assert len(rows) == 2 and "finest mesh" not in result.attrs["warnings"]
    columns = [result[name].values for name in ("value", "period", "min_x", "max_x")]
    rows += [tuple(column[k] for column in columns) for k in np.linspace(1, len(columns[0]) - 2, 3).astype(int)]
    for value, period, low, high in rows:
        witness = by_integration(rates(value), list(start.values()), period)
        assert period == pytest.approx(witness[0], rel=1e-7)
        assert (low, high) == pytest.approx(witness[1:], abs=1e-6 * (witness[2] - witness[1]))


def test_the_end_at_the_longest_period_names_its_key() -> None:
    """By default 20 times the first period, 4.546649 at A = 1.575: it says so, and with ten times as much the range ends."""
    keys: dict[str, Any] = {"along": "A", "range": (0.2, 2.9), "at": 1.575, "values": (1.0,), "start": {"X": 1.0}}
    result = orbits(BRUSSELATOR, **keys)
    ends = {e["kind"]: e for e in result.wucht.summary["ends"]}
    assert ends.keys() == {"period-limit", "hopf"} and "not identified" not in result.attrs["sentence"]
    assert ends["period-limit"]["period"] == pytest.approx(20 * 4.546649, rel=1e-6)
    (line,) = [line for line in report(result) if "longest" in line and "end  " in line]
    assert "the period reaches 90.933, up to which orbits are followed; study.longest = 900 follows the branch farther" in line
    assert line.endswith("(by default it is 20 times the first period)")
    assert {e["kind"] for e in orbits(BRUSSELATOR, **keys, longest=900.0).wucht.summary["ends"]} == {"range", "hopf"}
