"""Write the pictures of docs/cases/index.md and the page docs/cases/numbers.md from docs/cases/measured.csv and the case files.

`python docs/gallery_table.py` writes both; `python docs/gallery_table.py CASE ...` runs the quick variants of cases first,
`--all` those of the whole gallery, and keeps their metrics.
"""

import csv
import sys
import tomllib
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from pellucid import catalogue, load

FOLDER = Path(__file__).parent / "cases"
PAGE, NUMBERS, MEASURED = FOLDER / "index.md", FOLDER / "numbers.md", FOLDER / "measured.csv"
FIRST, LAST = "<!-- Written by docs/gallery_table.py from here, -->\n", "<!-- to here. -->\n"
ENDINGS = ("-whole", "-shapes", "-inside", "-water", "")  # of pictures of bodies, then of curves
GROUPS = ("gan2011", "lian2014", "mountris2019", "benet2015")  # shown first, in this order
ACROSS = 3  # pictures in a row
OPENING = """\
<!-- Written by docs/gallery_table.py from measured.csv. Do not edit: run the script. -->
# Numbers of the gallery

What `pellucid verify` finds of quick variants. An error is relative or in the unit of the value, as the page of a case tells.

| case | points | metric | found | reference | error | allowed |
|---|---|---|---|---|---|---|
"""
COLUMNS = ("case", "metric", "value", "reference", "error", "tolerance", "unit", "points")


def measured() -> dict[str, list[dict[str, str]]]:
    """Return the metrics of each case by its id, in the order of the file measured.csv."""
    rows: dict[str, list[dict[str, str]]] = {}
    with MEASURED.open(newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            rows.setdefault(row["case"], []).append(row)
    return rows


def measure(case: str) -> list[dict[str, str]]:
    """Run the quick variant of a case, and return its metrics as rows of the file measured.csv."""
    from pellucid.running.launch import run_case

    with TemporaryDirectory() as scratch:
        run = run_case(load(case).quick_variant(), Path(scratch) / "run", report=False)
        points = str(run.summary["points"])
        return [
            dict(
                zip(
                    COLUMNS,
                    (case, name, *map(_short, (m.value, m.reference, m.error, m.tolerance)), m.unit, points),
                    strict=True,
                )
            )
            for name, m in run.metrics.items()
        ]


def _short(number: float) -> str:
    return f"{number:.4g}"


def keep(rows: dict[str, list[dict[str, str]]]) -> None:
    with MEASURED.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        for case in sorted(rows):
            writer.writerows(rows[case])


def numbers() -> str:
    """Return the text of the page with all metrics."""
    return OPENING + "".join(
        f"| {_link(case)} | {row['points']} | {row['metric'].replace('_', ' ')} | {row['value']} {row['unit']} "
        f"| {row['reference']} | {row['error']} | {row['tolerance']} |\n"
        for case, rows in measured().items()
        for row in rows
    )


def index() -> str:
    """Return the text of the page of pictures, with new pictures and its other text unchanged."""
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(FIRST)
    return before + FIRST + _pictures() + LAST + rest.partition(LAST)[2]


def _pictures() -> str:
    rows, cards = measured(), [(case, _picture(case)) for case in sorted(catalogue.ids(), key=_rank)]
    shown = [_card(case, picture, rows[case][0]) for case, picture in cards if picture]
    lines = [shown[n : n + ACROSS] for n in range(0, len(shown), ACROSS)]
    head = "| " * ACROSS + "|\n" + "|---" * ACROSS + "|\n"
    return head + "".join("| " + " | ".join(line + [""] * (ACROSS - len(line))) + " |\n" for line in lines)


def _rank(case: str) -> int:
    group = case.partition("/")[0]
    return GROUPS.index(group) if group in GROUPS else len(GROUPS)


def _card(case: str, picture: str, row: dict[str, str]) -> str:
    """Return a cell of the table of pictures: picture, title, run times and first metric of a case; row: its row of
    measured.csv."""
    told: dict[str, Any] = tomllib.loads(catalogue.text(case))
    times = told["times"]
    found = f"{row['metric'].replace('_', ' ')} {row['value']} {row['unit']}".strip()
    error = f"reference {row['reference']}, error {row['error']}, allowed {row['tolerance']}"
    return (
        f"![{told['title']}]({picture})<br>**{_link(case)}**<br>{told['title']}<br>"
        f"{times['quick']:g} s quick, {times['full']:g} s in full<br>{found}; {error}<br>*{told['source']}*"
    )


def _picture(case: str) -> str:
    stem = case.replace("/", "-")
    return next((f"{stem}{ending}.png" for ending in ENDINGS if (FOLDER / f"{stem}{ending}.png").exists()), "")


def _link(case: str) -> str:
    """Return a link to the page of a case: the page with its name, or the page whose heading contains this name."""
    name = case.partition("/")[2]
    own = FOLDER / f"{name}.md"
    pages = [own] if own.exists() else [page for page in sorted(FOLDER.glob("*.md")) if page != NUMBERS and _names(page, name)]
    return f"[{case}]({pages[0].name})" if pages else case


def _names(page: Path, name: str) -> bool:
    heading = page.read_text(encoding="utf-8").partition("\n")[0]
    return name in heading.replace(",", " ").replace(":", " ").replace("/", " ").split()


def main(words: list[str]) -> None:
    rows = measured() if MEASURED.exists() else {}
    for case in catalogue.ids() if words == ["--all"] else words:
        rows[case] = measure(case)
        keep(rows)
    NUMBERS.write_text(numbers(), encoding="utf-8")
    PAGE.write_text(index(), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
