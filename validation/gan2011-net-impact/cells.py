"""Runs at several cells beside the finite elements, for net-impact and for membrane-expansion: a table and a figure.

    pellucid run gan2011/net-impact --set grid.cell=0.05 --out runs/net-0.05
    ...
    python cells.py FIGURE.png runs/net-0.05 runs/net-0.025 runs/net-0.02

prints the largest deviations over the largest change of the finite elements, as a table in Markdown.
"""

import sys
from pathlib import Path

from pellucid.references import finite_elements
from pellucid.results.pictures.style import DPI, LINES, house_style, label, new_figure
from pellucid.results.storage.run import Run

CURVES = {
    "gan2011/net-impact": (
        "net_impact",
        ("tied", "sliding"),
        {"cuboid_z": ("cuboid's centre, z", "m"), "net_z": ("net's middle, z", "m")},
    ),
    "gan2011/membrane-expansion": (
        "membrane_expansion",
        ("flowing", "uniform"),
        {"cube_z": ("cube's centre, z", "m"), "gas_pressure": ("mean pressure of the gas", "Pa")},
    ),
}


def main(figure_path: Path, folders: list[str]) -> None:
    runs = [Run(folder) for folder in folders]
    table, variants, columns = CURVES[runs[0].case.id]
    reference = finite_elements.read(table)
    with house_style():
        figure = new_figure(height=4.0)
        for axes, (name, (text, unit)) in zip(figure.subplots(1, len(columns)), columns.items(), strict=True):
            for variant, line in zip(variants, ("-", ":"), strict=True):
                known = f"{variant}_{name}"
                axes.plot(
                    reference["time"], reference[known], "k", linestyle=line, linewidth=1, label=f"finite elements, {variant}"
                )
            for run, line in zip(runs, LINES[1:] + LINES[:1], strict=False):
                axes.plot(run.history["time"], run.history[name], linestyle=line, label=f"cell {run.case.grid.cell:g} m")
            label(axes, "time", text, "s", unit)
        figure.axes[0].legend()
        figure.draw_without_rendering()
        figure.savefig(figure_path, dpi=DPI)
    print(
        f"| cell [m] | points | {' | '.join(columns)} | at the end | energy error |\n|---|---|{'---|' * len(columns)}---|---|"
    )
    for run in runs:
        errors = [
            finite_elements.largest_deviation(
                run.history["time"], run.history[name], reference["time"], reference[f"{variants[0]}_{name}"]
            )
            for name in columns
        ]
        first = next(iter(columns))
        print(
            f"| {run.case.grid.cell:g} | {run.summary['points']} | {' | '.join(f'{100 * error:.2f} %' for error in errors)} | "
            f"{run.history[first][-1]:.5f} | {100 * run.summary['conservation']['energy']:.2f} % |"
        )


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
