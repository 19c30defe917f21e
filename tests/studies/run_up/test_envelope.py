"""The stored amplitude of a run, from its first sample to its last."""

import numpy as np
import pytest

from wucht import RunUp
from wucht.files.catalogue import load_machine
from wucht.studies.runner import run


@pytest.mark.parametrize("until", [900.0, 901.0, 902.0])
def test_the_amplitude_is_as_large_at_both_ends_as_it_should_be(until: float) -> None:
    """Wherever the end cuts the vibration along one direction; and from rest it begins at rest."""
    machine = load_machine("drozdetskaya-2020/table-3.1-carrier").with_values({"u": 2.0})
    amplitude = run(RunUp(until=until), machine).amplitude.values
    assert amplitude[-100:] == pytest.approx(4.6146, rel=1e-3)
    assert amplitude[0] < 1e-6 < amplitude[10]
    assert (np.diff(amplitude[:10]) > 0).all()
