"""The page of a sweep: members, overlaid curves, dependence on each parameter, sensitivities."""

from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any

from pellucid.results.pictures.style import COLOURS, LINES, SEQUENTIAL, WIDTH, house_style, label, panels, pretty
from pellucid.results.report.html import number, table_of
from pellucid.results.storage.run import Run
from pellucid.studies.members import DONE, Member, places
from pellucid.studies.page import figure, frame_table, titled, write_page
from pellucid.studies.ranges import DECADES, with_units
from pellucid.studies.sensitivities import LEAST, Sensitivity
from pellucid.studies.table import outputs_of

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
        curves = _curves(out, [member for member in members if member.digest in set(done["member"])], done, numeric)
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


def _curves(out: Path, members: Sequence[Member], table: Any, numeric: Sequence[str]) -> list[str]:
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
