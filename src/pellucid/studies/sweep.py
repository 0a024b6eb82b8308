"""Sweeps: run a case for many values of its parameters; results in one table and one page."""

from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, NamedTuple

from pellucid.case.spec import required
from pellucid.progress import Progress, WarningsOnly
from pellucid.results.pictures.style import COLOURS, LINES, SEQUENTIAL, WIDTH, house_style, label, panels, pretty
from pellucid.results.report.html import number, table_of
from pellucid.results.storage.run import Run
from pellucid.studies import need
from pellucid.studies.members import DONE, FAILED, Member, Outcome, members_of, places
from pellucid.studies.pages import figure, frame_table, keys_of, outputs_of, tabulated, titled, write_page, write_table
from pellucid.studies.pool import Pool, Workers
from pellucid.studies.ranges import DECADES, named, rows_of, with_units

if TYPE_CHECKING:
    from pellucid.case import Case


class Sensitivity(NamedTuple):
    """First-order sensitivity index: the share of the variance of an output (result column) that one parameter (`key`) alone
    explains."""

    output: str  # name of the result column
    key: str  # dotted key of the parameter
    share: float  # the index, about 0 to 1
    interval: float
    """Half width of the 95 % confidence interval, by resampling."""


def sweep(
    case: "Case",
    over: Mapping[str, Any] | None = None,
    *,
    samples: int | None = None,
    rows: Sequence[Mapping[str, Any]] = (),
    out: Path | str | None = None,
    until: float | None = None,
    workers: int | None = None,
    threads: int | None = None,
    scheduler: str | None = None,
    slurm: Mapping[str, str] | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> Any:
    """Run a case for many settings; return a pandas table with a row for each member.

    `over`: a list of values, or a tuple (low, high), by dotted key. From ranges, `samples` members are drawn as a Latin
    hypercube with `seed`. `rows`: explicit settings of members. Members run `workers` at a time on this machine, each with
    `threads` threads, on the cluster of a dask `scheduler`, or as jobs of `slurm` (arguments of
    `dask_jobqueue.SLURMCluster`), up to the time `until` [s] or the end of the case. `out`: folder in which everything is
    kept, with `members.csv`, `members.parquet` and `report.html`. A repeated call skips finished members and resumes
    interrupted ones.

    Columns: `member`, `state` ("done" or "failed"), the settings in SI units, `steps`, `wall_seconds`, metrics, for each
    probe `_last`, `_min`, `_max` and `_mean`, and `message`. Raises `CaseError` and `UsageError` before any run.
    """
    drawn = rows_of(required(case), over or {}, samples, rows, seed)
    parts, at_random = Workers(workers, threads, scheduler, dict(slurm or {})), samples is not None
    parts.check()
    for module in ("distributed", "pandas", "pyarrow", *(["SALib"] if at_random else [])):
        need(module)
    progress = progress or WarningsOnly()
    members = members_of(case, drawn, until)

    def told(member: Member, ended: Outcome) -> None:
        if ended.state == FAILED:
            progress.message(f"member {member.digest} ({named(member.settings)}) failed: {ended.message}")

    with nullcontext(out) if out is not None else TemporaryDirectory(prefix="pellucid-") as folder:
        place = Path(folder)
        with Pool(place, parts, progress) as pool:
            ended = pool.compute(members, told)
        table, keys = tabulated(place, members, ended), keys_of(members)
        numeric = [key for key in keys if table[key].dtype.kind in "fiu" and table[key].nunique() > 1]
        found = sensitivities(table, numeric, outputs_of(table, keys)) if at_random else []
        progress.begin("report")
        write_table(table, place)
        write_sweep_page(place, case.title, members, table, keys, found)
    return table


MOST_CURVES, MOST_OUTPUTS = 200, 12
WORDS = dict(zip(LINES, ("solid", "dashed", "dash-dotted", "dotted"), strict=False))


def write_sweep_page(
    out: Path, title: str, members: Sequence[Member], table: Any, keys: Sequence[str], found: Sequence[Sensitivity]
) -> Path:
    """Write `report.html` of a sweep to `out`; return its path.

    title: title of the case. table: pandas table of the members. keys: varied parameters. found: sensitivity indices.
    """
    done = table[table["state"] == DONE]
    failed = table[table["state"] != DONE]
    outputs = outputs_of(done, keys)[:MOST_OUTPUTS]
    numeric = [key for key in keys if done[key].dtype.kind in "fiu" and done[key].nunique() > 1]
    with house_style():
        curves = _member_curves(out, [member for member in members if member.digest in set(done["member"])], done, numeric)
        dependence = _dependence(done, outputs, keys)
    few = "" if found else f'<p class="note">Sensitivities require at least {LEAST} members drawn with --samples.</p>'
    summary = f"<p>{len(done)} of {len(table)} members have finished. Parameters: {', '.join(map(escape, keys))}.</p>"
    listed = frame_table(table, ["member", "state", *keys, *outputs])
    failures = frame_table(failed, ["member", *keys, "message"]) if len(failed) else ""
    sections = [
        summary,
        titled("Failures", failures),
        titled("Curves", *curves),
        titled("Dependence", dependence, few),
        titled("Sensitivities", _indices(found)),
        titled("Members", listed),
    ]
    return write_page(out / "report.html", f"Sweep: {title}", sections)


def _member_curves(out: Path, members: Sequence[Member], table: Any, numeric: Sequence[str]) -> list[str]:
    """Return figures, as HTML, of every probe against time with a line for each member; numeric: varied parameters that are
    numbers.

    The colour shows the first numeric parameter; the line style shows the second one if its number of values is small.
    """
    import matplotlib

    probes = [probe.name for probe in members[0].case.probe] if members else []
    if not probes:
        return []
    shown = members[:: -(-len(members) // MOST_CURVES)]
    runs = [Run(places(out, member.digest).run) for member in shown]
    values = table.set_index("member")[numeric[0]] if numeric else None
    units = table.attrs.get("units", {})
    kinds = _kinds(table, numeric[1:])
    across = min(2, len(probes))
    drawn, axes = panels(len(probes), across, WIDTH, 3.2 * -(-len(probes) // across))
    for axis, name in zip(axes, probes, strict=True):
        for count, (member, run) in enumerate(zip(shown, runs, strict=True)):
            if values is None:
                colour: Any = COLOURS[count % len(COLOURS)]
            else:
                spread = values.max() - values.min()
                colour = matplotlib.colormaps[SEQUENTIAL](0.9 * (values[member.digest] - values.min()) / spread)
            axis.plot(*run.curve(name), kinds.get(member.digest, "-"), color=colour, linewidth=1.0)
        label(axis, "time", name, "s", runs[0].units[name])
    caption = f"Probes of {len(shown)} members"
    if values is not None:
        low, high = (number(float(end)) for end in (values.min(), values.max()))
        unit = pretty(units.get(numeric[0], ""))
        caption += f", coloured by {numeric[0]} from {low} (dark) to {high} {unit}".rstrip() + " (bright)"
    if kinds:
        lines = ", ".join(
            f"{number(float(value))} {WORDS[line]}" for value, line in zip(sorted(set(table[numeric[1]])), LINES, strict=False)
        )
        caption += f"; lines by {', '.join(with_units(numeric[1:2], units))}: {lines}"
    return [figure(drawn, f"{caption}.".replace("<sup>", "^").replace("</sup>", ""))]


def _kinds(table: Any, numeric: Sequence[str]) -> dict[str, str]:
    """Return the line style of each member by its value of the first parameter in `numeric`; empty without parameters or
    for too many values."""
    values = sorted(set(table[numeric[0]])) if numeric else []
    if not 1 < len(values) <= len(LINES):
        return {}
    return {member: LINES[values.index(value)] for member, value in zip(table["member"], table[numeric[0]], strict=True)}


def _dependence(table: Any, outputs: Sequence[str], keys: Sequence[str]) -> str:
    """Return a figure, as HTML, of every result column in `outputs` against every parameter in `keys` for all members; table:
    pandas table of the members."""
    if not outputs:
        return ""
    units = table.attrs.get("units", {})
    across = len(keys) if len(keys) > 1 else 3
    pairs = [(output, key) for output in outputs for key in keys]
    drawn, axes = panels(len(pairs), across, max(WIDTH, 3.0 * across), 2.6 * -(-len(pairs) // across))
    for axis, (output, key) in zip(axes, pairs, strict=True):
        values = table[key]
        if values.dtype.kind not in "fiu":
            values = values.astype(str)
        elif values.min() > 0.0 and values.max() >= DECADES * values.min():
            axis.set_xscale("log")
        axis.plot(values.to_numpy(), table[output].to_numpy(), "o", markersize=4)
        means = table[output].groupby(values).mean()
        if 1 < len(means) < len(table):
            axis.plot(means.index.to_numpy(), means.to_numpy(), "-", linewidth=1.0)
        label(axis, key, output, units.get(key, ""), units.get(output, ""))
    return figure(drawn, "Results of all members against each parameter; lines join the means of equal values.")


def _indices(found: Sequence[Sensitivity]) -> str:
    if not found:
        return ""
    rows = (
        [escape(one.output.replace("_", " ")), escape(one.key), number(one.share, 3), number(one.interval, 2)] for one in found
    )
    text = (
        "<p>First-order sensitivity: share of the variance of a result explained by one parameter alone (RBD-FAST), with "
        "its 95 % interval.</p>"
    )
    return text + table_of(("result", "parameter", "first-order index", "±"), rows, "numbers")


HARMONICS = 4
LEAST = 40
"""Smallest number of members for which indices are computed: in the resampling, half of them must resolve the harmonics."""


def sensitivities(table: Any, keys: Sequence[str], outputs: Sequence[str]) -> list[Sensitivity]:
    """Compute first-order sensitivity indices of the finished runs by RBD-FAST (Tarantola, Gatelli & Mara 2006); empty for too
    few runs.

    table: pandas table of the runs. keys: parameters that were sampled as numbers; the sample must be random, such as a Latin
    hypercube. outputs: names of result columns.
    """
    done = table[table["state"] == DONE]
    if len(done) < LEAST or not keys:
        return []
    analyse = need("SALib.analyze.rbd_fast").analyze
    found = []
    for output in outputs:
        rows = done[done[output].notna()]
        if len(rows) < LEAST:
            continue
        problem = {"num_vars": len(keys), "names": list(keys)}
        result = analyse(problem, rows[list(keys)].to_numpy(float), rows[output].to_numpy(float), M=HARMONICS, seed=0)
        numbers = zip(keys, result["S1"], result["S1_conf"], strict=True)
        found += [Sensitivity(output, key, float(share), float(half)) for key, share, half in numbers]
    return found
