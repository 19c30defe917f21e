"""The figure of ``synchronous-states``: force balances and the stability map, drawn from the Dataset alone."""

from __future__ import annotations

import io
from functools import cache
from itertools import combinations
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.text import Annotation
from tests.figure_checks import beyond, overlapping
from tests.refusals import refused

from wucht import JOURNAL, SynchronousStates, draw, load_machine, run
from wucht.files.building import machine_from

AXES = {"speed": (10.0, 400.0, 20), "ratio": (0.0, 3.0, 12)}


@pytest.fixture(scope="module")
def rollers() -> xr.Dataset:
    """Table 1 of 000 with a map."""
    machine = load_machine("sperling-rollers/table-1")
    return run(SynchronousStates(speed=80.0, axes=AXES), machine)


@cache
def many(count: int) -> xr.Dataset:
    ball = {"kind": "pendulum", "about": "drum", "length": 0.5, "damping": 0.02}
    described: dict[str, Any] = {
        "carrier": {"mass": 2.0, "stiffness": 1e4, "damping": 40.0},
        "bodies": [
            {"kind": "rotor", "name": "drum", "mass": 3.0, "unbalance": 0.01, "inertia": 1.5e-2},
            *(ball | {"name": f"b{k}", "mass": 0.01 + 0.001 * k} for k in range(count)),
        ],
        "drive": {"kind": "constant-speed", "speed": 100.0},
    }
    return run(SynchronousStates(full=False), machine_from(described))


def arrows(axis: Axes) -> list[tuple[complex, complex]]:
    """Tails and heads of the arrows of a force balance."""
    drawn = [child for child in axis.get_children() if isinstance(child, Annotation)]
    return [(complex(*a.xyann), complex(*a.xy)) for a in drawn]


def covers(one: tuple[complex, complex], other: tuple[complex, complex]) -> bool:
    """True if two arrows lie on one line, and one of them on the other."""
    size = abs(other[1] - other[0])
    along = (other[1] - other[0]) / size
    first, second = ((point - other[0]) / along for point in one)
    if max(abs(first.imag), abs(second.imag)) > 1e-6 * size:
        return False
    return min(max(first.real, second.real), size) - max(min(first.real, second.real), 0.0) > 1e-6 * size


def changed(result: xr.Dataset, k: int = 1, **values: Any) -> xr.Dataset:
    """A copy in which a state has other values, phases in degrees."""
    other = result.copy(deep=True)
    for name, value in values.items():
        if name == "phase":
            other.phase.values[k, 1:] = np.radians(value)
        else:
            other[name].values[k] = value
    return other


def legends(figure: Figure) -> list[str]:
    shown = [*figure.legends, *(a.get_legend() for a in figure.axes if a.get_legend() is not None)]
    return [text.get_text() for legend in shown for text in legend.get_texts()]


@pytest.mark.slow
def test_force_balances(rollers: xr.Dataset) -> None:
    """Head to tail from the axis, that of the rotor to the right; compensating ones close, others show what is left."""
    panels = draw(rollers).axes
    assert len(panels) == 6 + 1
    for k, axis in enumerate(panels[:2]):
        sides = arrows(axis)
        assert len(sides) == 3
        assert sides[0] == (0, 1e-4)
        for (_, head), (tail, _) in zip(sides, [*sides[1:], sides[0]], strict=True):
            assert head == pytest.approx(tail, abs=1e-15)
        assert axis.get_title().startswith("compensating: stable")
        assert ("138.6°, 262.8°", "221.4°, 97.2°")[k] in axis.get_title()
        assert {s.get_linestyle() for s in axis.spines.values()} == {"-"}
    for k, axis in enumerate(panels[2:6], start=2):
        sides = arrows(axis)
        assert len(sides) == 4
        for one, other in combinations(sides, 2):
            assert not covers(one, other), "an arrow behind another"
        assert axis.get_title().endswith("at 80 rad/s")
        tail, head = sides[-1]
        assert abs(head - tail) == pytest.approx(float(rollers.residual_unbalance[k]), rel=1e-9)
        assert sum(head - tail for tail, head in sides[:3]) == pytest.approx(head - tail, abs=1e-12)
        assert "unstable" in axis.get_title()
        assert "-" not in {s.get_linestyle() for s in axis.spines.values()}
    assert rollers.attrs["sentence"] in draw(rollers).get_suptitle()


