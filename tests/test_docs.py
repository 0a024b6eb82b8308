"""The documentation agrees with the code: snippets are valid, links exist, generated pages are up to date."""

import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import tomlkit
from typer.main import get_command

import gallery_table
import nodal_field_table
from case_reference import PAGE, reference
from pellucid import catalogue, loads
from pellucid.cli import app

ROOT = Path(__file__).parents[1]
TESTED_ALONE = {"extending.md", *(page.name for page in (ROOT / "docs" / "tutorials").glob("*.md"))}
# blocks that belong together: see test_extending.py and test_tutorials.py
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
FENCE = re.compile(r"^```([^\s`]*)[^\n`]*\n(.*?)^```", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\((?!https?:|#)([^)#]+)(?:#[^)]*)?\)")

# case in which a fragment of the documentation is inserted
FRAME = """
schema = 1
title = "frame"
[grid]
lower = [0, 0, 0]
upper = [1, 1, 0]
cell = 0.05
[time]
end = 1.0
[[body]]
name = "block"
kind = "material-points"
shape = { box = { lower = [0, 0, 0], upper = [0.5, 0.5, 0] } }
points_per_cell = [2, 2, 1]
material = { kind = "linear-elastic", density = 1000, young_modulus = 1e6, poisson_ratio = 0.3 }
"""


def snippets(language: str) -> list[Any]:
    """Return every fenced block of a language in the pages, as a test parameter with the name of its page."""
    return [
        pytest.param(text, page, id=f"{page.relative_to(ROOT)}-{number}")
        for page in PAGES
        if page.name not in TESTED_ALONE
        for number, (tag, text) in enumerate(FENCE.findall(page.read_text(encoding="utf-8")))
        if tag == language
    ]


def readme_command(ending: str) -> str:
    lines = [line for line in (ROOT / "README.md").read_text(encoding="utf-8").splitlines() if line.endswith(ending)]
    assert len(lines) == 1
    return lines[0]


@pytest.mark.parametrize(("text", "page"), snippets("toml"))
def test_toml_snippet_validates(text: str, page: Path) -> None:
    if "schema" not in tomlkit.parse(text):
        whole = tomlkit.parse(FRAME).unwrap() | tomlkit.parse(text).unwrap()
        text = tomlkit.dumps(whole)
    loads(text, "snippet.toml", str(page.parent))


@pytest.mark.parametrize(("text", "page"), snippets("python"))
def test_python_snippet_compiles(text: str, page: Path) -> None:
    compile(text, f"{page.stem}.py", "exec")


def test_readme_commands_do_their_own_setup() -> None:
    setup = "python3 -m venv --without-pip .venv && python3 -m pip --python .venv install "
    assert readme_command("pellucid run gan2011/piezo-icsi --quick").startswith(setup)
    assert readme_command("-m pytest").startswith(setup)


def test_ci_takes_the_test_command_from_the_readme() -> None:
    pattern = re.search(r"grep -E '(.*)' README.md", (ROOT / ".ci" / "run").read_text(encoding="utf-8"))
    assert pattern
    found = re.findall(pattern[1], (ROOT / "README.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert found == [readme_command("-m pytest")]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_to_files(page: Path) -> None:
    missing = [link for link in LINK.findall(page.read_text(encoding="utf-8")) if not (page.parent / link).exists()]
    assert not missing


def test_every_command_and_option_is_told() -> None:
    page = (ROOT / "docs" / "reference" / "commands.md").read_text(encoding="utf-8")
    for name, command in get_command(app).commands.items():  # type: ignore[attr-defined]
        assert f"`pellucid {name}" in page
        for option in command.params:
            if option.param_type_name == "option" and option.name != "help":
                assert f"`{option.opts[0]}" in page, f"{option.opts[0]} of {name}"


def test_case_reference_is_fresh() -> None:
    assert reference() == PAGE.read_text(encoding="utf-8"), "run `python docs/case_reference.py`"


def test_every_entry_of_the_energy_balance_is_on_its_page() -> None:
    page = (ROOT / "docs" / "physics" / "energy.md").read_text(encoding="utf-8")
    texts = (path.read_text(encoding="utf-8") for path in (ROOT / "src" / "pellucid").rglob("*.py"))
    names = {name for text in texts for name in re.findall(r"\bChannel\(\s*\"(\w+)\"", text)}
    assert len(names) >= 9
    assert [name for name in sorted(names) if f"`{name}`" not in page] == []


def test_table_of_nodal_fields_is_fresh() -> None:
    page = nodal_field_table.PAGE.read_text(encoding="utf-8")
    assert nodal_field_table.page() == page, "run `python docs/nodal_field_table.py`"


def test_gallery_is_fresh_and_has_all_cases() -> None:
    assert set(gallery_table.measured()) == set(catalogue.ids()), "run `python docs/gallery_table.py CASE`"
    assert gallery_table.numbers() == gallery_table.NUMBERS.read_text(encoding="utf-8"), "run `python docs/gallery_table.py`"
    assert gallery_table.index() == gallery_table.PAGE.read_text(encoding="utf-8"), "run `python docs/gallery_table.py`"
    rows = [row for rows in gallery_table.measured().values() for row in rows]
    assert all(float(row["error"]) <= float(row["tolerance"]) for row in rows)


def test_pages_build_without_warnings(tmp_path: Path) -> None:
    words = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", str(ROOT / "docs"), str(tmp_path / "pages")]
    built = subprocess.run(words, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr
    assert (tmp_path / "pages" / "tutorials" / "pierce-an-oocyte.html").exists()
