"""Draw docs/images/architecture.png, the picture of docs/architecture.md. Run it with `python docs/architecture_picture.py`."""

from pathlib import Path

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt

TARGET = Path(__file__).parent / "images" / "architecture.png"
BOXES = [  # column, row, room, text
    (0, 0, "case file", "[[body]] … material =\n{ kind, density, … }"),
    (1, 0, "case/", "Case: data model, units,\nchecks with file and line"),
    (2, 0, "materials/, bodies/", "law(): a NamedTuple\nbuild(): a body, its arrays"),
    (3, 0, "simulation/", "bodies, velocity fields,\nconditions on one clock"),
    (3, 1, "simulation/schemes", "stages of a step, in order:\nno physics, no output"),
    (2, 1, "bodies/", "the body's part of a stage:\nits passes, its sums"),
    (1, 1, "grid/straining …", "pass: law, what is read,\ngathered, kept, summed"),
    (0, 1, "grid/passes/each_point", "the loop: slabs, threads,\nblocks, vectors, faults"),
    (0, 2, "materials/<law>.py", "point functions: one point,\nscalars, no allocation"),
    (1, 2, "grid/nodal_fields", "momentum, mass, forces,\nvelocities of the nodes"),
    (2, 2, "energy/, probes", "sums of slabs in order:\nbalance, bound on the step"),
    (3, 2, "results/", "history, fields, checkpoint,\nfigures, report"),
]
ARROWS = [(0, 1), (1, 2), (2, 3), (3, 4), (4, 5), (5, 6), (6, 7), (7, 8), (7, 9), (9, 10), (10, 11)]
WIDTH, HEIGHT, ACROSS, DOWN = 2.9, 1.15, 3.5, 1.75
ROOM, TEXT, EDGE, FILL = "#1f4e79", "#222222", "#7a8ca0", "#f2f5f9"


def main() -> None:
    """Draw the picture and save it to TARGET."""
    figure, axes = plt.subplots(figsize=(11.0, 4.3), dpi=150)
    centres = [(column * ACROSS, -row * DOWN) for column, row, _, _ in BOXES]
    for (x, y), (_, _, room, text) in zip(centres, BOXES, strict=True):
        axes.add_patch(plt.Rectangle((x - WIDTH / 2, y - HEIGHT / 2), WIDTH, HEIGHT, facecolor=FILL, edgecolor=EDGE, lw=1.0))
        axes.text(x, y + 0.32, room, ha="center", va="center", color=ROOM, fontsize=9.5, weight="bold", family="monospace")
        axes.text(x, y - 0.18, text, ha="center", va="center", color=TEXT, fontsize=9)
    for one, other in ARROWS:
        (x, y), (u, v) = centres[one], centres[other]
        dx, dy = (u > x) - (u < x), (v > y) - (v < y)
        start = (x + dx * WIDTH / 2 if not dy or dx else x, y + dy * HEIGHT / 2)
        end = (u - dx * WIDTH / 2 if not dy or dx else u, v - dy * HEIGHT / 2)
        axes.annotate("", end, start, arrowprops={"arrowstyle": "-|>", "color": EDGE, "lw": 1.4, "shrinkA": 0, "shrinkB": 0})
    axes.set_xlim(-WIDTH / 2 - 0.1, 3 * ACROSS + WIDTH / 2 + 0.1)
    axes.set_ylim(-2 * DOWN - HEIGHT / 2 - 0.1, HEIGHT / 2 + 0.1)
    axes.axis("off")
    figure.subplots_adjust(0.005, 0.005, 0.995, 0.995)
    figure.savefig(TARGET)


if __name__ == "__main__":
    main()
