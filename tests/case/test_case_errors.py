"""Every kind of mistake in a case file, read as a user reads it: through `pellucid validate`."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from pellucid.case import loads, located
from pellucid.cli import app
from pellucid.errors import CaseError, Problem

# name: (what is replaced, by what, text on the line to blame ("" for the replacement, None for the file), words)
MISTAKES = {
    "unknown key": (
        "density = 1000.0",
        "desnity = 1000.0",
        "",
        ["body.drop.material.desnity", "did you mean `density`?"],
    ),
    "unknown table": ("[time]", "[tiem]", "", ["tiem", "unknown key", "did you mean `time`?"]),
    "unknown key in a table of a chosen kind": (
        "sound_speed = 20.0",
        "sound_speed = 20.0, gama = 1",
        "",
        [
            "body.drop.material.eos.gama = 1",
            "has the keys kind, sound_speed, exponent",
        ],
    ),
    "a key of another kind": (
        "sound_speed = 20.0",
        "sound_speed = 20.0, p_infinity = 1",
        "",
        ["body.drop.material.eos.p_infinity = 1", "leave it out: only `stiffened-gas` has it"],
    ),
    "unknown kind": ('kind = "tait"', 'kind = "tiat"', "", ["eos.kind", '"ideal-gas"', "did you mean `tait`?"]),
    "missing kind": (
        'kind = "tait", ',
        "",
        'material = { kind = "fluid',
        ["body.drop.material.eos.kind", "is missing", '"tait"'],
    ),
    "missing key": ("end = 0.1\n", "", "[time]", ["time.end", "is missing", "time at which the run ends, s"]),
    "no grid": (
        '[grid]\nlower = [0, 0, 0]\nupper = [1.0, 0.5, 0.0]\ncell = 0.05\nfunctions = "gimp"\n',
        "",
        None,
        ["grid", "is missing: bodies drop, block need one", "add a table [grid] with `lower`, `upper` and `cell`"],
    ),
    "missing table": ("[time]\nend = 0.1\ncourant = 0.5\n", "", None, ["time", "is missing", "the clock"]),
    "negative density": (
        "density = 1200.0",
        "density = -1",
        "",
        ["body.block.material.density = -1", "greater than 0 kg/m^3"],
    ),
    "poisson's ratio of a half": ("ratio = 0.3", "ratio = 0.5", "", ["poisson_ratio = 0.5", "less than 0.5"]),
    "courant above one": ("courant = 0.5", "courant = 1.5", "", ["time.courant = 1.5", "at most 1"]),
    "text for a number": ("cell = 0.05", 'cell = "fine"', "", ['grid.cell = "fine"', "no number", '"1 m"']),
    "boolean for a number": ("cell = 0.05", "cell = true", "", ["grid.cell = true", "must be a number"]),
    "number in quotes": ("cell = 0.05", 'cell = "0.05"', "", ["has no unit", "0.05 without quotes", '"0.05 m"']),
    "wrong dimension": ("cell = 0.05", 'cell = "5 kg"', "", ["[mass]", "[length] (m)"]),
    "unknown unit": ("cell = 0.05", 'cell = "5 Cm"', "", ['unknown unit "Cm"', "did you mean"]),
    "number for a text": ('title = "A drop and a block"', "title = 3", "", ["title = 3", "must be text in quotes"]),
    "number for a table": ("[quick]", "[quick]\ntime = 3\n[quick.a]", "time = 3", ["quick", "must be a table"]),
    "not finite": ("end = 0.1", "end = inf", "", ["time.end = inf", "finite"]),
    "two components": (
        "velocity = [1.0, 0, 0]",
        "velocity = [1.0, 0]",
        "",
        ["velocity = [1.0, 0]", "must have 3 components"],
    ),
    "four components": (
        "lower = [0, 0, 0]\nupper = [1.0",
        "lower = [0, 0, 0, 0]\nupper = [1.0",
        "",
        ["must have 3 components"],
    ),
    "text in a vector": ("velocity = [1.0, 0, 0]", 'velocity = ["x", 0, 0]', "", ["body.drop.velocity", "no number"]),
    "fraction of a point": (
        "points_per_cell = 4",
        "points_per_cell = 4.5",
        "",
        ["points_per_cell = 4.5", "whole number"],
    ),
    "a rotation without an angle": (
        "shape = { box = { lower = [0.5, 0.1, 0], upper = [0.8, 0.4, 0] } }",
        "shape = { box = { lower = [0.5, 0.1, 0], upper = [0.8, 0.4, 0] }, rotate = { axis = [0, 0, 1] } }",
        "rotate",
        ["body.block.shape.rotate.angle", "is missing", "add `angle = ...`"],
    ),
    "a rotation by too large an angle": (
        "shape = { box = { lower = [0.5, 0.1, 0], upper = [0.8, 0.4, 0] } }",
        "shape = { box = { lower = [0.5, 0.1, 0], upper = [0.8, 0.4, 0] }, rotate = { angle = 1700 } }",
        "rotate",
        ["body.block.shape.rotate.angle = 1700", "must be at most 360", "angle in degrees"],
    ),
    "a rotation about no axis": (
        "shape = { box = { lower = [0.5, 0.1, 0], upper = [0.8, 0.4, 0] } }",
        "shape = { box = { lower = [0.5, 0.1, 0], upper = [0.8, 0.4, 0] }, rotate = { angle = 17, axis = [0, 0, 0] } }",
        "rotate",
        ["body.block.shape.rotate", "`axis` has no length", "give a direction"],
    ),
    "a rotation beside the shape": (
        "shape = { box = { lower = [0.5, 0.1, 0], upper = [0.8, 0.4, 0] } }",
        "shape = { box = { lower = [0.5, 0.1, 0], upper = [0.8, 0.4, 0] } }\nrotate = { angle = 17 }",
        "rotate",
        ["body.block.rotate", "unknown key", "it belongs in `body.block.shape`"],
    ),
    "a rotation within the box": (
        "shape = { box = { lower = [0.5, 0.1, 0], upper = [0.8, 0.4, 0] } }",
        "shape = { box = { lower = [0.5, 0.1, 0], upper = [0.8, 0.4, 0], rotate = { angle = 17 } } }",
        "rotate",
        ["body.block.shape.box.rotate", "unknown key", "it belongs in `body.block.shape`, beside `box`"],
    ),
    "a misspelt rotation": (
        "shape = { box = { lower = [0.5, 0.1, 0], upper = [0.8, 0.4, 0] } }",
        "shape = { box = { lower = [0.5, 0.1, 0], upper = [0.8, 0.4, 0] }, rotate = { angel = 17 } }",
        "rotate",
        ["body.block.shape.rotate.angel", "unknown key", "did you mean `angle`?"],
    ),
    "the second of two rotations": (
        "shape = { box = { lower = [0.5, 0.1, 0], upper = [0.8, 0.4, 0] } }",
        'shape = { box = { lower = [0.5, 0.1, 0], upper = [0.8, 0.4, 0] }, rotate = [{ angle = 17 }, { angle = "3 m" }] }',
        "rotate",
        ["body.block.shape.rotate.1.angle", "[length]"],
    ),
    "a rotation out of the plane": (
        "shape = { box = { lower = [0.5, 0.1, 0], upper = [0.8, 0.4, 0] } }",
        "shape = { box = { lower = [0.5, 0.1, 0], upper = [0.8, 0.4, 0] }, rotate = { angle = 17, axis = [0, 1, 0] } }",
        "rotate",
        ["body.block.shape.rotate.axis", "one cell thick along z", "about z alone", "let the axis be [0, 0, 1]"],
    ),
    "a turned box without an extent": (
        "shape = { box = { lower = [0.5, 0.1, 0], upper = [0.8, 0.4, 0] } }",
        "shape = { box = { lower = [0.5, 0.1, 0], upper = [0.8, 0.1, 0] }, rotate = { angle = 17 } }",
        "rotate",
        ["body.block.shape", "before it is turned", "no extent there"],
    ),
    "a turned box that leaves the grid": (
        "shape = { box = { lower = [0.5, 0.1, 0], upper = [0.8, 0.4, 0] } }",
        "shape = { box = { lower = [0.5, 0.1, 0], upper = [0.8, 0.4, 0] }, rotate = { angle = 90, centre = [0, 0, 0] } }",
        "rotate",
        ["body.block.shape", "outside the grid"],
    ),
    "a region turned out of the plane": (
        "where = { box = { lower = [0.9, 0, 0], upper = [1, 0.5, 0] } }",
        "where = { box = { lower = [0.9, 0, 0], upper = [1, 0.5, 0] }, rotate = { axis = [1, 0, 0], angle = 5 } }",
        "rotate",
        ["support.1.where.rotate.axis", "one cell thick along z", "about z alone"],
    ),
    "a turned region beyond the grid": (
        "where = { box = { lower = [0.9, 0, 0], upper = [1, 0.5, 0] } }",
        "where = { box = { lower = [0.9, 0, 0], upper = [1, 0.5, 0] }, rotate = { angle = 90, centre = [0, 0, 0] } }",
        "rotate",
        ["support.1.where.box", "the box contains no node", "let the box overlap the grid"],
    ),
    "no points": ("points_per_cell = 4", "points_per_cell = 0", "", ["points_per_cell", "at least 1"]),
    "unknown choice": ('functions = "gimp"', 'functions = "gipm"', "", ['"trilinear"', "did you mean `gimp`?"]),
    "unknown face": (
        'where = "x-lower"',
        'where = "x-lowr"',
        "",
        ["support.0.where", '"all-nodes"', "did you mean `x-lower`?"],
    ),
    "normal without a face": (
        'where = "x-lower"',
        'where = "all-nodes"',
        '[[support]]\nwhere = "all',
        ["support.0", "needs a face"],
    ),
    "bad direction": ('fix = ["x", "y"]', 'fix = ["x", "w"]', "", ["support.1.fix.1", '"w"', '"x", "y", "z"']),
    "partial cells": ("cell = 0.05", "cell = 0.03", "[grid]", ["grid", "whole number of cells"]),
    "grid upside down": ("upper = [1.0, 0.5", "upper = [-1.0, 0.5", "[grid]", ["grid.upper", "below grid.lower"]),
    "body outside the grid": (
        "[0.25, 0.25, 0]",
        "[0.05, 0.25, 0]",
        "",
        [
            "body.drop.shape",
            "along x",
            "-0.05 to 0.15 m",
            "outside the grid: 0 to 1 m",
        ],
    ),
    "cut at a face that nothing holds": (
        "[0.25, 0.25, 0], radius = 0.1 } }",
        '[0.25, 0, 0], radius = 0.1 } }\ncut_at = ["y-lower"]',
        "cut_at",
        ["body.drop.cut_at.0", "no support at rest constrains the face y-lower", 'fix = "normal"'],
    ),
    "cut at a face, outside the grid at another": (
        "[0.25, 0.25, 0], radius = 0.1 } }",
        '[0, 0.05, 0], radius = 0.1 } }\ncut_at = ["x-lower"]',
        "shape = { cylinder",
        ["body.drop.shape", "along y", "outside the grid"],
    ),
    "cut away": (
        "[0.25, 0.25, 0], radius = 0.1 } }",
        '[-0.2, 0.25, 0], radius = 0.1 } }\ncut_at = ["x-lower"]',
        "shape = { cylinder",
        ["body.drop.shape", "along x", "leaves nothing of it"],
    ),
    "cut at a face that it does not reach": (
        "radius = 0.1 } }",
        'radius = 0.1 } }\ncut_at = ["y-lower"]',
        "cut_at",
        ["body.drop.cut_at.0", "ends 0.15 m before the face y-lower", "leave this face out"],
    ),
    "box cut at a face": (
        "points_per_cell = 4\n",
        'points_per_cell = 4\ncut_at = ["x-lower"]\n',
        "cut_at",
        ["body.block.cut_at", "let the box end at the face"],
    ),
    "body without extent": (
        "upper = [0.8, 0.4, 0]",
        "upper = [0.8, 0.1, 0]",
        "shape = { box",
        ["body.block.shape", "no extent"],
    ),
    "unknown shape": ("cylinder =", "cylindre =", "", ["body.drop.shape.cylindre", "did you mean `cylinder`?"]),
    "two shapes": (
        "radius = 0.1 } }",
        "radius = 0.1 }, sphere = { centre = [0, 0, 0], radius = 1 } }",
        "shape = { cylinder",
        [
            "body.drop.shape",
            "exactly one of the keys box, sphere, cylinder",
        ],
    ),
    "support off the grid": (
        "lower = [0.9, 0, 0], upper = [1, 0.5, 0]",
        "lower = [2, 0, 0], upper = [3, 1, 0]",
        "",
        [
            "support.1.where.box",
            "contains no node",
        ],
    ),
    "the same name twice": (
        'name = "block"',
        'name = "drop"',
        "",
        ["body.drop.name", "number 1 has this name already"],
    ),
    "a name with a space": ('name = "block"', 'name = "a block"', "", ["name", "begin with a letter"]),
    "a probe of no body": (
        'body = "drop"',
        'body = "dorp"',
        "",
        ["probe.front.body", "drop, block", "did you mean `drop`?"],
    ),
    "a probe of no field": (
        'quantity = "position"',
        'quantity = "postion"',
        "",
        ["velocity", "did you mean `position`?"],
    ),
    "a probe of another material's field": (
        'body = "drop"\nquantity = "position"\ncomponent = "x"',
        'body = "block"\nquantity = "internal_energy"',
        "quantity = ",
        [
            "probe.front.quantity",
            "body block has no such field",
        ],
    ),
    "a probe of no component": ('component = "x"', 'component = "xx"', "", ["position has the components x, y, z"]),
    "a probe without its place": (
        'reduce = "max"',
        'reduce = "nearest"',
        "[[probe]]",
        ["probe.front", "at = [x, y, z]"],
    ),
    "a fixed step above the stable one": (
        "courant = 0.5",
        "step = 5e-3",
        "",
        [
            "time.step = 0.005",
            "above 0.00238 s",
            "stable step at the start, of body drop: waves in it of",
            "make time.step smaller",
        ],
    ),
    "a fluid without a sound speed": (
        'kind = "tait", sound_speed = 20.0',
        'kind = "stiffened-gas", gruneisen = 4, p_infinity = 1e5 }, pressure = -1e6, artificial_viscosity = {',
        "material = ",
        ["body.drop.material.pressure", "no real sound speed", "raise the pressure"],
    ),
    "no body": (
        None,
        'schema = 1\ntitle = "t"\nbody = []\n[grid]\nlower = [0,0,0]\nupper = [1,1,1]\ncell = 1\n[time]\nend = 1\n',
        "body = []",
        ["body"],
    ),
    "points that cannot be shared": (
        "points_per_cell = [2, 2, 1]",
        "points_per_cell = 8",
        "",
        ["cannot be shared equally by 2 axes", "1, 4, 9"],
    ),
    "one bracket for a body": (
        None,
        'schema = 1\ntitle = "t"\n[grid]\nlower = [0,0,0]\nupper = [1,1,1]\ncell = 0.5\n[time]\nend = 1\n[body]\nname = "a"\n'
        '[[probe]]\nname = "p"\nbody = "a"\nquantity = "mass"\n',
        "[body]",
        ["must be a list", "write `[[body]]`"],
    ),
    "one bracket for a support": (
        '[[support]]\nwhere = "x-lower"\nfix = "normal"\n\n[[support]]',
        "[support]",
        "[support]",
        ["must be a list", "write `[[support]]`"],
    ),
    "a table for gravity": (
        "gravity = [0, -9.81, 0]",
        "gravity = { y = -9.81 }",
        "",
        ["gravity = { y = -9.81 }", "must be a list (acceleration of gravity, m/s^2)", "write `gravity = [x, y, z]`"],
    ),
    "a table for points per cell": (
        "points_per_cell = [2, 2, 1]",
        "points_per_cell = { x = 2 }",
        "",
        ["body.drop.points_per_cell", "must be a whole number or a list"],
    ),
    "a load of an unknown kind": (
        "[quick]",
        '[[load]]\nkind = "body-forse"\nbody = "drop"\n[quick]',
        "kind = ",
        ["load.0.kind", "did you mean `body-force`?"],
    ),
    "a load on an unknown body": (
        "[quick]",
        '[[load]]\nkind = "body-force"\nbody = "drip"\nacceleration = [1, 0, 0]\n[quick]',
        "body = ",
        ["load.0.body", "there are drop, block", "did you mean `drop`?"],
    ),
    "one bracket for a load": (
        "[quick]",
        '[load]\nkind = "body-force"\nbody = "drop"\nacceleration = [1, 0, 0]\n[quick]',
        "[load]",
        ["must be a list", "write `[[load]]`"],
    ),
    "a list where a table of a kind stands": (
        'eos = { kind = "tait", sound_speed = 20.0 }',
        'eos = "tait"',
        "",
        ["body.drop.material.eos", "must be a table"],
    ),
    "one bracket for a probe": ("[[probe]]", "[probe]", "[probe]", ["must be a list", "write `[[probe]]`"]),
    "cells without number": ("cell = 0.05", "cell = 1e-320", "[grid]", ["inf cells", "along x", "use a larger cell"]),
    "frames without number": (
        "[quick]",
        "[output]\nframes = 1e-9\n\n[quick]",
        "frames = ",
        ["output.frames = 1e-09", "1e+08 frames", "at most 100 000", "use 1e-06 s or more"],
    ),
    "rows without number": (
        "[quick]",
        "[output]\nhistory = '1 ps'\n\n[quick]",
        "history = ",
        ["output.history", "1e+11 rows", "at most 10 000 000", "use 1e-08 s or more"],
    ),
    "steps without number": (
        "courant = 0.5",
        "step = 1e-300",
        "step = ",
        ["time.step = 1e-300", "1e+299 steps", "time.end = 0.1 s", "at most 1e+12", "use 1e-13 s or more"],
    ),
    "a warning after the stop": (
        "[quick]",
        "[energy]\nwarn = 0.5\nstop = 0.2\n[quick]",
        "warn = ",
        ["energy.warn = 0.5", "above energy.stop = 0.2", "use 0.2 or less, or raise energy.stop"],
    ),
    "a quote within a quantity": ("end = 0.1", """end = '"5 ms'""", "", ["time.end", "a quote too many"]),
    "a later format": ("schema = 1", "schema = 2", "", ["schema = 2", "must be 1"]),
    "a bad quick setting": ('"grid.cell" = 0.1', '"grid.cel" = 0.1', "", ['quick."grid.cel"', "did you mean `cell`?"]),
    "an impossible quick setting": (
        '"grid.cell" = 0.1',
        '"grid.cell" = 0.3',
        "",
        ['quick."grid.cell"', "whole number"],
    ),
    "a bracket left open": (
        "upper = [1.0, 0.5, 0.0]",
        "upper = [1.0, 0.5, 0.0",
        "cell = 0.05",
        ["no valid TOML", "lists in [ ]"],
    ),
    "a key without a value": ("end = 0.1", "end =", "", ["no valid TOML"]),
    "a text without quotes": ('functions = "gimp"', "functions = gimp", "", ["no valid TOML", "texts stand in quotes"]),
    "a switch in quotes": (None, 'title = "x"\n[steady]\nmass_scaling = "no"\n', "mass_scaling", ["must be true or false"]),
    "a key twice": ("end = 0.1", "end = 0.1\nend = 0.2", "end = 0.2", ["no valid TOML", "overwrite"]),
}


def line_of(marker: str, written: str) -> int:
    """The line, from 1, where a text last stands."""
    return written[: written.rindex(marker)].count("\n") + 1


MISTAKES |= {
    f"a contact {what}": ("[quick]", f"[[contact]]\nbetween = {between}\n{more}\n[quick]", marker or "between = ", words)
    for what, between, more, marker, words in [
        ("of an unknown body", '["drop", "blok"]', "", "", ["contact.0.between", "did you mean `block`?"]),
        ("within one field", '["drop", "block"]', "", "", ["contact.0.between", "move together", "another `field`"]),
        ("with itself", '["drop", "drop"]', "", "[[contact]]", ["contact.0", "with itself is not supported"]),
        ("with friction of no kind", '["drop", "block"]', "friction = 0.3", "[[contact]]", ["friction", "coulomb"]),
    ]
}

MISTAKES |= {
    f"a wall {what}": ("[quick]", f"[[wall]]\n{written}\n[quick]", marker, words)
    for what, written, marker, words in [
        (
            "without a direction",
            "point = [0, 0.05, 0]\nnormal = [0, 0, 0]",
            "normal =",
            ["wall.0.normal", "the normal is zero"],
        ),
        (
            "that leans out of the plane",
            "point = [0, 0.05, 0]\nnormal = [0, 1, 0.5]",
            "normal =",
            ["wall.0.normal", "component 0.5 along z", "one cell thick", "set its z to 0"],
        ),
        (
            "that moves out of the plane",
            "point = [0, 0.05, 0]\nnormal = [0, 1, 0]\nvelocity = [1, 0, 2]",
            "velocity = [1, 0, 2]",
            ["wall.0.velocity", "component 2 along z"],
        ),
        (
            "behind the grid",
            "point = [0, -0.5, 0]\nnormal = [0, 2, 0]",
            "point =",
            ["wall.0.point", "outside of the grid", "is 0.5 m or more before it", "move `point`"],
        ),
        (
            "before the grid",
            "point = [0, 0.75, 0]\nnormal = [0, 2, 0]",
            "point =",
            ["wall.0.point", "outside of the grid", "is 0.25 m or more behind it"],
        ),
        (
            "for an unknown body",
            'point = [0, 0.05, 0]\nnormal = [0, 1, 0]\nbodies = ["blok"]',
            "bodies =",
            ["wall.0.bodies", "did you mean `block`?"],
        ),
        (
            "that names a body twice",
            'point = [0, 0.05, 0]\nnormal = [0, 1, 0]\nbodies = ["block", "block"]',
            "bodies =",
            ["wall.0.bodies.1", "body block is named twice", "leave it out once"],
        ),
        (
            "with friction of no kind",
            "point = [0, 0.05, 0]\nnormal = [0, 1, 0]\nfriction = 0.3",
            "[[wall]]",
            ['`friction` belongs to `kind = "coulomb"`'],
        ),
        (
            "for a body that follows a motion",
            'point = [0, 0.05, 0]\nnormal = [0, 1, 0]\nbodies = ["block"]\n'
            '[[motion]]\nname = "hand"\nbody = "block"\nhold = ["x", "y"]',
            "bodies =",
            ["wall.0.bodies.0", "body block follows a prescribed motion as a whole"],
        ),
        (
            "with the name of another",
            'name = "floor"\npoint = [0, 0.05, 0]\nnormal = [0, 1, 0]\n'
            '[[wall]]\nname = "floor" # taken\npoint = [0, 0.06, 0]\nnormal = [0, 1, 0]',
            'name = "floor" # taken',
            ["wall.floor.name", "wall number 1 has this name already", "give each its own name"],
        ),
    ]
}


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
            ["contact.1.between", "contact.0 (counted from 0) is between the same velocity fields", "keep one of the two"],
        ),
        (
            '[[motion]]\nname = "hand"\nbody = "block"\nhold = ["x"]\n'
            '[[contact]]\nname = "hand" # taken\nbetween = ["drop", "block"]\n',
            'name = "hand" # taken',
            ["contact.hand.name", "motion number 1 has this name already", "give each its own name"],
        ),
        (
            '[[support]]\nname = "wall"\nwhere = "y-lower"\nfix = "normal"\n'
            '[[contact]]\nname = "wall" # taken\nbetween = ["drop", "block"]\n',
            'name = "wall" # taken',
            ["contact.wall.name", "support number 3 has this name already"],
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
    assert "body number 1 has this name already" in message


def test_a_misspelt_key_is_not_also_reported_as_missing(text: str, tmp_path: Path) -> None:
    file = tmp_path / "my.toml"
    file.write_text(text.replace("cell = 0.05", "cel = 0.05"), encoding="utf-8")
    message = CliRunner().invoke(app, ["validate", str(file)]).stderr
    assert "did you mean `cell`?" in message
    assert "missing" not in message


@pytest.mark.parametrize(
    ("argument", "words"),
    [
        ("basics/sodd", ["no gallery case and no file basics/sodd", "did you mean `basics/sod`?"]),
        ("nothing.toml", ["no file nothing.toml"]),
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
    assert problem.text.startswith("must have 6 components (stress of a solid")


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
        interval = caught.value.problems[0].remedy.split()[1]
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
