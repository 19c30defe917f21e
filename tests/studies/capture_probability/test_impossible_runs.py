"""Random starts and values that some machines cannot have: arrangements on a track have none, other ones are left out."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.refusals import refused

from interrupting import assert_same, stop_at
from known_borders import rail
from wucht import CaptureProbability, draw, report, run
from wucht.files.building import machine_from

KEYS: dict[str, Any] = {"along": "drive.slope", "range": [0.01, 0.012], "points": 2, "samples": 16}
ANYWHERE = {"b1": {"uniform": [0.0, 2 * math.pi]}}


def asked(**keys: Any) -> xr.Dataset:
    return run(CaptureProbability(**KEYS | keys), rail())


def test_where_balls_overlap_the_probability_is_that_of_the_other_starts() -> None:
    """A third of the places is taken. All other starts get through: of n of these the bound is 0.025^(1/n)."""
    result = asked(random=ANYWHERE, start={"b2": 0.0})
    s = result.wucht.summary
    for row in s["probability"]:
        possible = round(16 * (1 - row["impossible"]))
        assert row["impossible"] == row["fractions"]["failed"] == pytest.approx(1 / 3, abs=0.2)
        assert (row["estimate"], row["high"], row["not_identified"]) == (1.0, 1.0, 0.0)
        assert row["low"] == pytest.approx(0.025 ** (1 / possible))
    assert s["impossible"] == round(16 * sum(row["impossible"] for row in s["probability"]))
    assert f"{100 * s['probability'][0]['impossible']:.4g} % of the runs cannot be made" in "\n".join(report(result))
    (told,) = (w for w in result.wucht.warnings if "left out" in w)
    assert "cannot be made: they are left out, and the probability is that of the other ones" in told
    assert told.endswith('; random = { "tracks.ring" = "uniform" } draws arrangements in which no bodies overlap')
    assert sum("failed: 'b" in w for w in result.wucht.warnings) == 3
    assert draw(result).axes


def test_an_arrangement_has_no_impossible_start() -> None:
    result = asked(random={"tracks": {"ring": "uniform"}}, samples=8)
    s = result.wucht.summary
    assert (s["impossible"], s["runs"], s["replicates"]) == (0, 16, 8)
    for row in s["probability"]:
        assert (row["estimate"], row["low"]) == (1.0, pytest.approx(0.025 ** (1 / 8))) and "impossible" not in row
    assert s["random"] == {"tracks.ring": "uniform: bodies without overlap, in any order"}
    assert not any("failed" in w or "power of two" in w for w in result.wucht.warnings)
    assert "b1" not in " ".join(report(result)), "no body starts at a place of its own"


def test_values_that_do_not_go_together_are_counted() -> None:
    """A ball of a radius of 30 to 59 mm in a track of 30 to 70 mm: it must be smaller, P = 14.5/40 that it is not."""
    ball = {"kind": "roller", "name": "b", "about": "drum", "mass": 0.1, "track_radius": 0.06, "radius": 0.02}
    drum = {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 1e-3, "inertia": 1e-2}
    machine = machine_from({
        "carrier": {"mass": 1.0, "stiffness": 1e4, "damping": 20.0},
        "bodies": [drum, ball | {"shape_factor": 0.4, "damping": 0.01}],
        "drive": {"kind": "linear", "slope": 0.01, "no_load_speed": 30.0},
    })  # fmt: skip
    random = {"b.radius": {"uniform": [0.03, 0.059]}, "b.track_radius": {"uniform": [0.03, 0.07]}}
    result = run(CaptureProbability(**KEYS | {"random": random, "samples": 64}), machine)
    s = result.wucht.summary
    share = s["probability"][0]["impossible"]
    assert share == pytest.approx(14.5 / 40, abs=0.03) and s["impossible"] == 2 * round(64 * share)
    assert s["probability"][0]["not_identified"] < 0.1 and s["probability"][0]["low"] > 0.8
    failed = [w for w in result.wucht.warnings if " failed: " in w]
    assert len(failed) == 3
    for sentence in failed:
        radius, track = (
            float(sentence.partition(f"b.{key} = ")[2].split()[0].rstrip(",")) for key in ("radius", "track_radius")
        )
        assert radius >= track


def test_where_no_start_is_possible_the_question_is_refused() -> None:
    with refused("study.start.b1", "overlap"):
        asked(random={"b1": {"uniform": [0.0, 0.5]}}, start={"b2": 0.0})


def test_every_batch_is_an_answer_and_is_kept(tmp_path: Path) -> None:
    """16 runs at both values, then 16 more, then 32: stopped in the second batch, it has an answer and goes on from there."""
    question = CaptureProbability(**KEYS | {"random": {"tracks.ring": "uniform"}, "samples": 64, "until": 20.0})
    labels: list[str] = []
    whole = run(question, rail(), progress=lambda _, label: labels.append(label))
    first, second, third, fourth, *more = dict.fromkeys(labels)
    assert (first, second, more[-1], len(more)) == ("drive.slope = 0.01", "drive.slope = 0.012", "", 3)
    assert third.startswith("drive.slope = 0.01 (") and fourth.startswith("drive.slope = 0.012 (")
    part = run(question, rail(), folder=tmp_path, progress=stop_at(1, during="drive.slope = 0.012 ("))
    s = part.wucht.summary
    assert not part.attrs["finished"]
    assert (s["runs"], s["values"], s["samples"]) == (32 + 16, [2, 2], 64)
    assert f"= 0.012 ({100 * s['probability'][1]['low']:.3g} to 100 % so far)" in fourth
    assert s["probability"][1]["low"] == pytest.approx(float(whole.low[1]), abs=0.2)
    assert "64 at each of 2 values; fewer so far at 2 of them" in "\n".join(report(part))
    labels.clear()
    resumed = run(question, rail(), folder=tmp_path, resume=True, progress=lambda _, label: labels.append(label))
    assert_same(whole, resumed)
    shares = list[float]()
    run(question, rail(), progress=lambda share, _: shares.append(share))
    assert np.all(np.diff(shares) >= 0)
