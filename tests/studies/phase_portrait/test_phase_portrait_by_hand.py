"""Two portraits that are made by hand: each variable, each line of the report, each warning against what was put in."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.contour import QuadContourSet
from matplotlib.figure import Figure
from tests.hand_made import titled

import wucht
from wucht.analysis.sections import Axis
from wucht.files.user_system import equations_from
from wucht.numerics.phase_plane.closed_curves import ClosedCurve
from wucht.numerics.phase_plane.fixed_points import FixedPoint, FixedPoints
from wucht.numerics.phase_plane.manifolds import Manifold
from wucht.numerics.phase_plane.phase_curves import CLOSED_CURVE, FAILURE, FIXED_POINT, KINKS, LENGTH, PhaseCurve
from wucht.studies.phase_portrait import computation, dataset, figure
from wucht.studies.phase_portrait.computation import Findings, Plan, PortraitCase, PortraitFindings

TURN = 2 * math.pi
AXES = (Axis("omega", "speed", "rad/s"), Axis("psi", "phase", "rad", 0.0, TURN))  # the abscissa is the angle, the second
SADDLE = FixedPoint(np.array([3.0, 4.0]), np.array([0.5, -2.0]), "saddle")
FOCUS = FixedPoint(np.array([1.0, math.pi]), np.array([-1.0 + 3.0j, -1.0 - 3.0j]), "stable focus")


def curve(states: Any, end: str = FIXED_POINT, index: int = 1, forwards: bool = True, **more: Any) -> PhaseCurve:
    states = np.array(states, float)
    return PhaseCurve(states, np.arange(float(states.shape[1])), forwards, end, index, **more)


LEAVING = curve([[3.0, 2.5, 1.0], [4.0, 3.5, 3.0]], gap=0.25, length=1.5)
COMING = curve([[3.0, 5.0], [4.0, 5.0]], CLOSED_CURVE, 0, False)
AHEAD, BACK = curve([[1.0, 2.0, 3.0], [10.0, 20.0, 30.0]]), curve([[1.0, 0.5], [10.0, 5.0]], "left the window", -1, False)
ROUND = ClosedCurve(np.array([[2.0, 2.5, 1.5, 2.0], [7.0, 9.0, 11.0, 7.0 + TURN]]), 1.25, np.array([0.0, TURN]), 0.5)
FIRST = PortraitFindings(
    FixedPoints((SADDLE, FOCUS), True, "all by subdivision"),
    (np.array([0.25 + 0j, -4.0]), np.array([-0.5 + 1j, -0.5 - 1j])),
    (Manifold(0, False, 1, 1e-7, LEAVING), Manifold(0, True, -1, 2e-7, COMING)),
    ((AHEAD, BACK),),
    (ROUND,),
    10,
    (5.0,),
)
SECOND = PortraitFindings(FixedPoints((FOCUS,), False, "by Newton"), (np.empty(0),), (), (), (), 4, ())


def plan(count: int = 2, section: bool = True, **keys: Any) -> Plan:
    of_machine = SimpleNamespace(rotor_speed=lambda state: -4.0, inertia=True, order=2)
    plane: Any = SimpleNamespace(
        turns=np.array([0.0, TURN]), low=np.array([-1.0, 0.0]), high=np.array([3.0, TURN]), scale=np.array([4.0, TURN]),
        rates=lambda at: np.array([10.0 * at[0], at[1]]),
    )  # fmt: skip
    labels = [("u = 1", 1.0), ("u = 2", 2.0)][:count] if count > 1 else [("", None)]
    cases = tuple(PortraitCase(name, value, plane, of_machine if section else None) for name, value in labels)  # type: ignore[arg-type]
    spec = wucht.PhasePortrait(**({"along": "u", "values": [1.0, 2.0]} if count > 1 else {}), **keys)
    return Plan(spec, cases, AXES, np.array([[-1.0, 3.0], [0.0, 2 * TURN]]), None, "s", ("of the section",))


@pytest.fixture(scope="module")
def several() -> xr.Dataset:
    return titled(dataset.dataset(plan(), Findings((FIRST, SECOND))))


def test_points_of_several_portraits_side_by_side(several: xr.Dataset) -> None:
    nan = math.nan
    wrapped = [[3.0, 4.0 - TURN], [1.0, math.pi]]
    assert several.fixed_points.values == pytest.approx(np.array([wrapped, [wrapped[1], [nan, nan]]]), nan_ok=True)
    assert several.fixed_point_kind.values.tolist() == [["saddle", "stable focus"], ["stable focus", ""]]
    assert several.eigenvalues_real.values[0].tolist() == [[0.5, -2.0], [-1.0, -1.0]]
    assert several.eigenvalues_imag.values[0].tolist() == [[0.0, 0.0], [3.0, -3.0]]
    assert several.transverse_growth.values == pytest.approx(np.array([[0.25, -0.5], [nan, nan]]), nan_ok=True)
    assert several.eigenvalues_real.attrs["units"] == several.transverse_growth.attrs["units"] == "1/s"
    assert several.value.values.tolist() == [1.0, 2.0] and several.case.values.tolist() == ["u = 1", "u = 2"]
    assert several.turn.values.tolist() == [0.0, TURN] and several.attrs["abscissa"] == 1


def test_curves_of_several_portraits_side_by_side(several: xr.Dataset) -> None:
    """A trajectory is one curve in the order of time: what was followed backwards comes first, its start once."""
    assert several.trajectories.values[0, 0].tolist() == [[0.5, 1.0, 2.0, 3.0], [5.0, 10.0, 20.0, 30.0]]
    assert several.trajectory_start.values[0].tolist() == [1.0] and several.trajectory_end.values.tolist() == [
        ["stable focus 2"],
        [""],
    ]
    leaving, coming = several.separatrices.values[0]
    assert leaving.tolist() == LEAVING.states.tolist()
    assert coming[:, :2].tolist() == COMING.states.tolist() and np.isnan(coming[:, 2]).all()
    assert several.separatrix_saddle.values[0].tolist() == [0.0, 0.0]
    assert several.separatrix_stable.values[0].tolist() == [0.0, 1.0]
    assert several.separatrix_end.values.tolist() == [["stable focus 2", "closed curve 1"], ["", ""]]
    assert several.closed_curves.values[0, 0].tolist() == ROUND.states.tolist()
    assert several.closed_curve_kind.values.tolist() == [["stable"], [""]]
    assert several.closed_curve_period.values[0].tolist() == [1.25] and np.isnan(several.closed_curve_period.values[1]).all()


def test_the_summary_of_each_portrait(several: xr.Dataset) -> None:
    s = several.wucht.summary
    one, two = s["cases"]
    assert [one["label"], one["value"], two["label"], two["value"]] == ["u = 1", 1.0, "u = 2", 2.0]
    saddle, focus = one["fixed_points"]
    assert saddle["state"] == {"omega": 3.0, "psi": pytest.approx(4.0 - TURN)} and focus["state"]["psi"] == pytest.approx(
        math.pi
    )
    assert (saddle["stable"], focus["stable"], two["fixed_points"][0]["stable"]) == (False, True, True)
    assert saddle["eigenvalues_phi"] == [[0.125, 0.0], [-0.5, 0.0]] and saddle["transverse_phi"] == [[0.0625, 0.0], [-1.0, 0.0]]
    leaving, coming = one["separatrices"]
    assert leaving == {
        "saddle": 0, "stable": False, "side": 1, "end": FIXED_POINT, "to": "stable focus 2", "fixed_point": 1,
        "closed_curve": None, "gap": 0.25, "length": 1.5, "error": 1e-7, "state": [1.0, 3.0],
    }  # fmt: skip
    assert (coming["stable"], coming["side"], coming["fixed_point"], coming["closed_curve"]) == (True, -1, None, 0)
    (closed,) = one["closed_curves"]
    assert (closed["period"], closed["period_phi"], closed["multiplier"], closed["turns"]) == (1.25, 5.0, 0.5, [0.0, 1.0])
    low, high = 7.0, 7.0 + TURN  # its middle, 7 + pi, is wrapped by two turns
    assert closed["min"] == {"omega": 1.5, "psi": pytest.approx(low - 2 * TURN)}
    assert closed["max"] == {"omega": 2.5, "psi": pytest.approx(high - 2 * TURN)}
    assert one["complete"] is True and two["complete"] is False
    assert one["shown"] == "all by subdivision; closed curves are those met by 10 followed curves"
    assert (s["along"], s["model"], s["inertia"], s["order"]) == ("u", "averaged", True, 2)


def test_the_sentence_counts_kinds() -> None:
    told = titled(dataset.dataset(plan(), Findings((FIRST, SECOND))))
    model = "averaged equations, second order, with the inertia of the balancing bodies"
    assert told.wucht.summary["sentence"] == (
        f"{model}: u = 1: 1 saddle, 1 stable focus (proved to be all), 1 stable closed curve; u = 2: 1 stable focus"
    )
    family = ClosedCurve(ROUND.states, 1.0, ROUND.turns, 1.0)
    many = PortraitFindings(FixedPoints((FOCUS, FOCUS, SADDLE, SADDLE), False, ""), (), (), (), (ROUND, ROUND, family), 0, ())
    assert dataset._sentence(many) == "2 stable foci, 2 saddles, 2 stable closed curves, 1 closed curve of a family"
    assert dataset._sentence(PortraitFindings(FixedPoints((), True, ""), (), (), (), (), 0, ())) == "no fixed point (proved)"


def test_a_single_portrait_has_no_dimension_of_cases() -> None:
    made = titled(dataset.dataset(plan(1, section=False), Findings((FIRST,))))
    assert made.fixed_points.dims == ("fixed_point", "state") and made.closed_curve_period.values.tolist() == [1.25]
    assert "eigenvalues_phi" not in made.wucht.summary["fixed_points"][0]
    assert [p["stable"] for p in made.wucht.summary["fixed_points"]] == [False, True]
    assert made.wucht.warnings == ["of the section"]
    assert dataset.report(made)[2:] == [
        "  1 saddle          omega 3, psi -2.283185; eigenvalues 0.5, -2",
        "  2 stable focus    omega 1, psi 3.141593; eigenvalues -1+3i, -1-3i",
        "  saddle 1, unstable manifold, one side: goes to stable focus 2",
        "  saddle 1, stable manifold, other side: comes from closed curve 1",
        "  closed curve 1: stable, winding around, period 1.25, 5 of the rotor's angle",
        "  fixed points: all by subdivision; closed curves are those met by 10 followed curves",
    ]


def test_each_portrait_is_doubted_by_its_name() -> None:
    def told(manifolds: tuple[PhaseCurve, ...] = (), *ahead: PhaseCurve, back: PhaseCurve = BACK) -> list[str]:
        made = PortraitFindings(
            FIRST.fixed_points, FIRST.transverse, tuple(Manifold(0, False, 1, 0.0, m) for m in manifolds),
            tuple((a, back) for a in ahead), (), 1, (),
        )  # fmt: skip
        return dataset._warnings(plan(), plan().cases[1], made)

    flat = [[0.0, 1.0], [0.0, 1.0]]
    assert told((LEAVING,), AHEAD) == []
    for end, words in (
        (LENGTH, f"stopped after {plan().spec.length:g} windows"),
        (FAILURE, "cannot be evaluated"),
        (KINKS, "slide along a jump"),
    ):
        stopped = curve(flat, end, -1)
        for warnings in (told((stopped,)), told((), stopped)):
            assert len(warnings) == 1 and warnings[0].startswith("u = 2: some curves") and words in warnings[0]
        assert told((), AHEAD, back=stopped) == [], "where a trajectory comes from is not what is asked"
    (connection,) = told((curve(flat, FIXED_POINT, 0),))
    assert connection.startswith("u = 2: a separatrix leads to a saddle")
    assert told((), curve(flat, FIXED_POINT, 0)) == []
    both = dataset.dataset(plan(), Findings((FIRST, SECOND))).wucht.warnings
    assert both == ["of the section", "u = 2: by Newton"]
    assert dataset.dataset(plan(), Findings((FIRST,))).wucht.warnings[-1] == "1 of 2 portraits are finished"


def test_rates_lie_over_the_panel_as_it_is_drawn() -> None:
    """Rows go up the ordinate, the first state here, columns along the abscissa, the angle."""
    rate = dataset._rates(plan(), 1).value[0]
    omega, psi = np.linspace(-1.0, 3.0, 161), np.linspace(0.0, 2 * TURN, 161)
    np.testing.assert_allclose(rate[0], np.repeat(10.0 * omega[:, None], 161, axis=1))
    np.testing.assert_allclose(rate[1], np.repeat(psi[None], 161, axis=0))


def test_starts_are_spread_by_the_plastic_number() -> None:
    """Roberts' sequence: each start is 1/g and 1/g^2 of the window farther on than the last one, g^3 = g + 1."""
    real = float(np.roots([1.0, 0.0, -1.0, -1.0])[0].real)
    low, scale = np.array([-1.0, 0.0]), np.array([4.0, TURN])
    places = computation._places(plan(), plan().cases[0].plane, 50)
    shares = (places - low[:, None]) / scale[:, None]
    assert places.shape == (2, 50) and (shares >= 0).all() and (shares < 1).all()
    assert np.diff(shares, axis=1) % 1 == pytest.approx(np.repeat([[1 / real], [1 / real**2]], 49, axis=1))
    assert computation._places(plan(seed=1), plan().cases[0].plane, 1) != pytest.approx(places[:, :1])


