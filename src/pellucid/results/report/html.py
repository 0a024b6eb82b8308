"""HTML elements of the report: formatted numbers, sections, tables."""

import math
from collections.abc import Iterable
from html import escape
from importlib.resources import files

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
