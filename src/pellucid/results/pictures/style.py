"""Style of all figures: axes with units, colours that colour-blind readers can distinguish."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:  # matplotlib is slow to import: it is imported in functions that draw
    from matplotlib.axes import Axes as Axes
    from matplotlib.figure import Figure as Figure

    from pellucid.results.storage.run import Run as Run
else:
    Axes = Figure = Run = object


# Okabe and Ito's palette, the yellow left out: it is too faint for lines on white
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000")
LINES = ("-", "--", "-.", ":")
SEQUENTIAL, DIVERGING = "viridis", "coolwarm"
"""Colour maps for values of one sign and for values of both signs; the grey middle of the second contrasts with white
paper."""
Layout = Literal["constrained", "compressed"]
Extend = Literal["neither", "both", "min", "max"]
DPI = 144
WIDTH = 9.5  # of a figure in the report [inch]


@contextmanager
def house_style() -> Iterator[None]:
    """Apply the house style to all new figures within the block, including figures of the gallery's modules."""
    import matplotlib
    from cycler import cycler

    look: dict[Any, Any] = {
        "axes.axisbelow": True,
        "axes.edgecolor": "#667",
        "axes.formatter.limits": (-3, 4),
        "axes.formatter.use_mathtext": True,
        "axes.grid": True,
        "axes.labelcolor": "#223",
        "axes.linewidth": 0.8,
        "axes.prop_cycle": cycler(color=COLOURS),
        "axes.spines.right": False,
        "axes.spines.top": False,
        "axes.titlesize": 10,
        "figure.titlesize": 11,
        "font.size": 9.5,
        "grid.alpha": 0.35,
        "grid.color": "#aab",
        "grid.linewidth": 0.6,
        "image.cmap": SEQUENTIAL,
        "legend.frameon": False,
        "lines.linewidth": 1.6,
        "savefig.dpi": DPI,
        "xtick.color": "#445",
        "ytick.color": "#445",
    }
    with matplotlib.rc_context(look):
        yield


def new_figure(width: float = WIDTH, height: float = 3.6, layout: Layout = "constrained") -> Figure:
    """Return an empty matplotlib figure that needs no screen and is not registered in pyplot. width, height: size [inch].
    layout: layout engine of matplotlib."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout=layout)
    FigureCanvasAgg(figure)
    return figure


def new_panels(
    rows: int = 1, columns: int = 1, width: float = WIDTH, height: float = 3.6, title: str = "", **shared: Any
) -> tuple[Figure, Any]:
    """Return a new figure and its axes in `rows` and `columns`, in the form that `Figure.subplots` returns.

    width, height: of the figure [inch]. title: title of the figure. shared: further arguments of `Figure.subplots`.
    """
    figure = new_figure(width, height)
    if title:
        figure.suptitle(title)
    return figure, figure.subplots(rows, columns, **shared)


def panels(
    number: int, across: int, width: float = WIDTH, height: float = 3.6, layout: Layout = "constrained", **shared: Any
) -> tuple[Figure, list[Axes]]:
    """Return a new figure and a list of `number` axes, at most `across` in a row.

    width, height: of the figure [inch]. layout, shared: layout engine of the figure, and arguments of `Figure.subplots`.
    """
    figure = new_figure(width, height, layout)
    every = figure.subplots(-(-number // across), across, squeeze=False, **shared).ravel()
    for unused in every[number:]:
        unused.remove()
    return figure, list(every[:number])


def colour_bar(
    figure: Figure, word: str, limits: tuple[float, float, Extend], palette: str, shrink: float = 0.7, aspect: float = 25
) -> None:
    """Draw a colour bar next to all axes of a figure.

    word: label of the bar. limits: the values at both ends, and the ends beyond which values of the picture lie. palette:
    name of the colour map. shrink, aspect: length of the bar relative to the axes, and length divided by width.
    """
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    low, high, extend = limits
    scale = ScalarMappable(Normalize(low, high), palette)
    bar = figure.colorbar(scale, ax=figure.axes, shrink=shrink, pad=0.01, aspect=aspect, extend=extend)
    bar.set_label(word)
    bar.outline.set_visible(False)


def finish_panel(axes: Axes, title: str, x: str, y: str, unit: str) -> None:
    """Format one of several pictures of a plane: equal scales, a title, labels only at the outer panels. x, y: labels of the
    axes; unit: their common unit."""
    axes.set_aspect("equal")
    label(axes, x, y, unit, unit, title)
    axes.label_outer()


def settle(figure: Figure) -> None:
    """Compute the layout of a figure once, which is accurate to a pixel, and fix it; otherwise matplotlib would compute the
    layout again whenever the figure is drawn."""
    layout = figure.get_layout_engine()
    if layout is not None and figure.axes:
        layout.execute(figure)
        figure.set_layout_engine("none")


def label(
    axes: Axes, x: str, y: str, x_unit: str = "", y_unit: str = "", title: str | None = None, legend: bool = False
) -> None:
    """Label both axes with their names x and y and their units; optionally set the title and draw a legend of the curves so
    far."""
    axes.set(xlabel=with_unit(x, x_unit), ylabel=with_unit(y, y_unit))
    if title is not None:
        axes.set_title(title)
    if legend:
        axes.legend()


def instant(time: float) -> str:
    """Format a time [s] for display: "t = 1.3 ms"."""
    from matplotlib.ticker import EngFormatter

    return f"t = {EngFormatter('s', useMathText=False)(float(f'{time:.4g}'))}"


def with_unit(name: str, unit: str) -> str:
    """Return the label of a quantity with its unit: "kinetic energy [J]"; without a unit: "step"."""
    words = name.replace("_", " ")
    return f"{words} [{pretty(unit)}]".lstrip() if unit and unit != "1" else words


def plain(text: str) -> str:
    """Escape dollar signs in a text of the user; matplotlib would read the text between them as a formula."""
    return text.replace("$", r"\$")


def pretty(unit: str) -> str:
    """Format a unit for display: "kg/m³" for "kg/m^3"."""
    for power, raised in (("^2", "²"), ("^3", "³"), ("^-1", "⁻¹")):
        unit = unit.replace(power, raised)
    return unit.replace("*", " ")


__all__ = ["Axes", "Figure", "Run"]
