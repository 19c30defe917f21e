"""The dimensionless numbers of 002 (4.8) and (3.30): for R1 and R2 those that the errata promise."""

import math

import pytest

from wucht.analysis.dimensionless import dimensionless_numbers
from wucht.files.catalogue import load_machine
from wucht.machines.operation import natural_frequencies

R1 = {
    "epsilon": 0.01, "s": 0.75, "w": 1.3, "p": 0.8, "mu": 0.01, "beta_p": 1.0, "beta_r": 3.46667, "lambda": 2.0, "sigma": 0.1,
    "u": 20.0,
}  # fmt: skip


def test_r1_has_the_numbers_of_the_errata():
    """Table 5.1 but for beta_r, which the reciprocity of the dampers asks for."""
    assert dimensionless_numbers(load_machine("drozdetskaya-2020/r1")) == pytest.approx(R1, rel=1e-6)


def test_r2_has_the_beta_r_of_table_5_1_and_another_epsilon():
    assert dimensionless_numbers(load_machine("drozdetskaya-2020/r2")) == pytest.approx(
        R1 | {"epsilon": 2.88462e-4, "beta_r": 0.1}, rel=2e-6
    )


@pytest.mark.parametrize("name", ["r1", "r2"])
def test_the_identities_that_every_machine_obeys(name):
    """mu s beta_r = 2 epsilon w beta_p; s w = M/M* = 1 - 2 mu/p; 0 < p <= 1 (errata)."""
    n = dimensionless_numbers(
        load_machine(f"drozdetskaya-2020/{name}", {"p1.damping": 0.31, "p2.damping": 0.31, "carrier.stiffness": 3e4})
    )
    assert n["mu"] * n["s"] * n["beta_r"] == pytest.approx(2 * n["epsilon"] * n["w"] * n["beta_p"], rel=1e-12)
    assert n["s"] * n["w"] == pytest.approx(1 - 2 * n["mu"] / n["p"], rel=1e-12)
    assert 0 < n["p"] <= 1


def test_u_follows_the_slope():
    """slope = 9.75e-4 u N m s."""
    for u in (1.0, 20.0, 80.0):
        assert dimensionless_numbers(load_machine("drozdetskaya-2020/r1", {"drive.slope": 9.75e-4 * u}))["u"] == pytest.approx(
            u, rel=1e-12
        )


def test_a_dimensionless_machine_returns_its_own():
    machine = load_machine("drozdetskaya-2020/table-5.1")
    assert dimensionless_numbers(machine) == machine.values
    assert machine.values["beta_r"] == 0.1


def test_unequal_pendulums_have_no_common_numbers():
    assert set(dimensionless_numbers(load_machine("drozdetskaya-2020/r1", {"p2.length": 0.1}))) == {
        "epsilon",
        "sigma",
        "lambda",
        "u",
    }


def test_an_anisotropic_carrier_has_no_single_frequency():
    assert dimensionless_numbers(load_machine("drozdetskaya-2020/r1", {"carrier.stiffness": [1e5, 2e5]})) == {}
    assert dimensionless_numbers(load_machine("drozdetskaya-2020/r1", {"carrier.damping": [100.0, 200.0]})) == {}
    same_both_ways = load_machine("drozdetskaya-2020/r1", {"carrier.stiffness": [1e5, 1e5], "carrier.damping": [200.0, 200.0]})
    assert dimensionless_numbers(same_both_ways) == pytest.approx(R1, rel=1e-6)


def test_a_balanced_rotor_has_no_epsilon():
    assert dimensionless_numbers(load_machine("drozdetskaya-2020/r1", {"drum.eccentricity": 0.0})) == {}


def test_natural_frequencies_count_all_bodies():
    machine = load_machine("drozdetskaya-2020/r1", {"carrier.stiffness": [1e5, 4e5], "carrier.mass": "2.4 kg"})
    total = 2.4 + 9.75 + 2 * 0.125
    assert natural_frequencies(machine) == pytest.approx({"x": math.sqrt(1e5 / total), "y": math.sqrt(4e5 / total)})
    assert natural_frequencies(load_machine("drozdetskaya-2020/table-5.1")) == {"x": 1.0, "y": 1.0}
