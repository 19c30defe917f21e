"""What data sheets state becomes the parameters of a machine: against formulas of makers, norms and other formulations."""

import math

import numpy as np
import pytest
from tests.refusals import refused

from wucht import InputError
from wucht.files.building import machine_from, with_settings
from wucht.files.machine_tables import machine_table
from wucht.machines.parts import DC, DCSeparate, Induction, Roller
from wucht.studies.subjects import MachineSubject

SHEET = {"working_moment": "900 kg cm"}
PLATE = {"power": "3 kW", "speed": "1450 rpm", "voltage": "400 V", "frequency": "50 Hz"}
PLACES = [[1.7, -0.5], [-1.7, -0.5], [1.5, -0.5], [-1.5, -0.5]]
EQUAL = {"count": 8, "pattern": PLACES, "static_deflection": "25 mm", "stiffness_ratio": 0.4, "damping_ratio": 0.05}
OIL = {"viscosity": "0.5 Pa s", "gap": "1 mm"}
BALL = {"name": "b", "about": "drum", "mass": "0.3 kg", "track_radius": "0.26 m", "radius": "21 mm"}


def table(exciter=SHEET, mounts=EQUAL, **more):
    """A screen of 1900 kg with an exciter of 80 kg at its centre of mass."""
    rotor = {"kind": "rotor", "name": "e1", "mass": 80.0, "inertia": 1.5} | exciter
    carrier = {"directions": "xyr", "mass": 1900.0, "inertia": 2700.0, "gravity": 9.81, "mounts": mounts}
    return {"carrier": carrier, "bodies": [rotor]} | more


# --- exciters ---


def test_the_working_moment_is_twice_the_unbalance():
    """The same machine, to the last bit; and the centrifugal force is that of NetterVibration's formula (4)."""
    sheet, given = machine_from(table()), machine_from(table({"unbalance": "450 kg cm"}))
    assert sheet.values == given.values
    assert sheet.system is given.system
    force = 54.84 * 900 * 1.488**2  # N, of M in kg cm and n/1000 rpm
    assert force == pytest.approx(109.3e3, rel=1e-3)
    by_force = machine_from(table({"centrifugal_force": {"force": force, "speed": "1488 rpm"}}))
    assert by_force.values["e1.unbalance"] == pytest.approx(4.5, rel=2e-4)
    assert "e1: unbalance 4.5 kg m, half of the working moment, 9 kg m" in sheet.notes
    assert not any(note.startswith("e1") for note in given.notes)


@pytest.mark.parametrize("way", [SHEET, {"centrifugal_force": {"force": "109.3 kN", "speed": "1488 rpm"}}])
def test_the_setting_is_a_part_of_the_largest_value(way):
    whole, part = (machine_from(table(way | setting)) for setting in ({}, {"setting": "70 %"}))
    assert part.values["e1.unbalance"] == pytest.approx(0.7 * whole.values["e1.unbalance"], rel=1e-12)
    assert any("70 % of" in note for note in part.notes)


def test_the_unbalance_is_the_one_parameter():
    """It can be set and varied as if it had been given, and the file of the machine has it."""
    machine = machine_from(table())
    assert {p for p in machine.parameters if p.startswith("e1.")} == {
        "e1.mass",
        "e1.unbalance",
        "e1.inertia",
        "e1.bearing_damping",
    }
    assert machine.with_values({"e1.unbalance": "300 kg cm"}).values["e1.unbalance"] == 3.0
    assert machine_from(with_settings(table(), {"e1.unbalance": "300 kg cm"})).values["e1.unbalance"] == 3.0
    assert machine_from(with_settings(table(), {"e1.setting": "50 %"})).values["e1.unbalance"] == 2.25
    assert machine_from(with_settings(table({"unbalance": 1.0}), {"e1.working_moment": 9.0})).values["e1.unbalance"] == 4.5
    assert machine_from(machine_table(machine.with_values({"e1.unbalance": 3.0}))).values["e1.unbalance"] == 3.0


BODY = "machine.bodies[0] (e1)"


