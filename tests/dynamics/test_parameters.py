"""The parameters that studies vary, of a machine and of one's own equations."""

from __future__ import annotations

import pytest
from tests.refusals import refused

from wucht.dynamics.parameters import checked_range, parameter_of, values_of
from wucht.errors import InputError
from wucht.files.catalogue import load_equations, load_machine

MACHINE = load_machine("drozdetskaya-2020/table-5.1")
OWN = load_equations("drozdetskaya-2020/figure-2.13")


def test_the_ends_of_a_range() -> None:
    """A support damps by at least 0; the parameters of one's own equations are any numbers."""
    assert checked_range(MACHINE, parameter_of(MACHINE, "sigma"), (0.0, 1.0)) == (0.0, 1.0)
    assert checked_range(OWN, parameter_of(OWN, "mu"), (-1.0, 1.0)) == (-1.0, 1.0)
    with refused("study.second_range[0]", code="limits") as raised:
        checked_range(MACHINE, parameter_of(MACHINE, "sigma"), (-1.0, 1.0), "second_range")
    assert raised.value.location == "study.second_range[0]"
    with refused("study.range", given=[1.0, -1.0]) as raised:
        checked_range(OWN, parameter_of(OWN, "mu"), (1.0, -1.0))
    assert raised.value.location == "study.range"


def test_values_and_the_subject_with_them() -> None:
    for subject, path in ((MACHINE, "sigma"), (OWN, "mu")):
        (value,) = values_of(subject, parameter_of(subject, path), (0.3,))
        assert subject.with_values({path: value}).values == {**subject.values, path: 0.3}
        with pytest.raises(InputError) as raised:
            parameter_of(subject, "nu", "second")
        assert raised.value.location == "study.second"
    with refused("study.values[1]", code="limits") as raised:
        values_of(MACHINE, parameter_of(MACHINE, "sigma"), (0.3, -0.3))
    assert raised.value.location == "study.values[1]"
