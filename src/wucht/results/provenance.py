"""Where a result comes from: the whole input, versions and wall time."""

from __future__ import annotations

import json
import platform
from collections.abc import Mapping
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import Any

_PACKAGES = ("wucht", "numpy", "scipy", "sympy", "heyoka", "xarray")


@cache
def versions() -> dict[str, str]:
    """The versions of wucht, Python and the libraries that compute."""
    installed = {"python": platform.python_version()}
    for package in _PACKAGES:
        try:
            installed[package] = version(package)
        except PackageNotFoundError:
            installed[package] = "not installed"
    return installed


def provenance(question: Mapping[str, Any], elapsed_s: float) -> dict[str, str | float]:
    """Attributes for a Dataset. question: what was asked, of what."""
    return {
        "input": json.dumps(question, default=str),
        "versions": json.dumps(versions()),
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
        "elapsed_s": elapsed_s,
    }