@pytest.mark.parametrize(("count", "kept"), [(1, [0]), (3, [0, 2]), (4, [0, 3]), (6, [0, 3, 5]), (7, [0, 3, 6])])
def test_thinned_curves_keep_every_third_state_and_the_last(count: int, kept: list[int]) -> None:
    thin = computation._thin_curve(curve([np.arange(count), 10.0 + np.arange(count)]))
    assert thin.time.tolist() == kept and thin.states[1].tolist() == [10.0 + k for k in kept]


def test_the_angle_of_the_rotor_in_a_period_is_positive(monkeypatch: pytest.MonkeyPatch) -> None:
    """Held at -3 rad/s; or the integral of the state that is its speed, over one period from the curve's first state."""
    held: Any = SimpleNamespace(turning=-1, speed=-3.0)
    assert computation._rotor_angle(held, ROUND) == pytest.approx(3.0 * 1.25)
    own = equations_from({"states": {"x": "0", "omega": "-2"}}, "a test")
    falling: Any = SimpleNamespace(turning=1, system=own.system, values=own.values)
    given = list[Any]()

    def integrate(compiled: Any, state: np.ndarray, values: Any, ends: np.ndarray) -> Any:
        (quadrature,) = compiled.quadratures
        given.extend([str(quadrature.expression), state.tolist(), ends.tolist()])
        motion = SimpleNamespace(failure=None, quadratures={"turned": np.array([0.0, -12.0])})
        return SimpleNamespace(reraise_interrupt=lambda: motion)

    monkeypatch.setattr(computation, "compile_system", lambda system: system)
    monkeypatch.setattr(computation, "integrate", integrate)
    assert computation._rotor_angle(falling, ClosedCurve(ROUND.states, 3.0, np.zeros(2), 0.5)) == 12.0
    assert given == ["omega", [2.0, 7.0], [0.0, 3.0]]


