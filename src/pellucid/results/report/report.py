"""The report of a run, `report.html`: one file with the case, the results of the checks, and pictures."""

import base64
from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from pellucid.grid.model import GridCase
from pellucid.progress import Progress, WarningsOnly
from pellucid.results.metrics import Metric
from pellucid.results.pictures import figures, painter
from pellucid.results.pictures.films import FILM_DPI
from pellucid.results.pictures.own import captions, noticed
from pellucid.results.pictures.quantities import is_film
from pellucid.results.pictures.stopped import place_of_stop
from pellucid.results.pictures.style import DPI, WIDTH, pretty
from pellucid.results.report.html import are_films_alone, facts, header, number, page_of, section, table_of
from pellucid.results.storage.files import explained, write_text
from pellucid.results.storage.run import Run
from pellucid.results.storage.run_folder import StoredBody, StoredCase
from pellucid.results.view.page import view_of
from pellucid.state import FIELDS
from pellucid.system.processes import Helper

WITH_RING = "The state at which the run stopped with an error; the ring marks the point, also in the enlarged view."
CAPTIONS = {
    "where_it_stopped": "The state at which the run stopped with an error.",
    "energies": "The energy balance and its relative error. Energy added by contact or transfers, which should only dissipate, "
    "also counts as an error.",
    "momentum": "Total momentum.",
    "probes": "Probes of the case.",
    "conditions": "Contents of enclosed volumes and points through open faces, if they change and no other figure shows them.",
    "bodies_displacement": "Bodies, coloured by displacement.",
    "bodies_displacement_inside": "Solids, cut open through the centre of the largest, coloured by displacement.",
    "bodies_speed": "Bodies, coloured by speed.",
    "bodies_load": "Bodies, coloured by pressure (fluids), von Mises equivalent stress (solids) or areal density (films).",
    "bodies_speed_inside": "Solids, cut open through the centre of the largest, coloured by speed.",
    "bodies_load_inside": "Solids, cut open through the centre of the largest, coloured by von Mises equivalent stress.",
    "profiles_of_points": "All points at the end.",
}


def write_report(out: Run | Path | str, beside: Run | None = None, progress: Progress | None = None) -> Path:
    """Draw the figures and films of a run and write the self-contained file `report.html`; return the path of this file.

    out: the run or its folder. beside: another run; the probes of this run are drawn into the figure of the probes, and its
    metrics are listed after the metrics of the first run. If the run is incomplete (stopped with an error, interrupted or
    killed), the report shows the results so far.

    Raises `UsageError` if the folder contains no run or no results yet, and if another process writes to the folder.
    """
    run = out if isinstance(out, Run) else Run(out)
    with run.folder.held() if run.folder.is_of_a_run else nullcontext():  # runs of earlier versions have none
        return draw_report(run, beside, progress)


def draw_report(
    run: Run, beside: Run | None = None, progress: Progress | None = None, helpers: Sequence[Helper] | None = None
) -> Path:
    """Write the report of a run into its folder, whose lock must be held, and return the path of the report.

    beside, progress: see `write_report`. helpers: worker processes of `drawing_helpers` that draw, if already started.
    """
    head, facts_of_run = header(run), facts(run)  # says where there is nothing yet, before anything is drawn
    texts = CAPTIONS | ({} if place_of_stop(run) is None else {"where_it_stopped": WITH_RING}) | captions(run)
    case = run.stored
    texts |= {asked.name: asked.title for asked in (*case.picture, *case.film, *case.plot) if asked.title}
    progress = progress or WarningsOnly()
    notices: list[str] = []
    titles = painter.write_pictures(run, beside, progress, notices, helpers)
    pictures = "".join(_figure(path, texts.get(path.stem, title)) for path, title in titles.items())
    view = ""
    with noticed(notices):
        view = view_of(run, len(pictures), "The figures below show the run.")
    for text in notices:
        progress.message(f"not included in the report: {text}")
    sections = [
        head,
        *(f'<p class="note">Not included: {escape(text)}.</p>' for text in notices),
        facts_of_run,
        section("Checks", metrics_table(run.metrics)) if run.metrics else "",
        section(f"Checks of the other run, {beside.out.name}", metrics_table(beside.metrics))
        if beside and beside.metrics
        else "",
        section("View", view) if view else "",
        section("Figures", pictures),
        section("Energy balance", _balance(run)),
        section("Conservation", _conservation(run)) if run.folder.ended else "",
        section("The case", _case(run)),
    ]
    body = "\n".join(filter(None, sections))
    page = page_of(run.stored.title, body)
    with explained(run.out):
        write_text(run.folder.report, page)
    return run.folder.report


