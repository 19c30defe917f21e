"""Where heyoka is absent (Windows and macOS from PyPI), everything runs on SciPy and gives the same."""

import importlib.util
import sys

import pytest

from wucht.files.catalogue import load_machine
from wucht.numerics.flow.compiled_system import available_engine
from wucht.studies.run_up.spec import RunUp
from wucht.studies.runner import run


@pytest.fixture
def no_heyoka(monkeypatch: pytest.MonkeyPatch) -> None:
    find = importlib.util.find_spec
    monkeypatch.setattr("wucht.numerics.flow.compiled_system.find_spec", lambda name: None if name == "heyoka" else find(name))
    monkeypatch.setitem(sys.modules, "heyoka", None)  # an import would fail


@pytest.mark.usefixtures("no_heyoka")
def test_a_run_up_on_scipy_alone() -> None:
    assert available_engine() == "scipy"
    machine = load_machine("drozdetskaya-2020/r1-u80")
    question = {"until": 5.0, "start": {"p1": 0.3, "p2": -0.5}, "tolerance": 1e-11}
    result = run(RunUp(**question), machine)
    assert result.attrs["engine"] == "scipy"
    assert result.attrs["outcome"] == "compensated"
    # Phases of cases.md; after 5 s 1e-4 rad of the way is left.
    phases = result.wucht.summary["final_phases"]
    assert phases["p1"] == pytest.approx(4.327992, abs=1e-3)
    assert phases["p2"] == pytest.approx(1.955193, abs=1e-3)
    assert result.wucht.summary["energy_residual"] < 1e-9