def test_legends(rollers: xr.Dataset) -> None:
    labels = legends(draw(rollers))
    assert {"drum", "r1", "r2", "resultant", "stable", "not stable"} <= set(labels)
    assert "bodies overlap" not in labels  # frames that are not there are not explained
    assert {"compensating", "together, adding", "together, reducing", "natural frequencies", "states above"} <= set(labels)


def test_the_map(rollers: xr.Dataset) -> None:
    axis = draw(rollers).axes[-1]
    assert axis.get_xlabel() == "speed (rad/s)"
    mesh, *hatched = axis.collections
    assert [tuple(h.hatches) for h in hatched] == [("///",), ("...",)], "adding and reducing differ in grey too"
    codes = np.asarray(mesh.get_array()).reshape(12, 20)
    stable = rollers.map_stable.values
    for region in range(len(stable)):
        inside = codes[stable[region] == 1]
        alone = codes[(stable[region] == 1) & (stable.sum(axis=0) == 1)]
        assert len(set(alone.tolist())) <= 1
        assert len(inside) >= len(alone)
    marked = [line for line in axis.get_lines() if line.get_marker() == "o"]
    assert [float(marked[0].get_xdata()[0]), float(marked[0].get_ydata()[0])] == pytest.approx([80.0, 2.0])  # type: ignore[index]


@pytest.mark.slow
def test_each_combination_of_stable_states_has_a_colour_of_its_own(rollers: xr.Dataset) -> None:
    """Nine states, and each two neighbours together: more than there are colours chosen by hand."""
    names = [f"state {k}" for k in range(9)]
    combinations = [*(1 << k for k in range(9)), *(3 << k for k in range(8)), 0]
    stable = np.array([[c >> k & 1 for c in combinations] for k in range(9)], np.int8)[:, None, :]
    stable = np.tile(stable, (1, rollers.sizes["map_ratio"], 1))
    speed = ("map_speed", rollers.map_speed.values[: len(combinations)], rollers.map_speed.attrs)
    many_regions = rollers.drop_dims(["region", "map_speed"]).assign_coords(region=names, map_speed=speed)
    for name in ("map_exists", "map_stable"):
        many_regions[name] = (("region", "map_ratio", "map_speed"), stable, rollers[name].attrs)
    mesh = draw(many_regions).axes[-1].collections[0]
    shown = mesh.cmap(mesh.norm(np.asarray(mesh.get_array()).reshape(rollers.sizes["map_ratio"], -1)[0]))
    assert len({tuple(c) for c in shown.tolist()}) == len(combinations)
    assert shown[-1].tolist() == [1.0, 1.0, 1.0, 1.0]


def test_the_legend_explains_the_frames_that_are_drawn() -> None:
    """The only stable one of seventeen is the last: it is shown first, and named."""
    result = many(4)
    verdict = np.array(["unstable"] * 17, dtype=object)
    verdict[-1] = "stable"
    last = result.assign(verdict=("state", verdict.astype(str), result.verdict.attrs))
    assert {"stable", "not stable"} <= set(legends(draw(last)))


@pytest.mark.slow
def test_no_more_than_twelve() -> None:
    result = many(4)
    assert result.sizes["state"] == 17
    figure = draw(result)
    assert len(figure.axes) == 12
    assert any("(5 more are not drawn)" in " ".join(text.get_text().split()) for text in figure.texts)
    assert figure.axes[1].get_title().count("°") == 2
    assert ", ..." in figure.axes[1].get_title()


