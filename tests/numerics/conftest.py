"""The integrators to test: what must hold of the explicit one holds of the implicit one."""

import pytest


@pytest.fixture(params=["compiled", "radau"])
def engine(request):
    return request.param
