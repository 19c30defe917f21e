"""Every script in examples/ runs and gives these numbers."""

import importlib.util
import math
import re
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import solve_ivp

from wucht.cams.correction import CorrectedLaw, MotionOverTime, orders, share_above_order
from wucht.cams.milled_cam import milled_motion
from wucht.cams.shaft_motion import ShaftMotion
from wucht.cams.workshop.lists import read_list
from wucht.files.catalogue import load_machine
from wucht.numerics.fourier_series import FourierSeries, even_angles
from wucht.studies.study_file import read_study

EXAMPLES = Path(__file__).parent.parent / "examples"


def _load(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_every_example_is_tested_here() -> None:
    assert sorted(p.stem for p in EXAMPLES.glob("*.py")) == [
        "averaging_alone", "cam_for_an_uneven_shaft", "hardening_spring", "lorenz", "numerics_alone", "own_cam",
        "own_equations", "own_part", "own_study", "van_der_pol",
    ]  # fmt: skip


def test_a_part_of_our_own_is_one_class() -> None:
    module = _load("own_part")
    weak, _ = module.main("0.3 N m")
    strong, speed = module.main("10 N m")
    assert weak == "captured"
    assert strong == "passed"
    # Torque balance beyond the resonance: 10 (1 - (w/200)^2) = c w^5 U^2/((k - m w^2)^2 + (c w)^2), U = 0.01, m = 10, k = 1e5,
    # c = 200: w = 199.33; the last digit of the run depends on when it counts as settled.
    torque = 200 * speed**5 * 1e-4 / ((1e5 - 10 * speed**2) ** 2 + (200 * speed) ** 2)
    assert 10 * (1 - (speed / 200) ** 2) == pytest.approx(torque, rel=1e-3)


def test_a_law_and_a_follower_of_our_own_are_one_class_each(wucht: Callable[..., Any], here: Path) -> None:
    imported = ("--import", EXAMPLES / "own_cam.py")
    listed = wucht("list", *imported).out
    assert {"cubic", "knife-edge"} <= {*re.findall(r"[\w-]+", listed)}
    keys = {key["name"]: key for key in wucht("list", "knife-edge", "--json", *imported).document["tables"][0]["keys"]}
    assert (keys["offset"]["unit"], keys["distance"]["needed"]) == ("m", True)
    (here / "edge.toml").write_text(sys.modules["own_cam"].FILE)
    ask = ("run", "edge.toml", *imported, "--json")
    s = wucht(*ask, "--set", "study.kind=cam-law").document["summary"]
    arc, stroke, D, e = 2 * math.pi / 3, 0.02, 0.05, 0.01
    # s = 3 x^2 - 2 x^3: s' is at most 3/2, s'' 6, at the ends, and s''' 12 everywhere.
    assert s["rise"] == pytest.approx({"velocity": 1.5, "acceleration": 6.0, "jerk": 12.0}, rel=1e-12)
    assert s["stroke"] == pytest.approx(stroke)
    assert s["peaks"]["velocity"] == pytest.approx(1.5 * stroke / arc, rel=1e-12)
    assert s["acceleration_jumps"] == pytest.approx(6 * stroke / arc**2, rel=1e-12)

    ask = (*ask, "--set", "study.speed=60 rpm")
    contact = 'study.contact={ mass = "2 kg", preload = "100 N" }'
    done = wucht(*ask, "--set", contact, "-o", "out")
    assert done.code == 0, done.err
    s = done.document["summary"]
    assert (s["follower"], s["outcome"], s["cams"]["cam"]["undercut"]) == ("knife-edge", "cuttable", [])
    assert s["base_radius"] == pytest.approx(math.hypot(D, e), rel=1e-9)
    assert s["largest_radius"] == pytest.approx(math.hypot(D + stroke, e), rel=1e-9)
    # tan alpha = (e + |s'|)/(D + s) on the side where the offset makes it steeper.
    x = np.linspace(0, 1, 200_001)
    tangent = (6 * stroke / arc * x * (1 - x) + e) / (D + stroke * x**2 * (3 - 2 * x))
    assert s["max_pressure_angle"] == pytest.approx(math.atan(tangent.max()), rel=1e-8)
    with xr.open_dataset(here / "out" / "result.nc") as result:  # at rest the edge bears the preload over cos alpha
        assert float(result.contact_force[0, 0]) == pytest.approx(100 * math.hypot(1, e / D), rel=1e-12)
    exported = wucht("export", "out/result.nc", *imported, "-o", "mill")
    assert exported.code == 0, exported.err
    assert float(re.search(r"deviates from its law by (\S+)", exported.out)[1]) < 1e-6
    assert len(read_list(here / "mill" / "cam.txt").position) == s["cams"]["cam"]["points_to_mill"]
    wide = wucht(*ask, "--set", contact.replace(" }", ', width = "5 mm" }'))
    assert (wide.code, "study.contact.width" in wide.err) == (2, True)
    wrong = wucht(*ask, "--set", "follower.kind=knive-edge")
    assert (wrong.code, "did you mean 'knife-edge'?" in wrong.err) == (2, True)


def test_averaging_without_a_machine() -> None:
    module = _load("averaging_alone")
    assert str(module.slow(1).system.derivatives[0].expand()) == "-mu*r**3/8 + mu*r/2"
    # Errors at twice the small parameter: twice, and four times as large (measured 1.90 and 4.22).
    for order in (1, 2):
        ratio = module.largest_error(order, 0.04) / module.largest_error(order, 0.02)
        assert ratio == pytest.approx(2**order, rel=0.1)


def test_numerics_without_a_machine() -> None:
    actual = _load("numerics_alone").periods()
    # For small mu the period is 2 pi (1 + mu^2/16 - 5 mu^4/3072 + ...) (Lindstedt's series).
    assert actual[0] == pytest.approx(2 * math.pi * (1 + 0.01 / 16 - 5e-4 / 3072), rel=1e-8)
    for mu, period in zip((1.0, 5.0), actual[1:], strict=True):
        assert period == pytest.approx(_period_by_scipy(mu), rel=1e-9)


def _period_by_scipy(mu: float) -> float:
    def zero(_t: float, y: np.ndarray) -> float:
        return float(y[0])

    zero.direction = 1  # type: ignore[attr-defined]

    def oscillator(_t: float, y: np.ndarray) -> list[float]:
        return [y[1], mu * (1 - y[0] ** 2) * y[1] - y[0]]

    run = solve_ivp(oscillator, (0, 200), [2.0, 0.0], "DOP853", events=zero, rtol=1e-13, atol=1e-13)
    return float(run.t_events[0][-1] - run.t_events[0][-2])


def test_a_study_of_our_own_is_one_file(wucht: Callable[..., Any], here: Path) -> None:
    """From the command line, with nothing changed in the package: run, plot, new, list and a wrong key.

    Without coupling of the directions the frequencies are sqrt(c/m), where m is all that the carrier carries.
    """
    imported = ("--import", EXAMPLES / "own_study.py")
    poles = (*imported, "--set", "study.kind=poles")
    summary = wucht("run", "practice/laundry-drum", *poles, "-o", "out", "--json").document["summary"]
    values = load_machine("practice/laundry-drum").values
    mass = sum(v for k, v in values.items() if k.endswith(".mass"))
    frequencies = [pole["frequency"] for pole in summary["poles"]]
    assert frequencies == pytest.approx([math.sqrt(values[f"carrier.stiffness.{a}"] / mass) for a in "xy"], rel=1e-9)
    assert (here / "out" / "poles.png").stat().st_size > 5000
    assert wucht("plot", "out/result.nc", *imported, "-o", "again").code == 0
    assert "poles" in wucht("list", *imported).out
    assert wucht("new", "poles", *imported).code == 0
    written = wucht("run", "poles.toml", *imported, "--json").document["summary"]
    assert written["poles"] == summary["poles"]
    refused = wucht("run", "practice/laundry-drum", *poles, "--set", "study.bellow=3")
    assert (refused.code, "below" in refused.err) == (2, True)
    none = wucht("run", "practice/laundry-drum", *poles, "--set", "study.below=0.001")
    assert (none.code, "no pole has a smaller angular frequency" in none.err) == (2, True)


@pytest.mark.slow
def test_from_a_motion_task_and_a_record_to_the_points_to_mill(tmp_path: Path) -> None:
    """On the shaft as it truly turns, the milled cam leaves what the noise of the record does; the original one a lot."""
    module = _load("cam_for_an_uneven_shaft")
    module.main(tmp_path)
    drive = read_study(str(tmp_path / "task.toml")).subject
    truth = ShaftMotion(FourierSeries.of(module.MEAN, module.COSINE, module.SINE))
    fitted = drive.shaft_motion.speed
    assert fitted.cosine == pytest.approx(module.COSINE, abs=0.01)
    assert fitted.sine == pytest.approx(module.SINE, abs=0.01)
    milled = read_list(tmp_path / "mill" / "cam.txt").position
    phi = truth.angle(even_angles(1024))
    law = CorrectedLaw(drive.motion_law.function, drive.shaft_motion)
    motion = FourierSeries.from_samples(milled_motion(milled, drive.follower, phi, law(phi)))
    acceleration = motion.derivative(2).amplitudes
    assert acceleration[5:30].max() < 5e-3 * acceleration[0]
    assert share_above_order(orders(MotionOverTime(drive.motion_law.function, truth)), 5) > 0.5
    assert (tmp_path / "cam-correction.png").exists()


def test_equations_of_ones_own_have_three_attractors() -> None:
    """SciPy's DOP853 gives the same equilibrium, and the same period of the orbit as the time between maxima of x."""
    example = _load("own_equations")
    periodic, chaotic, steady = (example.run_from(start).wucht.summary for start in example.STARTS)
    assert [s["outcome"] for s in (periodic, chaotic, steady)] == ["periodic", "chaotic", "equilibrium"]
    assert chaotic["lyapunov_exponent"]["low"] > 0

    def rates(_: float, state: np.ndarray) -> list[float]:
        (x, y, z), (f, g, a, b) = state, example.PARAMETERS.values()
        return [-(y**2) - z**2 - a * x + a * f, x * y - y - b * x * z + g, b * x * y + x * z - z]

    def turns(_: float, state: np.ndarray) -> float:
        return rates(0.0, state)[0]

    turns.direction = -1  # type: ignore[attr-defined]
    exact = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-12}
    end = solve_ivp(rates, (0, 400), [2.0, 1.0, 0.0], **exact).y[:, -1]
    maxima = solve_ivp(rates, (0, 40), end, events=turns, **exact)
    highest = maxima.t_events[0][np.isclose(maxima.y_events[0][:, 0], maxima.y_events[0][:, 0].max(), atol=1e-6)]
    assert periodic["period"] == pytest.approx(np.diff(highest).mean(), rel=1e-6)
    rest = solve_ivp(rates, (0, 100), [0.0, 1.5, 1.0], **exact).y[:, -1]
    assert list(steady["state"].values()) == pytest.approx(rest, abs=1e-9)


