"""Equal bodies that keep equal phases, with and without their inertia; and which of the two is the default."""

from __future__ import annotations

import numpy as np
import pytest
from tests.refusals import Refusal, refused

from wucht.analysis.averaged_equations import AveragedEquations, averaged_equations_of, keeps_inertia
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
    averaged_equations = averaged_equations_of(machine_at_speed(load_machine(R2), None), inertia)
    made = section_of(averaged_equations, True)
    assert made.embedding.shape == (len(averaged_equations.system.states), count) and made.inertia is inertia
    x = np.array([[0.4, 90.0, 88.0][:count]]).T
    own = Evaluator.of_rates(made.system).array(np.zeros(1), x, made.system.values(made.values))
    whole = Evaluator.of_rates(made.whole).array(np.zeros(1), made.embedding @ x, made.whole.values(made.values))
    assert made.embedding @ own == pytest.approx(whole, rel=1e-9)
    assert np.abs(own).max() > 1e-3


@pytest.mark.parametrize(("change", "inertia"), [({"p2.mass": 0.13}, True), ({"p1.damping": 0.2}, False)])
def test_bodies_that_differ_do_not_keep_together(change: dict[str, float], inertia: bool) -> None:
    averaged_equations = averaged_equations_of(machine_at_speed(load_machine(R2, change), None), inertia)
    with refused("study.together", "p1", "p2", code="phases-part"):
        section_of(averaged_equations, True)


def without_inertia(sense: float = 1.0, **values: float) -> AveragedEquations:
    machine = load_machine(R2, {"drive.no_load_speed": sense * 200.0} | values)
    return averaged_equations_of(machine_at_speed(machine, None), False)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_section_has_the_machines_senses(sense: float) -> None:
    """Clockwise its states are those of the averaged equations with the other sign; its rotor's speed is signed."""
    slow = without_inertia(sense)
    made = section_of(slow, True)
    assert np.abs(made.embedding).sum(axis=0).tolist() == [2, 1]
    assert np.unique(made.embedding).tolist() == sorted({0.0, sense})
    states = np.array([[0.4, 2.0], [sense * 90.0, sense * 50.0]])
    assert made.rotor_speed(states).tolist() == [sense * 90.0, sense * 50.0]
    here = Evaluator.of_rates(made.system).array(np.zeros(2), states, made.system.values(made.values))
    whole = Evaluator.of_rates(made.whole).array(np.zeros(2), made.embedding @ states, made.whole.values(made.values))
    assert made.embedding @ here == pytest.approx(whole, rel=1e-9)


def test_directions_out_of_a_section_are_those_of_unequal_phases() -> None:
    """The Jacobian of the whole, by differences, along p1 against p2: its only direction without inertia."""
    made = section_of(without_inertia(), True)
    state, h = np.array([0.4, 90.0]), 1e-6
    at, out = made.embedding @ state, np.array([1.0, -1.0, 0.0]) / np.sqrt(2)
    (phases,) = np.nonzero(made.embedding[:, 0])
    out = np.zeros(3)
    out[phases] = np.array([1.0, -1.0]) / np.sqrt(2)
    moved = np.stack([at + h * out, at - h * out], axis=1)
    rates = Evaluator.of_rates(made.whole).array(np.zeros(2), moved, made.whole.values(made.values))
    assert made.transverse(state) == pytest.approx([out @ (rates[:, 0] - rates[:, 1]) / (2 * h)], rel=1e-5)
    assert len(section_of(without_inertia(), None).transverse(np.array([0.4, 0.5, 90.0]))) == 0


@pytest.mark.parametrize(
    ("together", "refusal"),
    [
        (["p1", "p3"], refused("study.together", "p2", given="p3")),
        (["drum", "p1"], refused("study.together", given="drum")),
        (["p1"], refused("study.together", "p1", "p2", given=["p1"])),
    ],
)
def test_bodies_that_stay_together_are_two_or_more_about_a_rotor(together: list[str], refusal: Refusal) -> None:
    with refusal:
        section_of(without_inertia(), together)


def test_a_speed_that_is_fixed_is_in_the_rotors_sense() -> None:
    """A parameter of the equations, positive in that sense; the speed of the section is signed."""
    for sense in (1.0, -1.0):
        machine = machine_at_speed(load_machine(R2, {"drive.no_load_speed": sense * 200.0}), None)
        averaged_equations = averaged_equations_of(machine, False, has_fixed_speed=True)
        made = section_of(averaged_equations, True, sense * 75.0)
        assert made.values["speed"] == 75.0
        assert made.turning == -1
        assert made.rotor_speed(np.zeros((1, 2))).tolist() == [sense * 75.0] * 2
        assert [a.name for a in made.axes] == ["psi"]


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_speed_that_a_drive_prescribes_is_that_of_the_section(sense: float) -> None:
    """Signed, for every state; the phases alone are its axes."""
    rollers = load_machine("sperling-rollers/table-1")
    given = rollers.values["drive.speed"]
    averaged_equations = averaged_equations_of(machine_at_speed(rollers.with_values({"drive.speed": sense * given}), None))
    made = section_of(averaged_equations, None)
    assert made.turning == -1 and made.speed == pytest.approx(sense * given)
    assert made.rotor_speed(np.zeros((len(made.axes), 3))) == pytest.approx(np.full(3, sense * given))
