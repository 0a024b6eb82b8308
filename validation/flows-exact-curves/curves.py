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


def pulsation() -> None:
    """Write the share of a pressure that swings, and the mean velocity in a channel of unit density and viscosity, from rest,
    under the gradient G cos(ωt): modes a_n sin(nπy/H) 4/(nπ) with a_n' + (nπ/H)² a_n = G cos(ωt), whose means over the
    height H are 8 a_n/(nπ)²."""
    gradient, height, frequency, end = 16.0, 2.0, 16.0, 0.8
    time, n = np.linspace(0.0, end, 401), np.arange(1, 400, 2)[:, None]
    decay = (n * np.pi / height) ** 2
    swing = decay * np.cos(frequency * time) + frequency * np.sin(frequency * time)
    modes = gradient * (swing - decay * np.exp(-decay * time)) / (decay**2 + frequency**2)
    write("womersley", time__s=time, mean_velocity__m_per_s=np.sum(8.0 / (n * np.pi) ** 2 * modes, axis=0))
    shares = np.column_stack([time, np.cos(frequency * time)])
    np.savetxt(GALLERY / "womersley-pressure.csv", shares, "%.8g", ",", header="time,share", comments="")


def tank() -> None:
    """Write the mass that has left a tank, 1 m² in area and filled 0.5 m high with water, through a slot of 0.1 m², with the
    coefficient of Kirchhoff 1869: the root of the depth falls at a constant rate."""
    time = np.linspace(0.0, 0.8, 81)
    root = np.sqrt(0.5) - np.pi / (np.pi + 2.0) * 0.1 * np.sqrt(0.5 * 9.81) * time
    write("torricelli", time__s=time, outflow_mass__kg=1000.0 * (0.5 - root**2))


if __name__ == "__main__":
    tube()
    tank()
    pulsation()
    sphere()
