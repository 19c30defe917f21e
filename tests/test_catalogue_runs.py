"""Every file of the catalogue runs as it stands and gives these numbers."""

import pytest

from wucht.machines.catalogue import names
from wucht.studies.files import read_study
from wucht.studies.run_up import run_up, summary

# name: outcome, final speed, peak amplitude, relative tolerance of both. The speeds of R1 and of the Laval rotor are those of
# cases.md; peaks and the rest are what the program gave when it was checked against SciPy (tests/validation), six digits.
EXPECTED = {
    "drozdetskaya-2020/r1": ("captured-modulated", None, 0.0109721),
    "drozdetskaya-2020/r1-u1": ("captured", 70.2895, 0.00301062),
    "drozdetskaya-2020/r1-u40": ("compensated", 200.0, 0.0105593),
    "drozdetskaya-2020/r1-u80": ("compensated", 200.0, 0.00892762),
    "drozdetskaya-2020/r2": ("captured-modulated", None, 0.0139480),
    "drozdetskaya-2020/r2-u80": ("compensated", 200.0, 0.0113056),
    "drozdetskaya-2020/table-3.1-carrier": ("captured", 0.96866, 4.61483),
    "drozdetskaya-2020/table-3.1-laval": ("captured", 0.9686444, 4.62447),
    "drozdetskaya-2020/table-5.1": ("captured-modulated", None, 8.67954),
    "drozdetskaya-2020/table-a.1": ("captured-modulated", None, 5.27481),
    "practice/angle-grinder": ("compensated", 1130.19, 0.0001374),
    "practice/laboratory-centrifuge": ("compensated", 418.66, 0.0002013),
    "practice/laundry-drum": ("compensated", 126.13, 0.01343),
}


def test_every_file_is_listed() -> None:
    assert sorted(EXPECTED) == names()


@pytest.mark.parametrize("name", sorted(EXPECTED))
def test_runs_and_gives_its_numbers(name: str) -> None:
    outcome, speed, peak = EXPECTED[name]
    study = read_study(name)
    found = summary(run_up(study.machine, study.question))
    assert found["outcome"] == outcome
    if speed is not None:
        assert found["final_speed"] == pytest.approx(speed, rel=1e-4)
    # 24 samples a turn meet the peak of a circular orbit to better than 1e-4, that of |x| to (pi/24)^2/2 = 0.9 %.
    assert found["peak_amplitude"] == pytest.approx(peak, rel=1e-2)
    assert found["energy_residual"] < 1e-9
