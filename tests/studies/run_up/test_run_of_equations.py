"""The study run-up of equations of a table [system]."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import wucht
from wucht.errors import InputError
from wucht.files.user_system import UserSystem, equations_from
from wucht.studies.registry import study_of

NORMAL_FORM = {"x": "x - 2*y - x*(x^2 + y^2)", "y": "2*x + y - y*(x^2 + y^2)"}


def subject(states: dict[str, str] | None = None, angles: tuple[str, ...] = ()) -> UserSystem:
    return equations_from({"states": states or NORMAL_FORM, "angles": list(angles)}, "normal form")


def test_its_summary_has_the_orbit_and_names_of_its_states() -> None:
    result = wucht.run(wucht.RunUp(start={"x": 0.1}), subject())
    summary = result.wucht.summary
    assert (summary["outcome"], summary["stable"]) == ("periodic", True)
    assert summary["period"] == pytest.approx(np.pi, rel=1e-9)
    assert summary["max"] == pytest.approx({"x": 1.0, "y": 1.0}, abs=1e-5)
    assert summary["lyapunov_exponent"]["value"] is None
    assert not {name for name in summary if "speed" in name or "amplitude" in name}
    assert result.states.dims == ("state", "time")
    assert result.states.sel(state="x").values[0] == 0.1
    radius = np.hypot(*result.states.values)
    assert radius == pytest.approx(1 / np.sqrt(1 + 99 * np.exp(-2 * result.time.values)), abs=1e-9)


def test_a_report_and_a_figure_are_made_from_the_dataset(tmp_path: Path) -> None:
    result = wucht.run(wucht.RunUp(start={"a": 0.5}), subject({"a": "w", "w": "1 - w"}, ("a",)))
    lines = study_of("run-up").report(result)
    assert lines[1].startswith("verdict: PERIODIC, the motion tends to a periodic orbit of period 6.283185")
    assert any("a +1 a period" in line for line in lines)
    fig = wucht.draw(result)
    assert [axis.get_ylabel() for axis in fig.axes] == ["a", "w", "w"]
    fig.savefig(tmp_path / "figure.png")


@pytest.mark.parametrize("key", [{"turns": 3}, {"over": "phi"}, {"model": "slow"}, {"along": "x", "values": [1.0]}])
def test_keys_of_machines_are_refused(key: dict[str, object]) -> None:
    with pytest.raises(InputError, match="allowed for a machine only"):
        wucht.run(wucht.RunUp(**key), subject())


def test_a_start_names_states() -> None:
    with pytest.raises(InputError, match="unknown state; did you mean 'x'"):
        wucht.run(wucht.RunUp(start={"xx": 1.0}), subject())
    with pytest.raises(InputError, match=r"start\.x"):
        wucht.run(wucht.RunUp(start={"x": {"speed": 1.0}}), subject())


def test_a_short_run_advises_a_longer_one() -> None:
    result = wucht.run(wucht.RunUp(until=0.5, start={"x": 0.1}), subject())
    assert result.wucht.summary["outcome"] == "unsettled"
    assert "study.until = 2 may tell" in json.loads(result.attrs["warnings"])[0]


def test_stored_samples_are_limited() -> None:
    result = wucht.run(wucht.RunUp(until=2.0, start={"x": 0.1}, stored_samples=101), subject())
    assert result.sizes["time"] <= 101
