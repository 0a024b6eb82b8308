"""Parts of the pages of studies: figures in the text, tables of numbers, the frame."""

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
    """Write one file that needs no others."""
    body = "\n".join([f"<h1>{escape(title)}</h1>", *filter(None, sections)])
    with explained(path.parent):
        write_text(path, page_of(title, body))
    return path


def figure(drawn: Any, caption: str) -> str:
    """A figure of matplotlib, drawn into the page."""
    picture = BytesIO()
    drawn.savefig(picture, format="png")
    data, text = base64.b64encode(picture.getvalue()).decode("ascii"), escape(caption)
    image = f'<img alt="{text}" style="width: 100%" src="data:image/png;base64,{data}">'
    return f"<figure>{image}<figcaption>{text}</figcaption></figure>"


def cell(value: Any) -> str:
    """A number or text for a cell; empty for what is not there."""
    if isinstance(value, str):
        return escape(value)
    if value is None or value != value:
        return ""
    return number(float(value))


def frame_table(table: Any, columns: Iterable[str]) -> str:
    """Columns of a pandas table."""
    names = list(columns)
    rows = ([cell(value) for value in row] for row in table[names].itertuples(index=False, name=None))
    return table_of(map(escape, with_units(names, table.attrs.get("units", {}))), rows, "numbers")


def titled(title: str, *parts: str) -> str:
    """A section of the parts that are not empty; nothing without any."""
    body = "".join(parts)
    return section(title, body) if body else ""
