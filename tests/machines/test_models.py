"""Dimensionless machines: what does not follow from their energies."""

import pytest

from wucht.files.catalogue import load_machine


def mismatch(speeds: dict[str, float], **values: float) -> float:
    machine = load_machine("drozdetskaya-2020/table-5.1").with_values(values)
    expression = machine.structure.mismatch
    assert expression is not None
    known = machine.values | {f"{name}.speed": speed for name, speed in speeds.items()}
    return float(expression.subs({symbol: known[symbol.name] for symbol in expression.free_symbols}))


def test_dampers_that_are_not_reciprocal_make_power_out_of_nothing() -> None:
    """(s beta_r/(2 epsilon w) - beta_p/mu) (theta_1' + theta_2' - 2 phi') phi': none of bodies that turn with the rotor."""
    given = {"s": 0.75, "beta_r": 0.1, "epsilon": 0.02, "w": 1.5, "beta_p": 0.3, "mu": 0.05}
    factor = 0.75 * 0.1 / (2 * 0.02 * 1.5) - 0.3 / 0.05
    speeds = {"rotor": 1.5, "p1": 0.9, "p2": 1.7}
    assert mismatch(speeds, **given) == pytest.approx(factor * (0.9 + 1.7 - 3.0) * 1.5)
    assert mismatch({"rotor": 1.5, "p1": 1.5, "p2": 1.5}, **given) == pytest.approx(0.0, abs=1e-15)
    assert mismatch(speeds, **given | {"beta_p": 0.05 * 0.75 * 0.1 / (2 * 0.02 * 1.5)}) == pytest.approx(0.0, abs=1e-15)
