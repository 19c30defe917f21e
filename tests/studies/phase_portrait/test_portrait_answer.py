"""What is answered of portraits whose points and curves are known: side by side, in words, and drawn."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.contour import QuadContourSet

import wucht
from wucht import UserSystem
from wucht.files.user_system import equations_from

TURN = 2 * math.pi
SQUARE = {"x": (-2, 2), "y": (-2, 2)}
FORK = {"states": {"x": "mu*x - x^3", "y": "-2*y"}, "parameters": {"mu": 1.0}}
PENDULUM = {"states": {"w": "-sin(psi) - d*w", "psi": "w"}, "angles": ["psi"], "parameters": {"d": 0.2}}
ROUND = {"states": {"x": "x - y - x*(x^2 + y^2)", "y": "x + y - y*(x^2 + y^2)"}}


def answered(subject: UserSystem, **keys: Any) -> xr.Dataset:
    return wucht.run(wucht.PhasePortrait(**{"trajectories": 0, **keys}), subject)


@pytest.fixture(scope="module")
def forks() -> xr.Dataset:
    """A pitchfork: before it one node, beyond it a saddle between two."""
    start = [{"x": 0.3, "y": 1.0}]
    return answered(equations_from(FORK), ranges=SQUARE, along="mu", values=[-1.0, 1.0], trajectories=start)


@pytest.fixture(scope="module")
def pendulum() -> xr.Dataset:
    return answered(equations_from(PENDULUM), ranges={"w": (-3, 3)}, trajectories=[{"w": 0.0, "psi": 0.5}], nullclines=True)


# --- the Dataset ---


def test_points_of_several_portraits_side_by_side(forks: xr.Dataset) -> None:
    nan = math.nan
    kinds = forks.fixed_point_kind.values
    order = np.argsort(forks.fixed_points.values[1, :, 0])
    assert forks.fixed_points.values[0] == pytest.approx(np.array([[0, 0], [nan, nan], [nan, nan]]), nan_ok=True, abs=1e-9)
    assert forks.fixed_points.values[1][order] == pytest.approx(np.array([[-1, 0], [0, 0], [1, 0]]), abs=1e-9)
    assert kinds[0].tolist() == ["stable node", "", ""]
    assert kinds[1][order].tolist() == ["stable node", "saddle", "stable node"]
    values = np.sort(forks.eigenvalues_real.values, axis=2)
    assert values[0, 0] == pytest.approx([-2, -1]) and np.isnan(values[0, 1:]).all()
    assert values[1][order] == pytest.approx(np.array([[-2, -2], [-2, 1], [-2, -2]]))
    assert np.nanmax(np.abs(forks.eigenvalues_imag.values)) == 0 and np.isnan(forks.transverse_growth.values).all()
    assert forks.case.values.tolist() == ["mu = -1", "mu = 1"] and forks.value.values.tolist() == [-1.0, 1.0]
    assert forks.turn.values.tolist() == [0.0, 0.0] and forks.attrs["abscissa"] == 0


def test_curves_of_several_portraits_side_by_side(forks: xr.Dataset) -> None:
    """A trajectory is one curve in the order of time: what was followed backwards comes first, its start once."""
    for case, end in enumerate((0.0, 1.0)):
        curve = forks.trajectories.values[case, 0]
        curve = curve[:, np.isfinite(curve).all(axis=0)]
        begin = int(forks.trajectory_start.values[case, 0])
        assert curve[:, begin].tolist() == [0.3, 1.0]
        assert (np.diff(curve[1]) < 0).all(), "y decays"
        assert np.diff(curve[0]).max() < 0 if case == 0 else np.diff(curve[0]).min() > 0
        assert curve[:, -1] == pytest.approx([end, 0.0], abs=0.05)
        kind, number = str(forks.trajectory_end.values[case, 0]).rsplit(" ", 1)
        assert kind == "stable node" and forks.fixed_points.values[case, int(number) - 1, 0] == pytest.approx(end, abs=1e-9)
    saddle = forks.fixed_point_kind.values[1].tolist().index("saddle")
    assert np.isnan(forks.separatrices.values[0]).all() and forks.separatrices.shape[:3] == (2, 4, 2)
    assert forks.separatrix_saddle.values[1].tolist() == [saddle] * 4 and np.isnan(forks.separatrix_saddle.values[0]).all()
    assert forks.separatrix_stable.values[1].tolist() == [0.0, 0.0, 1.0, 1.0]
    assert forks.separatrix_end.values[0].tolist() == [""] * 4
    assert forks.separatrix_end.values[1, 2:].tolist() == ["left the window"] * 2
    assert {str(end)[:-2] for end in forks.separatrix_end.values[1, :2]} == {"stable node"}


def test_a_closed_curve_of_known_period_and_multiplier() -> None:
    result = answered(equations_from(ROUND), ranges=SQUARE)
    (curve,) = result.wucht.summary["closed_curves"]
    assert (curve["kind"], curve["period"], curve["turns"]) == ("stable", pytest.approx(TURN, rel=1e-7), [0.0, 0.0])
    assert curve["multiplier"] == pytest.approx(math.exp(-2 * TURN), rel=1e-2)
    assert (curve["min"], curve["max"]) == (
        {n: pytest.approx(-1.0, abs=1e-3) for n in "xy"}, {n: pytest.approx(1.0, abs=1e-3) for n in "xy"}
    )  # fmt: skip
    assert result.closed_curve_kind.values.tolist() == ["stable"] and result.closed_curve_period.values == pytest.approx([TURN])
    assert wucht.report(result)[2:4] == [
        "  1 unstable focus  x 0, y 0; eigenvalues 1+1i, 1-1i", "  closed curve 1: stable, period 6.283185",
    ]  # fmt: skip
    axis = wucht.draw(result).axes[0]
    (line,) = [x for x in axis.lines if x.get_linewidth() == 2.8]
    assert np.hypot(*np.asarray(line.get_xydata(), float).T) == pytest.approx(1.0, abs=1e-3) and line.get_linestyle() == "-"
    unstable = wucht.draw(result.assign(closed_curve_kind=result.closed_curve_kind.copy(data=["unstable"]))).axes[0]
    assert [x.get_linestyle() for x in unstable.lines if x.get_linewidth() == 2.8] == [":"]


def test_angles_are_in_half_a_turn_to_either_side(pendulum: xr.Dataset) -> None:
    """The angle, the second state, is the abscissa, over two turns."""
    states = {p["kind"]: p["state"] for p in pendulum.wucht.summary["fixed_points"]}
    assert states["stable focus"] == {"w": pytest.approx(0, abs=1e-9), "psi": pytest.approx(0, abs=1e-9)}
    assert states["saddle"]["psi"] == pytest.approx(math.pi)
    assert pendulum.attrs["abscissa"] == 1 and pendulum.turn.values.tolist() == [0.0, TURN]
    assert pendulum.drawn.values == pytest.approx(np.array([[-3, 3], [0, 2 * TURN]]))
    torus = equations_from({"states": {"a": "-sin(a)", "b": "-sin(b)"}, "angles": ["a", "b"]})
    both = answered(torus)
    assert both.drawn.values == pytest.approx(np.array([[0, TURN]] * 2)) and both.attrs["abscissa"] == 0
    given = answered(equations_from(PENDULUM), ranges={"w": (-3, 3), "psi": (-1, 1)})
    assert given.drawn.values[1] == pytest.approx([-1, 1])


def test_rates_lie_over_the_panel_as_it_is_drawn(pendulum: xr.Dataset) -> None:
    """Rows go up the ordinate, the first state here, columns along the abscissa, the angle."""
    w, psi = np.linspace(-3.0, 3.0, 161), np.linspace(0.0, 2 * TURN, 161)
    assert pendulum.rate.dims == ("state", "ordinate", "abscissa")
    np.testing.assert_allclose(pendulum.rate.values[0], -np.sin(psi)[None] - 0.2 * w[:, None], atol=1e-12)
    np.testing.assert_allclose(pendulum.rate.values[1], np.repeat(w[:, None], 161, axis=1), atol=1e-12)


def test_starts_are_spread_by_the_plastic_number() -> None:
    """Roberts' sequence: each start is 1/g and 1/g^2 of the window farther on than the last one, g^3 = g + 1."""
    real = float(np.roots([1.0, 0.0, -1.0, -1.0])[0].real)
    own = equations_from({"states": {"x": "-x", "y": "-y"}})
    firsts = []
    for seed in (0, 1):
        result = answered(own, ranges={"x": (-1, 3), "y": (-2, 2)}, trajectories=12, seed=seed)
        begin = result.trajectory_start.values.astype(int)
        places = np.array([result.trajectories.values[k, :, i] for k, i in enumerate(begin)]).T
        shares = (places - [[-1.0], [-2.0]]) / 4
        assert (shares >= 0).all() and (shares < 1).all()
        assert np.diff(shares, axis=1) % 1 == pytest.approx(np.repeat([[1 / real], [1 / real**2]], 11, axis=1))
        firsts.append(shares[:, 0])
    assert firsts[0] != pytest.approx(firsts[1])