def test_the_window_holds_the_fixed_points_of_all_portraits(monkeypatch: pytest.MonkeyPatch) -> None:
    around = iter([((-2.0, 1.0), (5.0, 2.0)), None, ((-1.0, -3.0), (7.0, 1.5))])
    monkeypatch.setattr(computation, "window_around", lambda *given: next(around))
    own = equations_from({"states": {"x": "-x", "y": "-y"}}, "a test")
    axes = tuple(Axis(n, n, "") for n in "xy")
    low, high = computation._window([(own.system, {})] * 3, axes, {})
    assert (list(low), list(high)) == ([-2.0, -3.0], [7.0, 2.0])
    low, high = computation._window([(own.system, {})], axes, {"x": (1.0, 2.0), "y": (3.0, 4.0)})
    assert (list(low), list(high)) == ([1.0, 3.0], [2.0, 4.0]), "as given"


def test_an_angle_is_drawn_over_two_turns_and_two_angles_over_one_each() -> None:
    one: Any = SimpleNamespace(turns=np.array([0.0, TURN]), low=np.array([-1.0, 0.5]), high=np.array([3.0, 0.5 + TURN]))
    assert computation._drawn_ranges(one, AXES, {}) == pytest.approx(np.array([[-1.0, 3.0], [0.5, 0.5 + 2 * TURN]]))
    assert computation._drawn_ranges(one, AXES, {"psi": (0.0, 1.0)})[1] == pytest.approx([0.0, 1.0])
    two: Any = SimpleNamespace(turns=np.array([TURN, TURN]), low=np.zeros(2), high=np.full(2, TURN))
    assert computation._drawn_ranges(two, AXES, {}) == pytest.approx(np.array([[0.0, TURN]] * 2))


