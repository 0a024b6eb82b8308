"""Results of the benchmark as tables for the terminal."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

from rich.console import Group, RenderableType
from rich.table import Table

Row = dict[str, Any]
WHAT = ("body", "functions", "transfer")
NUMBERS: dict[str, Callable[[Row], str]] = {
    "points": lambda row: f"{row['points']:,}",
    "nodes": lambda row: f"{row['points']:,}",
    "elements": lambda row: f"{row['elements']:,}",
    "threads": lambda row: str(row["threads"]),
    "cores": lambda row: f"{row['cores']:.1f}",
    "M point-steps/s": lambda row: f"{row['point_steps_per_second'] / 1e6:.1f}",
    "ns/point": lambda row: f"{1e9 / row['point_steps_per_second']:.0f}",
    "ms/step": lambda row: f"{1e3 * row['seconds_per_step']:.2f}",
    "processor ms/step": lambda row: f"{1e3 * row['processor_seconds_per_step']:.0f}",
    "steps/factor": lambda row: f"{1.0 / row['factors_per_step']:.0f}" if row["factors_per_step"] else "",
    "bytes/point": lambda row: f"{row['bytes_per_point']:.0f}",
    "KiB/node": lambda row: f"{row['bytes_per_point'] / 1024:.1f}",
    "built in, s": lambda row: f"{row['build_seconds']:.1f}",
    "nodes/point": lambda row: f"{row['nodes_per_point']:.0f}",
    "M point updates/s": lambda row: f"{row['point_updates_per_second'] / 1e6:.1f}",
    "ms/update": lambda row: f"{1e3 * row['seconds_per_update']:.2f}",
    "GB/s at least": lambda row: f"{row['moved_bytes_per_second'] / 1e9:.1f}",
    "ratio": lambda row: f"{row['ratio']:.2f}",
}
"""Texts of the columns of numbers, by their headings, from a result of a measurement."""


def table(result: Row) -> RenderableType:
    """Format the result of `bench` as tables for the terminal: machine, bodies with the parts of their step, shape functions,
    velocity transfers, membranes, threads, contact, meshless solid, films, other programs."""
    machine = result["machine"]
    bandwidth = f"triad {machine['triad_bytes_per_second'] / 1e9:.1f} GB/s"
    versions = f"pellucid {machine['pellucid']}, numba {machine['numba']}"
    step, parts = "run time of a complete time step", "fractions of its parts"
    shown: list[RenderableType] = [f"{machine['processor']}, {machine['threads']} threads, {bandwidth}, {versions}"]
    numbers = _columns("points", "M point-steps/s", "ms/step", "cores", "bytes/point") | _parts(result["bodies"])
    shown.append(_table(f"{step}, and {parts}", ("body",), numbers, result["bodies"]))
    title = f"{step} with other shape functions and transfers, and of a membrane sheet"
    shown.append(_table(title, WHAT, _columns("points", "M point-steps/s", "ns/point"), result["variants"]))
    shown.append(_passes(result["passes"], machine["triad_bytes_per_second"]))
    if rows := result["threads"]:
        alone = {row["points"]: row["seconds_per_step"] for row in rows if row["threads"] == 1}
        numbers = _columns("points", "threads", "cores", "M point-steps/s")
        numbers |= {"speed-up over one thread": lambda row: f"{alone[row['points']] / row['seconds_per_step']:.2f}"}
        shown.append(_table("speed-up of an ideal gas with different numbers of threads", (), numbers, rows))
    title = "run time of a time step of a block in contact with a sheet of elements, compared with each body alone"
    pressed = result["contact"] | {f"{what}, ms": f"{1e3 * s:.2f}" for what, s in result["contact"]["seconds_per_step"].items()}
    times = {heading: lambda row, name=heading: row[name] for heading in ("sheet, ms", "block, ms", "together, ms")}
    shown.append(_table(title, (), _columns("elements", "points") | times | _columns("ratio"), [pressed]))
    solid = result["solid"]
    title = f"forces of a meshless solid: {solid['points']:,} quadrature points, {solid['nodes']:,} nodes, built in"
    title = f"{title} {solid['build_seconds']:.1f} s with {solid['build_bytes'] / 2**20:.0f} MiB"
    numbers = _columns("nodes/point", "M point updates/s", "ms/update", "bytes/point", "GB/s at least")
    forms = [{**solid, **measured, "volume ratio": form} for form, measured in solid["forms"].items()]
    shown.append(_table(title, ("volume ratio",), numbers, forms))
    films = _columns("nodes", "ms/step", "processor ms/step", "steps/factor", "KiB/node", "built in, s")
    films["ms/step"] = lambda row: f"{1e3 * row['seconds_per_step']:.0f}"
    title = f"run time of a time step of a film in space with bending, and {parts}"
    shown.append(_table(title, (), films | _parts(result["films"]), result["films"]))
    if result["peers"]:
        shown.append(_peers(result["peers"]))
    return Group(*shown)


def _columns(*headings: str) -> dict[str, Callable[[Row], str]]:
    return {heading: NUMBERS[heading] for heading in headings}


def _parts(rows: list[Row]) -> dict[str, Callable[[Row], str]]:
    """Return columns with the fractions of the parts of a step, for the parts of all results."""

    def fraction(part: str) -> Callable[[Row], str]:
        return lambda row: f"{row['parts'][part]:.0%}" if part in row["parts"] else ""

    return {part: fraction(part) for row in rows for part in row["parts"]}


def _table(title: str, left: Sequence[str], right: dict[str, Callable[[Row], str]], rows: Iterable[Row]) -> Table:
    """Build a table with left-aligned text columns (`left`: keys of the rows), followed by right-aligned columns of numbers
    (`right`: texts by heading)."""
    shown = Table(title=title)
    for heading in left:
        shown.add_column(heading)
    for heading in right:
        shown.add_column(heading, justify="right")
    for row in rows:
        shown.add_row(*(row[key] for key in left), *(text(row) for text in right.values()))
    return shown


def _passes(rows: list[Row], triad: float) -> Table:
    def measured(name: str) -> Callable[[Row], str]:
        def text(row: Row) -> str:
            one = row["passes"].get(name)
            return f"{1e9 * one['seconds_per_point']:.1f}, {one['bytes_per_second'] / triad:.0%}" if one else ""

        return text

    title = "passes over the points: ns/point, and memory bandwidth of the point arrays divided by the triad bandwidth"
    return _table(title, WHAT, {name: measured(name) for row in rows for name in row["passes"]}, rows)


def _peers(rows: list[Row]) -> Table:
    def faster(row: Row) -> str:
        return row["missing"] if "missing" in row else f"{row['ratio']:.1f} times" if "ratio" in row else ""

    numbers: dict[str, Callable[[Row], str]] = {
        "threads": lambda row: str(row.get("threads", "")),
        "M point-steps/s": lambda row: "not run" if "missing" in row else NUMBERS["M point-steps/s"](row),
        "speed of pellucid relative to this program": faster,
    }
    return _table("the same time step in other programs (benchmarks/peers)", ("peer", "law"), numbers, rows)