def test_each_portrait_is_doubted_by_its_name() -> None:
    keys = {"ranges": SQUARE, "along": "mu", "values": [-1.0, 1.0]}
    short = answered(equations_from(FORK), length=0.1, **keys).wucht.warnings
    words = "some curves were stopped after 0.1 windows: study.length follows them further"
    assert short == [f"mu = 1: {words}"], "without a saddle there is no curve"
    drawn = answered(equations_from(FORK), length=0.1, trajectories=1, **keys).wucht.warnings
    assert drawn == [f"mu = -1: {words}", f"mu = 1: {words}"]


def test_a_connection_of_saddles_is_doubted() -> None:
    free = equations_from(PENDULUM | {"set": {"d": 0.0}})
    (warning,) = [w for w in answered(free, ranges={"w": (-3, 3)}).wucht.warnings if "saddle" in w]
    assert warning == "a separatrix leads to a saddle: the least change of a parameter breaks this connection"


@pytest.mark.slow
def test_a_machine_over_the_angle_of_its_rotor() -> None:
    """Its equations have no mean motion of their own time: eigenvalues over the angle are those over the speed there."""
    machine = wucht.load_machine("drozdetskaya-2020/table-5.1", {"u": 7.0})
    result = answered(machine, together=True, ranges={"speed": (0.4, 2.2)})
    for p in result.wucht.summary["fixed_points"]:
        for own in ("eigenvalues", "transverse"):
            assert np.array(p[f"{own}_phi"]) * p["state"]["speed"] == pytest.approx(np.array(p[own]), rel=1e-9)
    node = next(p for p in result.wucht.summary["fixed_points"] if p["kind"] == "stable node")
    assert node["transverse"][0][0] > 0 and node["stable"] is False, "it is left across the section"
    assert float(np.nanmax(result.transverse_growth)) >= node["transverse"][0][0]
    assert any("; out of the section " in line for line in wucht.report(result))


