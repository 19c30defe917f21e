"""Motors by their nameplates: known circuits are found again, the rated point is met, and what is missed is told."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from tests.refusals import refused

from wucht.machines.parts import DCSeparate, Induction
from wucht.machines.parts.equivalent_circuit import EquivalentCircuit, fitted_circuit
from wucht.machines.parts.nameplate import InductionNameplate

few = settings(max_examples=25, deadline=None)
SLIPS = (-1.0, -0.3, -0.02, 0.001, 0.02, 0.1, 0.3, 0.7, 1.0, 1.8)

# P. C. Krause, Analysis of Electric Machinery, table 4.10-1: 60 Hz, four poles. Horse power: line voltage, rated rpm, R_1, R_2,
# X_1 = X_2, X_m in ohm.
KRAUSE = {
    3: (220, 1710, 0.435, 0.816, 0.754, 26.13),
    50: (460, 1705, 0.087, 0.228, 0.302, 13.08),
    500: (2300, 1773, 0.262, 0.187, 1.206, 54.02),
    2250: (2300, 1786, 0.029, 0.022, 0.226, 13.04),
}
# Values usual for a four-pole cage motor of 4 kW.
CAGE = {
    "power": "4 kW", "speed": "1435 rpm", "voltage": "400 V", "connection": "delta", "frequency": "50 Hz",
    "efficiency": "86.6 %", "power_factor": 0.81, "breakdown_torque_ratio": 3.0, "starting_torque_ratio": 2.3,
}  # fmt: skip
# maxon RE 40, 148867, by its data sheet; its torque constant is 30.2 mN m/A.
RE40 = {
    "voltage": "24 V", "speed": "6940 rpm", "torque": "177 mN m", "current": "6 A", "no_load_speed": "7580 rpm",
    "no_load_current": "137 mA",
}  # fmt: skip


def krause(power):
    """The circuit of one of Krause's motors, and its rated slip."""
    voltage, rpm, r1, r2, x, xm = KRAUSE[power]
    return EquivalentCircuit(voltage / math.sqrt(3), 2 * math.pi * 30, r1, r2, x, x, xm), 1 - rpm / 1800


def plate_of(c, slip, **more):
    """What would be printed on the motor of a circuit."""
    rated, speed = c.torque(slip), c.synchronous * (1 - slip)
    ratios = {"breakdown_torque_ratio": c.breakdown()[1] / rated, "starting_torque_ratio": c.torque(1.0) / rated}
    named = {"power": rated * speed, "speed": speed, "voltage": math.sqrt(3) * c.voltage, "frequency": 60, "poles": 4}
    return InductionNameplate(**named, **ratios, **more)


def numbers(c):
    return (c.stator_resistance, c.rotor_resistance, c.stator_reactance, c.rotor_reactance, c.magnetising)


def with_circuit(c, **more):
    """The part of a circuit at 60 Hz."""
    named = ("stator_resistance", "rotor_resistance", "stator_reactance", "rotor_reactance")
    xm = {} if math.isinf(c.magnetising) else {"magnetising_reactance": c.magnetising}
    given = {"voltage": c.voltage, "frequency": 60, "pole_pairs": 2} | {n: getattr(c, n) for n in named} | xm
    return Induction(**given | more)


def solved(part, speed):
    """The torque by the voltage equations of stator and rotor, solved as they stand for both currents: another formulation."""
    rated, field = 2 * math.pi * part.rated_frequency, 2 * math.pi * part.frequency * part.sense
    rotor = field - part.pole_pairs * speed
    lm, l1, l2 = (x / rated for x in (part.magnetising_reactance, part.stator_reactance, part.rotor_reactance))
    equations = [
        [part.stator_resistance + 1j * field * (l1 + lm), 1j * field * lm],
        [1j * rotor * lm, part.rotor_resistance + 1j * rotor * (l2 + lm)],
    ]
    stator, induced = np.linalg.solve(equations, [part.voltage, 0.0])
    return 3 * part.pole_pairs * lm * (stator * np.conj(induced)).imag


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize("frequency", [0.0, 3.0, 90.0])
def test_the_torque_with_magnetising_current_is_that_of_the_voltage_equations(frequency, sense):
    c, _ = krause(3)
    part = with_circuit(c, frequency=frequency, rated_frequency=60, voltage=40, sense=sense)
    speeds = (-250.0, -40.0, 0.0, 3.0, 60.0, 180.0)
    actual = [part.torque_at(w) for w in speeds]
    assert actual == pytest.approx([solved(part, w) for w in speeds], rel=1e-11, abs=1e-12)
    if frequency == 0:  # a field that stands brakes
        assert all(t * w <= 0 for t, w in zip(actual, speeds, strict=True))
        assert part.synchronous_speed() is None
        assert part.breakdown() is None


@pytest.mark.parametrize("power", [3, 2250])
def test_krauses_circuits_are_found_again(power):
    """From rated point, breakdown and starting torque and power factor: all five elements of the circuit."""
    c, slip = krause(power)
    found = fitted_circuit(plate_of(c, slip, power_factor=c.power_factor(slip)))
    assert numbers(found) == pytest.approx(numbers(c), rel=1e-8)