def frames(figure: Figure) -> list[tuple[object, ...]]:
    """Line style, colour and width of each state's frame."""
    spines = [a.spines["top"] for a in figure.axes]
    return [(str(s.get_linestyle()), str(s.get_edgecolor()), s.get_linewidth()) for s in spines]


def test_only_what_is_shown_stable_has_the_frame_of_stable_states(rollers: xr.Dataset) -> None:
    """Stable in the averaged equations alone, or with bodies in each other's place: frames and words of their own."""
    stable = frames(draw(rollers))[0]
    slow = run(SynchronousStates(speed=80.0, full=False), load_machine("sperling-rollers/table-1"))
    assert len({stable, *frames(draw(slow))}) == 3
    assert draw(slow).axes[0].get_title().startswith("compensating: stable (averaged)")
    assert "stable (averaged equations only)" in legends(draw(slow))
    assert "stable" not in legends(draw(slow))
    jammed = draw(run(SynchronousStates(), load_machine("practice/grinder-2-balls")))
    assert stable not in frames(jammed)
    assert jammed.axes[0].get_title().startswith("together: bodies overlap")
    assert {"bodies overlap", "not stable"} <= set(legends(jammed))


@pytest.mark.slow
def test_ten_bodies_are_told_apart() -> None:
    """By colour, and the second five by hollow arrows; all stand in the legend, which is inside the figure."""
    figure = draw(many(10))
    shown = [text for text in legends(figure) if text[0] == "b" and text[1:].isdigit()]
    assert shown == [f"b{k}" for k in range(10)]
    looks = [(line.get_color(), bool(line.get_path_effects())) for line in figure.legends[0].get_lines()[:11]]
    assert len(set(looks)) == 11
    drawn = [child for child in figure.axes[0].get_children() if isinstance(child, Annotation)][:11]
    assert [bool(a.arrow_patch.get_path_effects()) for a in drawn] == [False] * 6 + [True] * 5  # type: ignore[union-attr]
    box = figure.legends[0].get_window_extent()
    assert box.x1 <= figure.bbox.x1
    assert box.y0 >= 0


def test_exciters_at_different_places_are_drawn_on_their_deck() -> None:
    """Two equal ones that turn against each other throw along a line."""
    machine = load_machine("practice/screen")
    result = run(SynchronousStates(full=False), machine)
    figure = draw(result)
    values = machine.values
    places = [complex(values[f"{r.name}.position.x"], values[f"{r.name}.position.y"]) for r in machine.rotors]
    assert len(figure.axes) == result.sizes["state"] == 2
    for axis, state, phases in zip(figure.axes, result.wucht.summary["states"], result.phase.values, strict=True):
        drawn = arrows(axis)
        assert [tail for tail, _ in drawn] == pytest.approx(places)
        angles = np.angle([head - tail for tail, head in drawn])
        direction = state["throw_direction"]
        along = [np.cos(angles + np.array([1, -1]) * later - direction).sum() for later in (0.0, 0.05, -0.05)]
        assert along[0] == max(along) > 1.99, "at another instant of the turn their sum along the throw is less"
        assert np.exp(1j * angles[1]) == pytest.approx(np.exp(-1j * (angles[0] + phases[1])))
        (path,) = (line for line in axis.get_lines() if len(line.get_xdata()) > 2)
        points = np.asarray(path.get_xdata()) + 1j * np.asarray(path.get_ydata())
        farthest = points[np.abs(points).argmax()] * np.exp(-1j * direction)
        assert abs(farthest.imag) < 0.02 * abs(farthest.real)
        assert f"stroke {1e3 * state['stroke']:.4g} mm" in axis.get_title()
    assert "path of the centre of mass" in legends(figure)
    column = draw(result, JOURNAL)
    assert (overlapping(column), beyond(column)) == ([], []), "titles beside each other, in a column of a journal, too"


def test_exciters_that_turn_against_each_other() -> None:
    """Nothing is left over of forces that turn in different senses."""
    figure = draw(run(SynchronousStates(full=False), load_machine("practice/screen")))
    assert [len(arrows(a)) for a in figure.axes] == [2, 2]
    assert "resultant" not in legends(figure)
    assert "rad/s" in figure.axes[0].get_title()