@pytest.mark.parametrize(("turns", "at"), [((0.0, 0.0), 0), ((TURN, 0.0), 0), ((0.0, TURN), 1), ((TURN, TURN), 0)])
def test_the_only_angle_is_the_abscissa(turns: tuple[float, float], at: int) -> None:
    case = SimpleNamespace(plane=SimpleNamespace(turns=np.array(turns)))
    assert dataset._abscissa(SimpleNamespace(cases=(case,))) == at  # type: ignore[arg-type]


def test_portraits_without_points_and_curves_have_the_same_dimensions() -> None:
    nothing = PortraitFindings(FixedPoints((), True, ""), (), (), (), (), 0, ())
    made = dataset.dataset(plan(), Findings((nothing, nothing)))
    assert made.fixed_points.shape == (2, 0, 2) and made.eigenvalues_real.shape == (2, 0, 2)
    assert made.separatrices.shape == (2, 0, 2, 0) and made.trajectory_end.shape == (2, 0)


@pytest.mark.parametrize(
    ("end", "stable", "words"),
    [
        ("left the window", True, "comes from outside the window"),
        ("left the window", False, "leaves the window"),
        ("saddle 2", True, "comes from saddle 2"),
        ("unstable node 1", False, "goes to unstable node 1"),
        ("degenerate 3", False, "goes to degenerate 3"),
        ("time", True, "followed no further: time"),
    ],
)
def test_where_a_manifold_comes_from_or_goes(end: str, stable: bool, words: str) -> None:
    assert dataset._end_clause(end, stable) == words


