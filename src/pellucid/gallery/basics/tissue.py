"""Metrics of a block of tissue under a rigid ball and under a drop of water. Of both cases a quarter, x > 0 and y > 0, is
computed."""

from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
from scipy.interpolate import LinearNDInterpolator, NearestNDInterpolator

from pellucid.bodies.membrane_elements.model import MembraneElementsCase
from pellucid.bodies.meshless_solid.model import MeshlessSolidCase
from pellucid.gallery.exact_curves import compared, energy_metric, vanishing, worst_balance
from pellucid.references.solids import Layer, force
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import Run

Array = np.ndarray

AT_REST = 0.9  # of the run; from then on the force is taken
FORCE, FINE = 0.03, 0.07  # 3 % with cells of 0.07 of the ball's radius, a quarter of the radius of contact, and of second order
BENEATH = 0.25  # of the ball's radius, within which the face lies on it
BALL_ENERGY = 0.02  # of the energy balance at the end; contact is slow and takes little
MOMENTUM = 1e-12  # of all impulses: contact gives both sides the same

BALL_METRICS = ("force", "gap", "energy", "momentum")


class Pressed(NamedTuple):
    """Reference for the ball pressed into the tissue, from which the contact force is computed: the elastic layer, and size
    and height of the ball."""

    layer: Layer  # the tissue, an elastic layer bonded to a rigid base
    radius: float  # outer radius of the ball, including half the thickness of its membrane [m]
    centre: float  # initial height of the centre of the ball [m]

    @classmethod
    def of(cls, run: Run) -> "Pressed":
        """Build the reference from the case of a run. Raises TypeError unless the bodies are a meshless block and a spherical
        membrane."""
        block, ball = run.case.body
        if not isinstance(block, MeshlessSolidCase) or not isinstance(ball, MembraneElementsCase) or not ball.surface.sphere:
            raise TypeError(
                "the exact force requires a block that is a meshless solid and a sphere that is a membrane of elements"
            )
        elastic, sphere = block.material.model_dump(), ball.surface.sphere
        low, high = block.bounds()
        layer = Layer(elastic["young_modulus"], elastic["poisson_ratio"], float(high[2] - low[2]), bonded=True)
        return cls(layer, sphere.radius + 0.5 * ball.thickness, sphere.centre[2])

    def middle(self, run: Run, time: float) -> float:
        """Return the prescribed height [m] of the centre of the ball at a time [s]."""
        return float(self.centre + run.case.motion[0].functions()[2](time))

    def depth(self, run: Run, time: float) -> float:
        """Return the depth [m] of the lowest point of the ball below the undeformed surface of the layer at a time [s]; 0
        before contact."""
        return max(0.0, self.layer.thickness + self.radius - self.middle(run, time))


def ball_metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: mean contact force over the last tenth of the run, in which the ball is at rest; mean gap
    between the ball and the face of the tissue beneath it at the end; errors of the energy and momentum balances."""
    exact, end = Pressed.of(run), float(run.history["time"][-1])
    depth = exact.depth(run, end)
    known, found = force(exact.layer, exact.radius, depth), _force(run)[np.asarray(run.history["time"]) > AT_REST * end].mean()
    cell = run.case.grid.cell / exact.radius
    begun, now = _tissue(run)
    from_middle = now - (0.0, 0.0, exact.middle(run, end))
    beneath = (begun[:, 2] > begun[:, 2].max() * (1.0 - 1e-9)) & (np.hypot(now[:, 0], now[:, 1]) < BENEATH * exact.radius)
    gap = float(np.mean(np.linalg.norm(from_middle[beneath], axis=1)) - exact.radius)
    momentum = float(run.summary["conservation"]["momentum"])
    off = "mean gap between the ball and the face beneath it; tolerance: rise of the ball's surface within a cell"
    return {
        "force": compared(
            float(found),
            known,
            FORCE * (cell / FINE) ** 2,
            "N",
            "force at rest; reference: exact force on a linear elastic layer",
        ),
        "gap": vanishing(gap, 0.5 * cell**2 * exact.radius, off, "m"),
        "energy": energy_metric(run, BALL_ENERGY),
        "momentum": vanishing(momentum, MOMENTUM, "error of the momentum balance, relative to all external impulses"),
    }


def _force(run: Run) -> Array:
    """Return the contact force on the whole ball, four times that on the computed quarter, at each row of the history [N]."""
    return np.asarray(4.0 * np.asarray(run.history["force"], dtype=float))


def _tissue(run: Run) -> tuple[Array, Array]:
    """Return the positions of the tissue's nodes [m] at the start and at the end, shape (n, 3) each."""
    times = run.times("tissue")
    begun, now = (run.fields("tissue", float(times[frame]))["position"] for frame in (0, -1))
    return begun, now


ROUNDING = 1e-12
DROP_ENERGY = 1e-3  # of the largest energy that moved; falls with the step at first order, 2e-5 at a Courant number of 0.5
LEAK = 0.5  # cells: the grid parts the bodies at its nodes

DROP_METRICS = ("clearance", "impulse", "momentum", "mass", "energy")


def drop_metrics(run: Run) -> dict[str, Metric]:
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
        "energy": worst_balance(
            run, DROP_ENERGY, "largest error of the energy balance, relative to the largest energy exchanged"
        ),
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


CASES = {
    "ball-on-tissue": SimpleNamespace(METRICS=BALL_METRICS, metrics=ball_metrics),
    "drop-on-tissue": SimpleNamespace(METRICS=DROP_METRICS, metrics=drop_metrics),
}
"""Metrics, captions and figures of each case, by its name without the group."""
