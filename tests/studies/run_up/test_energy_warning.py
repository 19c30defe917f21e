"""A run whose energy balance does not close to a millionth says so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from wucht.dynamics.work import Work
from wucht.files.building import machine_from
from wucht.machines.machine import DISSIPATED_WORK
from wucht.studies.registry import study_of
from wucht.studies.run_up.spec import RunUp
from wucht.studies.runner import run

MACHINE = {
    "carrier": {"stiffness": 1e5, "damping": 200.0},
    "bodies": [{"kind": "rotor", "name": "d", "mass": 10.0, "unbalance": 0.01, "inertia": 0.03}],
    "drive": {"kind": "linear", "slope": 0.04, "no_load_speed": 50.0},
}


def _booked(share: float) -> xr.Dataset:
    """A run-up of which, at last, such a share of the largest energy is booked as lost that is not."""
    study, asked = study_of("run-up"), RunUp(until=0.5)
    plan = study.prepare(asked, machine_from(MACHINE))
    *_, findings = study.run(plan, Work())
    ((motion,),) = findings.motions
    last = motion.trajectory
    of_run = run(asked, plan.machine)
    largest = max(float(of_run[name].max()) for name in ("stored_energy", "supplied_work"))
    lost = last.quadratures[DISSIPATED_WORK] + share * largest * np.append(np.zeros(len(last.time) - 1), 1.0)
    booked = replace(last, quadratures={**last.quadratures, DISSIPATED_WORK: lost})
    result: xr.Dataset = study.dataset(plan, replace(findings, motions=((replace(motion, trajectory=booked),),)))
    return result


@pytest.mark.parametrize(("share", "told"), [(0.0, False), (0.99e-6, False), (1.01e-6, True), (1e-3, True)])
def test_an_energy_balance_that_closes_to_a_millionth_is_not_warned_of(share: float, told: bool) -> None:
    result = _booked(share)
    assert result.wucht.summary["energy_residual"] == pytest.approx(share, rel=1e-4, abs=1e-11)
    assert any("energy balance closes only to" in w for w in result.wucht.warnings) is told
    assert any("study.tolerance" in w for w in result.wucht.warnings) is told
