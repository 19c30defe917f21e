"""Settled members are not called unidentified, however long the run: ``benchmarks.verdicts`` has the machines."""

import pytest
from benchmarks.verdicts import MACHINES, Tried

from wucht import Basin, CaptureProbability
from wucht.studies.runner import run

SERIES, SHUNT, TABLE = MACHINES[:3]
TURN = ["0 deg", "360 deg"]


@pytest.mark.parametrize(
    ("of", "until"),
    [
        (SERIES, 240.0),
        *(pytest.param(SERIES, until, marks=pytest.mark.slow) for until in (None, 60.0, 120.0)),
        *(pytest.param(of, until, marks=pytest.mark.slow) for of in (SHUNT, TABLE) for until in (None, 240.0)),
    ],
    ids=lambda value: getattr(value, "name", str(value)),
)
def test_all_starts_compensate_at_the_default_tolerance(of: Tried, until: float | None, request: pytest.FixtureRequest) -> None:
    """All of 12 x 12 starts were integrated independently, of the series motor; before, 2 to 50 % were unidentified."""
    cells = 6 if request.node.get_closest_marker("slow") else 2
    basin = Basin(axes={"p1": [*TURN, cells], "p2": [*TURN, cells]}, until=until)
    assert basin.tolerance == 1e-6
    assert run(basin, of.machine()).wucht.summary["fractions"] == {"compensated": 1.0}


@pytest.mark.slow
def test_so_does_capture_probability() -> None:
    random = {name: {"uniform": TURN} for name in ("p1", "p2")}
    asked = CaptureProbability(along="drive.voltage", range=["40 V", "44 V"], points=2, samples=64, random=random, until=240.0)
    summary = run(asked, SERIES.machine()).wucht.summary
    assert [p["estimate"] for p in summary["probability"]] == [1.0, 1.0]
    assert all(p["low"] > 0.9 for p in summary["probability"])
