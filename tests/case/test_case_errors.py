"""Every kind of mistake in a case file, read as a user reads it: through `pellucid validate`."""

from pathlib import Path

import pytest
from mistakes import MISTAKES
from typer.testing import CliRunner

from pellucid.case import loads, located
from pellucid.cli import app
from pellucid.errors import CaseError, Problem


def line_of(marker: str, written: str) -> int:
    """The line, from 1, where a text last stands."""
    return written[: written.rindex(marker)].count("\n") + 1


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_named_with_file_line_key_limit_and_remedy(mistake: str, text: str, tmp_path: Path) -> None:
    before, after, marker, words = MISTAKES[mistake]
    assert before is None or before in text
    written = after if before is None else text.replace(before, after, 1)
    file = tmp_path / "my.toml"
    file.write_text(written, encoding="utf-8")
    result = CliRunner().invoke(app, ["validate", str(file)])
    assert result.exit_code == 2
    place = file if marker is None else f"{file}:{line_of(marker or after.splitlines()[0], written)}"
    assert f"{place}: " in result.stderr
    for word in words:
        assert word in result.stderr
    for internal in ("pydantic", "Traceback", "literal[", "validation error", "Value error", "Input should"):
        assert internal not in result.stderr


@pytest.mark.parametrize(
    ("blocks", "marker", "words"),
    [
        (
            '[[contact]]\nbetween = ["drop", "block"]\n[[contact]]\nbetween = ["block", "drop"]\n',
            'between = ["block", "drop"]',
            ["contact.1.between", "contact number 1 is between the same velocity fields", "keep one of the two"],
        ),
        (
            '[[motion]]\nname = "hand"\nbody = "block"\nhold = ["x"]\n'
            '[[contact]]\nname = "hand" # taken\nbetween = ["drop", "block"]\n',
            'name = "hand" # taken',
            ["contact.hand.name", "motion number 1 already has this name", "choose different names"],
        ),
        (
            '[[support]]\nname = "wall"\nwhere = "y-lower"\nfix = "normal"\n'
            '[[contact]]\nname = "wall" # taken\nbetween = ["drop", "block"]\n',
            'name = "wall" # taken',
            ["contact.wall.name", "support number 3 already has this name"],
        ),
    ],
)
def test_contacts_that_are_there_twice_by_fields_or_by_name(
    blocks: str, marker: str, words: list[str], text: str, tmp_path: Path
) -> None:
    written = text.replace("points_per_cell = 4", 'points_per_cell = 4\nfield = "solid"', 1).replace(
        "[quick]", f"{blocks}[quick]"
    )
    file = tmp_path / "my.toml"
    file.write_text(written, encoding="utf-8")
    result = CliRunner().invoke(app, ["validate", str(file)])
    assert result.exit_code == 2
    assert f"{file}:{line_of(marker, written)}: " in result.stderr
    for word in words:
        assert word in result.stderr


def test_all_mistakes_of_a_file_are_reported_together(text: str, tmp_path: Path) -> None:
    for before, after in [
        ("cell = 0.05", "cell = -1"),
        ("density = 1000.0", "densty = 1000.0"),
        ('name = "block"', 'name = "drop"'),
        ('body = "drop"', 'body = "rock"'),
        ("end = 0.1", 'end = "3 m"'),
    ]:
        text = text.replace(before, after, 1)
    file = tmp_path / "my.toml"
    file.write_text(text, encoding="utf-8")
    message = CliRunner().invoke(app, ["validate", str(file)]).stderr
    assert f"5 errors in {file}" in message
    for marker in ("cell = -1", "densty", 'end = "3 m"', 'body = "rock"'):
        assert f"{file}:{line_of(marker, text)}: " in message
    assert "body number 1 already has this name" in message


def test_a_misspelt_key_is_not_also_reported_as_missing(text: str, tmp_path: Path) -> None:
    file = tmp_path / "my.toml"
    file.write_text(text.replace("cell = 0.05", "cel = 0.05"), encoding="utf-8")
    message = CliRunner().invoke(app, ["validate", str(file)]).stderr
    assert "did you mean `cell`?" in message
    assert "missing" not in message


