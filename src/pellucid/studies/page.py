"""Elements of the pages of studies: embedded figures, tables of numbers, page frame."""

import base64
from collections.abc import Iterable
from html import escape
from io import BytesIO
from pathlib import Path
from typing import Any

from pellucid.results.report.html import number, page_of, section, table_of
from pellucid.results.storage.files import explained, write_text
from pellucid.studies.ranges import with_units


def write_page(path: Path, title: str, sections: Iterable[str]) -> Path:
    """Write a self-contained HTML page with a title and sections (HTML) to `path`; return the path."""
    body = "\n".join([f"<h1>{escape(title)}</h1>", *filter(None, sections)])
    with explained(path.parent):
        write_text(path, page_of(title, body))
    return path


def figure(drawn: Any, caption: str) -> str:
    """Return a matplotlib figure as HTML with an embedded image and a caption."""
    picture = BytesIO()
    drawn.savefig(picture, format="png")
    data, text = base64.b64encode(picture.getvalue()).decode("ascii"), escape(caption)
    image = f'<img alt="{text}" style="width: 100%" src="data:image/png;base64,{data}">'
    return f"<figure>{image}<figcaption>{text}</figcaption></figure>"


def cell(value: Any) -> str:
    """Return a number or text as HTML for a table cell; empty for a missing value."""
    if isinstance(value, str):
        return escape(value)
    if value is None or value != value:
        return ""
    return number(float(value))


def frame_table(table: Any, columns: Iterable[str]) -> str:
    """Return columns of a pandas table as an HTML table, with the units in the table's `attrs["units"]`."""
    names = list(columns)
    rows = ([cell(value) for value in row] for row in table[names].itertuples(index=False, name=None))
    return table_of(map(escape, with_units(names, table.attrs.get("units", {}))), rows, "numbers")


def titled(title: str, *parts: str) -> str:
    """Return an HTML section with this title and those texts of `parts` that are not empty; an empty text if all are empty."""
    body = "".join(parts)
    return section(title, body) if body else ""
