"""The study sweep of equations of a table [system]."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from tests.refusals import check_refusal

import wucht
from wucht.files.user_system import UserSystem, equations_from

FOLD = 2 / (3 * np.sqrt(3))  # of x' = mu + x - x^3: where mu = -(x - x^3) has its extremes
JUMPS = (
    "verdict: 2 JUMPS: at mu = 0.385 rising x jumps from -0.6298 to 1.156; at mu = -0.385 falling x jumps from 0.6298 to -1.156"
)


def hysteresis() -> UserSystem:
    return equations_from({"states": {"x": "mu + x - x^3"}, "parameters": {"mu": 0.0}}, "two folds")


def test_jumps_are_at_the_folds_on_either_way() -> None:
    result = wucht.run(wucht.Sweep(along="mu", range=(-0.6, 0.6), start={"x": -1.0}, points=121), hysteresis())
    s = result.wucht.summary
    assert [j["direction"] for j in s["jumps"]] == ["up", "down"]
    step = 1.2 / 120
    for jump, sign in zip(s["jumps"], (1, -1), strict=True):
        assert sign * jump["value"] == pytest.approx(FOLD, abs=1.5 * step)
        # Beyond the fold x tends to the other root of mu + x - x^3 = 0.
        roots = np.roots([-1.0, 0.0, 1.0, jump["value"]])
        assert np.abs(roots - jump["to"]).min() < 0.05
        assert sign * jump["to"] > 1 > -sign * jump["from"] > 0.4
    assert s["hysteresis"] == pytest.approx([-FOLD, FOLD], abs=1.5 * step)
    first = s["jumps"][0]
    assert first["mu"] == first["value"] and wucht.report(result)[1] == JUMPS
    assert first["bracket"] == pytest.approx((first["mu"] - step / 2, first["mu"] + step / 2))
    assert s["rate"] == pytest.approx(step / s["span"])
    assert result.jump_value.values.tolist() == [j["mu"] for j in s["jumps"]]
    assert result.jump_upward.values.tolist() == [1, 0]
    fig = wucht.draw(result)
    at = [line.get_xdata()[0] for line in fig.axes[0].lines if line.get_linestyle() == ":"]
    assert at == [j["value"] for j in s["jumps"]]


def test_a_forced_oscillator_stays_on_its_upper_branch_to_the_peak() -> None:
    """x'' + 0.1 x' + x + x^3 = 0.3 cos(w t): the peak of one harmonic is at A = F/(d w) = 3/w, w^2 = 1 + 0.75 A^2, w = 1.773.

    Below it jumps back where dw/dA = 0 on the lower branch, by the same balance. Steps that changed the phase of the forcing
    would leave the upper branch at 1.4.
    """
    states = {"x": "v", "v": "-0.1*v - x - x^3 + 0.3*cos(w*t)"}
    subject = equations_from({"states": states, "parameters": {"w": 1.0}})
    s = wucht.run(wucht.Sweep(along="w", range=(1.2, 1.9), points=29), subject).wucht.summary
    a = np.linspace(0.05, 2.0, 200_000)
    # (w^2 - 1 - 0.75 A^2)^2 + (0.1 w)^2 = (0.3/A)^2: the lower of both solutions w^2 of each A is the branch below the peak
    middle = 1 + 0.75 * a**2 - 0.005
    root = np.sqrt(np.maximum(middle**2 - (1 + 0.75 * a**2) ** 2 + (0.3 / a) ** 2, 0.0))
    beyond = np.sqrt(middle + root)[a < 1.69]
    down = beyond[np.flatnonzero(np.diff(np.sign(np.diff(beyond))) > 0)].min()
    jumps = {jump["direction"]: jump["value"] for jump in s["jumps"]}
    assert jumps["up"] == pytest.approx(1.773, abs=0.05)
    assert jumps["down"] == pytest.approx(down, abs=0.04)
    assert s["hysteresis"] == pytest.approx([jumps["down"], jumps["up"]], abs=0.03)


def test_a_sweep_that_is_stopped_is_a_result() -> None:
    """Before the first way is complete, and before the second one is."""

    def stop(activity: str) -> Callable[[float, str], None]:
        def report(_share: float, what: str) -> None:
            if what == activity:
                raise KeyboardInterrupt

        return report

    study = wucht.Sweep(along="mu", range=(-0.6, 0.6), start={"x": -1.0}, points=21)
    for activity, ways in (("settling", []), ("up", []), ("down", ["up"])):
        result = wucht.run(study, hysteresis(), progress=stop(activity))
        assert (result.attrs["finished"], result.attrs["sentence"]) == (0, "the sweep was interrupted")
        assert result.direction.values.tolist() == ways
        assert result.maxima.shape == (len(ways), 1, 21, 60)
        assert [j["direction"] for j in result.wucht.summary["jumps"]] == ways
        assert wucht.report(result)[1] == "verdict: the sweep was interrupted"
        wucht.draw(result)


def test_a_motion_that_goes_to_infinity_ends_the_sweep() -> None:
    """x' = mu + x^2 has the equilibrium -sqrt(-mu), and none beyond mu = 0."""
    subject = equations_from({"states": {"x": "mu + x^2"}, "parameters": {"mu": 0.0}})
    result = wucht.run(wucht.Sweep(along="mu", range=(-1.0, 0.5), start={"x": -1.0}, points=16), subject)
    assert (result.attrs["finished"], result.attrs["sentence"]) == (0, "the sweep failed")
    assert result.attrs["failure"].startswith("at mu = 0.1: ") and result.attrs["failure"] in result.wucht.warnings
    assert result.direction.values.tolist() == ["up"]
    mu = result.value.values[0]
    assert result["mean"].values[0, 0, mu < -0.05] == pytest.approx(-np.sqrt(-mu[mu < -0.05]), abs=1e-3)
    assert np.isnan(result["mean"].values[0, 0, mu > 0.05]).all()
    wucht.draw(result)


