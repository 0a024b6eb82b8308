"""The benchmark's result as tables for the terminal."""

from typing import Any

from rich.console import Group, RenderableType
from rich.table import Table


def table(result: dict[str, Any]) -> RenderableType:
    """What `bench` returned, to print with rich: the machine, the bodies with the parts of their step, other functions and
    transfers and membranes, numbers of threads, contact, a meshless solid, films, the peers."""
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


def _bodies(rows: list[dict[str, Any]]) -> Table:
    parts = list(dict.fromkeys(part for row in rows for part in row["parts"]))
    shown = Table(title="a step, everything included, and the shares of its parts")
    shown.add_column("body")
    for heading in ("points", "M point-steps/s", "ms/step", "cores", "bytes/point", *parts):
        shown.add_column(heading, justify="right")
    for row in rows:
        shown.add_row(
            row["body"],
            f"{row['points']:,}",
            f"{row['point_steps_per_second'] / 1e6:.1f}",
            f"{row['seconds_per_step'] * 1e3:.2f}",
            f"{row['cores']:.1f}",
            f"{row['bytes_per_point']:.0f}",
            *(f"{row['parts'][part]:.0%}" if part in row["parts"] else "" for part in parts),
        )
    return shown


def _variants(rows: list[dict[str, Any]]) -> Table:
    shown = Table(title="the same with other functions and transfers, and of a sheet of membrane")
    for heading in ("body", "functions", "transfer"):
        shown.add_column(heading)
    for heading in ("points", "M point-steps/s", "ns/point"):
        shown.add_column(heading, justify="right")
    for row in rows:
        shown.add_row(
            *(row[key] for key in ("body", "functions", "transfer")),
            f"{row['points']:,}",
            f"{row['point_steps_per_second'] / 1e6:.1f}",
            f"{1e9 / row['point_steps_per_second']:.0f}",
        )
    return shown


def _passes(rows: list[dict[str, Any]], triad: float) -> Table:
    names = list(dict.fromkeys(name for row in rows for name in row["passes"]))
    shown = Table(
        title="passes over points alone: ns/point, and the rate at which they move points' arrays by that of the triad"
    )
    for heading in ("body", "functions", "transfer"):
        shown.add_column(heading)
    for heading in names:
        shown.add_column(heading, justify="right")
    for row in rows:
        found = [row["passes"].get(name) for name in names]
        cells = [f"{1e9 * one['seconds_per_point']:.1f}, {one['bytes_per_second'] / triad:.0%}" if one else "" for one in found]
        shown.add_row(*(row[key] for key in ("body", "functions", "transfer")), *cells)
    return shown


def _threads(rows: list[dict[str, Any]]) -> Table:
    alone = {row["points"]: row["seconds_per_step"] for row in rows if row["threads"] == 1}
    shown = Table(title="the ideal gas with some numbers of threads")
    for heading in ("points", "threads", "cores", "M point-steps/s", "times one thread"):
        shown.add_column(heading, justify="right")
    for row in rows:
        shown.add_row(
            f"{row['points']:,}",
            str(row["threads"]),
            f"{row['cores']:.1f}",
            f"{row['point_steps_per_second'] / 1e6:.1f}",
            f"{alone[row['points']] / row['seconds_per_step']:.2f}",
        )
    return shown


def _contact(row: dict[str, Any]) -> Table:
    shown = Table(title="a step of a block that presses on a sheet of elements, beside those of the two alone")
    for heading in ("elements", "points", "sheet, ms", "block, ms", "together, ms", "ratio"):
        shown.add_column(heading, justify="right")
    ms = [f"{1e3 * row['seconds_per_step'][what]:.2f}" for what in ("sheet", "block", "together")]
    shown.add_row(f"{row['elements']:,}", f"{row['points']:,}", *ms, f"{row['ratio']:.2f}")
    return shown


def _solid(row: dict[str, Any]) -> Table:
    title = f"forces of a meshless solid: {row['points']:,} quadrature points, {row['nodes']:,} nodes, built in"
    shown = Table(title=f"{title} {row['build_seconds']:.1f} s with {row['build_bytes'] / 2**20:.0f} MiB")
    shown.add_column("volume ratio")
    for heading in ("nodes/point", "M point updates/s", "ms/update", "bytes/point", "GB/s at least"):
        shown.add_column(heading, justify="right")
    for form, measured in row["forms"].items():
        shown.add_row(
            form,
            f"{row['nodes_per_point']:.0f}",
            f"{measured['point_updates_per_second'] / 1e6:.1f}",
            f"{1e3 * measured['seconds_per_update']:.2f}",
            f"{row['bytes_per_point']:.0f}",
            f"{measured['moved_bytes_per_second'] / 1e9:.1f}",
        )
    return shown


def _films(rows: list[dict[str, Any]]) -> Table:
    parts = list(dict.fromkeys(part for row in rows for part in row["parts"]))
    shown = Table(title="a step of its own of a film in space that bends, and the shares of its parts")
    for heading in ("nodes", "ms/step", "processor ms/step", "steps/factor", "KiB/node", "built in, s", *parts):
        shown.add_column(heading, justify="right")
    for row in rows:
        factors = row["factors_per_step"]
        shown.add_row(
            f"{row['points']:,}",
            f"{1e3 * row['seconds_per_step']:.0f}",
            f"{1e3 * row['processor_seconds_per_step']:.0f}",
            f"{1.0 / factors:.0f}" if factors else "",
            f"{row['bytes_per_point'] / 1024:.1f}",
            f"{row['build_seconds']:.1f}",
            *(f"{row['parts'][part]:.0%}" for part in parts),
        )
    return shown


def _peers(rows: list[dict[str, Any]]) -> Table:
    shown = Table(title="the same step in other programs (benchmarks/peers)")
    shown.add_column("peer")
    shown.add_column("law")
    for heading in ("threads", "M point-steps/s", "pellucid is faster by"):
        shown.add_column(heading, justify="right")
    for row in rows:
        if "missing" in row:
            shown.add_row(row["peer"], row["law"], "", "not run", row["missing"])
            continue
        ratio = f"{row['ratio']:.1f} times" if "ratio" in row else ""
        rate = f"{row['point_steps_per_second'] / 1e6:.1f}"
        shown.add_row(row["peer"], row["law"], str(row["threads"]), rate, ratio)
    return shown
