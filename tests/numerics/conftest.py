"""The engines to test: what must hold on one holds on all."""

from importlib.util import find_spec

import pytest

HEYOKA = pytest.param("heyoka", marks=pytest.mark.skipif(not find_spec("heyoka"), reason="heyoka is not installed"))
COMPILED = pytest.param("compiled", marks=pytest.mark.skipif(not find_spec("llvmlite"), reason="llvmlite is not installed"))


@pytest.fixture(params=[HEYOKA, COMPILED, "scipy"])
def engine(request):
    return request.param


@pytest.fixture(params=[HEYOKA, COMPILED, "scipy", "scipy-radau"])
def any_engine(request):
    return request.param
