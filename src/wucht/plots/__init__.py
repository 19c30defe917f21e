"""Dataset -> figure. One file a study; nothing here knows more than the Dataset."""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING

from wucht.errors import InputError

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def draw(result: xr.Dataset) -> Figure:
    """The figure of a result. Raises ``InputError`` for a study that has none, or a result that is not complete."""
    study = str(result.attrs.get("study"))
    module = f"{__name__}.{study.replace('-', '_')}"
    if not study.replace("-", "").isalpha() or find_spec(module) is None:
        raise InputError("study", study, "there is no figure for this study")
    try:
        drawn: Figure = import_module(module).figure(result)
    except (AttributeError, IndexError, KeyError, ValueError) as error:
        raise InputError(study, None, f"this is no complete result of this study: {error}") from None
    return drawn
