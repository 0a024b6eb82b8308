"""Metrics and figures of diffusion along a bar, compared with the Fourier series, and of spherical harmonics that decay on a
sphere, each compared with its exact rate."""

from types import SimpleNamespace

import numpy as np

from pellucid.bodies.diffusing_field.model import DiffusingFieldCase, Line
from pellucid.bodies.diffusing_field.weak_forms import windows_on_line
from pellucid.bodies.initial import SphericalHarmonic
from pellucid.gallery.exact_curves import compared, vanishing
from pellucid.references import Array
from pellucid.references.flows import between_zero_ends, harmonic_decay
from pellucid.results.metrics import Metric
from pellucid.results.pictures.style import COLOURS, Figure, Run, label, new_panels

BAR_CAPTIONS = {
    "profiles": "Concentration at the start and at the end (as figure 4.5 of the thesis).",
    "errors": "Errors of the nodes at the end (as figure 4.6).",
    "windows": (
        "Left: response of a window to a wave of the nodal values, divided by its width. Right: largest growth rate of "
        "the discrete equations of a closed bar. For windows wider than the spacing the response vanishes at some wave "
        "number; for content and outflow these wave numbers differ slightly, and a wave between them grows if it fits "
        "on the bar (as figure 4.7)."
    ),
}

BAR_METRICS = ("relative_error", "amount")

THESIS = 6e-5
"""Largest relative error that the thesis reports for 41 particles."""


def _bar(run: Run) -> tuple[DiffusingFieldCase, Line]:
    """Return the diffusing field and its bar. Raises ValueError for a case without an exact solution."""
    body = run.case.body[0]
    line = body.domain.line if isinstance(body, DiffusingFieldCase) else None
    if (
        not isinstance(body, DiffusingFieldCase)
        or line is None
        or (line.at_lower, line.at_upper, line.lower) != (0.0, 0.0, 0.0)
    ):
        raise ValueError("the reference requires a bar from x = 0 with zero concentration at both ends")
    return body, line


def _exact(run: Run, x: Array, time: float) -> Array:
    """Return the exact concentration at positions x [m] along the bar at a time [s]."""
    body, line = _bar(run)

    def start(y: Array) -> Array:
        places = np.stack([y, np.zeros_like(y), np.zeros_like(y)], axis=1)
        return np.asarray(body.concentration + sum(field.at(places) for field in body.initial))

    if time == 0.0:
        return start(x)
    return between_zero_ends(start, line.upper, body.material.diffusivity * time, x)


def _profiles(run: Run) -> tuple[Array, Array, Array, float]:
    """Return positions along the bar [m], computed and exact concentrations of the nodes at the end, shape (n,) each, and the
    time of the end [s]."""
    name = run.case.body[0].name
    time = float(run.times(name)[-1])
    fields = run.fields(name, time)
    x = np.asarray(fields["position"])[:, 0]
    return x, np.asarray(fields["concentration"]), _exact(run, x, time), time


def bar_metrics(run: Run) -> dict[str, Metric]:
    """Return the metrics by name: largest error of the concentration at a node at the end, relative to the largest
    concentration; amount (integral of the concentration) that remains at the end."""
    x, found, exact, time = _profiles(run)
    error = float(np.abs(found - exact).max() / np.abs(exact).max())
    # the thesis's error, and of the order of the polynomials for other numbers of nodes
    allowed = THESIS * (40.0 / (len(x) - 1)) ** 4
    points, weights = np.polynomial.legendre.leggauss(100)
    length = _bar(run)[1].upper
    left = float(0.5 * length * weights @ _exact(run, 0.5 * length * (points + 1.0), time))
    amount = float(run.history["amount"][-1])
    return {
        "relative_error": vanishing(error, allowed, "largest error of a node, relative to the largest concentration"),
        "amount": compared(amount, left, allowed, "m^3", "integral of the concentration over the bar; reference: exact series"),
    }


def bar_figures(run: Run) -> dict[str, Figure]:
    """Return figures by name that show the concentration along the bar, its error, and the stability of the averaging windows
    (intervals over which the equation is averaged) as a function of their width."""
    return {"profiles": _profile_figure(run), "errors": _error_figure(run), "windows": _window_figure(run)}