@pytest.mark.parametrize(
    ("argument", "words"),
    [
        ("basics/sodd", ["no gallery case and no file is named basics/sodd", "did you mean `basics/sod`?"]),
        ("nothing.toml", ["no file is named nothing.toml"]),
        (".", ["is a folder"]),
    ],
)
def test_a_case_that_is_not_there_is_named(argument: str, words: list[str]) -> None:
    result = CliRunner().invoke(app, ["validate", argument])
    assert result.exit_code == 2
    for word in words:
        assert word in result.stderr


def test_a_file_in_another_encoding_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "my.toml"
    file.write_bytes('title = "Tröpfchen"'.encode("latin-1"))
    result = CliRunner().invoke(app, ["validate", str(file)])
    assert result.exit_code == 2
    assert "UTF-8" in result.stderr


def test_an_error_in_the_only_body_is_the_only_one_told(text: str) -> None:
    block = text[text.index('[[body]]\nname = "block"') : text.index("[[support]]")]
    with pytest.raises(CaseError) as caught:
        loads(text.replace(block, "").replace("density = 1000.0", "density = -1", 1))
    assert [problem.key for problem in caught.value.problems] == ["body.drop.material.density"]


@pytest.mark.parametrize("count", [1, 2, 5, 7])
def test_a_list_of_another_length_is_told_once_with_the_length_that_it_may_have(text: str, count: int) -> None:
    wrong = text.replace('name = "block"', f'name = "block"\ninitial_stress = {[1.0] * count}')
    with pytest.raises(CaseError) as caught:
        loads(wrong)
    (problem,) = caught.value.problems
    assert problem.key == "body.block.initial_stress"
    assert problem.text.startswith("must have 6 components (initial stress of a solid")


def test_a_list_with_a_fewest_and_a_most_is_told_both(text: str) -> None:
    tissue = 'kind = "holzapfel-gasser-ogden"\ndensity = 1200.0\nfibres = []'
    with pytest.raises(CaseError) as caught:
        loads(text.replace('kind = "linear-elastic"\ndensity = 1200.0', tissue))
    (problem,) = [problem for problem in caught.value.problems if problem.key.endswith("fibres")]
    assert problem.text.startswith("must have at least 1 and at most 2 items")


def test_a_table_with_one_bracket_is_the_only_error_told() -> None:
    with pytest.raises(CaseError) as caught:
        loads(MISTAKES["one bracket for a body"][1])
    assert [problem.key for problem in caught.value.problems] == ["body"]


def test_the_remedy_for_too_many_frames_is_enough(text: str) -> None:
    for end in (1.0, 0.7, 0.123456789):
        changed = text.replace("end = 0.1", f"end = {end}").replace("[quick]", "[output]\nframes = 1e-9\n[quick]")
        with pytest.raises(CaseError) as caught:
            loads(changed)
        interval = caught.value.problems[0].remedy.partition("at least ")[2].split()[0]
        assert loads(changed.replace("frames = 1e-9", f"frames = {interval}")).output.frames == float(interval)


def test_the_set_up_of_a_run_is_blamed_on_a_line_by_name(text: str, tmp_path: Path) -> None:
    file = tmp_path / "my.toml"
    file.write_text(text.replace("[quick]", '[quick]\n"body.block.shape.box.upper" = [0.8, 0.4, 0]'), encoding="utf-8")
    error = CaseError(Problem("too thin", "body.block.shape"))
    shape = line_of("shape = { box", file.read_text())
    assert f"{file}:{shape}: body.block.shape" in str(located(error, str(file)))
    coarse = line_of('"body.block', file.read_text())
    assert f"{file}:{coarse}: " in str(located(error, str(file), quick=True))
    blamed = str(located(error, str(file), settings=["body.1.shape.box.upper=[0.7, 0.4, 0]", "grid.cell=0.1"]))
    assert blamed.startswith("--set body.1.shape.box.upper=[0.7, 0.4, 0]: body.block.shape\n")
    assert f"{file}:{line_of('[time]', text)}: time.step" in str(located(CaseError(Problem("no", "time.step")), str(file)))
    assert str(located(CaseError("all wrong"), str(file))) == f"{file}: all wrong"
