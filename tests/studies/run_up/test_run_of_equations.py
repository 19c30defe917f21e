"""The study run-up of equations of a table [system]."""

from __future__ import annotations

import json

import numpy as np
import pytest
from tests.refusals import check_refusal

import wucht
from wucht.files.user_system import UserSystem, equations_from

NORMAL_FORM = {"x": "x - 2*y - x*(x^2 + y^2)", "y": "2*x + y - y*(x^2 + y^2)"}


def subject(states: dict[str, str] | None = None, angles: tuple[str, ...] = ()) -> UserSystem:
    return equations_from({"states": states or NORMAL_FORM, "angles": list(angles)}, "normal form")


def test_its_summary_has_the_orbit_and_names_of_its_states() -> None:
    result = wucht.run(wucht.RunUp(start={"x": 0.1}, stored_samples=1001), subject())
    summary = result.wucht.summary
    assert (summary["outcome"], summary["stable"]) == ("periodic", True)
    assert summary["period"] == pytest.approx(np.pi, rel=1e-9)
    assert summary["max"] == pytest.approx({"x": 1.0, "y": 1.0}, abs=1e-5)
    assert summary["lyapunov_exponent"]["value"] is None
    assert not {name for name in summary if "speed" in name or "amplitude" in name}
    assert result.states.dims == ("state", "time") and result.sizes["time"] <= 1001
    assert result.states.sel(state="x").values[0] == 0.1
    radius = np.hypot(*result.states.values)
    assert radius == pytest.approx(1 / np.sqrt(1 + 99 * np.exp(-2 * result.time.values)), abs=1e-9)


def test_a_report_and_a_figure_are_made_from_the_dataset() -> None:
    result = wucht.run(wucht.RunUp(start={"a": 0.5}), subject({"a": "w", "w": "1 - w"}, ("a",)))
    lines = wucht.report(result)
    assert lines[1].startswith("verdict: PERIODIC, the motion tends to a periodic orbit of period 6.283")
    assert "the motion tends to a periodic orbit of period 6.283185" in result.wucht.sentence
    assert any("a +1 a period" in line for line in lines)
    assert [axis.get_ylabel() for axis in wucht.draw(result).axes] == ["a", "w", "w"]


@pytest.mark.parametrize(
    "key", [{"turns": 3}, {"over": "phi"}, {"model": "slow"}, {"start": {"xx": 1.0}}, {"start": {"x": {"speed": 1.0}}}]
)
def test_keys_of_machines_are_refused(key: dict[str, object]) -> None:
    check_refusal(f"run-up of equations: {key}", lambda: wucht.run(wucht.RunUp(**key), subject()))


def test_a_short_run_advises_a_longer_one() -> None:
    result = wucht.run(wucht.RunUp(until=0.5, start={"x": 0.1}), subject())
    assert result.wucht.summary["outcome"] == "unsettled"
    assert "study.until = 2 may tell" in json.loads(result.attrs["warnings"])[0]


def test_many_starts_and_values_are_one_result() -> None:
    """x' = mu x - x^3 tends to the root of mu with the sign of the start; where it starts at 0 it stays there."""
    pitchfork = equations_from({"states": {"x": "mu*x - x^3"}, "parameters": {"mu": 1.0}}, "pitchfork")
    starts = [{"x": 0.5}, {"x": -0.5}, {}]
    result = wucht.run(wucht.RunUp(starts=starts, along="mu", values=[1.0, 4.0]), pitchfork)
    s = result.wucht.summary
    assert s["cases"][2]["label"] == "mu = 1; all states 0" and s["cases"][3]["label"] == "mu = 4; x = 0.5"
    assert [(c["value"], c["start"], c["state"]["x"]) for c in s["cases"]] == [
        (mu, {"x": start.get("x", 0.0)}, pytest.approx(x * mu**0.5, abs=1e-6))
        for mu in (1.0, 4.0) for start, x in zip(starts, (1, -1, 0), strict=True)
    ]  # fmt: skip
    assert (s["outcome"], s["outcomes"], s["along"]) == ("equilibrium", {"equilibrium": 6}, "mu")
    assert [c["stable"] for c in s["cases"]] == [True, True, False] * 2
    assert result.states.dims == ("case", "state", "sample")
    assert result.states.values[:, 0, 0].tolist() == [0.5, -0.5, 0.0] * 2
    assert any("mu = 4; all states 0: the start lies on an unstable equilibrium" in w for w in result.wucht.warnings)
    assert wucht.report(result)[1] == "verdict: 6 equilibrium" and len(wucht.draw(result).axes[0].lines) == 6


