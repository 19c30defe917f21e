"""Random quantities by their distributions: against those of SciPy, and what is refused."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy import stats
from tests.refusals import Refusal, refused

from wucht.dynamics.sampling.distributions import check_form, distribution_in_words, distribution_of
from wucht.schema import Unit

LENGTH = Unit("m", "length")
SHARES = np.array([1e-12, 1e-4, 0.02, 0.25, 0.5, 0.6, 0.9, 0.999, 1 - 1e-12])
SIGMA = math.log(1.5)


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({"uniform": ["-1 mm", "3 mm"]}, stats.uniform(-1e-3, 4e-3)),
        ({"normal": ["2 mm", "0.5 mm"]}, stats.norm(2e-3, 5e-4)),
        ({"normal": ["2 mm", 5e-4], "between": ["1 mm", "4 mm"]}, stats.truncnorm(-2, 4, 2e-3, 5e-4)),
        ({"normal": [0.0, 1.0], "between": [4.0, 5.0]}, stats.truncnorm(4, 5)),
        ({"normal": [0.0, 1.0], "between": [-5.0, -4.0]}, stats.truncnorm(-5, -4)),
        ({"log-normal": ["2 mm", 1.5]}, stats.lognorm(SIGMA, scale=2e-3)),
        ({"triangular": ["1 mm", "2 mm", "5 mm"]}, stats.triang(0.25, 1e-3, 4e-3)),
        ({"triangular": [0.0, 0.0, 1.0]}, stats.triang(0.0)),
        ({"triangular": [0.0, 1.0, 1.0]}, stats.triang(1.0)),
    ],
)
def test_as_scipy_has_them(given: dict[str, Any], expected: Any) -> None:
    check_form(given, "study.random.x")
    values = distribution_of(given, LENGTH, "study.random.x").quantiles(SHARES)
    scale = expected.std()
    assert np.allclose(values, expected.ppf(SHARES), rtol=1e-7, atol=1e-7 * scale)
    assert (np.diff(values) > 0).all()


def test_a_log_normal_one_that_is_cut_off() -> None:
    """Its distribution function is that of the whole, shifted and stretched; 68 % of the whole lie within the factor."""
    whole, cut = (
        distribution_of({"log-normal": [2.0, 1.5]} | more, LENGTH, "study.random.x")
        for more in ({}, {"between": [0.0, 2.0 * 1.5]})
    )
    assert np.allclose(whole.quantiles(stats.norm.cdf([-1.0, 1.0])), [2.0 / 1.5, 2.0 * 1.5])
    below = stats.norm.cdf(1.0)
    assert np.allclose(cut.quantiles(SHARES[:-1]), whole.quantiles(SHARES[:-1] * below), rtol=1e-9)
    assert cut.quantiles(np.array([1.0]))[0] == pytest.approx(3.0)


@pytest.mark.parametrize(
    ("given", "where", "refusal"),
    [
        ({}, "", refused("study.random.x", given={})),
        ({"uniform": [0, 1], "normal": [0, 1]}, "", refused("study.random.x", given={"uniform": [0, 1], "normal": [0, 1]})),
        ({"unifrom": [0, 1]}, ".unifrom", refused("study.random.x.unifrom", "uniform", given=[0, 1])),
        ({"uniform": [0, 1, 2]}, ".uniform", refused("study.random.x.uniform", given=[0, 1, 2])),
        ({"uniform": 3.0}, ".uniform", refused("study.random.x.uniform", given=3.0)),
        ({"uniform": [0, 1], "between": [0, 1]}, ".between", refused("study.random.x.between", given=[0, 1])),
        ({"uniform": ["3 mm", "1 mm"]}, ".uniform", refused("study.random.x.uniform", given=["3 mm", "1 mm"], code="shape")),
        ({"uniform": ["3 kg", "1 mm"]}, ".uniform[0]", refused("study.random.x.uniform[0]", code="dimension")),
        ({"uniform": [True, 1]}, ".uniform[0]", refused("study.random.x.uniform[0]", code="no-quantity")),
        ({"normal": [1.0, 0.0]}, ".normal", refused("study.random.x.normal", given=[1.0, 0.0], code="deviation")),
        ({"normal": [1.0, 0.1], "between": [2.0, 1.0]}, ".between", refused("study.random.x.between", given=[2.0, 1.0])),
        (
            {"normal": [1.0, 0.1], "between": [2.0, 3.0]},
            ".between",
            refused("study.random.x.between", "1e-06", given=[2.0, 3.0]),
        ),
        ({"log-normal": [1.0, 0.9]}, ".log-normal", refused("study.random.x.log-normal", given=[1.0, 0.9], code="factor")),
        ({"log-normal": [-1.0, 1.2]}, ".log-normal", refused("study.random.x.log-normal", given=[-1.0, 1.2], code="factor")),
        ({"log-normal": [1.0, "1.2 mm"]}, ".log-normal[1]", refused("study.random.x.log-normal[1]", code="dimension")),
        ({"log-normal": [1.0, 1.2], "between": [-1.0, 2.0]}, ".between", refused("study.random.x.between", given=[-1.0, 2.0])),
        (
            {"triangular": [0.0, 2.0, 1.0]},
            ".triangular",
            refused("study.random.x.triangular", given=[0.0, 2.0, 1.0], code="shape"),
        ),
    ],
)
def test_what_is_refused(given: dict[str, Any], where: str, refusal: Refusal) -> None:
    with refusal as raised:
        check_form(given, "study.random.x")
        distribution_of(given, LENGTH, "study.random.x")
    assert raised.value.location == f"study.random.x{where}"


def test_distributions_in_words() -> None:
    cut = {"between": ["1 mm", "4 mm"], "normal": ["2 mm", "1 mm"]}
    assert distribution_in_words(cut) == "normal: mean 2 mm, deviation 1 mm, between 1 mm and 4 mm"
    assert distribution_in_words({"triangular": [0, 1, 3]}) == "triangular: low 0, mode 1, high 3"
