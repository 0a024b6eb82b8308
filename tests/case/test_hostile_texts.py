"""Texts that no person would write: what is too deep, too long, no text or no file is an error of the case like others."""

import os
import re
import time
from pathlib import Path

import pytest
from free_flight import CASE

import pellucid
from pellucid.case import loads, parse_setting
from pellucid.errors import CaseError, UsageError

DEEP, LONG = "[" * 500 + "]" * 500, "1" * 5000


def refused(text: str, words: str, **settings: str) -> None:
    start = time.process_time()
    with pytest.raises(CaseError, match=words) as caught:
        loads(text).with_settings(dict(parse_setting(f"{key.replace('__', '.')}={value}") for key, value in settings.items()))
    assert time.process_time() - start < 5.0
    message = str(caught.value)
    assert not re.search(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]", message)
    assert len(message) < 2000


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (LONG, "a number has too many digits"),
        ("1" * 4000, "time.end = 1.*must be at most 1e.18"),
        (DEEP, "more than 32 levels deep"),
        ("[" * 5000 + "]" * 5000, "more than 32 levels deep"),
        ("{a=" * 500 + "1" + "}" * 500, "more than 32 levels deep"),
        ("1.0\na" + ".a" * 3000 + " = 1", "more than 32 levels deep"),
        ('"9**9**9 s"', "cannot read"),
        (f'"{LONG} s"', "cannot read"),
    ],
)
def test_values_beyond_what_can_be_read(value: str, words: str) -> None:
    refused(CASE.replace("end = 1.0", f"end = {value}"), f"(?s){words}")


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (LONG, "too many digits|cannot read|no unit"),
        (DEEP, "not valid TOML"),
        ("[" * 5000, "not valid TOML"),
        ("\x1b[31m", "control"),
    ],
)
def test_settings_beyond_what_can_be_read(value: str, words: str) -> None:
    refused(CASE, words, time__end=value)


@pytest.mark.parametrize("table", ["", "end = 1.0\n"], ids=["of a case", "of a table"])
def test_a_key_of_a_million_letters(table: str) -> None:
    """Nothing is looked for that it may mean, and it is cut where it is shown."""
    key = "a" * 1_000_000
    text = CASE.replace(table, f"{table}{key} = 3\n", 1) if table else f"{key} = 3\n{CASE}"
    refused(text, "a{150,} \\.\\.\\. = 3\n +unknown key")


def test_a_key_of_thousands_of_parts() -> None:
    refused(CASE, "has 3000 parts; a key may have at most 32", **{".".join(["a"] * 3000): "1"})


def test_counts_that_no_number_holds() -> None:
    refused(CASE.replace("[5, 4, 1]", f"[{'1' * 400}, 4, 1]"), r"points_per_cell.*\n.*must be at most 1e\+18")


@pytest.mark.parametrize("key", ["name", "field"])
def test_names_that_no_file_can_have(key: str) -> None:
    refused(CASE.replace('name = "gas"', f'name = "gas"\nfield = "{"f" * 101}"'), "field.*\n.*at most 100 characters")
    refused(CASE.replace('"gas"', f'"{"g" * 300}"'), "at most 100 characters")


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('"Free flight"', r'"Free \u001b[31mflight"'),
        ('name = "gas"', r'name = "g\u001b[31mas"'),
        ('name = "gas"', 'name = "gas"\n"\\u001b[31m" = 1'),
        ("schema = 1", 'schema = 1\nextensions = ["a\\u0000b.py"]'),
        ("schema = 1", 'schema = 1\nid = "\\u009b1m"'),
    ],
)
def test_control_characters_do_not_reach_the_terminal(old: str, new: str) -> None:
    refused(CASE.replace(old, new), r"control character|unknown key|null byte")


def test_those_of_paths_do_not_either() -> None:
    with pytest.raises(UsageError) as caught:
        raise UsageError("no run in \x1b[2Jfolder")
    assert str(caught.value) == r"no run in \x1b[2Jfolder"


def test_a_pipe_is_no_case_and_no_extension(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe.toml"
    os.mkfifo(pipe)
    with pytest.raises(CaseError, match=r"cannot read .*pipe\.toml: it is a pipe or a device, not a file"):
        pellucid.load(pipe)
    with pytest.raises(CaseError, match="cannot read /dev/zero: it is a pipe or a device, not a file"):
        pellucid.load("/dev/zero")
    refused(CASE.replace("schema = 1", f'schema = 1\nextensions = ["{pipe}"]'), "it is a pipe or a device, not a file")


def test_a_path_with_a_null_is_no_case() -> None:
    with pytest.raises(CaseError, match=r"cannot read a\\x00b\.toml: the path has an embedded null byte"):
        pellucid.load("a\0b.toml")


def test_a_file_in_another_encoding_is_no_case(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_bytes(CASE.replace("Free", "Frei für").encode("latin-1"))
    with pytest.raises(CaseError, match=r"case\.toml is not a UTF-8 text file"):
        pellucid.load(path)


@pytest.mark.parametrize("radius", [50.0, 1e200])
def test_a_membrane_far_beyond_the_grid(radius: float) -> None:
    """The cells about it are more than whole numbers can count."""
    case = pellucid.load("gan2011/piezo-icsi")
    with pytest.raises(CaseError, match=r"along x the body extends from .*, outside the grid: 0 to 0\.00015 m"):
        case.with_settings({"body.0.surface.icosphere.radius": radius})