@pytest.mark.parametrize("ending", ["png", "pdf", "svg"])
@pytest.mark.filterwarnings("error")
def test_every_format(rollers: xr.Dataset, ending: str) -> None:
    file = io.BytesIO()
    draw(rollers).savefig(file, format=ending)
    assert file.getbuffer().nbytes > 5000


@pytest.mark.filterwarnings("error")
def test_no_state_at_all() -> None:
    """A ball heavier than the unbalance, in the resonance of a well damped carrier, stays nowhere."""
    described = {
        "carrier": {"mass": 2.0, "stiffness": 1e4, "damping": 200.0},
        "bodies": [
            {"kind": "rotor", "name": "drum", "mass": 3.0, "unbalance": 0.002, "inertia": 1.5e-2},
            {"kind": "pendulum", "name": "b", "about": "drum", "length": 0.5, "damping": 0.02, "mass": 0.03},
        ],
        "drive": {"kind": "constant-speed", "speed": 44.7},
    }
    result = run(SynchronousStates(), machine_from(described))
    assert result.sizes["state"] == 0
    assert result.attrs["sentence"] == "no steady phase configurations: the bodies do not synchronise here"
    draw(result).savefig(io.BytesIO(), format="png")


def test_a_dataset_that_is_no_result_is_refused(rollers: xr.Dataset) -> None:
    with refused("synchronous-states", given=None):
        draw(rollers.drop_vars("force_angle"))


def test_what_is_left_out_is_not_stable() -> None:
    """Of seventeen states the stable ones are drawn, wherever they stand."""
    result, verdict = many(4), np.array(["unstable"] * 17, dtype="U40")
    verdict[[12, 14, 16]] = "stable", "undecided", "stable in the averaged equations only"
    shown = draw(result.assign(verdict=("state", verdict, result.verdict.attrs))).axes
    assert len(shown) == 12
    words = [axis.get_title().partition(": ")[2].partition("\n")[0] for axis in shown]
    assert words == ["unstable"] * 9 + ["stable", "undecided", "stable (averaged)"]


@pytest.mark.parametrize(
    ("values", "title"),
    [
        ({}, "opposite: stable\n30.0°, 270.0°\nat 62.832 rad/s"),
        ({"name": ""}, "state: stable\n30.0°, 270.0°\nat 62.832 rad/s"),
        ({"phase": (-0.04, 359.96)}, "opposite: stable\n0.0°, 0.0°\nat 62.832 rad/s"),
        ({"overlapping": 1}, "opposite: bodies overlap\n30.0°, 270.0°\nat 62.832 rad/s"),
        (
            {"verdict": "unstable", "stable_full": 0},
            "opposite: averaged: stable, full: unstable\n30.0°, 270.0°\nat 62.832 rad/s",
        ),
        (
            {"verdict": "unstable", "stable_full": 0, "stable_slow": 0},
            "opposite: unstable\n30.0°, 270.0°\nat 62.832 rad/s",
        ),
        (
            {"verdict": "stable in the averaged equations only", "stable_full": -1},
            "opposite: stable (averaged)\n30.0°, 270.0°\nat 62.832 rad/s",
        ),
    ],
)
def test_the_title_of_a_state(rollers: xr.Dataset, values: dict[str, Any], title: str) -> None:
    common = {"name": "opposite", "verdict": "stable", "stable_full": 1, "stable_slow": 1, "overlapping": 0}
    state = common | {"speed": 62.83185, "phase": (30.0, -90.0)} | values
    wide = rollers.assign({name: rollers[name].astype("U40") for name in ("name", "verdict")})
    assert draw(changed(wide, **state)).axes[1].get_title() == title
    if not values:
        bare = changed(wide, **state)
        bare.speed.attrs["units"] = ""
        assert draw(bare).axes[1].get_title().endswith("\nat speed 62.832")


