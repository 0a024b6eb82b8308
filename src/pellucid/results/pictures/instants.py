"""Choice of the frames that a picture or film shows."""

from collections.abc import Iterable

import numpy as np


def evenly(times: np.ndarray, most: int) -> np.ndarray:
    """Choose at most `most` of the times [s] at even intervals, including the first and the last; for `most` = 1, the last."""
    return times[-1:] if most == 1 else times[np.unique(np.linspace(0, len(times) - 1, most).round().astype(int))]


def recorded(frames: np.ndarray, times: Iterable[float]) -> np.ndarray:
    """Return the times [s] of the stored frames that are nearest to the given times [s], without duplicates.

    frames: times of all frames [s]. Given times that the run did not reach are omitted; if the run reached none of the
    given times, the time of the last frame is returned.
    """
    reached = [time for time in times if time <= 1.01 * frames[-1]] or [frames[-1]]
    return np.unique([frames[np.argmin(np.abs(frames - time))] for time in reached])