@pytest.mark.parametrize(
    ("exciter", "refusal"),
    [
        (SHEET | {"unbalance": "450 kg cm"}, refused(f"{BODY}.unbalance", "working_moment", code="either-or")),
        (SHEET | {"eccentricity": 0.01}, refused(f"{BODY}.eccentricity", "working_moment", code="either-or")),
        (
            SHEET | {"centrifugal_force": {"force": 1e5, "speed": 150}},
            refused(f"{BODY}.centrifugal_force", "working_moment", code="either-or"),
        ),
        ({"unbalance": 4.5, "setting": 0.7}, refused(f"{BODY}.setting", "working_moment", given=0.7)),
        (SHEET | {"setting": "170 %"}, refused(f"{BODY}.setting", given="170 %", code="limits")),
        ({"working_moment": "900 kg"}, refused(f"{BODY}.working_moment", "kg m", given="900 kg", code="dimension")),
        ({"centrifugal_force": {"force": 1e5}}, refused(f"{BODY}.centrifugal_force.speed", code="missing")),
        ({}, refused(f"{BODY}.eccentricity", "working_moment")),
    ],
)
def test_an_exciter_is_given_in_one_way(exciter, refusal):
    with refusal:
        machine_from(table(exciter))


# --- mounts ---


def test_the_springs_deflect_under_the_weight():
    """The machine rests where its springs carry it, and swings with sqrt(g/d); horizontally 0.4 times as stiff."""
    machine = machine_from(table())
    x, y, _ = machine.rest
    assert (x, y) == (pytest.approx(0.0, abs=1e-12), pytest.approx(-0.025, rel=1e-9))
    mass, damping, stiffness = machine.matrices
    assert stiffness[1, 1] / mass[1, 1] == pytest.approx(9.81 / 0.025)
    assert stiffness[0, 0] == pytest.approx(0.4 * stiffness[1, 1])
    for i in (0, 1):
        assert damping[i, i] == pytest.approx(2 * 0.05 * math.sqrt(mass[i, i] * stiffness[i, i]))
    assert machine.notes[0].startswith("carrier: 8 mounts, each with stiffness 38847.6 and 97119 N/m")


def test_one_table_is_as_eight():
    """Two side by side at each of four places; [machine.mounts] is the carrier's."""
    one = {"stiffness": ["55 N/mm", "133 N/mm"], "damping": ["500 N s/m", "800 N s/m"]}
    pattern = {"count": 8, "pattern": PLACES} | one
    eight = machine_from(table(mounts=[{"at": at} | one for at in PLACES for _ in range(2)]))
    for equal in (machine_from(table(mounts=pattern)), machine_from(_with_machine_mounts(pattern))):
        for matrix, expected in zip(equal.matrices, eight.matrices, strict=True):
            assert matrix == pytest.approx(expected)
        assert not any(note.startswith("carrier") for note in equal.notes)


def _with_machine_mounts(mounts):
    document = table(mounts=None, mounts_of_the_machine=mounts)
    document["mounts"] = document.pop("mounts_of_the_machine")
    del document["carrier"]["mounts"]
    return document


def test_patterns():
    def places(**mounts):
        values = machine_from(table(mounts=mounts | {"stiffness": 1e5})).values
        return [(values[f"carrier.mounts.{i}.at.x"], values[f"carrier.mounts.{i}.at.y"]) for i in range(1, 5)]

    line = places(count=4, pattern="line", length=3.0, at=[0.1, -0.5])
    assert np.array(line) == pytest.approx(np.array([(-1.4, -0.5), (-0.4, -0.5), (0.6, -0.5), (1.6, -0.5)]))
    assert places(pattern="corners", length=3.0, height=1.0) == [(-1.5, -0.5), (-1.5, 0.5), (1.5, -0.5), (1.5, 0.5)]


def test_equal_mounts_share_the_natural_frequency_of_the_carrier():
    document = table(mounts={"count": 8, "pattern": PLACES})
    document["carrier"] |= {"frequency": "3 Hz", "damping_ratio": 0.05}
    mass, _, stiffness = machine_from(document).matrices
    assert math.sqrt(stiffness[1, 1] / mass[1, 1]) == pytest.approx(6 * math.pi)


MOUNTS = "machine.carrier.mounts"


@pytest.mark.parametrize(
    ("mounts", "refusal"),
    [
        (EQUAL | {"count": 7}, refused(f"{MOUNTS}.count", "4", given=7)),
        (EQUAL | {"stiffness": 1e5}, refused(f"{MOUNTS}.static_deflection", "stiffness", given="25 mm")),
        (EQUAL | {"damping": 100.0}, refused(f"{MOUNTS}.damping_ratio", "damping")),
        (EQUAL | {"pattern": "circle"}, refused(f"{MOUNTS}.pattern", "line", "corners", given="circle")),
        (EQUAL | {"pattern": []}, refused(f"{MOUNTS}.pattern", "corners", given=[])),
        (EQUAL | {"length": 1.0}, refused(f"{MOUNTS}.length")),
        (EQUAL | {"pattern": "corners", "length": 1.0}, refused(f"{MOUNTS}.height")),
        (EQUAL | {"static_deflection": "25 kg"}, refused(f"{MOUNTS}.static_deflection", given="25 kg", code="dimension")),
        ({"count": 8, "pattern": PLACES}, refused(MOUNTS, "frequency")),
        ({"count": 8}, refused(f"{MOUNTS}.pattern", code="missing")),
        ([{"at": [0, 0], "stiffness": "1 kg"}], refused(f"{MOUNTS}[0].stiffness", given="1 kg", code="dimension")),
    ],
)
def test_mounts_that_are_refused(mounts, refusal):
    with refusal:
        machine_from(table(mounts=mounts))


