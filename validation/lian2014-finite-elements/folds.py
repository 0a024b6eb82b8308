"""The corner of the sheet in membrane-on-sphere for elements of several sizes, sheets that differ by noise: a figure.

python folds.py FIGURE.png        # some 3 minutes
"""

import sys

import numpy as np
from explicit import Choice, run

from pellucid.results.pictures.style import COLOURS, DPI, house_style, label, new_figure
from reference import NOISE

CASE = "membrane-on-sphere"
SIZES = ((2e-3, 6), (1e-3, 6), (5e-4, 6), (2.5e-4, 3))


def main(path: str) -> None:
    with house_style():
        figure = new_figure(height=3.8)
        axes = figure.subplots()
        for (spacing, count), colour in zip(SIZES, COLOURS, strict=False):
            sheets = [run(Choice(CASE, spacing, rigid=True, noise=NOISE, seed=seed)) for seed in range(1, count + 1)]
            ms = 1e3 * sheets[0].times
            heights = 1e3 * np.array([sheet.curves[:, 1] for sheet in sheets])
            axes.plot(ms, heights.T, color=colour, linewidth=0.6, alpha=0.6)
            axes.plot(
                ms, heights.mean(0), color=colour, linewidth=2, label=f"{1e3 * spacing:g} mm, {count} sheets and their mean"
            )
        relaxed = run(Choice(CASE, 5e-4, rigid=True, tension_field=True))
        axes.plot(1e3 * relaxed.times, 1e3 * relaxed.curves[:, 1], "k:", label="0.5 mm, bears no compression")
        label(axes, "time", "z of the corner", "ms", "mm")
        axes.legend()
        figure.draw_without_rendering()
        figure.savefig(path, dpi=DPI)


if __name__ == "__main__":
    main(sys.argv[1])
