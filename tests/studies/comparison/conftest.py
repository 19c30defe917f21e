"""The study that recites is known while a test of this folder runs."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from tests.studies.comparison.recital import Recital


@pytest.fixture
def recital(here: Path) -> Iterator[None]:
    """In a folder of its own."""
    Recital.kind = "recital"
    yield
    Recital.kind = ""