def test_orbits_of_van_der_pol() -> None:
    """Against SciPy: the period between passages, and by Liouville's formula ln of the multiplier, the integral of
    mu (1 - x^2) over it.
    """
    cases = _load("van_der_pol").orbits([0.5, 2.0]).wucht.summary["cases"]

    def passage(_: float, state: np.ndarray) -> float:
        return float(state[1])

    passage.direction = -1  # type: ignore[attr-defined]
    for case, mu in zip(cases, (0.5, 2.0), strict=True):

        def rates(_: float, s: np.ndarray, mu: float = mu) -> list[float]:
            return [s[1], mu * (1 - s[0] ** 2) * s[1] - s[0], mu * (1 - s[0] ** 2)]

        run = solve_ivp(rates, (0, 80), [2.0, 0.0, 0.0], method="DOP853", rtol=1e-11, atol=1e-12, events=passage)
        times, states = run.t_events[0], run.y_events[0]
        assert case["period"] == pytest.approx(times[-1] - times[-2], rel=1e-8)
        ((multiplier, imaginary),) = case["multipliers"]
        assert (math.log(multiplier), imaginary) == (pytest.approx(states[-1][2] - states[-2][2], rel=1e-5), 0.0)
        assert (case["value"], case["stable"]) == (mu, True)