def metrics_table(metrics: dict[str, Metric]) -> str:
    """Return an HTML table of metrics with their references, errors and tolerances."""

    def row(name: str, metric: Metric) -> list[str]:
        unit = f" {escape(pretty(metric.unit))}" if metric.unit else ""
        mark = '<span class="pass">✓ pass</span>' if metric.passed else '<span class="fail">✗ fail</span>'
        meaning = f'<br><span class="meaning">{escape(metric.meaning)}</span>' if metric.meaning else ""
        return [
            f"{escape(name.replace('_', ' '))}{meaning}",
            number(metric.value, padded=True) + unit,
            number(metric.reference, padded=True) + unit,
            number(metric.error, 3),
            number(metric.tolerance, 3),
            mark,
        ]

    head = ("check", "found", "reference", "error", "tolerance", "")
    return table_of(head, (row(name, metric) for name, metric in metrics.items()), "numbers last-word")


def _figure(path: Path, caption: str) -> str:
    picture = path.read_bytes()
    data = base64.b64encode(picture).decode("ascii")
    kind = path.suffix[1:]
    pixels = int.from_bytes(picture[16:20]) if kind == "png" else int.from_bytes(picture[6:8], "little")  # of their headers
    width = min(100.0, 100.0 * pixels / (WIDTH * (DPI if kind == "png" else FILM_DPI)))  # so that letters have one size
    caption = escape(caption or path.stem.replace("_", " ").capitalize() + ".")
    image = f'<img alt="{caption}" style="width: {width:.0f}%" src="data:image/{kind};base64,{data}">'
    return f"<figure>{image}<figcaption>{caption}</figcaption></figure>"


def _balance(run: Run) -> str:
    def row(name: str) -> list[str]:
        values = run.history[name]
        shown = (values[0], values[-1], values[-1] - values[0], np.nanmax(np.abs(values)))
        return [name.replace("_", " "), *(number(float(value), padded=True) for value in shown)]

    head = ("entry", "start [J]", "end [J]", "change [J]", "largest absolute value [J]")
    error, limits = run.history["energy_error"], run.stored.energy
    told = f"warning above {number(limits.warn)}"
    if run.so_far.get("steady", {}).get("method") == "factored":
        told += "; works of equilibria are sums over load steps, whose error affects nothing else"
    else:
        told += f", stop above {number(limits.stop)}; not meaningful in the first steps, when the exchanged energy is small"
    verdict = (
        f"<p>Relative error of the energy balance: <strong>{number(float(error[-1]), 3)}</strong> at the end, at most "
        f"{number(float(np.nanmax(np.abs(error))), 3)} during the run ({told}).</p>"
    )
    moving = [name for name in figures.energy_columns(run) if np.any(run.history[name] != 0.0)]
    return table_of(head, map(row, moving), "numbers") + verdict


def _conservation(run: Run) -> str:
    def shown(error: float | None) -> str:
        return "not finite" if error is None else number(error, 3)

    has_films = any(map(is_film, run.stored.bodies))
    kept = "flux between the nodes of films is conservative" if has_films else "constant mass of each point"
    remarks = {
        "mass": _passed(run.summary) or kept,
        "momentum": "change minus external impulse, divided by the largest sum of m|v| or the sum of external impulses",
        "angular_momentum": "about the initial common centre of mass, divided by the largest sum of m|r||v|",
        "energy": "of the energy balance at the end",
    }
    left_out = {"momentum"} if are_films_alone(run.stored) else set()  # they have no inertia
    errors = run.summary["conservation"].items()
    rows = ([name, shown(error), remarks.get(name, "")] for name, error in errors if name not in left_out)
    return table_of(("quantity", "relative error", ""), rows, "numbers last-word")


