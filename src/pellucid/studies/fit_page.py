"""The page of a fit: estimates, correlations, fitted and measured curves, residuals."""

from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from pellucid.results.pictures.annotations import Figure
from pellucid.results.pictures.style import WIDTH, house_style, label, new_panels, pretty
from pellucid.results.report.html import number, table_of
from pellucid.results.storage.files import replacing
from pellucid.results.storage.run import Run
from pellucid.studies.estimates import Estimates
from pellucid.studies.measured import TIME, Curve
from pellucid.studies.page import figure, frame_table, titled, write_page


def write_fit_page(out: Path, title: str, found: Estimates, curves: Sequence[Curve], run: Run, table: Any) -> Path:
    """Write `report.html` and `fit.png` of a fit to `out`; return the path of the page.

    title: title of the case. found: the estimates. curves: measured curves. run: run with the estimated parameters. table:
    pandas table of all runs.
    """
    with house_style():
        drawn = _curves(curves, run)
        with replacing(out / "fit.png") as file:
            drawn.savefig(file, format="png")
        picture = figure(drawn, "Measured values with their standard deviations and the fitted case; below, the residuals.")
    notes = "".join(f'<p class="note">Warning: {escape(text)}.</p>' for text in found.warnings)
    keys = list(found.by_key)
    estimates = table_of(
        ("key", "estimate", "95 % from", "to", "unit"),
        (
            [escape(key), *(number(value, 5) for value in one[:3]), escape(pretty(one.unit))]
            for key, one in found.by_key.items()
        ),
        "numbers",
    )
    rows = (
        [escape(key), *(number(float(value), 3) for value in row)] for key, row in zip(keys, found.correlations, strict=True)
    )
    together = table_of(("", *map(escape, keys)), rows, "numbers") if len(keys) > 1 else ""
    sizes = ", ".join(number(float(size), 3) for size in found.singular_values)
    misfit = f"<p>Sum of squared residuals per degree of freedom: {number(found.chi_square, 4)}; singular values {sizes}.</p>"
    columns = [name for name in table.columns if name not in ("steps", "message")]
    sections = [
        notes,
        titled("Estimates", estimates, misfit),
        titled("Correlations", together),
        titled("Fit", picture),
        titled("Members", frame_table(table, columns[: 3 + len(keys)])),
    ]
    return write_page(out / "report.html", f"Fit: {title}", sections)


def _curves(curves: Sequence[Curve], run: Run) -> Figure:
    drawn, axes = new_panels(2, len(curves), WIDTH, 5.0, squeeze=False, gridspec_kw={"height_ratios": [2, 1]})
    for (above, below), curve in zip(np.transpose(axes), curves, strict=True):
        bars = {"yerr": curve.deviation} if curve.is_stated else {}
        above.errorbar(curve.x, curve.y, fmt="o", markersize=3, linewidth=0.8, label=f"measured, {curve.path.name}", **bars)
        above.plot(*run.curve(curve.probe, curve.against), "-", label="fitted")
        unit = "s" if curve.against == TIME else run.units[curve.against]
        label(above, curve.against, curve.probe, unit, curve.unit, legend=True)
        below.axhline(0.0, color="#667", linewidth=0.8)
        below.plot(curve.x, curve.residuals(run), "o", markersize=3)
        label(below, curve.against, f"residual over\n{'deviation' if curve.is_stated else 'spread'}", unit)
    return drawn
