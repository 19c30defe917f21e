"""Equal bodies that keep equal phases, with and without their inertia; and which of the two is the default."""

from __future__ import annotations

import numpy as np
import pytest
from tests.refusals import refused

from wucht.analysis.averaged_machine import averaged_machine, keeps_inertia
from wucht.analysis.sections import section_of
from wucht.files.catalogue import load_machine
from wucht.machines.operation import machine_at_speed
from wucht.numerics.flow.program import Evaluator

R2, TABLE = "drozdetskaya-2020/r2", "drozdetskaya-2020/table-5.1"


def test_inertia_is_kept_but_for_the_dimensionless_machines() -> None:
    real, printed = load_machine(R2), load_machine(TABLE)
    assert [keeps_inertia(m, None) for m in (real, printed)] == [True, False]
    assert [keeps_inertia(m, asked) for m in (real, printed) for asked in (True, False)] == [True, False, True, False]
    with refused("study.inertia", given=False):
        keeps_inertia(load_machine(R2, {"p1.damping": 0.0}), False)


@pytest.mark.parametrize(("inertia", "count"), [(True, 3), (False, 2)])
def test_a_section_has_the_rates_of_the_whole(inertia: bool, count: int) -> None:
    """Embedded, its rates are those of the averaged equations with equal phases and slips."""
    slow = averaged_machine(machine_at_speed(load_machine(R2), None), inertia)
    made = section_of(slow, True)
    assert made.embedding.shape == (len(slow.system.states), count) and made.inertia is inertia
    x = np.array([[0.4, 90.0, 88.0][:count]]).T
    own = Evaluator.of_rates(made.system).array(np.zeros(1), x, made.system.values(made.values))
    whole = Evaluator.of_rates(made.whole).array(np.zeros(1), made.embedding @ x, made.whole.values(made.values))
    assert made.embedding @ own == pytest.approx(whole, rel=1e-9)
    assert np.abs(own).max() > 1e-3


def test_bodies_that_differ_do_not_keep_together_with_inertia_either() -> None:
    slow = averaged_machine(machine_at_speed(load_machine(R2, {"p2.mass": 0.13}), None))
    with refused("study.together", "p1", "p2", code="phases-part"):
        section_of(slow, True)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_speed_that_a_drive_prescribes_is_that_of_the_section(sense: float) -> None:
    """Signed, for every state; the phases alone are its axes."""
    rollers = load_machine("sperling-rollers/table-1")
    given = rollers.values["drive.speed"]
    slow = averaged_machine(machine_at_speed(rollers.with_values({"drive.speed": sense * given}), None))
    made = section_of(slow, None)
    assert made.turning == -1 and made.speed == pytest.approx(sense * given)
    assert made.rotor_speed(np.zeros((len(made.axes), 3))) == pytest.approx(np.full(3, sense * given))