def test_mounts_are_given_once():
    with pytest.raises(InputError) as error:
        machine_from(table() | {"mounts": EQUAL})
    assert (error.value.location, error.value.code) == ("machine.mounts", "either-or")


# --- motors ---

# Motive, Delphi series, motors that are not in the program's table: power in W, rated rpm, breakdown and starting torque over
# the rated one, inertia.
CATALOGUE = [
    (5500.0, 1455, 3.16, 2.40, 0.0214), (15000.0, 2941, 3.14, 2.71, 0.0499), (2200.0, 940, 2.40, 2.10, 0.014),
    (30000.0, 1480, 2.30, 2.20, 0.262), (200.0e3, 1485, 2.20, 2.10, 4.73), (7500.0, 720, 2.0, 2.0, 0.126),
]  # fmt: skip


@pytest.mark.parametrize(("power", "rpm", "breakdown", "starting", "inertia"), CATALOGUE)
def test_a_motor_of_which_a_nameplate_is_known_is_as_in_catalogues(power, rpm, breakdown, starting, inertia):
    plate = PLATE | {"power": power, "speed": f"{rpm} rpm"}
    motor, rated = Induction(nameplate=plate, transmission={"ratio": 2.0}), power / (rpm * math.pi / 30)
    assert breakdown / 1.2 < motor.breakdown()[2] / rated < breakdown * 1.2
    assert starting / 1.25 < motor.torque_at(0.0) / 2 / rated < starting * 1.25  # behind the gear, twice
    assert inertia / 2 < motor.transmission.inertia < inertia * 2
    assert motor.torque_at(rpm * math.pi / 60) == pytest.approx(2 * rated, rel=1e-9)
    names = ("breakdown torque ratio", "starting torque ratio", "inertia")
    assert all(e.startswith(name) and "(estimate, " in e for name, e in zip(names, motor.estimates(), strict=True))
    assert motor.doubts() == ()


def test_what_is_given_wins_and_is_no_estimate():
    given = PLATE | {"breakdown_torque_ratio": 2.8, "starting_torque_ratio": 2.4}
    rated = 3000 / (1450 * math.pi / 30)
    motor = Induction(nameplate=given, transmission={"ratio": 1.0, "inertia": 0.0})
    assert motor.estimates() == ()
    assert motor.transmission.inertia == 0.0
    assert (motor.breakdown()[2], motor.torque_at(0.0)) == pytest.approx((2.8 * rated, 2.4 * rated), rel=1e-6)
    one = Induction(nameplate=PLATE | {"starting_torque_ratio": 2.4})
    assert one.torque_at(0.0) == pytest.approx(2.4 * rated, rel=1e-6)
    (estimate,) = one.estimates()
    assert estimate == "breakdown torque ratio 2.9 (estimate, 2.4 to 3.4)"
    strong = Induction(nameplate=PLATE | {"starting_torque_ratio": 3.6})  # pulls out with no less than it starts with
    assert strong.breakdown()[2] == pytest.approx(3.6 * rated, rel=1e-6)
    assert strong.estimates() == ("breakdown torque ratio 3.6 (estimate, 3.6 to 4.3)",)


def test_a_breakdown_torque_alone_keeps_the_circuit_that_it_had():
    """Kloss's 19.3 N m at standstill, as in files written before; the note has the typical torque beside it."""
    motor = Induction(nameplate=PLATE | {"breakdown_torque_ratio": 2.8})
    assert motor.torque_at(0.0) == pytest.approx(19.34, abs=0.01)
    assert motor.estimates() == ()
    assert "starting torque 19.3 N m by the circuit" in motor.derivation_notes()[1]
    assert "52.9 N m are typical of 3 kW, 4 poles" in motor.derivation_notes()[1]


