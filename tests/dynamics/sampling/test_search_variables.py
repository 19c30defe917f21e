"""What a search varies: keys of bodies, groups of them, single paths."""

import numpy as np
import pytest

from wucht.dynamics.sampling.search_variables import balancing, values_at, variables_of
from wucht.studies.optimise_balancer.spec import OptimiseBalancer
from wucht.studies.study_file import read_study

CENTRIFUGE = read_study("practice/laboratory-centrifuge").subject


def test_keys_groups_and_paths() -> None:
    vary = {"damping": [1e-5, 1e-3], "mass": {"of": ["b1", "b2"], "range": ["4 g", "5 g"]}, "drive": {"slope": [1e-3, 2e-3]}}
    damping, mass, slope = variables_of(CENTRIFUGE, OptimiseBalancer(vary=vary).vary, together=False)
    assert damping.paths == tuple(f"b{k}.damping" for k in range(1, 5))
    assert mass.paths == ("b1.mass", "b2.mass")
    assert (mass.low, mass.high) == (4e-3, 5e-3)
    assert slope.paths == ("drive.slope",)
    assert damping.at(np.array([0, 0.5, 1])) == pytest.approx([1e-5, 1e-4, 1e-3])
    assert mass.at(np.array([0.5])) == pytest.approx([4.5e-3])
    assert damping.share(1e-4) == pytest.approx(0.5)


def test_a_pendulums_inertia_keeps_its_ratio() -> None:
    machine = read_study("practice/laundry-drum").subject
    names = balancing(machine)
    if f"{names[0]}.inertia" not in machine.values:
        machine = read_study("drozdetskaya-2020/r1").subject
        names = balancing(machine)
    assert f"{names[0]}.inertia" in machine.values
    own = machine.values[f"{names[0]}.mass"]
    (mass,) = variables_of(machine, OptimiseBalancer(vary={"mass": [own / 2, 2 * own]}).vary, together=False)
    assert values_at(machine, [mass], [2 * own])[f"{names[0]}.inertia"] == pytest.approx(
        2 * machine.values[f"{names[0]}.inertia"]
    )