# --- the figure ---


def lines_of(axis: Axes, **look: Any) -> list[np.ndarray]:
    """The points of the lines of a look."""
    same = (look["color"], look["linewidth"])
    return [np.asarray(x.get_xydata(), float) for x in axis.lines if (x.get_color(), x.get_linewidth()) == same]


@pytest.fixture(scope="module")
def panel(several: xr.Dataset) -> Axes:
    axis = Figure().subplots()
    figure._panel(axis, several.isel(case=0))
    return axis


def test_the_angle_is_drawn_to_the_right_in_all_turns_that_are_visible(panel: Axes) -> None:
    """Over 0 to 4 pi; the saddle at 4 rad and the focus at pi, where the speed is 3 and 1."""
    assert (panel.get_xlim(), panel.get_ylim()) == ((0.0, 2 * TURN), (-1.0, 3.0))
    single = [x for x in panel.lines if len(x.get_xdata()) == 1]
    points = [(x.get_marker(), x.get_xdata()[0], x.get_ydata()[0], x.get_markerfacecolor()) for x in single]
    assert [p[:3] for p in points] == [
        ("x", pytest.approx(4.0), 3.0), ("x", pytest.approx(4.0 + TURN), 3.0),
        ("o", pytest.approx(math.pi), 1.0), ("o", pytest.approx(math.pi + TURN), 1.0),
    ]  # fmt: skip
    assert points[2][3] == "black", "stable"


