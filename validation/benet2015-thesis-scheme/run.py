"""A circle of film that a load p (n·e) n drives, by the scheme of Benet 2015 (`thesis_film.py`) and by that of the package.

Writes roughness.csv and oscillation.png beside this script, in some seconds.
"""

import csv
from pathlib import Path

import numpy as np
import thesis_film  # noqa: F401  # registers the kind

from pellucid.case import Case, loads
from pellucid.errors import RunStopped
from pellucid.results.pictures.style import COLOURS, house_style, label, new_figure
from pellucid.simulation.simulation import Simulation

HERE = Path(__file__).parent
FILM = """
schema = 1
title = "Driven circle"

[time]
end = 8

[[body]]
name = "film"
kind = "{kind}"
shape = { ellipse = { radius = 1, nodes = 41 } }
material = { kind = "lipid-film", density = 1, viscosity = 1, dilatational_viscosity = 1, stiffness = 100 }
"""
LOAD = """
[[load]]
kind = "film-pressure"
body = "film"
value = 0.1
along = [0, -1, 0]
"""
TAUT = """
[[load]]
kind = "film-pressure"
body = "film"
value = 0.2
"""
OUTPUT = """
[output]
history = 0.05
"""
PAST_ITS_BALANCE = """
[energy]
warn = 10
stop = 10
"""
THESIS = FILM.replace("{kind}", "thesis-film") + "accuracy = 6e-3\n" + LOAD + OUTPUT + PAST_ITS_BALANCE
OURS = FILM.replace("{kind}", "fluid-film") + "drag = { normal = 1, tangential = 1 }\n" + LOAD + TAUT + OUTPUT


def followed(case: Case) -> tuple[list[float], list[np.ndarray]]:
    """Times [s], and normal velocities of the nodes beside the mean motion [m/s], until the end or where the run stops."""
    simulation = Simulation(case)
    film, times, found = simulation.bodies[0], [], []
    try:
        while not simulation.clock.finished(None):
            simulation.step()
            v = film.arrays["v"]
            times.append(simulation.time)
            found.append(np.einsum("ni,ni->n", film.geometry.normals(film.arrays["x"]), v - v.mean(axis=0)))
    except RunStopped as stop:
        print(stop)
    return times, found


def rough(normal: np.ndarray) -> float:
    """Size of the waves that are shorter than four nodes [m/s]."""
    return float(np.linalg.norm(np.fft.rfft(normal)[len(normal) // 4 :]) / len(normal))


def main() -> None:
    """Both runs, the table and the figure."""
    runs = {"thesis": followed(loads(THESIS, "thesis.toml")), "implicit, with drag": followed(loads(OURS, "ours.toml"))}
    with (HERE / "roughness.csv").open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(["scheme", "time", "roughness"])
        for name, (times, found) in runs.items():
            rows.writerows([name, f"{time:.3f}", f"{rough(values):.3e}"] for time, values in zip(times, found, strict=True))
    with house_style():
        figure = new_figure(10.0, 3.4)
        left, right = figure.subplots(1, 2)
        for colour, (name, (times, found)) in zip((COLOURS[1], COLOURS[0]), runs.items(), strict=True):
            left.semilogy(times, [rough(values) for values in found], color=colour, label=name)
            right.plot(
                1e3 * found[len(runs["thesis"][0]) - 1], ".-", color=colour, label=f"{name}, {runs['thesis'][0][-1]:.2g} s"
            )
        right.plot(1e3 * runs["thesis"][1][0], color="black", linewidth=1, label=f"thesis, {runs['thesis'][0][0]:.2g} s")
        label(left, "time", "waves shorter than four nodes", "s", "m/s")
        label(right, "node", "normal velocity beside the mean", "", "mm/s")
        left.legend()
        right.legend()
        figure.savefig(HERE / "oscillation.png")


if __name__ == "__main__":
    main()