def _passed(summary: Mapping[str, Any]) -> str:
    """Return a text with the mass [kg] and the number of material points that entered and left through the faces of the grid;
    empty if the summary of the run has none."""
    ways = {"inflow": "entered", "outflow": "left"}
    passed = [(summary[way], words) for way, words in ways.items() if way in summary]
    return ", ".join(f"{number(counts['mass'])} kg in {counts['points']} points {words}" for counts, words in passed)


def _case(run: Run) -> str:
    case = run.stored
    rows = [
        *([_grid_row(case.grid)] if case.grid else []),
        _analysis_row(run, case),
        *([f"body <em>{escape(body.name)}</em>", escape(_words(body))] for body in case.bodies),
        *([["other entries", escape(", ".join(f"{n} × {kind}" for kind, n in case.others.items()))]] if case.others else []),
        *_start_overlap_rows(run),
        *_viscosity_rows(run),
    ]
    text = escape(run.folder.case.read_text(encoding="utf-8"))
    folded = f"<details><summary>The resolved case, case.toml</summary><pre>{text}</pre></details>"
    return table_of(("", ""), rows, "plain") + folded


def _start_overlap_rows(run: Run) -> list[list[str]]:
    """Return a row of the table (label, text) for each pair of bodies that overlap at the start, with the depth of the overlap
    [m]."""
    rows = []
    for overlap in run.so_far.get("start_overlaps", ()):
        depth = f"{number(overlap['depth'])} m"
        text = f"{depth}; this overlap exerts no force until the bodies have separated once, so contact starts {depth} late"
        if len(overlap["between"]) == 1:
            text = f"self-overlap of up to {depth}; it exerts no force on a point until the point has separated once"
        rows.append(["overlap at the start", f"{escape(' and '.join(overlap['between']))}: {text}"])
    return rows


def _viscosity_rows(run: Run) -> list[list[str]]:
    """Return a row of the table for each velocity field with implicit viscosity: mean and largest number of iterations of its
    linear solver per step."""
    solved = run.summary.get("implicit_viscosity", {}) if run.folder.ended else {}
    words = "{rounds_mean:.1f} iterations per step on average, at most {rounds_largest}"
    return [[f"implicit viscosity, field <em>{escape(field)}</em>", words.format(**found)] for field, found in solved.items()]


def _analysis_row(run: Run, case: StoredCase) -> list[str]:
    if case.steady is not None:
        if case.steady.control == "arc-length":
            most = f"at most {case.steady.load_steps} equilibria"
            factors = run.so_far.get("steady", {}).get("load_factors")
            most += f", last load factor {number(factors[-1])}" if factors else ""
            return ["path of equilibria", f"{most}, arc-length control, tolerance {number(case.steady.tolerance)}"]
        steps = f"{case.steady.load_steps} load steps" if case.steady.load_steps > 1 else "one load step"
        return ["steady states", f"{steps} to {number(case.time.end)} s, tolerance {number(case.steady.tolerance)}"]
    if case.time.method == "implicit":
        return ["time", f"implicit steps of {number(case.time.step or case.time.end)} s, to {number(case.time.end)} s"]
    fixed = f"fixed at {number(case.time.step)} s" if case.time.step else ""
    if are_films_alone(case):
        step = f"adaptive steps of the films within steps {fixed or 'of the output'}"
    else:
        step = f"step {fixed}" if fixed else f"step Courant number {number(case.time.courant)}"
    order = f"{case.time.scheme.upper()}, {case.time.transfer.upper()} transfer, " if case.grid else ""
    return ["time", f"{order}{step}, to {number(case.time.end)} s"]


def _grid_row(grid: GridCase) -> list[str]:
    cells = " × ".join(map(str, grid.counts()))
    thick = f", {number(grid.slice_thickness())} m thick" if any(grid.thin()) else ""
    return ["grid", f"{cells} cells of {number(grid.cell)} m{thick}, {grid.functions} functions"]


def _words(body: StoredBody) -> str:
    unit = FIELDS["areal_density" if is_film(body) else "density"].unit
    words = (body.kind, body.material, body.equation_of_state, f"density {body.density:g} {pretty(unit)}")
    text = ", ".join(filter(None, words)).replace("-", " ")
    if body.thickness is None or body.contact_offset is None:
        return text
    return f"{text}, thickness {body.thickness:.4g} m, contact offset {body.contact_offset:.4g} m from its mid-surface"
