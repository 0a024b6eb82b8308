"""Metrics and figures of spherical harmonics that decay on a sphere by diffusion, each compared with its exact rate."""

import numpy as np

from pellucid.bodies.diffusing_field.model import DiffusingFieldCase
from pellucid.bodies.initial import SphericalHarmonic
from pellucid.gallery.exact_curves import compared
from pellucid.references import Array
from pellucid.references.flows import harmonic_decay
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

CAPTIONS = {"harmonics": "Left: amplitude of each harmonic. Right: relative difference from the exact amplitude."}

METRICS = ("decay_2", "decay_3", "amount", "area")


def _field(run: Run) -> tuple[DiffusingFieldCase, float]:
    """Return the diffusing field and the radius of its sphere [m]. Raises ValueError for a case without an exact solution."""
    body = run.case.body[0]
    surface = body.domain.surface if isinstance(body, DiffusingFieldCase) else None
    if not isinstance(body, DiffusingFieldCase) or surface is None or surface.icosphere is None:
        raise ValueError("the reference requires an icosphere")
    return body, surface.icosphere.radius


def _amplitudes(run: Run) -> tuple[Array, dict[int, Array]]:
    """Return the times of the stored frames [s], and for each spherical harmonic of the initial concentration, by its degree,
    the amplitude at these times divided by its initial value."""
    body, _ = _field(run)
    times = run.times(body.name)
    at_start = run.fields(body.name, 0.0)
    share = np.asarray(at_start["volume"])
    result = {}
    for field in body.initial:
        if isinstance(field, SphericalHarmonic):
            shape = field.at(at_start["position"])
            parts = [float(share @ (shape * run.fields(body.name, float(t))["concentration"])) for t in times]
            result[field.degree] = np.array(parts) / parts[0]
    return times, result


def metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: decay rate of each spherical harmonic, change of the total amount (integral of the
    concentration), area of the sphere that the shape functions represent."""
    body, radius = _field(run)
    times, amplitudes = _amplitudes(run)
    area = float(np.sum(run.fields(body.name)["volume"]))
    exact = 4.0 * np.pi * radius**2
    spacing = np.sqrt(exact / len(run.fields(body.name)["id"])) / radius
    result = {}
    for degree, part in amplitudes.items():
        rate, sought = -np.log(part[-1]) / times[-1], harmonic_decay(degree, radius, body.material.diffusivity)
        angle = sought * (run.case.time.step or 0.0)
        # of the trapezoidal rule, and of polynomials of degree 4 as found, which fall faster
        allowed = 1.2 * (abs(body.alpha - 0.5) * angle + angle**2 / 12.0) + 2e-3 * (degree * spacing) ** 4
        text = f"decay rate of the harmonic of degree {degree}; reference: l (l + 1) D/R²"
        result[f"decay_{degree}"] = compared(float(rate), sought, allowed, "1/s", text)
    amounts = run.history["amount"]
    drift = float(np.abs(amounts - amounts[0]).max() / abs(amounts[0]))
    result["amount"] = Metric(
        float(amounts[-1]), float(amounts[0]), drift, 1e-12, "m^3", "amount at the end; error: largest relative change"
    )
    result["area"] = compared(area, exact, 0.02 * spacing**4, "m^2", "area of the surface represented by the shape functions")
    return result


def figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the amplitudes of the spherical harmonics and their relative errors against time."""
    body, radius = _field(run)
    times, amplitudes = _amplitudes(run)
    figure, (left, right) = new_panels(1, 2, width=9.5, height=3.4)
    fine = np.linspace(0.0, times[-1], 200)
    for (degree, part), colour in zip(amplitudes.items(), COLOURS, strict=False):
        rate = harmonic_decay(degree, radius, body.material.diffusivity)
        left.semilogy(fine, np.exp(-rate * fine), color=colour, linewidth=1.0, label=f"exact, l = {degree}")
        left.semilogy(times, part, "o", color=colour, markersize=4, label=f"nodes, l = {degree}")
        right.semilogy(times[1:], np.abs(part * np.exp(rate * times) - 1.0)[1:], "o-", color=colour, markersize=4)
    label(left, "time", "amplitude / initial amplitude", "s", legend=True)
    label(right, "time", "relative difference", "s")
    return {"harmonics": figure}
