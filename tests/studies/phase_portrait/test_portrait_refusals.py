"""What a phase portrait is asked wrongly, what it says of its equations, and what it gives up."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.refusals import failed, refused

import wucht
from wucht import InputError, UserSystem
from wucht.files.user_system import equations_from

SADDLE = {"states": {"x": "mu*x - x^3", "y": "-y"}, "parameters": {"mu": 1.0}}
SQUARE = {"x": (-2, 2), "y": (-2, 2)}


def own(x: str, y: str = "-y") -> UserSystem:
    return equations_from({"states": {"x": x, "y": y}})


def summary(subject: Any, **keys: Any) -> dict[str, Any]:
    return wucht.run(wucht.PhasePortrait(**{"trajectories": 0, **keys}), subject).wucht.summary


@pytest.mark.slow
def test_closed_curves_are_met_where_no_trajectory_is_drawn() -> None:
    """R2 has two in its section, cases.md: captured-modulated; van der Pol's oscillator at mu = 1 one of period 6.6632869."""
    (orbit,) = summary(own("y", "(1 - x^2)*y - x"), ranges={"x": (-4, 4), "y": (-4, 4)})["closed_curves"]
    assert (orbit["kind"], orbit["period"]) == ("stable", pytest.approx(6.6632869, rel=1e-7))
    s = summary(wucht.load_machine("drozdetskaya-2020/r2"), together=True)
    assert sorted(c["kind"] for c in s["closed_curves"]) == ["stable", "unstable"]
    assert "closed curves are those met by 12 followed curves" in s["shown"]


@pytest.mark.slow
def test_the_model_is_named() -> None:
    """Machines in SI units keep the inertia of their bodies, where two states are left with it; else a warning says it."""
    real = wucht.run(wucht.PhasePortrait(together=True, trajectories=0), wucht.load_machine("drozdetskaya-2020/r1-u1"))
    s = real.wucht.summary
    assert (s["model"], s["inertia"], s["order"]) == ("averaged", False, 1)
    assert any("the inertia of p1, p2 is left out" in w and "approximation" in w for w in real.wucht.warnings)
    assert s["sentence"].startswith("averaged equations, without the inertia of the balancing bodies")
    states = ("p1.phase", "p2.phase", "drum.speed", "p1.speed", "p2.speed", "inertia = false")
    with refused("study.together", *states, given=True):
        summary(wucht.load_machine("drozdetskaya-2020/r1-u1"), together=True, inertia=True)


def test_jumps_are_no_proof() -> None:
    """x' = sign(x) - x: both nodes are found, and whether more is at the jump is left open; x = 0 slides."""
    s = summary(own("sign(x) - x"), ranges=SQUARE)
    assert [p["state"]["x"] for p in s["fixed_points"]] == pytest.approx([-1.0, 1.0])
    assert not s["complete"] and "bifurcation or a jump" in s["shown"]
    assert summary(own("abs(x) - 1.1"), ranges=SQUARE)["complete"]


@pytest.mark.parametrize("x", ["sign(x) - x", "-sign(x)", pytest.param("x^1000", marks=pytest.mark.slow)])
def test_curves_that_cannot_be_followed_are_given_up(x: str) -> None:
    """Backwards, sign(x) - x slides along x = 0, as -sign(x) does forwards: a kink follows the other."""
    result = wucht.run(wucht.PhasePortrait(trajectories=2, ranges=SQUARE), own(x))
    assert not result.wucht.summary["complete"]
    ends = set(map(str, result.trajectory_end.values))
    if x == "-sign(x)":
        assert ends == {"too many kinks"}
        assert any("slide along a jump" in w for w in result.wucht.warnings)


def test_one_signal_ends_the_search() -> None:
    """Within a curve and within Newton's method, not only between them."""
    calls = []

    def stop(share: float, what: str) -> None:
        calls.append(what)
        if what == "trajectories":
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        wucht.run(wucht.PhasePortrait(ranges=SQUARE), own("y", "-sin(x)"), progress=stop)
    assert calls.count("trajectories") == 1


def test_equal_values_are_one_portrait_and_bad_ranges_are_refused() -> None:
    several = equations_from(SADDLE)
    for given, missing in (({"along": "mu"}, "values"), ({"values": [1.0]}, "along")):
        with refused(f"study.{missing}", code="missing"):
            wucht.PhasePortrait(**given)
    assert len(summary(several, along="mu", values=[1, 1.0, 2], ranges=SQUARE)["cases"]) == 2
    for bad in ((0, float("inf")), (0, 1e300), (False, True), (0, "nan"), (1, 1 + 1e-12)):
        with pytest.raises(InputError, match=r"study\.ranges"):
            summary(several, ranges={"x": bad, "y": (-1, 1)})
        if bad[1] != 1e300 and bad[0] != 1:
            with pytest.raises(InputError, match=r"study\.ranges"):
                wucht.SpeedCurve(along="mu", range=(0, 1), ranges={"x": bad})
    assert wucht.SpeedCurve(along="mu", range=(0, 1), ranges={"x": ("-1", 1)}).ranges == {"x": (-1.0, 1.0)}


def test_angles_are_reported_within_half_a_turn() -> None:
    """cases.md: at u1* the phase is -1.6914641."""
    machine = wucht.load_machine("drozdetskaya-2020/table-5.1", {"u": 1.833107})
    result = wucht.run(wucht.PhasePortrait(together=True, trajectories=0, ranges={"speed": (0.4, 2.2)}), machine)
    angles = [p["state"]["psi"] for p in result.wucht.summary["fixed_points"]]
    assert angles == pytest.approx([-1.6914641] * 2, abs=3e-3)
    assert result.fixed_points.values[:, 0] == pytest.approx(np.array(angles))


def test_one_state_left_is_advised() -> None:
    machine = wucht.load_machine("drozdetskaya-2020/table-5.1")
    with refused("study.speed", "p1.phase", "p2.phase", given=1.0):
        summary(machine, together=True, speed=1.0)


def test_keys_that_another_study_leaves_out_are_named(here: Path, wucht: Callable[..., Any]) -> None:
    completed = wucht("run", "drozdetskaya-2020/figure-5.5", "--set", "study.kind=speed-curve")
    assert completed.code == 2
    assert "the values of" in completed.err and "along" in completed.err and "values" in completed.err
    assert "use --set study.along=..." in completed.err


def test_a_window_in_which_nothing_attracts_any_more() -> None:
    """Its sides are 1e28 times as different as the decay can be told in."""
    focus = equations_from({"states": {"x": "y", "y": "-x - 0.1*y"}})
    with failed("too-narrow", "0"):
        summary(focus, ranges={"x": (-4, 1e29), "y": (-5, 5)})
