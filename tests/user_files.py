"""A case and an extension as users write them, into which tests insert mistakes, and messages of commands about these."""

import re
from pathlib import Path

from typer.testing import CliRunner

from pellucid.cli import app

EXTENSION = """\
from typing import Literal

import numpy as np

from pellucid.extend import InitialField, Load, SignalModel, parameter, quantity, reduction, register


@register
class Push(Load):
    kind: Literal["push"] = "push"
    channel = "push_work"
    strength: float = parameter("m/s^2", "force on unit mass", 1.0)

    def forces(self, points, time):
        return self.strength * points.mass[:, None] * np.ones(3)


@register
class Shear(InitialField):
    kind: Literal["shear"] = "shear"

    def at(self, position):
        return 0.1 * position[:, [1, 0, 2]]


@register
class Glide(SignalModel):
    kind: Literal["glide"] = "glide"
    speed: float = parameter("m/s", "speed", 0.1)

    def function(self):
        def displacement(t):
            return self.speed * t

        return displacement

    def top_speed(self):
        return self.speed


@reduction("middle")
def middle(values):
    return np.median(values)


@quantity("speed", unit="m/s", meaning="length of the velocity")
def speed(field):
    return np.linalg.norm(field("velocity"), axis=1)
"""
CASE = """\
schema = 1
title = "A pushed block"
extensions = ["mine.py"]

[grid]
lower = [0, 0, 0]
upper = [2, 2, 0]
cell = 0.25

[time]
end = 0.01
step = 1e-3

[[body]]
name = "block"
shape = { box = { lower = [0.5, 0.5, 0], upper = [1.5, 1.5, 0] } }
points_per_cell = [1, 1, 1]
material = { kind = "neo-hookean", density = 1000, young_modulus = 1e5, poisson_ratio = 0.3 }
initial = [{ kind = "shear" }]

[[load]]
kind = "push"
body = "block"

[[motion]]
name = "guide"
body = "block"
part = { box = { lower = [0.5, 0.5, 0], upper = [0.75, 0.75, 0] } }
displacement = { x = { kind = "glide" } }

[[probe]]
name = "typical"
body = "block"
quantity = "speed"
reduce = "middle"

[output]
history = 1e-3
frames = 1e-3
"""
FORCES = "        return self.strength * points.mass[:, None] * np.ones(3)"
AT = "        return 0.1 * position[:, [1, 0, 2]]"
DISPLACEMENT = "            return self.speed * t"
MIDDLE = "    return np.median(values)"
SPEED = '    return np.linalg.norm(field("velocity"), axis=1)'


def write(folder: Path, before: str = "", after: str = "") -> int:
    """Write the case and the extension with the text `before` replaced by `after`; return the line number of the
    replacement in the extension."""
    assert before in EXTENSION + CASE
    (folder / "case.toml").write_text(CASE.replace(before, after) if before in CASE else CASE, encoding="utf-8")
    changed = EXTENSION.replace(before, after) if before else EXTENSION
    (folder / "mine.py").write_text(changed, encoding="utf-8")
    return EXTENSION[: EXTENSION.find(before)].count("\n") + 1


def told(status: int, *command: str) -> str:
    """Run a command that must fail with an exit status, and return its error output as one line."""
    result = CliRunner().invoke(app, command)
    assert result.exit_code == status, result.output + repr(result.exception)
    assert "Traceback" not in result.stderr
    return re.sub(r"\s+", " ", result.stderr)
