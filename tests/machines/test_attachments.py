"""What is fastened to the carrier: from a file and in Python, paths and schedules, studies that know it, what is refused."""

import math
from types import SimpleNamespace

import pytest
import sympy as sp
from tests.refusals import refused

from witness import moved
from wucht import CoastDown, Machine, Response, parts, run
from wucht.analysis.averaged_equations import averaged_equations_of
from wucht.analysis.switching import with_rigid_pendulums
from wucht.errors import InputError
from wucht.files.building import machine_from
from wucht.machines.parts import attachments
from wucht.machines.parts.base import Point

CARRIER = {"mass": 3.0, "stiffness": 8e3, "damping": 20.0}
PLANAR = {"directions": "xyr", "mass": 30.0, "inertia": 4.0, "stiffness": 8e3, "rotation_stiffness": 2e3}
ROTOR = {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 0.01, "inertia": 0.03}
DAMPER = {"kind": "friction-damper", "name": "left", "angle": 0.0, "force": "40 N"}
STOP = {"kind": "end-stop", "name": "buffer", "angle": "90 deg", "gap": "10 mm", "stiffness": 4e4, "restitution": 0.5}
LAYER = {"kind": "material-layer", "name": "sand", "mass": "10 kg", "share": 0.3}
DRIVE = {"kind": "linear", "slope": 0.05, "no_load_speed": 90.0}


def described(*attached: dict, carrier: dict = CARRIER, **more: object) -> dict:
    return {"carrier": carrier, "bodies": [ROTOR], "drive": DRIVE, "attachments": list(attached), **more}


def test_files_and_python_make_the_same_machine() -> None:
    from_file = machine_from(described(DAMPER, STOP, LAYER))
    attached = [
        parts.FrictionDamper(name="left", angle=0.0, force=40.0),
        parts.EndStop(name="buffer", angle="90 deg", gap=0.01, stiffness=4e4, restitution=0.5),
        parts.MaterialLayer(name="sand", mass=10.0, share=0.3),
    ]
    rotor = parts.Rotor(name="drum", mass=2.0, eccentricity=0.01, inertia=0.03)
    drive = parts.LinearDrive(slope=0.05, no_load_speed=90.0)
    carrier = parts.Carrier(mass=3.0, stiffness=8e3, damping=20.0)
    machine = Machine(carrier, [rotor], [drive], attachments=attached)
    assert machine.values == from_file.values
    assert machine.system == from_file.system
    assert set(attachments()) == {"end-stop", "friction-damper", "material-layer"}


def test_their_keys_are_parameters() -> None:
    machine = machine_from(described(DAMPER, STOP, set={"left.force": "55 N", "buffer.gap": "4 mm"}))
    assert (machine.values["left.force"], machine.values["buffer.gap"]) == (55.0, 0.004)
    assert machine.with_values({"left.force": "60 N"}).values["left.force"] == 60.0
    with refused("buffer.stiffness", code="limits"):
        machine.with_values({"buffer.stiffness": -1.0})


def test_a_schedule_of_the_material_closes_the_energy_balance() -> None:
    fill = {"parameter": "sand.mass", "points": [[0.0, 1.0], [0.5, 20.0]]}
    rows = moved(described(LAYER | {"damping": 100.0}, carrier=CARRIER | {"gravity": 9.81}, schedules=[fill]))
    given = rows["supplied_work"] - rows["dissipated_work"] + rows["schedule_work"]
    assert given == pytest.approx(rows["stored_energy"] - rows["stored_energy"][0], abs=1e-9)


@pytest.mark.parametrize(("attached", "words"), [(DAMPER, "the dry friction of 'left'"), (STOP, "the end stop 'buffer'")])
def test_what_needs_a_linear_carrier_refuses_the_others(attached: dict, words: str) -> None:
    machine = machine_from(described(attached))
    with refused("machine", words, "averaged equations", code="not-linear"):
        averaged_equations_of(machine)
    with refused("machine", words, "study.kind", "closed form", code="not-linear"):
        run(Response(range=(5.0, 60.0)), machine)


