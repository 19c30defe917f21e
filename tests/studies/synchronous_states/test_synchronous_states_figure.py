"""The figure of ``synchronous-states``: force balances, what is shown to be stable, decks and the map."""

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

from wucht import JOURNAL, SynchronousStates, draw, load_machine, run
from wucht.files.building import machine_from

AXES = {"speed": (10.0, 400.0, 20), "ratio": (0.0, 3.0, 12)}


@cache
def rollers() -> xr.Dataset:
    """Table 1 of 000 with a map."""
    return run(SynchronousStates(speed=80.0, axes=AXES, full=False), load_machine("sperling-rollers/table-1"))


@cache
def seventeen() -> xr.Dataset:
    """The states of four unequal balls."""
    ball = {"kind": "pendulum", "about": "drum", "length": 0.5, "damping": 0.02}
    rotor = {"kind": "rotor", "name": "drum", "mass": 3.0, "unbalance": 0.01, "inertia": 1.5e-2}
    described = {
        "carrier": {"mass": 2.0, "stiffness": 1e4, "damping": 40.0},
        "bodies": [rotor, *(ball | {"name": f"b{k}", "mass": 0.01 + 0.001 * k} for k in range(4))],
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


def legends(figure: Figure) -> list[str]:
    shown = [*figure.legends, *(a.get_legend() for a in figure.axes if a.get_legend() is not None)]
    return [text.get_text() for legend in shown for text in legend.get_texts()]


def test_force_balances() -> None:
    """Head to tail from the axis, that of the rotor to the right; compensating ones close, others show what is left."""
    panels = draw(rollers()).axes
    assert len(panels) == 6 + 1
    for axis in panels[:2]:
        sides = arrows(axis)
        assert len(sides) == 3 and sides[0] == (0, 1e-4)
        for (_, head), (tail, _) in zip(sides, [*sides[1:], sides[0]], strict=True):
            assert head == pytest.approx(tail, abs=1e-15)
    for k, axis in enumerate(panels[2:6], start=2):
        sides = arrows(axis)
        assert len(sides) == 4
        for one, other in combinations(sides, 2):
            assert not covers(one, other), "an arrow behind another"
        tail, head = sides[-1]
        assert abs(head - tail) == pytest.approx(float(rollers().residual_unbalance[k]), rel=1e-9)
        assert sum(head - tail for tail, head in sides[:3]) == pytest.approx(head - tail, abs=1e-12)


def test_only_what_is_shown_stable_has_the_frame_of_stable_states() -> None:
    """Stable in the averaged equations alone, or with bodies in each other's place: frames and words of their own."""

    def frames(figure: Figure) -> list[tuple[object, ...]]:
        spines = [a.spines["top"] for a in figure.axes]
        return [(str(s.get_linestyle()), str(s.get_edgecolor()), s.get_linewidth()) for s in spines]

    stable = frames(draw(run(SynchronousStates(speed=80.0), load_machine("sperling-rollers/table-1"))))[0]
    slow = draw(rollers())
    assert len({stable, *frames(slow)[:6]}) == 3
    assert "stable (averaged equations only)" in legends(slow) and "stable" not in legends(slow)
    jammed = draw(run(SynchronousStates(), load_machine("practice/grinder-2-balls")))
    assert stable not in frames(jammed) and {"bodies overlap", "not stable"} <= set(legends(jammed))
    assert jammed.axes[0].get_title().startswith("together: bodies overlap")


def test_of_more_than_twelve_states_the_stable_ones_are_drawn_wherever_they_stand() -> None:
    result, verdict = seventeen().copy(deep=True), np.array(["unstable"] * 17, dtype="U40")
    result.stable_slow.values[0], result.stable_full.values[0] = 1, 0
    verdict[[12, 14, 16]] = "stable", "undecided", "stable in the averaged equations only"
    figure = draw(result.assign(verdict=("state", verdict, result.verdict.attrs)))
    words = [axis.get_title().partition(": ")[2].partition("\n")[0] for axis in figure.axes]
    assert words == ["averaged: stable, full: unstable"] + ["unstable"] * 8 + ["stable", "undecided", "stable (averaged)"]
    figure.savefig(io.BytesIO())
    assert any("5 more states are not drawn" in " ".join(text.get_text().split()) for text in figure.texts)


def test_exciters_at_different_places_are_drawn_on_their_deck() -> None:
    """Two equal ones that turn against each other throw along a line."""
    machine = load_machine("practice/screen")
    result = run(SynchronousStates(full=False), machine)
    figure, values = draw(result), machine.values
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
    assert "resultant" not in legends(figure), "nothing is left over of forces that turn in different senses"
    column = draw(result, JOURNAL)
    assert (overlapping(column), beyond(column)) == ([], []), "titles beside each other, in a column of a journal, too"


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
    assert result.sizes["state"] == 0 and result.attrs["sentence"].startswith("no steady phase configurations")
    assert draw(result)


def test_an_arrow_that_would_cover_another_is_moved_to_its_right() -> None:
    """Both balls pull against the rotor: 3 to the right, back by 2 and by 1; nothing is left."""
    result = rollers().assign(unbalance=rollers().unbalance.copy(data=[3.0, 2.0, 1.0]))

    def drawn(*angles: float, **attrs: Any) -> np.ndarray:
        other = result.copy(deep=True).assign_attrs(**attrs)
        other.force_angle.values[1] = angles
        return np.array(arrows(draw(other).axes[1]))

    up = 1j * 0.07 * 6
    assert drawn(0.0, np.pi, np.pi) == pytest.approx(np.array([(0, 3), (3 + up, 1 + up), (1 + up, up)]))
    turned = np.array([(0, 3), (3, 3 + 2j), (3 + 2j, 2 + 2j), (0, 2 + 2j)])
    assert drawn(0.0, np.pi / 2, np.pi) == pytest.approx(turned)
    assert len(drawn(0.0, np.pi / 2, np.pi, comparable=0)) == 3, "no resultant of forces that turn in different senses"


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
    unbalances: tuple[float, ...], speeds: tuple[float, ...], shown: list[float] | None
) -> None:
    """The bodies' unbalance over that of the rotor, 0.75 here, and the speeds without their sense."""
    three = rollers().isel(state=slice(3))
    result = three.assign(unbalance=three.unbalance.copy(data=list(unbalances)), speed=three.speed.copy(data=list(speeds)))
    marked = [line for line in draw(result).axes[-1].get_lines() if line.get_marker() == "o"]
    expected = [] if shown is None else [(shown, [0.75] * len(shown))]
    assert [(np.asarray(x.get_xdata()).tolist(), np.asarray(x.get_ydata()).tolist()) for x in marked] == expected
