"""The study basin of equations of a table [system]."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from tests.refusals import check_refusal

import wucht
from wucht.files.user_system import UserSystem, equations_from

WELLS = {"x": "v", "v": "-0.5*v + x - x^3", "z": "-z"}
AXES = {"x": [-2.0, 2.0, 12], "v": [-2.0, 2.0, 10]}


def subject(states: dict[str, str]) -> UserSystem:
    return equations_from({"states": states}, "two wells")


def test_a_map_of_two_wells() -> None:
    result = wucht.run(wucht.Basin(axes=AXES, start={"z": 0.5}), subject(WELLS))
    s = result.wucht.summary
    assert s["fractions"] == {"equilibrium-1": 0.5, "equilibrium-2": 0.5}  # by symmetry
    assert sorted(a["state"]["x"] for a in s["attractors"]) == pytest.approx([-1, 1])
    assert [a["stable"] for a in s["attractors"]] == [True, True]
    assert result.outcome.shape == (10, 12)
    assert (result.outcome.values == result.outcome.values[::-1, ::-1]).sum() == 0  # the opposite start, the opposite well


def wells_of(result: xr.Dataset, name: str) -> np.ndarray:
    """The position of the attractor of each cell."""
    position = {a["label"]: a["state"]["x"] for a in result.wucht.summary["attractors"]}
    flags = dict(zip(result[name].flag_values.tolist(), result[name].flag_meanings.split(), strict=True))
    return np.vectorize(lambda k: position[flags[k]])(result[name].values)


def test_refined_borders_are_those_of_a_map_of_fine_cells() -> None:
    """Two halvings against a map of as fine cells: the same label in nearly every cell, with fewer runs."""
    few, fine = ({"x": [-2.0, 2.0, 8 * n], "v": [-2.0, 2.0, 6 * n]} for n in (1, 4))
    coarse, dense = (wucht.run(one, subject(WELLS)) for one in (wucht.Basin(axes=few, refine=2), wucht.Basin(axes=fine)))
    assert coarse.refined_outcome.shape == dense.outcome.shape == (24, 32)
    assert np.isclose(wells_of(coarse, "refined_outcome"), wells_of(dense, "outcome"), atol=0.01).mean() > 0.99
    assert 48 < coarse.wucht.summary["runs"] < dense.wucht.summary["runs"] == 768
    assert coarse.refined_x.values == pytest.approx(dense.x.values)
    s = coarse.wucht.summary
    assert s["uncertainty"]["equilibrium-1"] == pytest.approx(2 * s["standard_errors"]["equilibrium-1"])
    image = wucht.draw(coarse).axes[0].get_images()[0].get_array()
    assert image is not None and image.shape == (24, 32)


def test_shares_err_by_no_more_than_their_bound() -> None:
    """Of x from -1 to 2 two thirds lead to 1: on no grid is the border, x = 0, an edge of cells."""
    wells = subject({"x": "x - x^3", "y": "-y"})
    result = wucht.run(wucht.Basin(axes={"x": [-1.0, 2.0, 8], "y": [-1.0, 1.0, 4]}, refine=2), wells)
    s, right = result.wucht.summary, next(a["label"] for a in result.wucht.summary["attractors"] if a["state"]["x"] > 0)
    levels = s["levels"]
    assert [one["cells"] for one in levels] == [[8, 4], [16, 8], [32, 16]]
    for one in levels:
        assert 0 < abs(one["fractions"][right] - 2 / 3) <= one["bound"][right]
    assert [one["bound"][right] for one in levels] == pytest.approx([1 / 8, 1 / 16, 1 / 32]), "half of two columns of cells"
    assert (s["bound"], s["missing"]) == (levels[-1]["bound"], 0.0)
    assert s["runs"] == sum(one["runs"] for one in levels) < s["runs_of_dense_map"] == 512
    assert np.array_equal(np.unique(result.refined_level), [0, 1, 2])


def test_further_states_are_drawn_at_random() -> None:
    result = wucht.run(wucht.Basin(axes={"x": [-1.0, 1.0, 8], "y": [-1.0, 1.0, 8]}, ranges={"z": [-3.0, 1.0]}),
                       subject({"x": "-x", "y": "-y", "z": "z - z^3"}))  # fmt: skip
    s = result.wucht.summary
    share = next(a["share"] for a in s["attractors"] if a["state"]["z"] < 0)
    error = np.sqrt(0.75 * 0.25 / 64)
    assert share == pytest.approx(0.75, abs=3 * error)
    assert s["standard_errors"]["equilibrium-1"] == pytest.approx(np.sqrt(share * (1 - share) / 64))


@pytest.mark.parametrize(
    "keys",
    [
        {"axes": {"x": [-1.0, 1.0, 4], "w": [-1.0, 1.0, 4]}},
        {"axes": {"x": [1.0, -1.0, 4], "v": [-1.0, 1.0, 4]}},
        {"axes": AXES, "start": {"x": 1.0}},
        {"axes": AXES, "ranges": {"x": [0.0, 1.0]}},
        {"axes": AXES, "ranges": {"z": [1.0, 0.0]}},
        {"axes": AXES, "model": "slow"},
        {"axes": AXES, "ranges": {"z": [0.0, 1.0]}, "refine": 1},
    ],
)
def test_questions_that_do_not_fit_are_refused(keys: dict[str, object]) -> None:
    check_refusal(f"basin of equations: {keys}", lambda: wucht.run(wucht.Basin(**keys), subject(WELLS)))


def test_a_hamiltonian_system_is_refused() -> None:
    henon_heiles = {"x": "u", "y": "v", "u": "-x - 2*x*y", "v": "-y - x^2 + y^2"}
    question = wucht.Basin(axes={"x": [-1.0, 1.0, 4], "y": [-1.0, 1.0, 4]})
    check_refusal("basin of equations: Henon-Heiles", lambda: wucht.run(question, subject(henon_heiles)))


def test_four_basins_of_equal_shape_have_equal_shares() -> None:
    """Of 6 x 6 cells some centres lie on the equilibria; of 5 x 5 those in the middle lie between the basins."""
    wells = subject({"x": "x - x^3", "y": "y - y^3"})
    even, odd = (wucht.run(wucht.Basin(axes={"x": [-2, 2, n], "y": [-2, 2, n]}), wells) for n in (6, 5))
    assert sorted(even.wucht.summary["fractions"].values()) == [0.25] * 4
    assert (even.wucht.summary["failures"], even.wucht.warnings) == (0, [])
    s = odd.wucht.summary
    stable = [a for a in s["attractors"] if a["stable"]]
    assert [a["share"] for a in stable] == pytest.approx([4 / 25] * 4)
    for a in stable:  # of the area it is a quarter
        assert a["share"] + s["uncertainty"][a["label"]] >= 0.25
    unstable = [a for a in s["attractors"] if not a["stable"]]
    assert sum(a["share"] for a in unstable) == pytest.approx(9 / 25)
    assert all(s["uncertainty"][a["label"]] == pytest.approx(a["share"]) for a in unstable)  # of the area it is nothing


def test_a_saddle_is_drawn_and_named_apart_from_attractors() -> None:
    """Of y' = y - y^3 in x' = -x: 0 is reached from the middle row of cells, the line y = 0; the rest belongs to 1 and -1."""
    result = wucht.run(wucht.Basin(axes={"x": [-2, 2, 5], "y": [-2, 2, 5]}), subject({"x": "-x", "y": "y - y^3"}))
    assert result.attrs["sentence"].endswith(", 20 % of the starts end in the saddle equilibrium-3")
    (axis,) = wucht.draw(result).axes
    places = {(line.get_marker(), round(float(line.get_ydata()[0]), 6)) for line in axis.lines}
    assert places == {("o", 1.0), ("o", -1.0), ("x", 0.0)}
    assert wucht.report(result)


def test_runs_that_fail_have_a_warning_with_the_reason() -> None:
    """For y > 0 x slides along a jump of its rate."""
    slides = subject({"x": "-sign(x)*(1 + sign(y)) - (1 - sign(y))*(x - 3)", "y": "y - y^3"})
    result = wucht.run(wucht.Basin(axes={"x": [1, 2, 2], "y": [-1, 1, 4]}), slides)
    s = result.wucht.summary
    assert (s["fractions"], s["failures"]) == ({"equilibrium": 0.5, "failed": 0.5}, 4)
    assert "slides along a jump" in result.wucht.warnings[0]
    assert result.wucht.warnings[-1] == "1 more runs failed"
