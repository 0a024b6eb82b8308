"""Curves of a drop that falls on something: heights against time, and where the energy goes."""

from collections.abc import Mapping

from pellucid.results.pictures.annotations import Figure, Run
from pellucid.results.pictures.style import label, new_panels


def drop_curves(run: Run, heights: Mapping[str, str], struck: str, title: str = "") -> Figure:
    """heights: columns of the history with what they are; struck: what the drop falls on."""
    figure, (above, energy) = new_panels(1, 2, height=3.4, title=title)
    ms, history = 1e3 * run.history["time"], run.history
    for column, what in heights.items():
        above.plot(ms, 1e3 * history[column], label=what)
    label(above, "time", "z", "ms", "mm", legend=True)
    energy.plot(ms, 1e3 * history["kinetic_energy"], label="kinetic")
    energy.plot(ms, 1e3 * history["strain_energy"], label=f"in the {struck}")
    energy.plot(ms, 1e3 * history["internal_energy"], label="in the water")
    energy.plot(ms, -1e3 * history["contact_work"], label="taken by contact")
    label(energy, "time", "energy", "ms", "mJ", legend=True)
    return figure
