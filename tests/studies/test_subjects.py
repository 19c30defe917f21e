"""What a study is asked of, as a System with values."""

from __future__ import annotations

import numpy as np

from wucht.files.catalogue import load_equations, load_machine
from wucht.numerics.flow.program import Evaluator
from wucht.studies.subjects import MACHINE_OR_SYSTEM, equations_of


def test_machines_and_own_equations_are_systems_with_values() -> None:
    own, machine = load_equations("drozdetskaya-2020/figure-2.10"), load_machine("drozdetskaya-2020/table-5.1")
    assert equations_of(own) is own
    of_machine = equations_of(machine)
    assert of_machine.system == machine.system and of_machine.values["u"] == 2.5
    for each in (own, of_machine):
        numbers = each.system.values(each.values)
        rates = Evaluator.of_rates(each.system)(np.zeros(1), np.full((len(each.system.states), 1), 0.3), numbers)
        assert np.isfinite(list(rates.values())).all()
        described = MACHINE_OR_SYSTEM.describe(each if each is own else machine)
        assert described.facts["parameters"] == dict(each.values) and described.dimensionless


def test_two_sets_of_equations_differ_by_their_structure() -> None:
    names = ("figure-2.10", "figure-2.11")
    one, other = (MACHINE_OR_SYSTEM.describe(load_equations(f"drozdetskaya-2020/{n}")).facts["structure"] for n in names)
    assert one != other
