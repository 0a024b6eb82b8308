"""Errors in users' code, read as a user would: the file, the line, what failed, what to do; and no results are lost."""

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from registries import forgotten_afterwards
from user_files import AT, CASE, DISPLACEMENT, FORCES, MIDDLE, SPEED, told, write

from pellucid import Run


def at(line: str, key: str) -> str:
    """The place of a key of the case, as messages name it."""
    return f"case.toml:{CASE.splitlines().index(line) + 1}: {key}"


PLACES = {
    AT: at('initial = [{ kind = "shear" }]', "body.block.initial.0"),
    FORCES: at("[[load]]", "load.0"),
    DISPLACEMENT: at('displacement = { x = { kind = "glide" } }', "motion.guide.displacement.x"),
    MIDDLE: at("[[probe]]", "probe.typical"),
    SPEED: at("[[probe]]", "probe.typical"),
}


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.chdir(tmp_path)
    write(tmp_path)
    with forgotten_afterwards():
        yield tmp_path


# when the case is read


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ('kind: Literal["push"]', "kind: str", ['Push has no kind: add the field `kind: Literal["my-kind"] = "my-kind"`']),
        (
            '"force on unit mass", 1.0',
            '"force on unit mass", 1.0, min=0',
            ["line {line}: TypeError: `parameter` has no limit `min`; use one of gt, ge"],
        ),
        ('reduction("middle")', 'reduction("")', ['the reduction "" must start with a letter']),
        ("def forces", "def force", ["TypeError: Push does not define `forces`: every load must define these methods"]),
        ("def at", "def where", ["Shear does not define `at`: every initial field must define these methods"]),
        ("def function", "def functions", ["Glide does not define `function`: every signal must define these methods"]),
        ('parameter("m/s^2"', 'parameter("m/sq"', ['line {line}: UnitError: unknown unit "sq"']),
        ('parameter("m/s^2"', 'parameter("kPa"', ['line {line}: UnitError: "kPa" is not an SI unit without prefix']),
        ('parameter("m/s^2"', "parameter(3", ["line {line}: UnitError: the unit must be a text"]),
        ('@reduction("middle")', "@reduction", ['line {line}: TypeError: write `@reduction("name")` above middle']),
        ('unit="m/s", meaning', 'unit="knot", meaning', ['line {line}: UnitError: "knot" is not an SI unit']),
        ('meaning="length of', 'components=2, meaning="length of', ["has 2 components; use 1, 3"]),
    ],
)
def test_at_registration(before: str, after: str, words: list[str], folder: Path) -> None:
    line = write(folder, before, after)
    message = told(2, "validate", "case.toml")
    for word in (f'case.toml:3: extensions.0 = "{folder / "mine.py"}"'[:50], "Correct /", *words):
        assert word.format(line=line) in message


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        (DISPLACEMENT, "            return self.speed / 0", ["ZeroDivisionError", "(`return self.speed / 0`)", "t = 0 s"]),
        (DISPLACEMENT, "            return np.nan", ["motion guide along x returns nan m at t = 0 s; correct its `function`"]),
        (DISPLACEMENT, '            return "far"', ["could not convert string to float: 'far'"]),
        ("        return displacement", "        return self.displaced", ["fails in `function`", "(`return self.displaced`)"]),
        ("        return self.speed\n", "        return -1.0\n", ["has the top speed -1.0 m/s; correct its `top_speed`"]),
    ],
)
def test_a_signal_is_tried_at_the_start(before: str, after: str, words: list[str], folder: Path) -> None:
    write(folder, before, after)
    message = told(2, "validate", "case.toml")
    for word in (PLACES[DISPLACEMENT], 'the signal of kind "glide"', *words):
        assert word in message


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("yield self.strength / 0", "cannot be checked: ZeroDivisionError: float division by zero, at "),
        ('yield "too strong"', "`problems` of Push yields 'too strong'; it must yield `pellucid.findings.Finding`"),
    ],
)
def test_checks_between_parts_that_fail_themselves(line: str, words: str, folder: Path) -> None:
    write(folder, "    def forces", f"    def problems(self, path, parts):\n        {line}\n\n    def forces")
    assert f'{PLACES[FORCES]} = {{ kind = "push", body = "block" }} {words}' in told(2, "validate", "case.toml")