def test_estimates_are_marked_in_the_parts_of_a_result():
    drive = {"on": "e1", "kind": "induction", "nameplate": PLATE}
    description = MachineSubject().describe(machine_from(table(drive=drive)))
    (estimates,) = (part["estimates"] for part in description.parts if "estimates" in part)
    assert estimates[1] == "starting torque ratio 2.7 (estimate, 2.1 to 3.4)"
    assert any(estimates[1] in note and "rotor, some 0.0067 kg m^2" in note for note in description.notes)


def test_a_dc_motor_by_its_catalogue_is_the_circuit_that_has_this_line():
    """k Phi = U_n/w_0, R_A = U_n^2/(w_0 T_s): torque and heat at any voltage and speed, both signs."""
    no_load = 7580 * math.pi / 30
    sheet = {"nominal_voltage": "24 V", "stall_torque": "2.1 N m", "no_load_speed": "7580 rpm"}
    for voltage in (24.0, 18.0, -12.0):
        motor = DC(**sheet, voltage=voltage)
        circuit = DCSeparate(
            voltage=voltage, armature_resistance=24**2 / (no_load * 2.1), motor_constant=1.0, flux=24 / no_load
        )
        for speed in (-50.0, 0.0, 300.0, no_load):
            assert motor.torque_at(speed) == pytest.approx(circuit.torque_at(speed), abs=1e-12)
            heat = [float(m.number(m.circuit_loss(speed))) for m in (motor, circuit)]
            assert heat[0] == pytest.approx(heat[1], abs=1e-9)
    assert DC(**sheet).voltage == 24.0
    assert (DC(**sheet).torque_at(0.0), DC(**sheet).torque_at(no_load)) == pytest.approx((2.1, 0.0), abs=1e-12)


@pytest.mark.parametrize(
    ("changes", "refusal"),
    [
        ({"nominal_voltage": None}, refused("dc.nominal_voltage", code="missing")),
        ({"stall_torque": "-1 N m"}, refused("dc.stall_torque", given="-1 N m", code="limits")),
        ({"no_load_speed": "24 V"}, refused("dc.no_load_speed", given="24 V", code="dimension")),
    ],
)
def test_dc_motors_that_are_refused(changes, refusal):
    sheet = {"nominal_voltage": "24 V", "stall_torque": "2.1 N m", "no_load_speed": "7580 rpm"} | changes
    with refusal:
        DC(**{k: v for k, v in sheet.items() if v is not None})


# --- balls in oil ---

# A. J. Goldman, R. G. Cox, H. Brenner, Chem. Eng. Sci. 22 (1967) 637-651, table of exact values: distance of the centre from
# one wall over the radius, and the drag over Stokes'.
EXACT = [(1.005004, 3.7863, 1e-3), (1.0453, 2.6475, 6e-3), (1.1276, 2.1514, 2e-2)]


@pytest.mark.parametrize(("distance", "one_wall", "within"), EXACT)
def test_the_drag_of_a_ball_between_two_walls(distance, one_wall, within):
    """What each wall adds to Stokes' 6 pi eta r, at the arm of the ball's centre."""
    ball = Roller(**BALL, oil=OIL | {"gap": 0.021 * (distance - 1)})
    stokes = 6 * math.pi * 0.5 * 0.021 * (0.26 - 0.021) ** 2
    assert (ball.damping / stokes + 1) / 2 == pytest.approx(one_wall, rel=within)


def test_a_gap_of_half_the_radius_is_taken():
    assert Roller(**BALL, oil=OIL | {"gap": "10.5 mm"}).damping > 0


def test_the_damping_of_balls_in_oil_is_told_once_and_can_be_set():
    bodies = [
        {"kind": "rotor", "name": "drum", "mass": 15, "unbalance": 0.72, "inertia": 0.75},
        {"kind": "roller", "count": 3, "track": "ring", "oil": OIL} | BALL,
    ]
    document = {"carrier": {"mass": 45.0, "stiffness": 1e4}, "bodies": bodies}
    machine = machine_from(document)
    assert machine.values["b3.damping"] == pytest.approx(0.04767, abs=1e-5)
    assert not [path for path in machine.parameters if "oil" in path]
    (note,) = machine.notes
    # The slip at which c_D rho pi r^2 v^2/2 is the drag, with the density 950 kg/m^3.
    slip = 0.04767 / (0.239**3 * 0.22 * 950 * math.pi * 0.021**2)
    assert f"slip of about {slip:.2g} rad/s" in note
    changed = machine_from(with_settings(document, {"b.damping": 0.1}))
    assert (changed.values["b1.damping"], changed.notes) == (0.1, ())
    assert machine_from(with_settings(document, {"b.oil.viscosity": "1 Pa s"})).values["b1.damping"] == pytest.approx(
        0.09535, abs=1e-5
    )
    one = machine_from(with_settings(document, {"b3.oil.viscosity": "1 Pa s"})).values
    assert (one["b1.damping"], one["b3.damping"]) == (pytest.approx(0.04767, abs=1e-5), pytest.approx(0.09535, abs=1e-5))


