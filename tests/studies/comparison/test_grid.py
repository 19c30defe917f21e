"""A question at every combination of values: each is the run of its own, whoever computes it; failures stand beside them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.refusals import Refusal, refused

import wucht

R1 = "drozdetskaya-2020/r1"
ASKED = wucht.RunUp(until=2.0, start={"p1": 0.3, "p2": -0.5})
SLOPES = np.array([0.0195, 0.039])


def test_each_place_has_the_run_of_its_values(tmp_path: Path) -> None:
    machine = wucht.load_machine(R1)
    vary = {"drive.slope": SLOPES, "drum.eccentricity": ["1 mm", "1.2 mm", "-1 mm"]}
    result = wucht.grid(ASKED, machine, vary, processes=2, folder=tmp_path)
    assert result.final_speed.dims == ("drive.slope", "drum.eccentricity")
    assert result["drum.eccentricity"].values.tolist() == pytest.approx([1e-3, 1.2e-3, -1e-3])
    assert (result["drum.eccentricity"].units, result.final_speed.units) == ("m", "rad/s")
    for slope in SLOPES:
        for eccentricity in (1e-3, 1.2e-3):
            alone = wucht.run(ASKED, machine.with_values({"drive.slope": slope, "drum.eccentricity": eccentricity}))
            there = result.sel({"drive.slope": slope, "drum.eccentricity": eccentricity})
            assert there.final_speed == alone.wucht.summary["final_speed"]
            assert there.outcome == alone.wucht.summary["outcome"] and there.failure == ""
    failed = result.sel({"drum.eccentricity": -1e-3})
    assert (failed.outcome == "failed").all() and failed.final_speed.isnull().all()
    assert all("eccentricity" in sentence for sentence in failed.failure.values)
    again = wucht.grid(ASKED, machine, vary, folder=tmp_path, resume=True)  # nothing is computed again
    assert again.identical(result)
    assert len(wucht.draw(wucht.load(tmp_path)).axes) >= 2


def test_keys_of_the_question_and_of_a_file_are_varied() -> None:
    settled = wucht.RunUp(until="settled", start=ASKED.start)
    result = wucht.grid(settled, R1, {"study.until": range(1, 3), "p1.kind": ["pendulum"], "study.start.p1": ["10 deg"]})
    assert result.final_speed.dims == ("study.until", "p1.kind", "study.start.p1")
    assert result["study.until"].values.tolist() == [1, 2] and result["study.start.p1"].units == "rad"
    alone = wucht.run(wucht.RunUp(until=1.0, start=ASKED.start | {"p1": np.radians(10)}), R1)
    assert result.final_speed.values[0, 0, 0] == pytest.approx(alone.wucht.summary["final_speed"], rel=1e-12)


@pytest.mark.parametrize(
    ("subject", "vary", "refusal"),
    [
        ("machine", {"drive.slop": [1.0]}, refused("drive.slop", "drive.slope", given=1.0)),
        (R1, {"drive.slop": [1.0]}, refused("machine.drive.slop", "slope", given=1.0, code="unknown-key", file="r1.toml")),
        ("machine", {"study.untl": [1.0]}, refused("study.untl", "until", given=1.0, code="unknown-key")),
        ("machine", {"drive.slope": 0.02}, refused("study.vary.drive.slope", given=0.02)),
        ("machine", {"drive.slope": []}, refused("study.vary.drive.slope", given=[])),
        ("machine", {}, refused("study.vary", given={})),
        ("machine", {"drive.slope": np.ones((1, 2))}, refused("drive.slope", given=[1.0, 1.0], code="no-quantity")),
        (3, {"drive.slope": [0.02]}, refused("machine", given=3)),
    ],
    ids=lambda value: "" if isinstance(value, Refusal) else str(value),
)
def test_what_is_refused(subject: Any, vary: Any, refusal: Refusal) -> None:
    with refusal:
        wucht.grid(ASKED, wucht.load_machine(R1) if subject == "machine" else subject, vary)


def test_a_name_is_a_subject() -> None:
    by_name = wucht.run(wucht.Response(), "practice/screen")
    assert by_name.wucht.summary == wucht.run(wucht.Response(), wucht.load_machine("practice/screen")).wucht.summary
    with refused("FILE", "practice/screen", given="practice/scren", code="unknown-name"):
        wucht.run(wucht.Response(), "practice/scren")
    with refused("machine", "law", file="screen.toml", code="unknown-key"):
        wucht.run(wucht.CamLaw(), "practice/screen")
