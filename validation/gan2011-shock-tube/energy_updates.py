"""The paper's comparison: how the energy equation is solved decides what the gas behind a strong shock does.

Runs the tube with every energy update, with and without the work of the artificial viscosity in the energy equation,
and with other coefficients of that viscosity, and writes energy_updates.csv, energy_updates.md and energy_updates.png.

    python energy_updates.py [--cell 0.00125]
"""

import argparse
import csv
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import pellucid
from pellucid.case import load
from pellucid.errors import RunStopped
from pellucid.references.gas_dynamics import QUANTITIES, Profile, Tube, points_of

HERE = Path(__file__).parent
VARIANTS = [  # energy update, does q do work, c0, c1, step over the paper's
    ("closed", True, 2.0, 1.0, 1),
    ("iterated", True, 2.0, 1.0, 1),
    ("explicit", True, 2.0, 1.0, 1),
    ("closed", False, 2.0, 1.0, 1),
    ("iterated", False, 2.0, 1.0, 1),
    ("explicit", False, 2.0, 1.0, 1),
    ("closed", True, 2.0, 1.0, 10),
    ("explicit", True, 2.0, 1.0, 10),
    ("closed", True, 2.0, 0.2, 1),
    ("closed", True, 1.0, 1.0, 1),
    ("closed", True, 0.0, 0.0, 1),
    ("explicit", True, 0.0, 0.0, 1),
]
HEAD = ["energy update", "work of q", "c0", "c1", "step / 2e-5 s", "stopped because"]
HEAD += ["densest point [kg/m^3]", "densest mean [kg/m^3]"]
HEAD += [f"L1 error of {name}" for name in QUANTITIES] + ["energy error"]


def run(cell, update, work, c0, c1, step):
    """The run, or None and why it stopped itself."""
    case = load("gan2011/shock-tube")
    settings = {"grid.cell": cell, "time.step": 2e-5 * step * cell / 0.00125, "energy.warn": 1e6, "energy.stop": 1e6}
    for body in ("driver", "driven"):
        material = f"body.{body}.material"
        viscosity = {"quadratic": c0, "linear": c1, "work": work}
        settings |= {f"{material}.energy_update": update, f"{material}.artificial_viscosity": viscosity}
    try:
        return pellucid.run(case.with_settings(settings)), None
    except RunStopped as stopped:
        return None, str(stopped)


def measure(found):
    """The numbers of the table, and the profile over four cells."""
    time, tube = float(found.times("driven")[-1]), Tube.of(found.case)
    profile, exact = Profile.of_points(points_of(found), tube.edges(4)), tube.mean_profile(time)
    behind = profile.centres > 0.5 * (tube.fronts(time)["fan tail"] + tube.fronts(time)["contact"])
    densest = float(found.fields("driven")["density"].max())
    row = ["", f"{densest:.4f}", f"{np.nanmax(profile.means['density'][behind]):.4f}"]
    row += [f"{profile.relative_l1(exact, name):.5f}" for name in QUANTITIES]
    return [*row, f"{found.summary['conservation']['energy']:.2e}"], profile


def draw(profiles, tube, time):
    """Density about the contact and the shock, for the variants with the paper's coefficients."""
    figure = Figure(figsize=(11, 7), layout="constrained")
    x = np.linspace(0.55, 0.75, 2000)
    for axes, name in zip(figure.subplots(2, 2, sharex=True).flat, QUANTITIES, strict=True):
        axes.plot(x, tube.exact(x, time)[name], color="black", linewidth=1, label="exact")
        for (update, work, *rest), profile in profiles.items():
            if rest == [2.0, 1.0, 1]:
                style = {"closed": "o", "iterated": "+", "explicit": "x"}[update]
                colour = "tab:blue" if work else "tab:red"
                text = f"{update}, q {'works' if work else 'does no work'}"
                near = (profile.centres > 0.55) & (profile.centres < 0.75)
                axes.plot(profile.centres[near], profile.means[name][near], style, color=colour, label=text)
        axes.set_xlabel("x [m]")
        axes.set_ylabel(f"{name.replace('_', ' ')} [{QUANTITIES[name]}]")
        axes.grid(alpha=0.3)
    figure.axes[0].legend(fontsize=8)
    figure.suptitle("Energy updates: means over four cells about the contact and the shock")
    figure.savefig(HERE / "energy_updates.png", dpi=130)


def main():
    """Run all variants and write the table and the figure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cell", type=float, default=0.00125)
    cell = parser.parse_args().cell
    rows, profiles = [], {}
    for variant in VARIANTS:
        found, stopped = run(cell, *variant)
        if found is None:
            print(*variant, stopped, sep="; ")
            rows.append([*variant, stopped, *[""] * (len(HEAD) - 6)])
            continue
        numbers, profiles[variant] = measure(found)
        rows.append([*variant, *numbers])
        print(*rows[-1], sep="; ", flush=True)
    with (HERE / "energy_updates.csv").open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows([HEAD, *rows])
    lines = [HEAD, ["---"] * len(HEAD), *rows]
    text = "\n".join("| " + " | ".join(str(value) for value in line) + " |" for line in lines)
    (HERE / "energy_updates.md").write_text(text + "\n", encoding="utf-8")
    draw(profiles, Tube.of(load("gan2011/shock-tube")), 0.143)


if __name__ == "__main__":
    main()
