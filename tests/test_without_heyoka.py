"""Where heyoka is absent (Windows and macOS from PyPI), everything runs in machine code, else on SciPy, and gives the same."""

import importlib.util
import sys

import pytest
from tests import refusals

from wucht.errors import WuchtError
from wucht.files.catalogue import load_machine
from wucht.numerics.flow.compiled_system import available_engine, compile_system
from wucht.studies.run_up.spec import RunUp
from wucht.studies.runner import run
from wucht.studies.study_file import read_study


def hide(monkeypatch: pytest.MonkeyPatch, *packages: str) -> None:
    find = importlib.util.find_spec
    monkeypatch.setattr("wucht.numerics.flow.compiled_system.find_spec", lambda name: None if name in packages else find(name))
    compile_system.cache_clear()  # of systems that another engine was chosen for
    for package in packages:
        monkeypatch.setitem(sys.modules, package, None)  # an import would fail


@pytest.mark.parametrize(("hidden", "engine"), [(("heyoka",), "compiled"), (("heyoka", "llvmlite"), "scipy")])
def test_a_run_up_without_heyoka(monkeypatch: pytest.MonkeyPatch, hidden: tuple[str, ...], engine: str) -> None:
    if engine == "compiled":
        pytest.importorskip("llvmlite")
    hide(monkeypatch, *hidden)
    assert available_engine() == engine
    machine = load_machine("drozdetskaya-2020/r1-u80")
    question = {"until": 5.0, "start": {"p1": 0.3, "p2": -0.5}, "tolerance": 1e-11}
    result = run(RunUp(**question), machine)
    assert result.attrs["engine"] == engine
    assert result.attrs["outcome"] == "compensated"
    # Phases of cases.md; after 5 s 1e-4 rad of the way is left.
    phases = result.wucht.summary["final_phases"]
    assert phases["p1"] == pytest.approx(4.327992, abs=1e-3)
    assert phases["p2"] == pytest.approx(1.955193, abs=1e-3)
    assert result.wucht.summary["energy_residual"] < 1e-9


@pytest.mark.parametrize(("engine", "package"), [("heyoka", "heyoka"), ("compiled", "llvmlite")])
def test_an_engine_that_is_not_installed_is_refused(monkeypatch: pytest.MonkeyPatch, engine: str, package: str) -> None:
    hide(monkeypatch, package)
    with refusals.refused("study.engine", f"needs the package {package}, which is not installed", given=engine):
        read_study("drozdetskaya-2020/r1", {"study.engine": engine})
    with pytest.raises(WuchtError, match=f"needs the package {package}"):
        compile_system(load_machine("drozdetskaya-2020/r1").system, engine=engine)