@few
@given(
    r1=st.floats(0.01, 0.05), slip=st.floats(0.01, 0.05), x=st.floats(0.06, 0.12), xm=st.floats(1.5, 4.0),
    r2=st.floats(0.01, 0.06),
)  # fmt: skip
def test_any_circuit_is_found_again(r1, slip, x, xm, r2):
    """Of usual motors, in ohm of a motor of 1 ohm rated impedance. Iron losses change nothing."""
    c = EquivalentCircuit(230.0, 2 * math.pi * 30, r1, r2, x, x, xm)
    assume(slip < 0.6 * c.breakdown()[0] and c.breakdown()[1] > 1.1 * c.torque(slip))
    drawn = c.complex_power(slip) + 1.5 * 3 * c.current(slip) ** 2 * r1  # the iron takes more than the winding
    outside = drawn.real - c.torque(slip) * c.synchronous
    assume(abs(drawn) ** 2 / (3 * c.voltage**2) * r1 < 0.49 * outside)  # with the iron's current too
    shaft = c.torque(slip) * c.synchronous * (1 - slip)
    given_ = {"efficiency": shaft / drawn.real, "current": abs(drawn) / (3 * c.voltage)}
    found = fitted_circuit(plate_of(c, slip, **given_))
    assert [found.torque(s) for s in SLIPS] == pytest.approx([c.torque(s) for s in SLIPS], rel=1e-6)
    assert found.torque(slip) == pytest.approx(c.torque(slip), rel=1e-9)
    exact = fitted_circuit(plate_of(c, slip, power_factor=c.power_factor(slip)))
    assert numbers(exact) == pytest.approx(numbers(c), rel=1e-5)


def test_klosss_formula_where_the_data_allow_no_circuit():
    """With neither losses nor a starting torque: T/T_b = 2/(s/s_b + s_b/s), through the rated point."""
    plate = {k: CAGE[k] for k in ("power", "speed", "voltage", "frequency", "breakdown_torque_ratio")}
    made = Induction(nameplate=plate)
    assert made.stator_resistance == 0
    assert made.magnetising_reactance is None
    rated, slip = 4000 / (1435 * math.pi / 30), 65 / 1500
    breakdown = slip * (3 + math.sqrt(8))
    synchronous = 50 * math.pi
    kloss = [6 * rated / (s / breakdown + breakdown / s) for s in SLIPS]
    assert [made.torque_at(synchronous * (1 - s)) for s in SLIPS] == pytest.approx(kloss, rel=1e-9)
    assert "(Kloss)" in made.derivation_notes()[0]
    assert made.doubts() == ()


def test_a_usual_cage_motor():
    """All that is printed is met; the winding takes half of what the cage does not lose, and the bars displace the current."""
    made, rated = Induction(nameplate=CAGE), 4000 / (1435 * math.pi / 30)
    assert made.torque_at(1435 * math.pi / 30) == pytest.approx(rated, rel=1e-9)
    assert made.breakdown()[2] == pytest.approx(3 * rated, rel=1e-9)
    c, slip = made.circuit_at(400.0, 50.0), 65 / 1500
    active = 4000 / 0.866
    assert c.complex_power(slip).imag == pytest.approx(active * math.tan(math.acos(0.81)), rel=1e-8)
    current = active / (3 * 400 * 0.81)
    assert 3 * current**2 * made.stator_resistance == pytest.approx(0.5 * (active - 4000 / (1 - slip)), rel=1e-9)
    assert made.torque_at(0.0) == pytest.approx(2.3 * rated, rel=1e-7)
    assert made.standstill_resistance / made.rotor_resistance == pytest.approx(1.51, abs=0.01)
    assert "starting torque 61.22 N m met; power factor 0.81 met" in made.derivation_notes()[0]
    assert made.doubts() == ()


def test_a_start_weaker_than_any_circuit_is_told():
    """With no resistance of the stator at all the circuit starts with more."""
    doubts = Induction(nameplate=CAGE | {"starting_torque_ratio": 0.5}).doubts()
    assert len(doubts) == 1
    assert doubts[0].startswith("drive.nameplate: starting torque 37.")
    assert "for 13.31 N m (+" in doubts[0]


@pytest.mark.parametrize(
    ("changes", "refusal"),
    [
        ({"speed": "1505 rpm"}, refused("induction.nameplate.speed", "50", given="1505 rpm")),
        ({"poles": 2}, refused("induction.nameplate.poles", "52", given=2)),
        ({"efficiency": 0.97}, refused("induction.nameplate.efficiency", "0.9567", given=0.97)),
        (
            {"efficiency": None, "current": "6 A", "power_factor": 0.9},
            refused("induction.nameplate.power_factor", "1.006", given=0.9),
        ),
        ({"power_factor": None, "current": "5 A"}, refused("induction.nameplate.current", "6.667 A", given="5 A")),
    ],
)
def test_what_no_motor_has_is_refused(changes, refusal):
    with refusal:
        Induction(nameplate={k: v for k, v in (CAGE | changes).items() if v is not None})


