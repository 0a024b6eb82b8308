"""Curves that figures of flows show beside the run: writes `src/pellucid/gallery/flows/*.csv`."""

from pathlib import Path

import numpy as np
from scipy.special import jn_zeros

GALLERY = Path(__file__).parents[2] / "src/pellucid/gallery/flows"


def write(name: str, **columns: np.ndarray) -> None:
    """Write a table of a case; names of columns end in their unit, behind two underlines."""
    names = ",".join("{} [{}]".format(*column.replace("_per_", "/").split("__")) for column in columns)
    header = f"# validation/flows-exact-curves/curves.py\n{names}"
    np.savetxt(GALLERY / f"{name}.csv", np.column_stack(list(columns.values())), "%.8g", ",", header=header, comments="")


def tube() -> None:
    """Write the mean velocity of a liquid in a round tube after the start, in units of the steady one; the unit of time is the
    square of the radius divided by the kinematic viscosity (Szymanski 1932)."""
    root, time = jn_zeros(0, 200)[:, None], np.linspace(0.0, 1.5, 61)
    write(
        "round-tube-start",
        time__s=time,
        mean_velocity__m_per_s=1.0 - 32.0 * np.sum(np.exp(-(root**2) * time) / root**4, axis=0),
    )


def speed_in_array(share: float, radius: float, force: float, viscosity: float) -> float:
    """Return the speed of the spheres of a simple cubic array that fill a share of the volume, in the frame of no net flow of
    volume: the series of Sangani & Acrivos 1982, of which Hasimoto 1959 has the first terms."""
    third = share ** (1.0 / 3.0)
    by_drag = 1.0 - 1.7601 * third + share - 1.5593 * share**2 + 3.9799 * third**8 - 3.0734 * third**10
    return force / (6.0 * np.pi * viscosity * radius) * by_drag


def sphere() -> None:
    """Write the speed of the ball: the drag balances its force and its share of the mean pressure gradient."""
    radius, force = 0.22854, 0.5143
    share = 4.0 / 3.0 * np.pi * radius**3
    speed = speed_in_array(share, radius, force / (1.0 - share), 1.0)
    print(f"share {share:.5f}, speed {speed:.5f}")
    write("sphere-in-box", time__s=np.array([0.0, 0.25]), ball_velocity__m_per_s=np.array([speed, speed]))


if __name__ == "__main__":
    tube()
    sphere()