def test_coasting_down_they_stay() -> None:
    """With the linear drive gone, dry friction on the carrier brakes the rotor; its own state is kept."""
    half = {}
    for force in (0.0, 40.0):
        machine = machine_from(described(DAMPER | {"force": force}, carrier=CARRIER | {"damping": 0.0}))
        half[force] = run(CoastDown(until=20.0), machine).wucht.summary["half_time"]
    assert half[0.0] is None
    assert 0 < half[40.0] < 20


def test_other_bodies_leave_them_where_they_are() -> None:
    pendulum = {
        "kind": "switchable-pendulum", "name": "p", "about": "drum", "mass": 0.3, "moving_mass": 0.2, "inner_stop": 0.05,
        "outer_stop": 0.09, "stiffness": 300.0, "preload": 20.0,
    }  # fmt: skip
    machine = machine_from(described(LAYER) | {"bodies": [ROTOR, pendulum]})
    assert with_rigid_pendulums(machine).values["sand.share"] == 0.3


@pytest.mark.parametrize(
    ("document", "where", "sentence"),
    [
        (described(DAMPER | {"kind": "friction_damper"}), "attachments[0] (left).kind", "did you mean 'friction-damper'"),
        (described({"kind": "end-stop"}), "attachments[0].", "this key is missing"),
        (described(DAMPER | {"force": "-1 N"}), "attachments[0] (left).force", "at least 0 N"),
        (described(DAMPER | {"force": "40 N m"}), "attachments[0] (left).force", "N"),
        (described(DAMPER | {"build_up": 0}), "attachments[0] (left).build_up", "greater than 0 m"),
        (described(DAMPER | {"free_travel": "-1 mm"}), "attachments[0] (left).free_travel", "at least 0 m"),
        (described(DAMPER | {"freetravel": "1 mm"}), "attachments[0] (left).freetravel", "did you mean 'free_travel'"),
        (described({k: v for k, v in DAMPER.items() if k != "angle"}), "attachments[0] (left).angle", "missing; give"),
        (described(DAMPER, DAMPER), "attachments[1].name", "this name is already used"),
        (described(DAMPER | {"name": "drum"}), "attachments[0].name", "this name is already used"),
        (described(DAMPER | {"name": "carrier"}), "attachments[0].name", "this name is already used"),
        (described(DAMPER | {"at": [0.1, 0.0]}), "attachments[0] (left).at", "allowed only on a carrier that turns"),
        (described(DAMPER, carrier=CARRIER | {"directions": "y"}), "attachments[0]", "does not move in the direction"),
        (described(LAYER, carrier={"directions": "fixed"}), "attachments[0]", "does not move in the direction"),
        (described(STOP | {"damping": 3.0}), "attachments[0] (buffer).restitution", "either damping or restitution"),
        (described(STOP | {"restitution": 1.2}), "attachments[0] (buffer).restitution", "between 0.01 and 1"),
        (described(STOP | {"sides": "left"}), "attachments[0] (buffer).sides", "'one' or 'both'"),
        (described(STOP | {"gap": "-1 mm"}), "attachments[0] (buffer).gap", "at least 0 m"),
        (described(LAYER | {"share": 1.5}), "attachments[0] (sand).share", "between 0 and 1"),
        (described(LAYER | {"mass": 0}), "attachments[0] (sand).mass", "greater than 0 kg"),
        (described() | {"attachments": DAMPER}, "attachments", "must be tables: [[machine.attachments]]"),
        ({"model": "exciter", "attachments": [DAMPER]}, "attachments", "not allowed beside model"),
        (described() | {"drive": {"kind": "inverter", "set_speed": 90}}, "drive.gain", "this key is missing"),
        (
            described() | {"drive": {"kind": "inverter", "set_speed": 9, "gain": 1, "integral_time": 0, "torque_limit": 1}},
            "drive.integral_time", "greater than 0 s",
        ),
    ],
)  # fmt: skip
def test_what_is_refused(document: dict, where: str, sentence: str) -> None:
    with pytest.raises(InputError) as error:
        machine_from(document)
    assert error.value.location.startswith(f"machine.{where}")
    assert sentence in error.value.explanation