def test_runs_of_different_ends_are_counted() -> None:
    """Of x' = x^3 - x: within 1 it decays, beyond it grows without bound; each with the warnings of its own run."""
    runs = wucht.run(wucht.RunUp(starts=[{"x": 0.5}, {"x": 2.0}]), subject({"x": "x^3 - x"}))
    assert runs.wucht.summary["outcomes"] == {"equilibrium": 1, "diverges": 1}
    assert runs.wucht.summary["outcome"] is None and runs.attrs["outcome"] == "several"
    assert runs.wucht.summary["sentence"] == "1 equilibrium, 1 diverges"
    for keys in ({"starts": [{}, {"y": 2.0}]}, {"along": "q", "values": [1.0]}):
        check_refusal(
            f"run-up of equations: {keys}", lambda keys=keys: wucht.run(wucht.RunUp(**keys), subject({"x": "x^3 - x"}))
        )


def test_a_chaotic_motion_is_so_for_a_time_and_tends_to_nothing() -> None:
    lorenz = subject({"x": "10*(y - x)", "y": "x*(28 - z) - y", "z": "x*y - 8/3*z"})
    result = wucht.run(wucht.RunUp(start={"x": 1.0, "y": 1.0, "z": 1.0}), lorenz)
    s, told = result.wucht.summary, wucht.report(result)
    assert f"  run          stored until t = {s['end_time']:.6g}" in told, "less than the time for which it is chaotic"
    assert (s["outcome"], s["stable"], s["settling_time"]) == ("chaotic", None, None)
    assert s["sentence"].startswith("the motion is chaotic for at least ") and "tends to" not in s["sentence"]


def test_a_conservative_motion_is_one_of_a_family() -> None:
    """The oscillator without damping preserves volume; the equations of Lotka and Volterra have a family of orbits as well."""
    volume, family = "preserve volume", "one of a family: disturbances neither grow nor decay"
    for states, start, preserves in (
        ({"x": "v", "v": "-x"}, {"x": 1.0}, True),
        ({"x": "v", "v": "-x"}, {}, True),
        ({"x": "x*(1 - y)", "y": "y*(x - 1)"}, {"x": 1.5, "y": 1.0}, False),
    ):
        s = wucht.run(wucht.RunUp(start=start), subject(states)).wucht.summary
        assert family in s["sentence"] and (volume in s["sentence"]) is preserves and s["stable"] is None
    damped = wucht.run(wucht.RunUp(start={"x": 1.0}), subject({"x": "v", "v": "-x - 0.1*v"})).wucht.summary
    assert family not in damped["sentence"] and damped["stable"]


def test_a_start_on_an_unstable_equilibrium_is_said() -> None:
    """Upside down the pendulum falls by rounding; x' = x - x^3 stays at 0; at 1 it is stable."""
    pendulum = subject({"x": "v", "v": "-sin(x) - 0.1*v"}, ("x",))
    (warning,) = wucht.run(wucht.RunUp(start={"x": np.pi}), pendulum).wucht.warnings
    assert "leaves it by rounding alone" in warning
    assert not wucht.run(wucht.RunUp(start={"x": 3.0}), pendulum).wucht.warnings
    pitchfork = subject({"x": "x - x^3"})
    (warning,) = wucht.run(wucht.RunUp(start={"x": 0.0}), pitchfork).wucht.warnings
    assert warning.startswith("the start lies on an unstable equilibrium: any disturbance")
    assert not wucht.run(wucht.RunUp(start={"x": 1.0}), pitchfork).wucht.warnings
    switch = subject({"x": "3/(1 + y^2) - x", "y": "3/(1 + x^2) - y"})
    (warning,) = wucht.run(wucht.RunUp(start={"x": 0.5, "y": 0.5}), switch).wucht.warnings
    assert warning.startswith("the motion ends in an unstable equilibrium")
