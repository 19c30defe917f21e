"""A run whose energy balance does not close to a millionth says so."""

from __future__ import annotations

import pytest

import wucht
from wucht.files.building import machine_from

MACHINE = {
    "carrier": {"stiffness": 1e5, "damping": 200.0},
    "bodies": [{"kind": "rotor", "name": "d", "mass": 10.0, "unbalance": 0.01, "inertia": 0.03}],
    "drive": {"kind": "linear", "slope": 0.04, "no_load_speed": 50.0},
}


@pytest.mark.parametrize(("tolerance", "is_warned"), [(1e-9, False), (1.5e-3, False), (1.6e-3, True), (1e-2, True)])
def test_an_energy_balance_that_closes_to_a_millionth_is_not_warned_of(tolerance: float, is_warned: bool) -> None:
    """Integrated ever less accurately: at 1.5e-3 the residual is 0.94e-6."""
    result = wucht.run(wucht.RunUp(until=0.5, tolerance=tolerance), machine_from(MACHINE))
    assert (result.wucht.summary["energy_residual"] > 1e-6) is is_warned
    assert any("energy balance closes only to" in w for w in result.wucht.warnings) is is_warned
    assert any("study.tolerance" in w for w in result.wucht.warnings) is is_warned