def test_bodies_of_a_screen_turn_them_along() -> None:
    """A viscous-like check of the place: a stop at the end of a screen is met by its turning alone."""
    stop = STOP | {"at": ["0.5 m", "0 m"], "gap": "1 mm", "stiffness": 1e6}
    rows = moved(described(stop, carrier=PLANAR) | {"bodies": [ROTOR | {"eccentricity": 0.0}]}, {"carrier": {"vr": 0.5}})
    highest = (rows["carrier.y"] + 0.5 * rows["carrier.r"]).max()
    # The place weighs 1/(1/m + a^2/J) there.
    weight = 1 / (1 / 32.0 + 0.25 / 4.0)
    assert highest == pytest.approx(0.001 + 0.25 * (weight / 1e6) ** 0.5, rel=2e-2)


def test_equations_show_the_states_of_their_own(wucht, here) -> None:
    text = wucht("equations", "practice/laundry-drum-friction").out
    assert "z_left' = " in text
    assert "tau_drive' = (" in text
    assert "left.free_travel: free travel to either side" in text
    listed = wucht("list").out
    assert all(f"  {kind} " in listed for kind in ("friction-damper", "end-stop", "material-layer", "inverter"))


@pytest.mark.parametrize("angle", [0.0, "180 deg", "135 deg", "-60 deg"])
def test_a_line_may_point_either_way_along_the_carriers_motion(angle: object) -> None:
    machine = machine_from(described(DAMPER | {"angle": angle}, carrier=CARRIER | {"directions": "x"}))
    assert machine.without_contacts[-1].applied_forces


@pytest.mark.parametrize(("at", "hint"), [(None, True), ([0.5, 0.0], False)])
def test_on_a_carrier_that_only_turns_a_part_needs_a_place_off_its_axis_of_motion(at: object, hint: bool) -> None:
    """Along the line from the pivot to its place nothing moves, and at the pivot neither."""
    rocking = {"directions": "r", "inertia": 4.0, "rotation_stiffness": 2e3}
    place = {} if at is None else {"at": at}
    with refused("machine.attachments[0]", given="left") as error:
        machine_from(described(DAMPER | place, carrier=rocking))
    assert ("at = [x, y]" in error.value.explanation) is hint
    upright = machine_from(described(DAMPER | {"at": [0.5, 0.0], "angle": "-90 deg"}, carrier=rocking))
    assert "left.force" in upright.values


def test_on_a_carrier_that_does_not_turn_no_place_is_asked_for() -> None:
    with refused("machine.attachments[0]", given="left") as error:
        machine_from(described(DAMPER | {"angle": "90 deg"}, carrier=CARRIER | {"directions": "x"}))
    assert "at = [x, y]" not in error.value.explanation


def test_of_several_stops_the_pressed_one_is_doubted_where_the_carrier_rests() -> None:
    """Under its weight the carrier of 5 kg hangs 6.1 mm below: a stop below with a gap of 5 mm is pressed, one of 7 mm not."""
    stop = STOP | {"angle": "-90 deg"}
    made = machine_from(
        described(stop | {"gap": "7 mm"}, stop | {"name": "near", "gap": "5 mm"}, carrier=CARRIER | {"gravity": 9.81})
    )
    assert made.rest == pytest.approx([0.0, -5 * 9.81 / 8e3])
    (doubt,) = [w for w in made.warnings if "near" in w or "buffer" in w]
    assert "near" in doubt


def test_the_velocity_along_a_line_is_the_rate_of_the_displacement():
    """d(x cos + y sin)/dt, of a line in any direction."""
    x, y, vx, vy = sp.symbols("x y vx vy", real=True)
    frame = SimpleNamespace(axis=lambda name: Point(x, y, vx, vy))
    stop = parts.EndStop(name="s", angle="30 deg", gap=0.01, stiffness=1.0, damping=0.0)
    displacement, velocity = stop.line_motion(frame)
    assert sp.simplify(sp.diff(displacement, x) * vx + sp.diff(displacement, y) * vy - velocity) == 0
    assert stop.motion(frame) == (velocity,)
    at = {sp.Symbol("s.angle", real=True): math.radians(30), x: 2.0, y: 1.0}
    assert float(displacement.subs(at)) == pytest.approx(math.sqrt(3) + 0.5)
