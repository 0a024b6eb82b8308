"""Metrics of a drop on tissue: the water does not penetrate the face, the contact impulse equals the momentum of the water,
and mass, momentum and energy are conserved.

A quarter, x > 0 and y > 0, is computed.
"""

import numpy as np
from scipy.interpolate import LinearNDInterpolator, NearestNDInterpolator

from pellucid.gallery.exact_curves import vanishing, worst_balance
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import Run

Array = np.ndarray

ROUNDING = 1e-12
ENERGY = 1e-3  # of the largest energy that moved; it falls with the step at first order, and is 2e-5 at a Courant number of 0.5
LEAK = 0.5  # cells: the grid parts the bodies at its nodes

METRICS = ("clearance", "impulse", "momentum", "mass", "energy")


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: smallest height of the water above the face of the tissue, change of the water's momentum
    compared with the contact impulse, errors of the momentum, mass and energy balances."""
    kept, cells = run.summary["conservation"], min(clearance(run, float(time)) for time in run.times("water"))
    cells /= run.case.grid.cell
    given = -float(np.asarray(run.history["force"]) @ np.diff(run.history["time"], prepend=0.0))
    begun, ended = (_momentum(run, float(run.times("water")[frame])) for frame in (0, -1))
    gained, momentum, mass = ended - begun, float(kept["momentum"]), float(kept["mass"])
    above = "smallest height of the water above the face in any frame, in cells"
    got = "change of the water's momentum along z; reference: impulse of the contact force"
    unexplained = "error of the momentum balance, relative to the largest sum of mass times speed"
    return {
        "clearance": Metric(cells, 0.0, max(0.0, -cells), LEAK, "", above),
        "impulse": Metric(gained, given, abs(gained - given) / abs(begun), ROUNDING, "N*s", got),
        "momentum": vanishing(momentum, ROUNDING, unexplained),
        "mass": vanishing(mass, ROUNDING, "relative change of the total mass"),
        "energy": worst_balance(run, ENERGY, "largest error of the energy balance, relative to the largest energy exchanged"),
    }


def clearance(run: Run, time: float) -> float:
    """Return the smallest height [m] of the water's points above the face, in the stored frame nearest to a time [s].

    The face is interpolated linearly between its nodes; outside, the height of the nearest node is used.
    """
    water, begun, now = (run.fields(name, at)["position"] for name, at in (("water", time), ("tissue", 0.0), ("tissue", time)))
    face = now[begun[:, 2] > begun[:, 2].max() * (1.0 - 1e-9)]
    height = LinearNDInterpolator(face[:, :2], face[:, 2])(water[:, :2])
    beside = NearestNDInterpolator(face[:, :2], face[:, 2])(water[:, :2])
    return float(np.min(water[:, 2] - np.where(np.isnan(height), beside, height)))


def _momentum(run: Run, time: float) -> float:
    water = run.fields("water", time)
    return float(water["mass"] @ water["velocity"][:, 2])
