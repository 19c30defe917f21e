"""What a prediction states, with springs and with a drive: numbers of its variables."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import xarray as xr

import wucht
from wucht.cams.tables.camshaft import ShaftTable
from wucht.cams.tables.harmonic_law import HarmonicLawTable

LAW = HarmonicLawTable(coefficients={"mean": "0.5 rad", "cosine": ["-0.4 rad", "0.1 rad"]})
J0, J1, OMEGA, RPM = 20.0, 6.0, 50.0, 30 / math.pi
SPRINGS = {"output_frequency": "20 Hz", "shaft_stiffness": 4e6, "shaft_damping": 2000.0, "cam_inertia": 0.5}
LINEAR = {"kind": "linear", "slope": 200.0, "no_load_speed": "510 rpm"}


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


def test_as_many_orders_as_three_times_those_of_the_law_but_fifteen_at_least_and_a_hundred_at_most() -> None:
    for count, shown in ((2, 15), (6, 18), (34, 100)):
        law = HarmonicLawTable(coefficients={"mean": 0.5, "cosine": [0.4] + (count - 2) * [0.0] + [0.001]})
        assert predicted(law).order.values.tolist() == list(range(1, shown + 1))