# --- the report ---


def test_where_a_manifold_comes_from_or_goes() -> None:
    back = wucht.report(answered(equations_from({"states": {"x": "x^3 - x", "y": "2*y"}}), ranges=SQUARE))
    assert sum("stable manifold, one side: comes from unstable node " in line for line in back) == 1
    assert sum("unstable manifold, other side: leaves the window" in line for line in back) == 1
    short = wucht.report(answered(equations_from(FORK), ranges=SQUARE, length=0.1))
    assert sum(": followed no further: " in line for line in short) == 2


# --- the figure ---


def test_the_angle_is_drawn_to_the_right_in_all_turns_that_are_visible(pendulum: xr.Dataset) -> None:
    axis = wucht.draw(pendulum).axes[0]
    single = [x for x in axis.lines if len(x.get_xdata()) == 1 and abs(x.get_ydata()[0]) < 1e-6]
    saddles, foci = (sorted(x.get_xdata()[0] for x in single if x.get_marker() == marker) for marker in "xo")
    assert saddles == pytest.approx([math.pi, 3 * math.pi]) and foci == pytest.approx([0, TURN, 2 * TURN], abs=1e-6)
    one_turn = pendulum.copy(deep=True)
    one_turn.drawn.values[1] = 0.0, TURN
    assert wucht.draw(one_turn).axes[0].get_xticks() == pytest.approx(math.pi / 2 * np.arange(5))


