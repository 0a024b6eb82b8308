"""Files and packages of users that register kinds: found, loaded once, and blamed with their line."""

import sys
import warnings
from collections.abc import Iterator
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest
from registries import forgotten_afterwards
from typer.testing import CliRunner

from pellucid import load
from pellucid.bodies.initial import INITIAL_FIELDS
from pellucid.case import Case, dumps, loads
from pellucid.cli import app
from pellucid.results.storage.identity import digests
from pellucid.users import users_code

UNIFORM = """\
from typing import Literal
import numpy as np
from pellucid.extend import InitialField, register

@register
class Uniform(InitialField):
    kind: Literal["uniform"] = "uniform"
    speed: float = 1.0

    def at(self, position):
        return np.full_like(position, self.speed)
"""
CASE = """\
schema = 1
title = "A block"
extensions = ["uniform.py"]
[grid]
lower = [0, 0, 0]
upper = [1, 1, 1]
cell = 0.25
[time]
end = 0.1
[[body]]
name = "block"
shape = { box = { lower = [0, 0, 0], upper = [0.5, 0.5, 0.5] } }
initial = [{ kind = "uniform", speed = 2 }]
material = { kind = "neo-hookean", density = 1000, young_modulus = 1e5, poisson_ratio = 0.3 }
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path) -> Iterator[Path]:
    (tmp_path / "uniform.py").write_text(UNIFORM)
    (tmp_path / "case.toml").write_text(CASE)
    with forgotten_afterwards():
        yield tmp_path


def refused(folder: Path) -> str:
    result = CliRunner().invoke(app, ["validate", str(folder / "case.toml")])
    assert result.exit_code == 2
    assert "Traceback" not in result.stderr
    return str(result.stderr)


def test_a_case_names_files_beside_it_and_keeps_their_paths(folder: Path) -> None:
    case = load(folder / "case.toml")
    assert case.extensions == (str(folder / "uniform.py"),)
    assert case.body[0].initial[0].kind == "uniform"
    assert loads(dumps(case)) == case
    assert Case.model_validate(case.to_data()) == case
    assert list(digests(case)) == [str(folder / "uniform.py")]


def test_a_file_is_run_once_until_it_changes(folder: Path) -> None:
    load(folder / "case.toml")
    first = INITIAL_FIELDS.entries["uniform"]
    load(folder / "case.toml")
    assert INITIAL_FIELDS.entries["uniform"] is first
    (folder / "uniform.py").write_text(UNIFORM.replace("speed: float = 1.0", "speed: float = 3.0"))
    load(folder / "case.toml")
    assert INITIAL_FIELDS.entries["uniform"]().speed == 3.0


def test_its_classes_stand_in_a_module_of_the_same_name_everywhere(folder: Path) -> None:
    load(folder / "case.toml")
    model = INITIAL_FIELDS.entries["uniform"]
    assert model.__module__ == users_code.module_name(str(folder / "uniform.py"))
    assert sys.modules[model.__module__].Uniform is model
    one, other = (users_code.module_name(f"/{folder}/my law.py") for folder in "ab")
    assert one.isidentifier()
    assert one == users_code.module_name("/a/my law.py") != other


def test_mistakes_in_what_a_file_registers_are_found_like_any_other(folder: Path) -> None:
    (folder / "case.toml").write_text(CASE.replace("speed = 2", "sped = 2"))
    message = refused(folder)
    assert "case.toml:13: body.block.initial.0.sped" in message
    assert "did you mean `speed`?" in message
    (folder / "case.toml").write_text(CASE.replace('"uniform", speed', '"unifrom", speed'))
    message = refused(folder)
    assert 'must be one of "sine-wave", ' in message
    assert '"spherical-harmonic", "velocity-gradient", "uniform"\n' in message
    assert "did you mean `uniform`?" in message


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ("np.full_like", "np.full_like(", ["line 11: SyntaxError", "Correct "]),
        ("import numpy as np", "import nunpy as np", ["line 2: ModuleNotFoundError: No module named 'nunpy'"]),
        (
            '"uniform"] = "uniform"',
            '"sine-wave"] = "sine-wave"',
            ['"sine-wave" is already registered by pellucid: choose another name for `'],
        ),
        ("(InitialField)", "", ["line 5: TypeError", "no base class"]),
    ],
)
def test_a_file_that_fails_is_named_with_its_line(before: str, after: str, words: list[str], folder: Path) -> None:
    (folder / "uniform.py").write_text(UNIFORM.replace(before, after))
    message = refused(folder)
    for word in (f'case.toml:3: extensions.0 = "{folder / "uniform.py"}"'[:40], "uniform.py", *words):
        assert word in message
    (folder / "uniform.py").write_text(UNIFORM)
    assert CliRunner().invoke(app, ["validate", str(folder / "case.toml")]).exit_code == 0


def test_a_file_that_is_not_there(folder: Path) -> None:
    (folder / "uniform.py").unlink()
    assert "case.toml:3: extensions.0" in refused(folder)
    assert "the file cannot be read: No such file or directory" in refused(folder)


@pytest.mark.parametrize(("value", "words"), [('"uniform.py"', "must be a list"), ("[3]", "must be text in quotes")])
def test_extensions_are_a_list_of_texts(value: str, words: str, folder: Path) -> None:
    (folder / "case.toml").write_text(CASE.replace('["uniform.py"]', value))
    assert words in refused(folder)


class Entry:
    """An entry point of an installed package."""

    dist = None
    value = "tissues.laws"

    def __init__(self, error: Exception | None = None) -> None:
        self.error, self.loads = error, 0

    def load(self) -> None:
        self.loads += 1
        if self.error:
            raise self.error


def test_installed_packages_are_loaded_once_and_one_that_fails_is_warned_of(monkeypatch: pytest.MonkeyPatch) -> None:
    entries = [Entry(ImportError("no gcc")), Entry()]
    monkeypatch.setattr(users_code, "entry_points", lambda group: entries if group == "pellucid.extensions" else [])
    monkeypatch.setattr(users_code, "_installed", False)
    with pytest.warns(UserWarning, match=r"extension tissues\.laws of a package could not be loaded: ImportError: no gcc"):
        users_code.load_installed()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        users_code.load_installed()
    assert [entry.loads for entry in entries] == [1, 1]


def test_an_entry_point_registers_what_its_module_holds(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(folder))
    entry = EntryPoint("uniform", "uniform", users_code.GROUP)
    monkeypatch.setattr(users_code, "entry_points", lambda group: [entry])
    monkeypatch.setattr(users_code, "_installed", False)
    case = loads(CASE.replace('extensions = ["uniform.py"]\n', ""))
    assert case.body[0].initial[0].kind == "uniform"
    del sys.modules["uniform"]
