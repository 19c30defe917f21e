"""Sound files (WAV)."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np

from wucht.measurements.optional_library import reading
from wucht.measurements.recording import FULL_SCALE, Channel, Recording


def read_sound(path: Path) -> Recording:
    """The channels "1", "2", ... of a sound file, time from 0 s, values between -1 and 1 in ``FULL_SCALE``.

    A sound file has no units: give a channel some with ``Channel.scaled``. Raises ``InputError`` for a file that is no sound.
    """
    from scipy.io import wavfile

    with reading(path, "a sound file"), warnings.catch_warnings():
        warnings.simplefilter("ignore", wavfile.WavFileWarning)  # of chunks that hold no samples
        rate, samples = wavfile.read(path)
        if not len(samples):
            raise ValueError("it has no samples")
    columns = samples.reshape(len(samples), -1)
    time = np.arange(len(columns)) / rate
    source = str(path)

    def load(name: str) -> Channel:
        return Channel(source, name, FULL_SCALE, time, _to_full_scale(columns[:, int(name) - 1]))

    return Recording(source, tuple(str(i + 1) for i in range(columns.shape[1])), load)


def _to_full_scale(values: np.ndarray) -> np.ndarray:
    """Integers of any width between -1 and 1; unsigned ones have their zero in the middle."""
    if values.dtype.kind == "f":
        return values.astype(float)
    full = 2.0 ** (8 * values.dtype.itemsize - 1)
    return (values - (full if values.dtype.kind == "u" else 0.0)) / full