def test_manifolds_that_lead_to_a_saddle_are_dashed_and_follow_the_time(panel: Axes) -> None:
    leaving, coming = lines_of(panel, **figure._UNSTABLE), lines_of(panel, **figure._STABLE)
    assert [x.tolist() for x in leaving] == [
        LEAVING.states[::-1].T.tolist(),
        np.add(LEAVING.states[::-1].T, [TURN, 0.0]).tolist(),
    ]
    assert coming[0].tolist() == COMING.states[::-1, ::-1].T.tolist() and len(coming) == 2
    dashed = [x.is_dashed() for x in panel.lines if x.get_color() == figure._STABLE["color"]]
    assert dashed == [True, True]
    (stable,) = lines_of(panel, **figure._CLOSED_CURVES["stable"])[:1]
    assert np.ptp(stable[:, 0]) == pytest.approx(TURN)
    trajectory = lines_of(panel, **figure._TRAJECTORY)[0]
    assert np.diff(trajectory[:, 0]) == pytest.approx([5.0, 10.0, 10.0]) and trajectory[:, 1].tolist() == [0.5, 1.0, 2.0, 3.0]


@pytest.mark.parametrize(
    ("x", "turn", "shifts"),
    [
        ([1.0, 2.0], TURN, [0.0, TURN]), ([-1.0, 1.0], TURN, [0.0, TURN, 2 * TURN]), ([1.0, 2.0], 0.0, [0.0]),
        ([30.0, 31.0], TURN, [-4 * TURN, -3 * TURN]), ([0.0, 0.0], TURN, [0.0, TURN, 2 * TURN]),
        ([np.nan, 20.0], TURN, [-3 * TURN, -2 * TURN]), ([np.nan, np.nan], TURN, []),
    ],
)  # fmt: skip
def test_the_turns_that_move_a_curve_into_the_panel(x: list[float], turn: float, shifts: list[float]) -> None:
    box, states = np.array([[0.0, 2 * TURN], [-1.0, 3.0]]), np.array([x, [1.0, 2.0]])
    actual = figure._shifts(states, box, np.array([turn, 0.0]))
    assert [(a, b) for a, b in actual] == [(pytest.approx(k), 0.0) for k in shifts]
    swapped = figure._shifts(states[::-1], box[::-1], np.array([0.0, turn]))
    assert [(b, a) for a, b in swapped] == [(pytest.approx(k), 0.0) for k in shifts]


@pytest.mark.parametrize(
    ("kind", "growth", "symbol"),
    [
        ("stable node", -0.5, "stable"), ("stable node", math.nan, "stable"), ("stable focus", 0.5, "within"),
        ("unstable focus", -0.5, "unstable"), ("saddle", 0.5, "saddle"), ("centre", -0.5, "other"),
        ("degenerate", -0.5, "other"),
    ],
)  # fmt: skip
def test_symbols_of_fixed_points(kind: str, growth: float, symbol: str) -> None:
    one = xr.Dataset({"fixed_point_kind": ("p", [kind]), "transverse_growth": ("p", [growth])})
    assert figure._classes(one) == [symbol]


