"""Results of the benchmark as tables for the terminal."""

from collections.abc import Iterable, Sequence
from typing import Any

from rich.console import Group, RenderableType
from rich.table import Table


def table(result: dict[str, Any]) -> RenderableType:
    """Format the result of `bench` as tables for the terminal: machine, bodies with the parts of their step, shape functions,
    velocity transfers, membranes, threads, contact, meshless solid, films, other programs."""
    machine = result["machine"]
    bandwidth = f"triad {machine['triad_bytes_per_second'] / 1e9:.1f} GB/s"
    versions = f"pellucid {machine['pellucid']}, numba {machine['numba']}"
    head = f"{machine['processor']}, {machine['threads']} threads, {bandwidth}, {versions}"
    shown: list[RenderableType] = [head, _bodies(result["bodies"]), _variants(result["variants"])]
    shown.append(_passes(result["passes"], machine["triad_bytes_per_second"]))
    if result["threads"]:
        shown.append(_threads(result["threads"]))
    shown += [_contact(result["contact"]), _solid(result["solid"]), _films(result["films"])]
    if result["peers"]:
        shown.append(_peers(result["peers"]))
    return Group(*shown)


WHAT = ("body", "functions", "transfer")


def _table(title: str, left: Sequence[str], right: Sequence[str], rows: Iterable[Sequence[str]]) -> Table:
    """Build a table with left-aligned text columns, followed by right-aligned columns of numbers. left, right: headings of both
    kinds of columns."""
    shown = Table(title=title)
    for heading in left:
        shown.add_column(heading)
    for heading in right:
        shown.add_column(heading, justify="right")
    for row in rows:
        shown.add_row(*row)
    return shown


def _names(rows: list[dict[str, Any]], key: str) -> list[str]:
    """Return the names of the parts of a step or of the kernels (`key`: "parts" or "passes") in all results, without
    duplicates."""
    return list(dict.fromkeys(name for row in rows for name in row[key]))


def _rate(row: dict[str, Any]) -> str:
    return f"{row['point_steps_per_second'] / 1e6:.1f}"


def _bodies(rows: list[dict[str, Any]]) -> Table:
    parts = _names(rows, "parts")
    headings = ("points", "M point-steps/s", "ms/step", "cores", "bytes/point", *parts)
    cells = [
        (
            row["body"],
            f"{row['points']:,}",
            _rate(row),
            f"{row['seconds_per_step'] * 1e3:.2f}",
            f"{row['cores']:.1f}",
            f"{row['bytes_per_point']:.0f}",
            *(f"{row['parts'][part]:.0%}" if part in row["parts"] else "" for part in parts),
        )
        for row in rows
    ]
    return _table("run time of a complete time step, and fractions of its parts", ("body",), headings, cells)


def _variants(rows: list[dict[str, Any]]) -> Table:
    title = "run time of a complete time step with other shape functions and transfers, and of a membrane sheet"
    cells = [
        (*(row[key] for key in WHAT), f"{row['points']:,}", _rate(row), f"{1e9 / row['point_steps_per_second']:.0f}")
        for row in rows
    ]
    return _table(title, WHAT, ("points", "M point-steps/s", "ns/point"), cells)


def _passes(rows: list[dict[str, Any]], triad: float) -> Table:
    names = _names(rows, "passes")
    cells = []
    for row in rows:
        found = [row["passes"].get(name) for name in names]
        of = [f"{1e9 * one['seconds_per_point']:.1f}, {one['bytes_per_second'] / triad:.0%}" if one else "" for one in found]
        cells.append([*(row[key] for key in WHAT), *of])
    title = "passes over the points: ns/point, and memory bandwidth of the point arrays divided by the triad bandwidth"
    return _table(title, WHAT, names, cells)


def _threads(rows: list[dict[str, Any]]) -> Table:
    alone = {row["points"]: row["seconds_per_step"] for row in rows if row["threads"] == 1}
    headings = ("points", "threads", "cores", "M point-steps/s", "speed-up over one thread")
    cells = [
        (
            f"{row['points']:,}",
            str(row["threads"]),
            f"{row['cores']:.1f}",
            _rate(row),
            f"{alone[row['points']] / row['seconds_per_step']:.2f}",
        )
        for row in rows
    ]
    return _table("speed-up of an ideal gas with different numbers of threads", (), headings, cells)


def _contact(row: dict[str, Any]) -> Table:
    title = "run time of a time step of a block in contact with a sheet of elements, compared with each body alone"
    headings = ("elements", "points", "sheet, ms", "block, ms", "together, ms", "ratio")
    ms = [f"{1e3 * row['seconds_per_step'][what]:.2f}" for what in ("sheet", "block", "together")]
    return _table(title, (), headings, [(f"{row['elements']:,}", f"{row['points']:,}", *ms, f"{row['ratio']:.2f}")])


def _solid(row: dict[str, Any]) -> Table:
    title = f"forces of a meshless solid: {row['points']:,} quadrature points, {row['nodes']:,} nodes, built in"
    title = f"{title} {row['build_seconds']:.1f} s with {row['build_bytes'] / 2**20:.0f} MiB"
    headings = ("nodes/point", "M point updates/s", "ms/update", "bytes/point", "GB/s at least")
    cells = [
        (
            form,
            f"{row['nodes_per_point']:.0f}",
            f"{measured['point_updates_per_second'] / 1e6:.1f}",
            f"{1e3 * measured['seconds_per_update']:.2f}",
            f"{row['bytes_per_point']:.0f}",
            f"{measured['moved_bytes_per_second'] / 1e9:.1f}",
        )
        for form, measured in row["forms"].items()
    ]
    return _table(title, ("volume ratio",), headings, cells)


def _films(rows: list[dict[str, Any]]) -> Table:
    parts = _names(rows, "parts")
    title = "run time of a time step of a film in space with bending, and fractions of its parts"
    headings = ("nodes", "ms/step", "processor ms/step", "steps/factor", "KiB/node", "built in, s", *parts)
    cells = [
        (
            f"{row['points']:,}",
            f"{1e3 * row['seconds_per_step']:.0f}",
            f"{1e3 * row['processor_seconds_per_step']:.0f}",
            f"{1.0 / row['factors_per_step']:.0f}" if row["factors_per_step"] else "",
            f"{row['bytes_per_point'] / 1024:.1f}",
            f"{row['build_seconds']:.1f}",
            *(f"{row['parts'][part]:.0%}" for part in parts),
        )
        for row in rows
    ]
    return _table(title, (), headings, cells)


def _peers(rows: list[dict[str, Any]]) -> Table:
    cells = []
    for row in rows:
        faster = f"{row['ratio']:.1f} times" if "ratio" in row else ""
        found = ("", "not run", row["missing"]) if "missing" in row else (str(row["threads"]), _rate(row), faster)
        cells.append((row["peer"], row["law"], *found))
    headings = ("threads", "M point-steps/s", "speed of pellucid relative to this program")
    return _table("the same time step in other programs (benchmarks/peers)", ("peer", "law"), headings, cells)
