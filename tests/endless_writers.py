"""Checkpoints and frames with known numbers, and functions that write them one after the other until their process is
killed."""

from pathlib import Path
from typing import NoReturn

import numpy as np

from pellucid.results.storage import checkpoint, frames

POINTS = 60


def arrays(seed: int, size: int = 50) -> dict[str, np.ndarray]:
    generator = np.random.default_rng(seed)
    return {"gas/position": generator.random((size, 3)), "gas/id": generator.permutation(size)}


def frame(k: int) -> dict[str, np.ndarray]:
    generator = np.random.default_rng(k)
    return {
        "position": generator.random((POINTS, 3)),
        "velocity": generator.random((POINTS, 3)),
        "density": generator.random(POINTS),
        "stress": generator.random((POINTS, 6)),
        "mass": np.full(POINTS, 0.1),
        "id": np.arange(POINTS),
    }


def write_checkpoints(folder: Path, seed: int) -> NoReturn:
    """Write the checkpoints `arrays(seed)` of all seeds after a given one, without end."""
    while True:
        seed += 1
        checkpoint.write(folder, arrays(seed), {"seed": seed})


def append_frames(path: Path, count: int) -> NoReturn:
    """Append frames without end to a file that contains `count` frames."""
    while True:
        frames.append(path, 0.5 * count, frame(count))
        count += 1