def test_a_motion_without_folds_has_no_jump() -> None:
    subject = equations_from({"states": {"x": "mu - x"}, "parameters": {"mu": 0.0}})
    result = wucht.run(wucht.Sweep(along="mu", range=(0.0, 1.0), direction="up", points=21), subject)
    assert (result.wucht.summary["jumps"], result.wucht.summary["hysteresis"]) == ([], None)
    assert result.attrs["sentence"] == "no jump: the motion follows mu between 0 and 1"
    assert result["mean"].values[0, 0] == pytest.approx(np.linspace(0, 1, 21), abs=1e-5)


def test_maxima_are_those_of_the_orbit() -> None:
    """r' = mu r - r^3: a circle of radius sqrt(mu), turned at the rate 2."""
    states = {"x": "mu*x - 2*y - x*(x^2 + y^2)", "y": "2*x + mu*y - y*(x^2 + y^2)"}
    subject = equations_from({"states": states, "parameters": {"mu": 0.5}})
    result = wucht.run(wucht.Sweep(along="mu", range=(0.5, 2.0), direction="up", start={"x": 0.5}, points=11), subject)
    peaks = result.maxima.sel(state="x").values[0]
    assert np.nanmax(np.abs(peaks - np.sqrt(np.linspace(0.5, 2.0, 11))[:, None])) < 1e-4


@pytest.mark.parametrize("key", [{"rate": 1.0}, {"jump_tolerance": 1e-3}])
def test_keys_of_machines_do_not_fit(key: dict[str, float]) -> None:
    question = wucht.Sweep(along="mu", range=(0.0, 1.0), **key)
    check_refusal(f"sweep of equations: {key}", lambda: wucht.run(question, hysteresis()))


LORENZ = {
    "states": {"x": "10*(y - x)", "y": "x*(r - z) - y", "z": "x*y - 8*z/3"}, "parameters": {"r": 0.5},
}  # fmt: skip


@pytest.mark.parametrize(("x", "is_warned"), [(0.0, True), (0.1, False)])
def test_a_motion_that_rests_on_an_unstable_equilibrium_is_warned_of(x: float, is_warned: bool) -> None:
    """Lorenz' equations: zero is unstable beyond r = 1. A start on it stays there, another one leaves for one of two states."""
    study = wucht.Sweep(along="r", range=(0.5, 20.0), points=14, start={"x": x, "y": 0.0, "z": 0.0}, direction="up")
    result = wucht.run(study, equations_from(LORENZ))
    warnings = result.wucht.warnings
    assert [("for r between 2 and 20" in w and "unstable equilibrium" in w) for w in warnings] == [True] * is_warned
    assert (result.high.values[0, 0, -1] == 0.0) == is_warned