@pytest.mark.parametrize(
    ("kind", "growth", "marker", "fill"),
    [("stable node", math.nan, "o", "full"), ("stable focus", 0.5, "o", "bottom"), ("unstable focus", -0.5, "o", "full"),
     ("saddle", 0.5, "x", "full"), ("centre", -0.5, "o", "none")],
)  # fmt: skip
def test_symbols_of_fixed_points(kind: str, growth: float, marker: str, fill: str) -> None:
    """Filled where stable, half filled where only the section is, a cross at the saddle."""
    result = answered(equations_from({"states": {"x": "-x", "y": "-2*y"}}), ranges=SQUARE)
    other = {"fixed_point_kind": [kind], "transverse_growth": [growth]}
    changed = result.assign({name: result[name].copy(data=np.array(values)) for name, values in other.items()})
    (point,) = [x for x in wucht.draw(changed).axes[0].lines if len(x.get_xdata()) == 1]
    assert (point.get_marker(), point.get_fillstyle()) == (marker, fill)
    assert kind != "unstable focus" or point.get_markerfacecolor() == "white"


def test_without_a_fixed_point() -> None:
    nothing = answered(equations_from({"states": {"x": "1", "y": "-y"}}), ranges=SQUARE)
    assert nothing.attrs["sentence"] == "no fixed point (proved)"
    assert nothing.fixed_points.shape == (0, 2) == nothing.eigenvalues_real.shape
    assert nothing.separatrices.shape == (0, 2, 0) and nothing.trajectory_end.shape == (0,)
    assert wucht.draw(nothing).axes


def test_nullclines(pendulum: xr.Dataset) -> None:
    contours = [c for c in wucht.draw(pendulum).axes[0].collections if isinstance(c, QuadContourSet)]
    angle, speed = (np.concatenate([p.vertices for p in c.get_paths()]) for c in contours)
    assert angle[:, 1] == pytest.approx(0.0, abs=1e-9) and np.ptp(angle[:, 0]) == pytest.approx(2 * TURN), "of the angle, first"
    assert speed[:, 1] == pytest.approx(-np.sin(speed[:, 0]) / 0.2, abs=0.02)


def test_arrows_point_the_way_of_time() -> None:
    """Those of both manifolds of a saddle away from it and to it, each in the middle of what is visible of its curve."""
    own = equations_from({"states": {"x": "x", "y": "-y"}})
    window = {"x": (-1, 1), "y": (-1, 1)}
    axis = wucht.draw(answered(own, trajectories=[{"x": 0.3, "y": 0.3}], ranges=window)).axes[0]
    arrows = [(np.array(t.xyann), np.array(t.xy)) for t in axis.texts if t.arrow_patch is not None]
    assert len(arrows) == 5
    for tail, head in arrows:
        (x, y), (dx, dy) = tail, head - tail
        assert dx * x >= 0 and dy * y <= 0 and abs(dx) + abs(dy) > 0
    result = answered(equations_from({"states": {"x": "1", "y": "-y"}}), ranges=window, trajectories=[{"x": 0.9, "y": 0.0}])
    ((begin, end),) = [(t.xyann[0], t.xy[0]) for t in wucht.draw(result).axes[0].texts if t.arrow_patch is not None]
    assert begin == pytest.approx(0.0, abs=0.1) and begin < end < begin + 0.3
    result.drawn.values[0] = 0.0, 40.0  # what is left of the curve is short
    assert [t for t in wucht.draw(result).axes[0].texts if t.arrow_patch is not None] == []