@pytest.mark.parametrize(
    ("beside", "refusal"),
    [
        ({"rotor_resistance": 3}, refused("induction.rotor_resistance", given=3)),
        ({"stator_resistance": 30}, refused("induction.stator_resistance", "9.567 ohm", given=30)),
    ],
)
def test_what_does_not_go_beside_a_nameplate(beside, refusal):
    with refusal:
        Induction(**{"nameplate": CAGE} | beside)


def test_a_dc_motor_by_its_data_sheet():
    """The rated and the no-load point are met; k Phi is the torque constant of the data sheet, and the current comes out."""
    made = DCSeparate(nameplate=RE40)
    assert made.torque_at(6940 * math.pi / 30) == pytest.approx(0.177, rel=1e-12)
    assert made.torque_at(7580 * math.pi / 30) == pytest.approx(0.0, abs=1e-15)
    assert made.flux * made.motor_constant == pytest.approx(30.2e-3, rel=2e-3)
    assert "rated current 5.991 A for 6 A (-0.15 %)" in made.derivation_notes()[0]
    assert made.doubts() == ()
    # The 0.299 ohm of the data sheet are those of a cold winding.
    doubts = DCSeparate(nameplate=RE40 | {"armature_resistance": "0.299 ohm"}).doubts()
    assert doubts == ("drive.nameplate: armature resistance 0.3461 ohm for 0.299 ohm (+16 %)",)


@few
@given(flux=st.floats(0.02, 2.0), share=st.floats(0.02, 0.3), friction=st.floats(0.0, 0.1))
def test_any_dc_motor_is_found_again(flux, share, friction):
    """A motor with dry friction, by its no-load speed, by its resistance, or by its losses: the same torque on the shaft."""
    voltage, current = 100.0, 10.0
    resistance, idle = share * voltage / current, friction * current
    speed, no_load = (voltage - resistance * current) / flux, (voltage - resistance * idle) / flux
    rated = flux * (current - idle)
    plate = {"voltage": voltage, "speed": speed, "power": rated * speed}
    ways = (
        {"no_load_speed": no_load},
        {"current": current, "armature_resistance": resistance},
        {"current": current, "no_load_current": idle},
    )
    for way in ways:
        made = DCSeparate(nameplate=plate | way)
        for w in (0.0, 0.5 * speed, speed, no_load):
            exact = flux * ((voltage - flux * w) / resistance - idle)
            assert made.torque_at(w) == pytest.approx(exact, rel=1e-7, abs=1e-9 * flux * current)


@pytest.mark.parametrize(
    ("changes", "refusal"),
    [
        ({"no_load_speed": "6900 rpm"}, refused("dc-separate.nameplate.no_load_speed", given="6900 rpm")),
        ({"no_load_current": "7 A"}, refused("dc-separate.nameplate.no_load_current", given="7 A")),
        ({"current": "5 A"}, refused("dc-separate.nameplate.current", "5.36 A", given="5 A")),
        (
            {"no_load_speed": None, "armature_resistance": "9 ohm"},
            refused("dc-separate.nameplate.armature_resistance", given="9 ohm"),
        ),
    ],
)
def test_what_no_dc_motor_has_is_refused(changes, refusal):
    with refusal:
        DCSeparate(nameplate={k: v for k, v in (RE40 | changes).items() if v is not None})


def test_a_measured_resistance_beside_the_nameplate_is_taken():
    made = Induction(nameplate=CAGE, stator_resistance="2 ohm", voltage="200 V", frequency="25 Hz")
    assert (made.stator_resistance, made.voltage, made.frequency, made.rated_frequency) == (2.0, 200.0, 25.0, 50.0)
    assert Induction(nameplate=CAGE, stator_resistance=2).torque_at(1435 * math.pi / 30) == pytest.approx(26.618, abs=1e-3)


def test_what_contradicts_itself_is_told():
    doubts = Induction(nameplate=CAGE | {"current": "5 A"}).doubts()
    assert any("input power by current 2806 W for 4619 W (-39 %)" in d for d in doubts)
    assert any("the leakage alone draws more" in d for d in Induction(nameplate=CAGE | {"power_factor": 0.995}).doubts())


@pytest.mark.parametrize("frequency", [20.0, 60.0])
@pytest.mark.parametrize("magnetising", [26.13, None])
def test_circuit_and_part_agree_where_the_bars_displace_the_current(frequency, magnetising):
    c = EquivalentCircuit(127.0, 2 * math.pi * 30, 0.435, 0.816, 0.754, 0.6, magnetising or math.inf)
    part = with_circuit(c, standstill_resistance=2.0, frequency=frequency, rated_frequency=60)
    there, field = part.circuit_at(127.0, frequency), math.pi * frequency
    assert [part.torque_at(field * (1 - s)) for s in SLIPS] == pytest.approx([there.torque(s) for s in SLIPS], rel=1e-10)
    assert part.breakdown()[2] == pytest.approx(part.torque_at(part.breakdown()[1]), rel=1e-9)
