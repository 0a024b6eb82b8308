"""Metrics and figures of a belt on a drum: forces and tensions compared with the capstan equation including the drag of the
belt."""

from typing import Any

import numpy as np

from pellucid.gallery.exact_curves import column, compared, energy_metric, vanishing
from pellucid.references import Array
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

SLIDES = 0.2  # s from when on the weight has grown and all of the belt slides
RATIO, PULL, CURVE, ENERGY = 0.02, 0.02, 0.02, 0.01

METRICS = ("ratio", "pull", "tension", "energy")
CAPTIONS = {"capstan": "Mean tension along the drum while the belt slides; ratio of the contact forces of the drum."}


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: ratio of the horizontal to the vertical contact force on the drum, force at the pulled end,
    largest error of the tension along the drum, error of the energy balance."""
    exact, late = Capstan(run), np.asarray(run.history["time"]) >= SLIDES
    touch_x, touch_z = (float(np.mean(column(run, name)[late])) for name in ("touch_x", "touch_z"))
    pull = abs(float(np.mean(column(run, "pull")[late])))
    angles, tensions = tension_along(run)
    worst = float(np.abs(tensions / exact.tension(angles) - 1.0).max())
    text = f"mean from {SLIDES:g} s on; reference: capstan equation with drag"
    of_drum = "ratio of the horizontal to the vertical contact force of the drum"
    return {
        "ratio": compared(abs(touch_x / touch_z), exact.ratio, RATIO, "", f"{of_drum}, {text}"),
        "pull": compared(pull, exact.pull, PULL, "N", f"force at the pulled end, {text}"),
        "tension": vanishing(worst, CURVE, "largest relative error of the mean tension along the drum"),
        "energy": energy_metric(run, ENERGY),
    }


class Capstan:
    """Capstan equation of a belt that slides over a quarter of a drum with friction and drag: dT/dφ = μ T + q R.

    T: tension [N]; φ: angle from the end where the weight hangs; q: drag of the belt per unit length [N/m]; R: radius of
    the mid-surface [m].
    """

    def __init__(self, run: Run) -> None:
        case: Any = run.case
        belt: Any = next(body for body in case.body if body.name == "belt")
        drum: Any = next(body for body in case.body if body.name == "drum")
        motion: Any = next(motion for motion in case.motion if motion.name == "pull")
        start = run.fields("belt", float(run.times("belt")[0]))["position"]
        self._friction = case.contact[0].friction
        self.radius = drum.shape.cylinder.radius + 0.5 * belt.thickness
        per_length = belt.material.density * belt.thickness * float(np.ptp(start[:, 1]))
        self._drag = per_length * belt.damping * abs(motion.displacement.x.velocity)
        self._hangs = sum(abs(load.force[2]) for load in case.load) - self._drag * float(start[:, 2].min())
        self._straight = -float(start[:, 0].min())

    def tension(self, angle: Array) -> Array:
        """Return the exact tension of the belt [N] at angles on the drum from the end where the weight hangs [rad]."""
        q = self._drag * self.radius / self._friction
        return np.asarray((self._hangs + q) * np.exp(self._friction * np.asarray(angle)) - q)

    @property
    def pull(self) -> float:
        """Return the exact force at the pulled end of the belt [N]."""
        return float(self.tension(np.array(0.5 * np.pi))) + self._drag * self._straight

    @property
    def ratio(self) -> float:
        """Exact ratio of horizontal to vertical force on the drum, from the tensions at both ends of the contact and the drag
        between."""
        drag = self._drag * self.radius
        return (float(self.tension(np.array(0.5 * np.pi))) - drag) / (self._hangs + drag)


def tension_along(run: Run) -> tuple[Array, Array]:
    """Return 41 angles on the drum from the end where the weight hangs [rad], shape (41,), and the tension of the belt there
    [N], averaged across the belt and over the stored frames in which it slides, shape (41,)."""
    angles, found = np.linspace(0.02, 0.98, 41) * 0.5 * np.pi, []
    for time in run.times("belt"):
        if time < SLIDES:
            continue
        fields = run.fields("belt", float(time))
        x = fields["position"]
        # the mean tension of both directions is half of that along the belt: nothing pulls across it
        tension = 2.0 * fields["tension"] * np.ptp(x[:, 1])
        angle = np.arctan2(x[:, 2], x[:, 0])
        near = (angle > -0.5) & (angle < 2.0)
        row = np.unique(np.round(angle[near], 2), return_inverse=True)[1]
        count = np.bincount(row)
        at, mean = (np.bincount(row, values[near]) / count for values in (angle, tension))
        found.append(np.interp(angles, at, mean))
    return angles, np.mean(found, axis=0)


def figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the tension along the drum, and the ratio of horizontal to vertical force on the drum
    against time, with the exact values."""
    exact, (angles, tensions) = Capstan(run), tension_along(run)
    figure, (left, right) = new_panels(1, 2)
    smooth = np.linspace(0.0, 0.5 * np.pi, 91)
    left.plot(np.degrees(smooth), exact.tension(smooth), color="#bbb", linewidth=4.0, label="capstan equation with drag")
    left.plot(np.degrees(angles), tensions, "o", color=COLOURS[0], markersize=3.0, label="belt")
    label(left, "angle from the start of the contact on the drum", "tension", "degrees", "N", legend=True)
    time = np.asarray(run.history["time"])
    loaded = time > 0.05
    right.axhline(exact.ratio, color="#bbb", linewidth=4.0, label="capstan equation with drag")
    ratio = np.abs(column(run, "touch_x")[loaded] / column(run, "touch_z")[loaded])
    right.plot(time[loaded], ratio, color=COLOURS[0], label="belt")
    right.set_ylim(0.8, 2.0)
    label(right, "time", "horizontal / vertical force", "s", "", legend=True)
    return {"capstan": figure}
