"""HTML elements of the report: head with outcome and statistics of the run, formatted numbers, sections, tables."""

import math
from collections.abc import Callable, Iterable
from html import escape
from importlib.resources import files
from typing import Any

from pellucid.results.pictures.quantities import is_film
from pellucid.results.storage.run import Run
from pellucid.results.storage.run_folder import StoredCase

PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>{title}</title>
<meta name="viewport" content="width=device-width, initial-scale=1">
<style>
{style}</style></head>
<body><main>
{body}
</main></body></html>
"""


def page_of(title: str, body: str) -> str:
    """Return a complete HTML page that needs no other file. body: HTML of the contents."""
    style = (files(__package__) / "report.css").read_text(encoding="utf-8")
    return PAGE.format(title=escape(title), style=style, body=body)


def number(value: float, digits: int = 4, padded: bool = False) -> str:
    """Return a number as HTML with `digits` significant digits; very large and very small numbers have a power of ten.

    padded: keep trailing zeros.
    """
    if not math.isfinite(value):
        return "not finite"
    if value == 0.0:
        return "0"
    if 1e-3 <= abs(value) < 10.0**digits:
        text = f"{value:#.{digits}g}" if padded else f"{value:.{digits}g}"
        return text.rstrip(".").replace("-", "−")
    if 1e-3 <= abs(value) < 1e6:
        return f"{value:.0f}".replace("-", "−")
    mantissa, power = f"{value:.{digits - 1}e}".split("e")
    shown = mantissa if padded else f"{float(mantissa):g}"
    return f"{shown} × 10<sup>{int(power)}</sup>".replace("-", "−")


def section(title: str, body: str) -> str:
    """Return a section of the page as HTML, from its title and its contents `body` in HTML. The anchor is the title in
    lower case with hyphens."""
    return f'<section id="{title.lower().replace(" ", "-")}"><h2>{title}</h2>{body}</section>'


def table_of(head: Iterable[str], rows: Iterable[Iterable[str]], kind: str = "") -> str:
    """Return an HTML table: `head` has the column titles, `rows` the cells in HTML; `kind` is the class of the table in the
    style sheet."""
    titles = "".join(f"<th>{cell}</th>" for cell in head)
    lines = "".join("<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>" for row in rows)
    table = f'<table class="{kind}"><thead><tr>{titles}</tr></thead><tbody>{lines}</tbody></table>'
    return f'<div class="wide">{table}</div>'


def are_films_alone(case: StoredCase) -> bool:
    """Return True if all bodies are films with their own nodes, which have no inertia and choose their own time steps."""
    return case.grid is None and all(map(is_film, case.bodies))


def header(run: Run) -> str:
    """Return the head of the report as HTML: title, source, outcome, passed checks, description."""
    source = f'<p class="source">{escape(run.stored.source)}</p>' if run.stored.source else ""
    description = filter(None, map(str.strip, run.stored.description.split("\n\n")))
    paragraphs = "".join(f"<p>{escape(part)}</p>" for part in description)
    name = f'<p class="id">{escape(run.stored.id)}</p>' if run.stored.id else ""
    return f"<header>{name}<h1>{escape(run.stored.title)}</h1>{source}{_badge(run)}{_ending(run)}{paragraphs}</header>"


def facts(run: Run) -> str:
    """Return the number of points and steps, the simulated and wall-clock time and the speed of the run as HTML, without values
    that are unknown."""
    known, alone = run.so_far, are_films_alone(run.stored)  # their own steps are not counted
    commit = known.get("commit", "")[:10]
    shown: dict[str, tuple[str, Callable[[Any], str]]] = {
        "points": ("nodes" if alone else "points", lambda value: f"{value:,}".replace(",", "\u202f")),
        "steps": ("steps of the clock" if alone else "steps", lambda value: f"{value:,}".replace(",", "\u202f")),
        "end_time": ("simulated time", lambda value: f"{number(value)} s"),
        "wall_seconds": ("wall-clock time of the steps", lambda value: f"{number(value, 3)} s"),
        "point_steps_per_second": ("point-steps per second", lambda value: f"{number(value / 1e6, 3)} million"),
        "threads": ("threads", str),
        "version": ("pellucid", lambda value: escape(value) + (f" <small>({escape(commit)})</small>" if commit else "")),
    }
    if alone:
        del shown["point_steps_per_second"]
    items = (f"<div><dt>{title}</dt><dd>{text(known[key])}</dd></div>" for key, (title, text) in shown.items() if key in known)
    return f'<dl class="facts">{"".join(items)}</dl>'


def _badge(run: Run) -> str:
    metrics = run.metrics.values()
    passed = sum(metric.passed for metric in metrics)
    if run.stopped:
        return '<p class="badge fail">the run stopped with an error</p>'
    if not metrics:
        return ""
    if passed == len(metrics):
        return f'<p class="badge pass">{"the check" if passed == 1 else f"all {passed} checks"} passed</p>'
    return f'<p class="badge fail">{len(metrics) - passed} of {len(metrics)} checks failed</p>'


def _ending(run: Run) -> str:
    """Return HTML that states why the run has not reached the end of its case and how to resume it; empty if the run has
    reached the end."""
    if run.finished:
        return ""
    at, end = number(run.so_far["end_time"]), number(run.stored.time.end)
    resume = f"<code>pellucid resume {escape(str(run.out))}</code>"
    if run.stopped:
        text = escape(run.stopped["message"]).replace("\n", "<br>")
        kept = any(run.folder.checkpoint.glob("*.npz"))
        where = "from its last checkpoint" if kept else "from its start, because it has no checkpoint"
        why = f"{text}<br>{resume} continues the run {where}; <code>--set</code> changes its step or limits."
    elif run.folder.ended:
        why = f"Stopped early, at {at} s of {end} s; checks are not evaluated yet."
    else:
        why = f"Interrupted or killed at {at} s of {end} s; checks are not evaluated yet. {resume} continues the run."
    return f'<p class="note">{why}</p>'