@pytest.mark.parametrize(
    ("verdict", "overlapping", "is_solid", "width"),
    [
        ("stable", 0, True, 2.0),
        ("stable in the averaged equations only", 0, False, 2.0),
        ("stable", 1, False, 1.6),
        ("unstable", 1, False, 0.8),
        ("undecided", 0, False, 1.4),
    ],
)
def test_the_frame_of_a_state(rollers: xr.Dataset, verdict: str, overlapping: int, is_solid: bool, width: float) -> None:
    wide = rollers.assign(verdict=rollers.verdict.astype("U40"))
    axis = draw(changed(wide, verdict=verdict, overlapping=overlapping)).axes[1]
    spine = axis.spines["left"]
    assert spine.get_linewidth() == width
    assert (spine.get_linestyle() == "-") is is_solid and axis.get_aspect() == 1.0


def test_an_arrow_that_would_cover_another_is_moved_to_its_right(rollers: xr.Dataset) -> None:
    """Both balls pull against the rotor: 3 to the right, back by 2 and by 1; nothing is left."""
    result = rollers.assign(unbalance=rollers.unbalance.copy(data=[3.0, 2.0, 1.0]))
    drawn = arrows(draw(changed(result, force_angle=[0.0, np.pi, np.pi])).axes[1])
    up = 1j * 0.07 * 6
    assert np.array(drawn) == pytest.approx(np.array([(0, 3), (3 + up, 1 + up), (1 + up, up)]))
    turned = arrows(draw(changed(result, force_angle=[0.0, np.pi / 2, np.pi])).axes[1])
    assert np.array(turned) == pytest.approx(np.array([(0, 3), (3, 3 + 2j), (3 + 2j, 2 + 2j), (0, 2 + 2j)]))
    apart = arrows(draw(changed(result, force_angle=[0.0, np.pi / 2, np.pi]).assign_attrs(comparable=0)).axes[1])
    assert len(apart) == 3, "no resultant of forces that turn in different senses"


@pytest.mark.parametrize(
    ("unbalances", "speeds", "shown"),
    [
        ((2.0, 1.0, 0.5), (20.0, -30.0, 35.0), [20.0, 30.0, 35.0]),
        ((2.0, 1.0, 0.5), (15.0, 390.0, 500.0), [15.0, 390.0]),
        ((2.0, 1.0, 0.5), (500.0, 5.0, 6.0), None),
        ((2.0, 7.0, 0.5), (20.0, 20.0, 20.0), None),
        ((0.0, 1.0, 0.5), (20.0, 20.0, 20.0), None),
    ],
)
def test_the_machine_is_on_the_map_where_it_is_in_its_range(
    rollers: xr.Dataset, unbalances: tuple[float, ...], speeds: tuple[float, ...], shown: list[float] | None
) -> None:
    """The bodies' unbalance over that of the rotor, 0.75 here, and the speeds without their sense."""
    three = rollers.isel(state=slice(3))
    result = three.assign(unbalance=three.unbalance.copy(data=list(unbalances)), speed=three.speed.copy(data=list(speeds)))
    marked = [line for line in draw(result).axes[-1].get_lines() if line.get_marker() == "o"]
    expected = [] if shown is None else [(shown, [0.75] * len(shown))]
    assert [(np.asarray(x.get_xdata()).tolist(), np.asarray(x.get_ydata()).tolist()) for x in marked] == expected


def test_natural_frequencies_within_the_map_are_drawn(rollers: xr.Dataset) -> None:
    frequency = rollers.natural_frequency
    values = np.resize([9.0, -20.0, 389.0, 500.0], frequency.shape)
    low, high = rollers.map_speed.values[[0, -1]]
    axis = draw(rollers.assign(natural_frequency=frequency.copy(data=values))).axes[-1]
    expected = sorted({abs(f) for f in values.tolist() if low <= abs(f) <= high})
    assert [np.asarray(x.get_xdata())[0] for x in axis.get_lines() if x.get_linestyle() == ":"] == expected
