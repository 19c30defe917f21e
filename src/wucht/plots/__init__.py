"""Dataset -> figure. One file a study; nothing here knows more than the Dataset."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wucht.errors import InputError

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def draw(result: xr.Dataset) -> Figure:
    """The figure of a result. Raises ``InputError`` for a study that has none."""
    study = str(result.attrs.get("study"))
    if study == "run-up":
        from wucht.plots.run_up import figure

        try:
            return figure(result)
        except (AttributeError, IndexError, KeyError, ValueError) as error:
            raise InputError("run-up", None, f"this is no complete result of a run-up: {error}") from None
    raise InputError("study", study, "there is no figure for this study; known: run-up")
