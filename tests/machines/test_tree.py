"""Who turns about whom."""

import pytest
from tests.refusals import rejected

from wucht.machines.tree import SlidingBody, Tree
from wucht.mechanics.lagrange import Coordinate

TREE = Tree({"ball": "cage", "drum": None, "cage": "drum", "second": None, "pendulum": "second"})


def test_a_body_has_a_path_to_the_carrier() -> None:
    assert TREE.path("ball") == ["ball", "cage", "drum"]
    assert TREE.path("drum") == ["drum"]
    assert [TREE.root(b) for b in ("ball", "drum", "pendulum")] == ["drum", "drum", "second"]


def test_bodies_stand_in_order_from_the_axis_out() -> None:
    assert TREE.outward == ["drum", "second", "cage", "pendulum", "ball"]


def test_a_group_is_a_body_and_all_that_turn_about_it() -> None:
    assert TREE.group("drum") == ["drum", "cage", "ball"]
    assert TREE.group("cage") == ["cage", "ball"]


@pytest.mark.parametrize("above", [{"a": "a"}, {"a": "b", "b": "a"}, {"a": "b", "b": "c", "c": "b"}])
def test_a_circle_has_no_root(above: dict[str, str | None]) -> None:
    with rejected("circle"):
        Tree(above).root("a")


def test_a_sliding_mass_is_named_by_its_guide_where_that_is_its_own() -> None:
    coordinate = Coordinate.from_names("p.displacement", "p.velocity")
    assert SlidingBody("p", "switchable-pendulum", coordinate, "p").words == "the mass in p"
    assert SlidingBody("s", "slider", coordinate, "drum").words == "s"
