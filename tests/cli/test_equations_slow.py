"""``wucht equations --slow``."""

from __future__ import annotations

from collections.abc import Callable
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest

Refused = Callable[..., str]
Command = Callable[..., Any]
R1 = "drozdetskaya-2020/r1"


def test_the_dissertations_slow_equations(wucht: Command) -> None:
    """002 (4.60)-(4.62), corrected: multiplied out, the coefficients of the rates and of the torques."""
    lines = [line.strip() for line in wucht("equations", "drozdetskaya-2020/table-5.1", "--slow").out.splitlines()]
    assert "alpha_p1'*beta_p/mu = V_p1 - omega'/mu" in lines
    assert "Re(D_x) = 1 - omega**2" in lines
    assert "Im(D_x) = 2*omega*sigma" in lines
    assert "Re(S_x) = s + cos(alpha_p1) + cos(alpha_p2)" in lines


def test_inertia_and_order(wucht: Command) -> None:
    kept, plain, second = (
        wucht("equations", R1, "--slow", *w).out for w in (["--inertia"], ["--no-inertia"], ["--order", "2"])
    )
    assert "order 1, with the inertia of the balancing bodies:" in kept
    assert "J_p1*omega_p1' = " in kept
    assert plain == wucht("equations", R1, "--slow").out
    assert "averaged equations of order 2, without the inertia" in second
    assert len(second.splitlines()) > 2 * len(plain.splitlines())


REFUSED = {
    "order 3": ([R1, "--slow", "--order", "3"], ("--order: given 3", "must be 1 or 2")),
    "order of the full ones": ([R1, "--order", "2"], ("--order", "only with --slow")),
    "slider": (["sperling-vibration/figure-7", "--slow"], ("there are no averaged equations", "slides in a guide")),
    "not damped": ([R1, "--slow", "--no-inertia", "--set", "p1.damping=0"], ("--no-inertia", "not damped against its rotor")),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refused(refused: Refused, case: str) -> None:
    words, says = REFUSED[case]
    refused("equations", *words, says=says)


def test_a_parameter_that_a_schedule_raises_from_zero_is_printed(wucht: Command, tmp_path: Path) -> None:
    text = (files("wucht") / "machines/catalogue/drozdetskaya-2020/r1.toml").read_text(encoding="utf-8")
    schedule = '[[machine.schedules]]\nparameter = "drive.slope"\npoints = [["0 s", "0 N m s"], ["2 s", "0.01 N m s"]]\n'
    (tmp_path / "ramp.toml").write_text(text + "\n" + schedule, encoding="utf-8")
    printed = wucht("equations", str(tmp_path / "ramp.toml"), "--slow").out
    (value,) = [line for line in printed.splitlines() if "drive.slope" in line]
    (formula,) = [line for line in printed.splitlines() if line.startswith("  T_drive(omega) = ")]
    assert value.split(" = ")[0] in formula and "left out" not in value


DRIVEN = """
[machine.carrier]
directions = "x"
mass = "10 kg"
stiffness = "1e4 N/m"
[[machine.bodies]]
kind = "rotor"
name = "a"
mass = "5 kg"
unbalance = "0.01 kg m"
inertia = "0.01 kg m^2"
[machine.drive]
kind = "inverter"
set_speed = "100 rad/s"
gain = "1 N m s"
integral_time = "0.1 s"
torque_limit = "5 N m"
[[machine.schedules]]
parameter = "drive.set_speed"
points = [["0 s", "0 rad/s"], ["2 s", "100 rad/s"]]
[study]
kind = "run-up"
"""


def test_the_full_equations_have_those_of_internal_states_and_say_what_a_schedule_changes(wucht: Command, here: Path) -> None:
    Path("driven.toml").write_text(DRIVEN, encoding="utf-8")
    lines = wucht("equations", "driven.toml").out.splitlines()
    rates = [line for line in lines if line.startswith("  ") and "=" in line and "T_drive(" not in line.split("=")[0]]
    assert len(rates) == 3 and rates[-1].lstrip().split("'")[0] not in {line.lstrip().split("'")[0] for line in rates[:2]}
    scheduled = [line for line in lines if "drive.set_speed" in line]
    assert len(scheduled) == 1 and scheduled[0].endswith(", at t = 0: it has a schedule")
    in_latex = wucht("equations", "driven.toml", "--latex").out.splitlines()
    assert all(line.count("&=") == 1 for line in in_latex if line.startswith("  "))