def test_lorenz_has_two_equilibria_with_equal_shares() -> None:
    """At r = 10 they are at x = y = +- sqrt(b (r - 1)), z = r - 1; x -> -x, y -> -y maps one basin on the other."""
    s = _load("lorenz").basins(cells=8).wucht.summary
    assert s["fractions"] == {"equilibrium-1": 0.5, "equilibrium-2": 0.5}
    places = sorted(tuple(a["state"].values()) for a in s["attractors"])
    root = math.sqrt(24)
    assert places == [pytest.approx((-root, -root, 9.0)), pytest.approx((root, root, 9.0))]


@pytest.mark.slow
def test_lorenz_is_chaotic() -> None:
    """J. C. Sprott, "Chaos and Time-Series Analysis", Oxford 2003, table A.5.1: largest exponent 0.9056."""
    s = _load("lorenz").motion().wucht.summary
    exponent = s["lyapunov_exponent"]
    assert s["outcome"] == "chaotic"
    assert abs(exponent["value"] - 0.9056) < 1.5 * (exponent["high"] - exponent["low"])


@pytest.mark.slow
def test_a_hardening_spring_jumps_where_one_harmonic_says() -> None:
    """A cos(w t - phase): A^2 ((1 - w^2 + 3/4 g A^2)^2 + (2 d w)^2) = f^2 has one root A^2 below the first jump and beyond the
    last one, three between them. The third harmonic, some g A^2/32 of the first, is left out: one step is 0.005.
    """
    example = _load("hardening_spring")
    jumps = {j["direction"]: j["w"] for j in example.sweep().wucht.summary["jumps"]}
    d, g, f, _ = example.PARAMETERS.values()

    def states(w: float) -> int:
        a, b = 1 - w**2, 0.75 * g
        roots = np.roots([b**2, 2 * a * b, a**2 + (2 * d * w) ** 2, -(f**2)])
        return int((np.abs(roots.imag) < 1e-9).sum())

    grid = np.linspace(*example.RANGE, 6001)
    several = grid[[states(w) == 3 for w in grid]]
    assert (jumps["down"], jumps["up"]) == pytest.approx((several[0], several[-1]), abs=0.01)