def _profile_figure(run: Run) -> Figure:
    x, found, _, time = _profiles(run)
    figure, axes = new_panels(width=7.0, height=3.6)
    fine = np.linspace(x[0], x[-1], 400)
    start = np.asarray(run.fields(run.case.body[0].name, 0.0)["concentration"])
    for instant, values, colour in ((0.0, start, COLOURS[0]), (time, found, COLOURS[1])):
        axes.plot(fine, _exact(run, fine, instant), color=colour, linewidth=1.0, label=f"exact, t = {instant:g} s")
        axes.plot(x, values, "o", color=colour, markersize=3.5, label=f"nodes, t = {instant:g} s")
    label(axes, "x", "concentration", "m")
    axes.legend(ncols=2)
    return figure


def _error_figure(run: Run) -> Figure:
    x, found, exact, _ = _profiles(run)
    figure, axes = new_panels(width=7.0, height=3.2)
    axes.plot(x, 100.0 * np.abs(found - exact) / np.abs(exact).max(), "o-", color=COLOURS[1], markersize=3.5)
    axes.axhline(100.0 * THESIS, color=COLOURS[0], linestyle="--", linewidth=1.0)
    axes.annotate("largest in the thesis, 41 particles", (x[0], 100.0 * THESIS), color=COLOURS[0], fontsize=8, va="bottom")
    label(axes, "x", "error / largest concentration", "m", "%")
    return figure


def _window_figure(run: Run) -> Figure:
    """Return a figure of the Fourier symbol of averaging windows (factor on a wave that is averaged over the window), and the
    largest growth rate of the nodal equations, i.e. the largest real part of the eigenvalues of -M⁻¹ D K, for many widths of
    the windows, with closed ends."""
    body, bar = _bar(run)
    x = bar.places()
    figure, (left, right) = new_panels(1, 2, width=9.5, height=3.6)
    waves = np.linspace(1e-3, 1.0, 300)  # k h/π
    for width, line in ((0.5, "-"), (1.0, "--"), (1.5, "-.")):
        left.plot(waves, np.sinc(waves * width), line, label=f"w = {width:g} h")
    left.axhline(0.0, color="#889", linewidth=0.8)
    label(left, "wave number, kh/π", "response of a window, sin(kw)/(kw)", legend=True)
    widths = np.concatenate([np.linspace(0.3, 0.99, 15), np.linspace(1.01, 1.9, 30)])
    growth = [_fastest_growth(x, width, body) for width in widths]
    right.plot(widths, growth, "o-", markersize=3, color=COLOURS[1])
    right.set_yscale("symlog", linthresh=1.0)
    right.axvline(1.0, color="#889", linewidth=0.8)
    label(right, "half-width of the windows, w/h", "fastest growth", "", "1/s")
    return figure


def _fastest_growth(x: Array, width: float, body: DiffusingFieldCase) -> float:
    """Return the largest growth rate of the nodal equations [1/s] for averaging windows of a half-width; it is 0 for a uniform
    concentration.

    x: positions of the nodes [m], shape (n,). width: half-width of the windows divided by the node spacing. body: the diffusing
    field.
    """
    content, outflow = (part.toarray() for part in windows_on_line(x, body.radial, width))
    rates = np.linalg.eigvals(np.linalg.solve(content, -body.material.diffusivity * outflow).astype(complex))
    return float(rates.real.max())


SPHERE_CAPTIONS = {"harmonics": "Left: amplitude of each harmonic. Right: relative difference from the exact amplitude."}

SPHERE_METRICS = ("decay_2", "decay_3", "amount", "area")


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


def sphere_metrics(run: Run) -> dict[str, Metric]:
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


def sphere_figures(run: Run) -> dict[str, Figure]:
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


CASES = {
    "diffusion": SimpleNamespace(METRICS=BAR_METRICS, CAPTIONS=BAR_CAPTIONS, metrics=bar_metrics, figures=bar_figures),
    "diffusion-on-sphere": SimpleNamespace(
        METRICS=SPHERE_METRICS, CAPTIONS=SPHERE_CAPTIONS, metrics=sphere_metrics, figures=sphere_figures
    ),
}
"""Metrics, captions and figures of each case, by its name without the group."""