def test_an_arrow_is_in_the_middle_of_what_is_visible_and_points_ahead() -> None:
    """A line from -2 to 2 in a panel from 0 to 2: the visible part is about 1; too short a one has none."""
    box, style = np.array([[0.0, 2.0], [-1.0, 1.0]]), figure._UNSTABLE

    def arrows(x: np.ndarray) -> list[Any]:
        axis = Figure().subplots()
        figure._arrow(axis, np.stack([x, 0.0 * x]), box, style, 6.0)
        return [(t.xyann[0], t.xy[0]) for t in axis.texts]

    ((tail, head),) = arrows(np.linspace(-2.0, 2.0, 401))
    assert tail == pytest.approx(1.0, abs=0.02) and tail < head < tail + 0.05
    ((tail, head),) = arrows(np.linspace(2.0, -2.0, 401))
    assert tail == pytest.approx(1.0, abs=0.02) and tail - 0.05 < head < tail
    assert arrows(np.linspace(1.0, 1.11, 50)) == [] and len(arrows(np.linspace(1.0, 1.13, 50))) == 1


def test_angles_have_ticks_in_parts_of_pi_and_states_their_symbols(several: xr.Dataset) -> None:
    axis = Figure().subplots()
    figure._scales(axis, several)
    assert [t.get_text() for t in axis.get_xticklabels()] == ["0", "π", "2π", "3π", "4π"]
    assert axis.get_xticks() == pytest.approx(math.pi * np.arange(5))
    assert (axis.get_xlabel(), axis.get_ylabel()) == ("phase $\\psi$ (rad)", "speed (rad/s)")
    one_turn = several.copy(deep=True)
    one_turn.drawn.values[1] = 0.0, TURN
    figure._scales(axis, one_turn)
    assert axis.get_xticks() == pytest.approx(math.pi / 2 * np.arange(5))
    figure._scales(axis, several.assign_attrs(section=0))
    assert axis.get_xlabel() == "phase (rad)"


def test_the_legend_has_what_is_drawn_in_any_of_the_portraits(several: xr.Dataset) -> None:
    names = [h.get_label() for h in figure._legend(several)]
    assert names == [
        "stable fixed point", "saddle", "unstable manifold: leaves the saddle", "stable manifold: leads to the saddle",
        "closed curve, stable", "trajectory",
    ]  # fmt: skip
    second = several.isel(case=[1], separatrix=[], trajectory=[])
    assert [h.get_label() for h in figure._legend(second)] == ["stable fixed point"]


def test_nullclines_are_where_each_rate_is_zero() -> None:
    """The rates are ten times the speed, and the angle less pi."""
    made = plan(nullclines=True)
    made.cases[0].plane.rates = lambda at: np.array([10.0 * at[0], at[1] - math.pi])  # type: ignore[method-assign]
    one = dataset.dataset(made, Findings((FIRST,))).isel(case=0)
    axis = Figure().subplots()
    figure._panel(axis, one)
    contours = [c for c in axis.collections if isinstance(c, QuadContourSet)]
    paths = [np.concatenate([p.vertices for p in c.get_paths()]) for c in contours]
    assert paths[0][:, 0] == pytest.approx(math.pi) and np.ptp(paths[0][:, 1]) == pytest.approx(4.0), "of the angle, first"
    assert paths[1][:, 1] == pytest.approx(0.0, abs=1e-9) and np.ptp(paths[1][:, 0]) == pytest.approx(2 * TURN)
    assert [tuple(c.get_edgecolor()[0]) for c in contours] == [to_rgba(colour) for colour, _ in figure._NULLCLINES]
    names = [(h.get_label(), h.get_color()) for h in figure._legend(dataset.dataset(made, Findings((FIRST,))))[-2:]]
    assert names == [("nullcline of psi", figure._NULLCLINES[0][0]), ("nullcline of omega", figure._NULLCLINES[1][0])]
