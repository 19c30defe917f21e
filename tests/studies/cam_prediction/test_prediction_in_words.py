"""What a prediction states, with springs and with a drive: numbers of its variables, lines of the report, and the figure."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import xarray as xr

import wucht
from wucht.cams.tables.camshaft import ShaftTable
from wucht.cams.tables.harmonic_law import HarmonicLawTable
from wucht.plots.style import COLOURS

LAW = HarmonicLawTable(coefficients={"mean": "0.5 rad", "cosine": ["-0.4 rad", "0.1 rad"]})
J0, J1, OMEGA, RPM = 20.0, 6.0, 50.0, 30 / math.pi
SPRINGS = {"output_frequency": "20 Hz", "shaft_stiffness": 4e6, "shaft_damping": 2000.0, "cam_inertia": 0.5}
LINEAR = {"kind": "linear", "slope": 200.0, "no_load_speed": "510 rpm"}
MOVED = "the camshaft as inertia and drive move it"


def predicted(law: HarmonicLawTable = LAW, asked: Any = None, **shaft: Any) -> xr.Dataset:
    table = {"inertia": J0, "output_inertia": J1} | ({} if "drive" in shaft else {"mean_speed": OMEGA}) | shaft
    keys = {"points": 16, "speed_points": 3, "dwell": ("-10 deg", "10 deg"), "cuts": 0, "simulate": 0} | (asked or {})
    return wucht.run(wucht.CamPrediction(**keys), wucht.CamDrive(law, shaft=ShaftTable(**table)))


@pytest.fixture(scope="module")
def elastic() -> xr.Dataset:
    return predicted(asked={"cuts": 3, "simulate": 1}, elastic=SPRINGS)


@pytest.fixture(scope="module")
def driven() -> xr.Dataset:
    return predicted(drive=LINEAR)


def percent(share: float) -> str:
    return f"{100 * share:.3g} %" if share >= 1e-6 else f"{share:.0e}"


def test_numbers_are_those_of_the_variables(elastic: xr.Dataset, driven: xr.Dataset) -> None:
    s, phi = elastic.wucht.summary, np.linspace(0.0, 2 * math.pi, 100_001)
    slope = 0.4 * np.sin(phi) - 0.2 * np.sin(2 * phi)
    assert s["inertia_ratio"] == pytest.approx(J1 * (slope**2).max() / J0, rel=1e-5)
    assert (s["unit"], s["harmonics"], s["driven"], s["record"]) == ("rad", 2, "eigenmotion", None)
    assert s["above"] | {"original": 0, "corrected": 0} == {
        "orders": 2, "reference_order": 1, "law": pytest.approx(0.0, abs=1e-15), "original": 0, "corrected": 0,
    }  # fmt: skip
    assert s["above"]["original"] == s["cut_residuals"][0] > 1e3 * s["above"]["corrected"]
    assert s["position_error"]["original"] > 1e3 * s["position_error"]["corrected"]
    assert elastic.cut.values.tolist() == [1, 2, 3] and elastic.cut_residual.values.tolist() == s["cut_residuals"]
    assert s["contraction"] == s["cut_residuals"][2] / s["cut_residuals"][1]
    for result in (elastic, driven):
        s = result.wucht.summary
        assert result.drive_power.values == pytest.approx(result.drive_torque.values * result.speed.values)
        even = result.power_at_constant_speed.values[:-1]
        saved = {"peak": even.max(), "mean_positive": np.maximum(even, 0).mean()}
        assert s["power"]["constant_speed"] == pytest.approx(saved | {"mean": even.mean()}, abs=1e-9)
        for name, one in (("original", s), ("corrected", s["corrected"])):
            power = result.drive_power.sel(cam=name).values[:-1]
            numbers = {"peak": power.max(), "mean": power.mean(), "mean_positive": np.maximum(power, 0).mean()}
            assert s["power"][name] == pytest.approx(numbers) and one["mean_power"] == s["power"][name]["mean"]
            orders = result.speed.sel(cam=name).values[:-1]
            assert one["mean_speed"] == pytest.approx(orders.mean(), rel=1e-6)
            assert one["speed_orders"][:4] == pytest.approx(np.abs(np.fft.rfft(orders))[1:5] / 8, abs=1e-3)
        gain = {key: saved[key] - s["power"]["corrected"][key] for key in saved}
        assert s["power_saved"] == pytest.approx(gain)
        speed = s["corrected"]["speed"]
        assert np.hypot(speed["cosine"], speed["sine"]) == pytest.approx(s["corrected"]["speed_orders"])
    assert driven.wucht.summary["power"]["original"]["peak"] != driven.wucht.summary["power"]["corrected"]["peak"]
    assert s["simulation"] is None and "simulated_tau" not in driven and "excited" not in driven and "twisted" not in driven


def test_springs_are_stated_as_variables_and_in_the_summary(elastic: xr.Dataset) -> None:
    s = elastic.wucht.summary
    assert s["output"]["natural_frequency"] == pytest.approx(40 * math.pi) and s["output"]["damping_ratio"] == pytest.approx(
        0.02
    )
    assert elastic.lever.values.tolist()[:2] == ["original cam", "corrected cam"]
    assert elastic.swept_speed.values[[0, -1]] == pytest.approx([25.0, 75.0])
    for key, variable in (("name", "excited"), ("deviation", "excited_deviation"), ("acceleration", "excited_acceleration"),
                          ("peak", "excited_peak")):  # fmt: skip
        assert [one[key] for one in s["output"]["excited"]] == elastic[variable].values.tolist()
    for key, variable in (
        ("name", "twisted"),
        ("above", "twist_residual"),
        ("torque", "twist_torque"),
        ("twist", "twist_angle"),
    ):
        assert [one[key] for one in s["shaft"]] == elastic[variable].values.tolist()
    units = [elastic.wucht.unit_at(path) for path in ("output.natural_frequency", "output.excited[0].peak", "shaft[0].torque")]
    assert units == ["rad/s", "rad/s^2", "N m"]
    assert elastic.simulated_tau.sizes == {"simulated_tau": 36}
    assert elastic.simulated_deviation.values.tolist() == [s["simulation"][k]["deviation"] for k in ("original", "corrected")]
    assert elastic.simulated_residual.values.tolist() == [s["simulation"][k]["above"] for k in ("original", "corrected")]


def test_as_many_orders_as_three_times_those_of_the_law_but_fifteen_at_least_and_a_hundred_at_most() -> None:
    for count, shown in ((2, 15), (6, 18), (34, 100)):
        law = HarmonicLawTable(coefficients={"mean": 0.5, "cosine": [0.4] + (count - 2) * [0.0] + [0.001]})
        assert predicted(law).order.values.tolist() == list(range(1, shown + 1))


def test_assumptions_name_springs_and_drive(elastic: xr.Dataset, driven: xr.Dataset) -> None:
    held = predicted(asked={"cuts": 3, "simulate": 1}, drive={"kind": "constant-speed", "speed": "500 rpm"})
    assert elastic.wucht.assumed[-2:] == ["elastic parts where stiffnesses are given", MOVED]
    assert driven.wucht.assumed[-2:] == ["rigid parts", MOVED]
    assert held.wucht.assumed[-2:] == ["rigid parts", "the camshaft held at its drive's speed"]
    assert held.sizes["cut"] == 0 and held.wucht.summary["simulation"] is None, "another cam would change nothing"
    lines = wucht.report(held)
    assert "without a drive" not in lines[2] and not any(line.startswith("  drive") for line in lines)


def test_the_lines_of_the_report(elastic: xr.Dataset) -> None:
    s, simulated = elastic.wucht.summary, elastic.wucht.summary["simulation"]["corrected"]
    constant, output = s["power"]["constant_speed"], s["output"]
    shafts = list[str]()
    for name, one in (("original", s), ("corrected", s["corrected"])):
        speed = (
            f"{one['mean_speed']:.5g} rad/s ({one['mean_speed'] * RPM:.0f} rpm), fluctuating by {percent(one['fluctuation'])}"
        )
        shafts.append(f"  {name:13}{speed}; orders above 2: {percent(s['above'][name])} of order 1")
    errors = {name: f"{math.degrees(error):.3g}°" for name, error in s["position_error"].items()}
    listed = [e for i, e in enumerate(output["excited"]) if i < 3 or e["name"].endswith("cam")]
    twists = [
        f"  shaft        twists by {math.degrees(one['twist']):.3g}°, {one['torque']:.4g} N·m, orders above 2: "
        f"{percent(one['above'])} of order 1: {one['name']}" for one in s["shaft"]
    ]  # fmt: skip
    assert wucht.report(elastic)[2:-1] == [
        f"  inertia      of the output at most {s['inertia_ratio']:.3g} of the shaft's; without a drive there is a corrected "
        f"cam up to {s['inertia_ratio_limit']:.3g}",
        *shafts,
        f"  position     off the law by at most {errors['corrected']}; with the original cam by {errors['original']}",
        f"  even speed   would need {constant['peak'] / 1e3:.4g} kW at most, {constant['mean_positive'] / 1e3:.4g} kW on "
        "average without power flowing back",
        "  drive        none: the eigenmotion saves all of this power",
        f"  instead      cutting, measuring and cutting again leaves {', '.join(map(percent, s['cut_residuals']))}",
        f"  simulated    1 turns with the corrected cam: the speed deviates by {simulated['deviation']:.1e}; orders above 2: "
        f"{simulated['above']:.1e} of order 1",
        "  elastic      output at 20 Hz, damping ratio 0.02; in the dwell at most",
        *(f"               {math.degrees(e['deviation']):.3g}°: {e['name']}" for e in listed),
        *twists,
        "  springs      of output and shaft: each is computed with the other rigid",
    ]


def test_the_lines_of_a_drive(driven: xr.Dataset) -> None:
    s, lines = driven.wucht.summary, wucht.report(driven)
    assert s["driven"] == "drive" and [line[2:12].strip() for line in lines[2:-1]] == [
        "inertia", "original", "corrected", "position", "even speed", "drive",
    ]  # fmt: skip

    def power(value: float) -> str:
        return f"{value / 1e3:.4g} kW" if abs(value) >= 1e3 else f"{value:.4g} W"

    drive, saved = s["power"]["corrected"], s["power_saved"]
    demand = f"{power(drive['peak'])} at most, {power(drive['mean_positive'])} on average"
    gain = f"saved {power(saved['peak'])} and {power(saved['mean_positive'])}"
    assert lines[-2] == f"  drive        {demand}; {gain}"


# --- the figure ---


def named(axis: Any) -> dict[str, Any]:
    return {str(line.get_label()): line for line in axis.get_lines()}


def test_each_panel(elastic: xr.Dataset) -> None:
    s = elastic.wucht.summary
    speed, spectrum, power, cuts, sweep, excited, twist, law = wucht.draw(elastic).axes
    degrees, mean = np.degrees(elastic.tau.values), RPM * s["corrected"]["mean_speed"]
    for k, name in enumerate(("original", "corrected")):
        line, dots = named(speed)[f"{name} cam"], named(speed)[f"simulated, {name} cam"]
        assert line.get_xdata() == pytest.approx(degrees) and line.get_ydata() == pytest.approx(RPM * elastic.speed.values[k])
        assert dots.get_xdata() == pytest.approx(np.arange(36) * 10.0)
        assert dots.get_ydata() == pytest.approx(RPM * elastic.simulated_speed.values[k])
    assert [x.get_ydata()[0] for x in speed.get_lines() if len(set(x.get_ydata())) == 1] == [pytest.approx(mean)]
    bars = [(b.get_x() + b.get_width() / 2, b.get_y() + b.get_height()) for b in spectrum.patches]
    amplitudes = elastic.output_acceleration.values
    assert bars[:3] == [pytest.approx((k + 0.8, a)) for k, a in enumerate(amplitudes[0, :3])]
    assert bars[15:17] == [pytest.approx((k + 1.2, a)) for k, a in enumerate(amplitudes[1, :2])]
    assert [x.get_xdata()[0] for x in spectrum.get_lines() if len(x.get_xdata()) == 2] == [2.5], "the law ends at order 2"
    assert named(power)["at constant speed"].get_ydata() == pytest.approx(1e-3 * elastic.power_at_constant_speed.values)
    assert named(power)["eigenmotion"].get_ydata()[0] == 0.0
    assert list(cuts.get_lines()[0].get_xdata()) == [1, 2, 3]
    assert list(cuts.get_lines()[0].get_ydata()) == s["cut_residuals"]
    assert cuts.get_ylabel().replace("\n", " ") == "above order 2, over order 1"
    for k, name in enumerate(("original cam", "corrected cam")):
        assert named(sweep)[name].get_xdata() == pytest.approx(RPM * elastic.swept_speed.values)
        assert named(sweep)[name].get_ydata() == pytest.approx(np.degrees(elastic.residual_deviation.values[k]))
    assert named(sweep)["mean speed"].get_xdata()[0] == pytest.approx(mean)
    places = zip(elastic.resonance_order.values, elastic.resonance_speed.values, strict=True)
    assert [(t.get_text(), t.xy[0]) for t in sweep.texts] == [(f"k = {k}", pytest.approx(RPM * x)) for k, x in places]
    assert [b.get_x() + b.get_width() for b in excited.patches] == pytest.approx(np.degrees(elastic.excited_deviation.values))
    names = elastic.excited.values.tolist()
    assert [t.get_text() for t in excited.texts] == names, "the smallest on top"
    colours = {name.endswith("cam"): bar.get_facecolor() for name, bar in zip(names, excited.patches, strict=True)}
    assert len(set(colours.values())) == 2, "cams have another colour than laws"
    assert [bar.get_facecolor() == colours[True] for bar in excited.patches] == [name.endswith("cam") for name in names]
    residuals = np.maximum(elastic.twist_residual.values, 1e-6)
    assert [b.get_x() + b.get_width() for b in twist.patches] == pytest.approx(residuals)
    assert law.get_lines()[0].get_ydata() == pytest.approx(np.degrees(elastic.acceleration.values))


def test_panels_of_a_drive(driven: xr.Dataset) -> None:
    """All power in one unit; without cuts the law; the law's order in the figure of the cuts where it has one."""
    axes = wucht.draw(driven).axes
    assert [" ".join(a.get_ylabel().split()) for a in axes][4:] == [
        "acceleration of the cam's law (°/rad²)", "law of the corrected cam (°)",
    ]  # fmt: skip
    unit = 1e-3 if "kW" in axes[2].get_ylabel() else 1.0
    assert named(axes[2])["drive, corrected cam"].get_ydata() == pytest.approx(unit * driven.drive_power.values[1])
    for k, name in enumerate(("original", "corrected")):
        assert named(axes[3])[f"{name} cam"].get_ydata() == pytest.approx(unit * driven.drive_power.values[k])
        assert named(axes[3])[f"{name} cam"].get_color() == (COLOURS[1], COLOURS[0])[k]
    assert axes[5].get_lines()[0].get_ydata() == pytest.approx(np.degrees(driven.position.values))