def test_a_check_of_a_kind_that_fails_itself(folder: Path) -> None:
    check = "\n    def model_post_init(self, context):\n        self.strength / 0.0\n"
    line = write(folder, "\n    def forces", f"{check}\n    def forces") + 2
    message = told(2, "validate", "case.toml")
    assert f'{PLACES[FORCES]} = {{ kind = "push", body = "block" }}' in message
    assert (
        f'the class of the load of kind "push" raised an error: ZeroDivisionError: float division by zero, at {folder}'
        in message
    )
    assert f"mine.py:{line} (`self.strength / 0.0`)" in message


# when a run is set up: the results of an earlier run stay


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        (AT, "        return position[:, 0]", ["`at` returns an array of shape (16,)", "(16, 3)"]),
        (AT, "        return position / 0 * 0", ["adds [nan nan nan] to the velocity of the point at (0.625"]),
        (AT, "        return position.sun()", ["'sun', at ", "mine.py:{line} (`return position.sun()`)"]),
        (AT, "        position -= 1\n        return position", ["read-only", "modify a copy"]),
        (FORCES, "        return points.mass[:, 0]", ["fails in `forces` at t = 0 s: IndexError", "mine.py:{line}"]),
        (FORCES, "        points.velocity[:] = 0", ["read-only", "mine.py:{line}", "modify a copy"]),
        (
            FORCES,
            "        return [[1j, 0, 0]] * 16",
            ["`forces` returns an array of complex128; it must return an array of shape"],
        ),
        (FORCES, "        raise SystemExit(4)", ["fails in `forces` at t = 0 s: SystemExit: 4, at ", "mine.py:{line} (`raise"]),
        (FORCES, "        pass", ["`forces` returns None; it must return an array of shape (16, 3)"]),
        (MIDDLE, "    return values[:3]", ["returns an array of shape (3,)", "one number", "mine.py:"]),
        (SPEED, '    return field("velo")', ["body block has no field `velo`; available: id, position", "mine.py:{line}"]),
        (SPEED, '    return field("velocity")', ["array of shape (16, 3); it must return an array of shape (16,)"]),
        (SPEED, '    field("velocity")[:] *= 0', ['quantity "speed" of body block raised an error', "read-only"]),
    ],
)
def test_before_a_run_writes_anything(before: str, after: str, words: list[str], folder: Path) -> None:
    (folder / "out").mkdir()
    (folder / "out" / "run.lock").write_text('{"program": "pellucid"}')
    (folder / "out" / "history.csv").write_text("earlier")
    line = write(folder, before, after)
    message = told(2, "run", "case.toml", "--out", "out")
    for word in (PLACES[before], *words):
        assert word.format(line=line) in message
    assert (folder / "out" / "history.csv").read_text() == "earlier"


# while it runs: what it has written stays


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        (
            FORCES,
            "        return {0.0: np.ones((16, 3))}[time]",
            'the load of kind "push" on body block fails in `forces` at t = 0.001 s: KeyError: 0.001',
        ),
        (
            DISPLACEMENT,
            "            return t / (t < 0.0025)",
            'the signal of kind "glide" of motion guide along x fails at t = 0.003 s: ZeroDivisionError',
        ),
        (
            MIDDLE,
            "    return 1 / int(values.max() < 0.198)",
            'the reduction "middle" of the probe typical raised an error: ZeroDivisionError',
        ),
    ],
)
def test_in_a_run(before: str, after: str, words: str, folder: Path) -> None:
    line = write(folder, before, after)
    message = told(3, "run", "case.toml", "--out", "out")
    assert words in message
    assert f"mine.py:{line} (`{after.strip()}`)" in message
    run = Run("out")
    rows = len(run.history["time"])
    assert 0 < rows < 11
    assert run.history["time"] == pytest.approx(1e-3 * np.arange(rows))
    assert len(run.times("block")) == rows
    assert not run.finished
    failure = json.loads((folder / "out" / "forensics" / "failure.json").read_text())
    assert words in failure["message"]
    assert failure["step"] in (rows - 1, rows)
