"""Results of studies: the table of all runs, and elements of the pages (figures, tables of numbers, page frame)."""

import base64
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from pellucid.errors import PellucidError, shown
from pellucid.results.report.html import number, page_of, section, table_of
from pellucid.results.storage.files import explained, replacing, write_text
from pellucid.results.storage.run import Run
from pellucid.studies import need
from pellucid.studies.members import DONE, Member, Outcome, places
from pellucid.studies.ranges import at_key, unit_at, with_units


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


REDUCED = ("last", "min", "max", "mean")


def tabulated(out: Path, members: Sequence[Member], ended: Mapping[str, Outcome]) -> Any:
    """Return a pandas table with a row per member of the study in the folder `out`, in the order of the members. ended: outcome
    of each member by digest.

    Columns: `member`, `state`, settings by key in SI units, `steps`, `wall_seconds`, metrics by name, probes as `<probe>_last`,
    `_min`, `_max` and `_mean` over time, and `message`; the units are in `attrs["units"]`.
    """
    rows = [_row(out, member, ended[member.digest]) for member in members]
    columns = dict.fromkeys(name for row in rows for name in row if name != "message")
    table = need("pandas").DataFrame(rows, columns=[*columns, "message"])
    for key in keys_of(members):
        if table[key].dtype == object:  # words, or numbers beside words, which no column of a Parquet file can be
            table[key] = table[key].astype(str)
    table.attrs["units"] = units_of(out, members, ended)
    return table


def units_of(out: Path, members: Sequence[Member], ended: Mapping[str, Outcome]) -> dict[str, str]:
    """Return the SI units of the table's columns that have a unit, by name. Arguments as in `tabulated`."""
    units = {"wall_seconds": "s"} | {key: unit_at(members[0].case, key) for key in keys_of(members)}
    done = next((member for member in members if ended[member.digest].state == DONE), None)
    if done is not None:
        run = Run(places(out, done.digest).run)
        units |= {name: str(metric.get("unit", "")) for name, metric in run.summary["metrics"].items()}
        units |= {f"{probe.name}_{word}": run.units[probe.name] for probe in done.case.probe for word in REDUCED}
    return {name: unit for name, unit in units.items() if unit not in ("", "1")}


def write_table(table: Any, out: Path) -> list[Path]:
    """Write the pandas table of a study to `members.csv` and `members.parquet` in the folder `out`; return their paths."""
    need("pyarrow")
    csv, parquet = out / "members.csv", out / "members.parquet"
    with replacing(csv) as file:
        table.to_csv(file, index=False)
    with replacing(parquet) as file:
        table.to_parquet(file, index=False)
    return [csv, parquet]


def keys_of(members: Sequence[Member]) -> list[str]:
    """Return the keys of the varied parameters, in order."""
    return list(dict.fromkeys(key for member in members for key in member.settings))


def outputs_of(table: Any, keys: Sequence[str]) -> list[str]:
    """Return the names of numeric result columns whose values vary among the members."""
    inner = {"member", "state", "message", "steps", "wall_seconds", *keys}
    found = [name for name in table.columns if name not in inner and table[name].dtype.kind in "fiu"]
    return [name for name in found if table[name].nunique() > 1]


def _row(out: Path, member: Member, ended: Outcome) -> dict[str, Any]:
    row: dict[str, Any] = {"member": member.digest, "state": ended.state}
    row |= {key: _plain(at_key(member.case, key), value) for key, value in member.settings.items()}
    if ended.state == DONE:
        run = Run(places(out, member.digest).run)
        row |= {"steps": run.summary["steps"], "wall_seconds": run.summary["wall_seconds"]}
        row |= metrics_of(run) | probes_of(run, [probe.name for probe in member.case.probe])
    return row | {"message": ended.message}


def _plain(value: Any, said: Any) -> Any:
    """Return a setting as a table cell: numbers and texts as in the case (`value`), other values in TOML syntax. said: the
    setting as the user wrote it, used if the case has no such value."""
    value = said if value is None else value
    return value if isinstance(value, (int, float, str)) else shown(value, 200)


def metrics_of(run: Run) -> dict[str, float]:
    """Return the computed values of the metrics of a run by name, from the summary of the run; if the run was killed before
    the summary was complete, compute the metrics from its files."""
    stored = run.summary["metrics"]
    try:
        found: Mapping[str, Any] = stored or {name: metric.to_data() for name, metric in run.metrics.items()}
    except PellucidError:
        return {}
    return {name: float("nan") if metric["value"] is None else float(metric["value"]) for name, metric in found.items()}


def probes_of(run: Run, names: Sequence[str]) -> dict[str, float]:
    """Return the last, smallest, largest and mean value over time of each named probe, by `<probe>_last`, `_min`, `_max` and
    `_mean`."""
    found: dict[str, float] = {}
    for name in names:
        time, values = run.curve(name)
        span = time[-1] - time[0]
        mean = float(np.trapezoid(values, time) / span) if span > 0.0 else float(values[-1])
        reduced = (float(values[-1]), *map(float, (np.nanmin(values), np.nanmax(values))), mean)
        found |= {f"{name}_{word}": value for word, value in zip(REDUCED, reduced, strict=True)}
    return found
