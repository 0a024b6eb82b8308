"""The drop on tissue: nothing passes through the face, what contact gives is what the water gets, and the balances hold.

A quarter, x and y above 0, is computed.
"""

import numpy as np
from scipy.interpolate import LinearNDInterpolator, NearestNDInterpolator

from pellucid.gallery.drop_curves import drop_curves
from pellucid.gallery.exact_curves import vanishing, worst_balance
from pellucid.results.metrics import Metric
from pellucid.results.pictures.annotations import Figure, Run
from pellucid.results.pictures.instants import recorded
from pellucid.results.pictures.style import COLOURS, finish_panel, panels

Array = np.ndarray

ROUNDING = 1e-12
ENERGY = 1e-3  # of the largest energy that moved; it falls with the step at first order, and is 2e-5 at a Courant number of 0.5
LEAK = 0.5  # cells: the grid parts the bodies at its nodes
SECTIONS = (0.0, 3e-3, 6e-3, 9e-3, 1.2e-2, 1.8e-2)

HEIGHTS = {"water_z": "lowest water", "face_z": "middle of the face"}

CAPTIONS = {
    "sections": "What lay beside the plane y = 0 at the start, of water and tissue.",
    "curves": "Middle of the face and lowest water; energies of the quarter and what contact took.",
}

METRICS = ("clearance", "impulse", "momentum", "mass", "energy")


def metrics(run: Run) -> dict[str, Metric]:
    """Least height of the water above the face, what contact gave the water, momentum, mass, energy."""
    kept, cells = run.summary["conservation"], min(clearance(run, float(time)) for time in run.times("water"))
    cells /= run.case.grid.cell
    given = -float(np.asarray(run.history["force"]) @ np.diff(run.history["time"], prepend=0.0))
    begun, ended = (_momentum(run, float(run.times("water")[frame])) for frame in (0, -1))
    gained, momentum, mass = ended - begun, float(kept["momentum"]), float(kept["mass"])
    above = "least height of the water above the face in any frame, in cells"
    got = "momentum along z that the water got; the reference is the sum of the forces of contact"
    unexplained = "momentum that no impulse explains, over the largest sum of mass times speed"
    return {
        "clearance": Metric(cells, 0.0, max(0.0, -cells), LEAK, "", above),
        "impulse": Metric(gained, given, abs(gained - given) / abs(begun), ROUNDING, "N*s", got),
        "momentum": vanishing(momentum, ROUNDING, unexplained),
        "mass": vanishing(mass, ROUNDING, "relative change of the mass"),
        "energy": worst_balance(run, ENERGY, "largest error of the energy balance, over the largest energy that moved"),
    }


def clearance(run: Run, time: float) -> float:
    """Least height [m] of the water's points above the face in the frame nearest to a time [s].

    The face is flat between the nodes on it; beside it counts the height of the nearest.
    """
    water, begun, now = (run.fields(name, at)["position"] for name, at in (("water", time), ("tissue", 0.0), ("tissue", time)))
    face = now[begun[:, 2] > begun[:, 2].max() * (1.0 - 1e-9)]
    height = LinearNDInterpolator(face[:, :2], face[:, 2])(water[:, :2])
    beside = NearestNDInterpolator(face[:, :2], face[:, 2])(water[:, :2])
    return float(np.min(water[:, 2] - np.where(np.isnan(height), beside, height)))


def _momentum(run: Run, time: float) -> float:
    water = run.fields("water", time)
    return float(water["mass"] @ water["velocity"][:, 2])


def figures(run: Run) -> dict[str, Figure]:
    """The middle cut, and curves against time."""
    return {"sections": _sections(run), "curves": drop_curves(run, HEIGHTS, "tissue")}


def _sections(run: Run) -> Figure:
    chosen = recorded(run.times("water"), SECTIONS)
    figure, subplots = panels(len(chosen), 2, height=2.3 * -(-len(chosen) // 2), layout="compressed", sharex=True, sharey=True)
    near = 0.26e3 * run.case.grid.cell  # beyond the first layer of points, nearer than the second
    for axes, time in zip(subplots, chosen, strict=True):
        for name, colour in (("water", COLOURS[0]), ("tissue", COLOURS[1])):
            begun, now = (1e3 * run.fields(name, instant)["position"] for instant in (0.0, float(time)))
            shown = begun[:, 1] < begun[:, 1].min() + near
            x, z = np.concatenate([now[shown, 0], -now[shown, 0]]), np.tile(now[shown, 2], 2)
            axes.plot(x, z, ".", markersize=1.5, color=colour, label=name)
        finish_panel(axes, f"t = {1e3 * float(time):.0f} ms", "x", "z", "mm")
    subplots[0].legend(markerscale=5, loc="upper right")
    return figure