@pytest.mark.parametrize(
    ("changes", "refusal"),
    [
        ({"damping": 0.1}, refused("roller.damping", "oil", given=0.1, code="either-or")),
        ({"shape_factor": 0.5}, refused("roller.oil", "shape_factor")),
        ({"oil": OIL | {"viscosity": "10 cSt"}}, refused("roller.oil.viscosity", "Pa s", given="10 cSt", code="dimension")),
        ({"oil": {"viscosity": 0.5}}, refused("roller.oil.gap", code="missing")),
        ({"oil": OIL | {"gap": "10.6 mm"}}, refused("roller.oil", "0.0105 m")),
        ({"oil": OIL | {"gap": 0}}, refused("roller.oil.gap", given=0, code="limits")),
    ],
)
def test_oil_that_is_refused(changes, refusal):
    with refusal:
        Roller(**BALL | {"oil": OIL} | changes)


# --- plausibility ---


def screen(**changes):
    """A screen with two exciters, at 1490 rpm. Its mass is 2060 kg."""
    exciters = [
        {"kind": "rotor", "name": name, "mass": 80.0, "inertia": 10.0} | changes.get("exciter", SHEET) for name in ("e1", "e2")
    ]
    speed = changes.get("speed", 156.0)
    drives = [{"on": n, "kind": "linear", "slope": 1.0, "no_load_speed": s * speed} for n, s in (("e1", 1), ("e2", -1))]
    return machine_from(table(mounts=EQUAL | changes.get("mounts", {}), drives=drives) | {"bodies": exciters})


def plausibility(**changes):
    """The notes on it that speak of practice."""
    return [note for note in MachineSubject().describe(screen(**changes)).notes if note.startswith("far from practice")]


def test_a_usual_screen_is_plausible():
    assert plausibility() == []


@pytest.mark.parametrize(("unbalance", "expected"), [(4.9, 0), (5.0, 1), (9.0, 1)])
def test_a_machine_number_beyond_12_is_told(unbalance, expected):
    """2 m r/M w^2/g = 12 at m r = 12 x 9.80665 x 2060/(2 x 156^2) = 4.981 kg m."""
    notes = plausibility(exciter={"unbalance": unbalance})
    assert len(notes) == expected
    assert all("write working_moment" in note for note in notes)
    if unbalance == 9.0:  # the working moment of 900 kg cm taken for the unbalance
        assert "stroke 17.5 mm and machine number 21.7" in notes[0]


@pytest.mark.parametrize(
    ("speed", "unbalance", "expected"), [(100.0, 7.7, 0), (100.0, 7.75, 1), (300.0, 0.5, 1), (300.0, 0.53, 0)]
)
def test_a_stroke_out_of_1_to_15_mm_is_told(speed, unbalance, expected):
    """4 m r/M: 7.725 and 0.515 kg m."""
    assert len(plausibility(speed=speed, exciter={"unbalance": unbalance})) == expected


@pytest.mark.parametrize(("share", "expected"), [(1.01, 0), (0.99, 1)])
def test_a_support_that_is_too_stiff_is_told(share, expected):
    """A natural frequency above the speed; here that of tilting is the highest."""
    mass, _, stiffness = screen().matrices
    highest = math.sqrt(max(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real))
    notes = plausibility(speed=share * highest, exciter={"unbalance": 25.0})
    assert sum("natural frequency" in note for note in notes) == expected


@pytest.mark.parametrize(("ratio", "expected"), [(0.29, 0), (0.31, 2)])
def test_mounts_that_are_too_damped_are_told(ratio, expected):
    assert len(plausibility(mounts={"damping_ratio": ratio})) == expected


def test_a_machine_that_hardly_shakes_is_no_screen():
    """A machine number below 1: whatever its support, nothing is said."""
    assert plausibility(exciter={"unbalance": 0.4}, mounts={"damping_ratio": 0.5}) == []
    assert len(plausibility(exciter={"unbalance": 0.43}, mounts={"damping_ratio": 0.5})) == 3
