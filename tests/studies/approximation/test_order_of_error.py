"""The family of machines whose small parameter is made smaller: kappa = 1 is the machine, and epsilon goes as kappa."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest

from wucht import System, load_machine
from wucht.analysis.averaged_equations import AveragedEquations, averaged_equations_of
from wucht.dynamics.scenarios.order_of_error import STRENGTH, scale_epsilon, scaled_values
from wucht.machines.operation import has_damped_balancers
from wucht.numerics.flow.program import Evaluator

MACHINES = (
    "drozdetskaya-2020/table-5.1",
    "drozdetskaya-2020/r2",
    "drozdetskaya-2020/table-3.1-carrier",
    "practice/screen",
    "sperling-rollers/figure-8",
    "sperling-vibration/figure-2a",
)


def states(names: tuple[str, ...], seed: int = 3) -> np.ndarray:
    """Random angles, positive speeds, small displacements (n, 1)."""
    rng = np.random.default_rng(seed)
    values = [rng.uniform(20, 30) if n.endswith(".speed") else rng.uniform(-1e-3, 1e-3) for n in names]
    turned = [rng.uniform(-3, 3) if n.endswith((".angle", ".phase")) else v for n, v in zip(names, values, strict=True)]
    return np.array(turned)[:, None]


def rates_of(s: System, values: Mapping[str, float]) -> np.ndarray:
    return Evaluator.of_rates(s).array(np.zeros(1), states(s.state_names), s.values(values))[:, 0]


def rates(averaged_equations: AveragedEquations, kappa: float) -> np.ndarray:
    """State derivatives (n,) of a slow machine with a strength."""
    values = averaged_equations.machine.values
    return rates_of(
        averaged_equations.system, values | (scaled_values(averaged_equations.machine, kappa) if STRENGTH in values else {})
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", MACHINES)
def test_factor_1_is_the_machine_itself(name: str) -> None:
    expected, family = (rates_of(m.system, m.values) for m in (load_machine(name), scale_epsilon(load_machine(name), 1.0)))
    assert np.abs(expected).max() > 1.0
    assert family == pytest.approx(expected, rel=1e-9, abs=1e-9 * np.abs(expected).max())  # round-off: solved in another order


@pytest.mark.parametrize("name", ["drozdetskaya-2020/table-5.1", "drozdetskaya-2020/r2", "practice/laboratory-centrifuge"])
def test_the_strongly_damped_slow_equations_go_as_kappa(name: str) -> None:
    """002 (3.24): phases' and speed's rates are epsilon times a function of them."""
    machine = load_machine(name)
    assert has_damped_balancers(machine)
    averaged_equations = averaged_equations_of(scale_epsilon(machine, 1.0), inertia=False)
    own = rates(averaged_equations_of(machine, inertia=False), 1.0)
    assert np.abs(own).max() > 1e-4
    assert rates(averaged_equations, 1.0) == pytest.approx(own, rel=1e-9, abs=1e-12 * np.abs(own).max())
    for kappa in (0.5, 0.03):
        assert rates(averaged_equations, kappa) == pytest.approx(kappa * own, rel=1e-9, abs=1e-12 * np.abs(own).max())


@pytest.mark.parametrize("name", ["practice/screen", "sperling-vibration/figure-2a"])
def test_the_speeds_of_rotors_go_as_kappa(name: str) -> None:
    """J theta'' = kappa (L + V), of a shaken carrier too; the phases' rates are differences of speeds, and stay."""
    averaged_equations = averaged_equations_of(scale_epsilon(load_machine(name), 1.0))
    names, own = averaged_equations.system.state_names, rates(averaged_equations, 1.0)
    is_speed = np.array([n.endswith(".speed") for n in names])
    quarter = rates(averaged_equations, 0.25)
    assert quarter[is_speed] == pytest.approx(0.25 * own[is_speed], rel=1e-8)  # the screen's bearings damp it by 1e-9 as well
    assert quarter[~is_speed] == pytest.approx(own[~is_speed], rel=1e-12)


def test_with_inertia_the_dampers_between_bodies_stay() -> None:
    """J theta'' + B theta' = kappa (L + V): affine in kappa, and at kappa = 0 only the slip decays."""
    averaged_equations = averaged_equations_of(scale_epsilon(load_machine("drozdetskaya-2020/r2"), 1.0), inertia=True)
    none, half, whole = (rates(averaged_equations, k) for k in (0.0, 0.5, 1.0))
    assert half == pytest.approx((none + whole) / 2, rel=1e-9, abs=1e-9)
    value = dict(zip(averaged_equations.system.state_names, none, strict=True))
    at = dict(zip(averaged_equations.system.state_names, states(averaged_equations.system.state_names)[:, 0], strict=True))
    v = averaged_equations.machine.values
    assert value["p1.speed"] == pytest.approx(-v["p1.damping"] * (at["p1.speed"] - at["drum.speed"]) / v["p1.inertia"])


def test_the_machine_itself_is_left_as_it_is() -> None:
    machine = load_machine("drozdetskaya-2020/r2")
    before = dict(machine.values)
    family = scale_epsilon(machine, 0.5)
    assert machine.values == before
    assert family.values == before | {STRENGTH: 0.5}
    assert family.with_values({STRENGTH: 0.25}).values[STRENGTH] == 0.25
