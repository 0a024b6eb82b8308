"""Mistakes in surfaces, and in what lies inside or outside of them, as `pellucid validate` tells them."""

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from pellucid.cli import app
from pellucid.geometry.surfaces.triangles import Icosphere

TEXT = """\
schema = 1
title = "A bag in a vessel"
[grid]
lower = [-4, -4, -4]
upper = [4, 4, 4]
cell = 1.0
[time]
end = 0.1
[[body]]
name = "medium"
shape = { box = { lower = [-4, -4, -4], upper = [4, 4, 4] } }
outside = ["bag"]
points_per_cell = 8
material = { kind = "neo-hookean", density = 1000, young_modulus = 1e5, poisson_ratio = 0.3 }
[[body]]
name = "bag"
kind = "membrane-points"
surface = { icosphere = { centre = [0, 0, 0], radius = 3, refinements = 3 } }
thickness = 0.01
material = { kind = "linear-membrane", density = 1000, young_modulus = 1e5, poisson_ratio = 0.3 }
[[body]]
name = "filling"
shape = { inside = { surface = { icosphere = { centre = [0, 0, 0], radius = 3, refinements = 3 } } } }
material = { kind = "neo-hookean", density = 1000, young_modulus = 1e5, poisson_ratio = 0.3 }
"""
BALL = Icosphere(centre=(0, 0, 0), radius=3.0, refinements=3).triangulate()
SPHERE = "icosphere = { centre = [0, 0, 0], radius = 3, refinements = 3 }"
TUBE = "tube = { start = [0, 0, -3], end = [0, 0, 3], radius = 2, points = [40, 20] }"
MEMBRANE, INSIDE = f"surface = {{ {SPHERE} }}\nthickness", f"surface = {{ {SPHERE} }} }} }}"


def with_surface(table: str) -> str:
    return MEMBRANE.replace(SPHERE, table)


# name: (what is replaced, by what, text on the line to blame, words)
MISTAKES = {
    "outside an unknown body": (
        '["bag"]',
        '["beg"]',
        '["beg"]',
        ["no body has this name", "did you mean `bag`?"],
    ),
    "exclude itself": ('["bag"]', '["medium"]', '["medium"]', ["cannot exclude itself"]),
    "outside the same twice": ('["bag"]', '["bag", "bag"]', '["bag", ', ["body.medium.outside.1", "named twice"]),
    "outside each other": ('name = "filling"', 'name = "filling"\noutside = ["medium"]', '["medium"]', ["would be empty"]),
    "outside an open membrane": (MEMBRANE, with_surface(TUBE), "outside", ["membrane bag is open", "closed = true"]),
    "inside an open surface": (INSIDE, INSIDE.replace(SPHERE, TUBE), "inside =", ["surface is open", "closed = true"]),
    "a membrane too sparse": (
        MEMBRANE,
        with_surface(SPHERE.replace("= 3 }", "= 1 }")),
        "refinements = 1",
        ["longer than a cell of 1 m", "refine its triangles 4 times along each edge"],
    ),
    "a membrane a little too sparse": (
        MEMBRANE,
        with_surface(SPHERE.replace("= 3 }", "= 2 }")),
        "refinements = 2",
        ["points per grid cell"],
    ),
    "outside, with a lattice of its own": (
        "shape = { box = { lower = [-4, -4, -4], upper = [4, 4, 4] } }",
        "shape = { pipe = { centre = [0, 0, 0], outer_radius = 4, inner_radius = 3, height = 4, points = [2, 40, 8] } }",
        "outside",
        ["a shape with its own lattice is filled completely", "remove `points`"],
    ),
    "a pipe without a wall": (
        "shape = { box = { lower = [-4, -4, -4], upper = [4, 4, 4] } }",
        "shape = { pipe = { centre = [0, 0, 0], outer_radius = 2, inner_radius = 3, height = 4 } }",
        "pipe",
        ["inner_radius = 3 m must be smaller than"],
    ),
    "a file that is not there": (
        MEMBRANE,
        with_surface('file = { path = "no.stl" }'),
        "no.stl",
        ["there is no file", "no.stl"],
    ),
}
FLIPPED = BALL.triangles.copy()
FLIPPED[5] = FLIPPED[5, ::-1]
FAULTS = {
    "flipped": (FLIPPED, "opposite normals at 3 edges"),
    "twice": (np.concatenate([BALL.triangles, BALL.triangles[:2]]), "2 triangles occur twice"),
    "holes": (np.delete(BALL.triangles, [3, 700], axis=0), "declared closed but has 2 holes with 6 edges in total"),
    "inward": (BALL.triangles[:, ::-1], "the normals point inward"),
}


def blamed(folder: Path, text: str) -> str:
    file = folder / "my.toml"
    file.write_text(text, encoding="utf-8")
    result = CliRunner().invoke(app, ["validate", str(file)])
    assert result.exit_code == 2
    return str(result.stderr)


def test_without_mistakes_it_is_valid(tmp_path: Path) -> None:
    (tmp_path / "my.toml").write_text(TEXT)
    assert CliRunner().invoke(app, ["validate", str(tmp_path / "my.toml")]).exit_code == 0


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_named_with_its_line(mistake: str, tmp_path: Path) -> None:
    before, after, marker, words = MISTAKES[mistake]
    assert before in TEXT
    written = TEXT.replace(before, after, 1)
    if mistake == "outside each other":
        written = written.replace('["bag"]', '["bag", "filling"]')
    message = blamed(tmp_path, written)
    line = written[: written.rindex(marker)].count("\n") + 1
    assert f"my.toml:{line}: body." in message
    for word in words:
        assert word in message


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("place", [MEMBRANE, INSIDE], ids=["membrane", "inside"])
def test_a_faulty_file_is_an_error_of_the_body(fault: str, place: str, tmp_path: Path) -> None:
    meshlane = pytest.importorskip("meshlane")
    triangles, words = FAULTS[fault]
    meshlane.write_points_cells(tmp_path / "bag.obj", BALL.vertices, [("triangle", triangles)])
    written = TEXT.replace(place, place.replace(SPHERE, 'file = { path = "bag.obj", closed = true }'), 1)
    message = blamed(tmp_path, written)
    assert f"my.toml:{written[: written.index('bag.obj')].count(chr(10)) + 1}: body." in message
    assert words in message
    assert ("declare it open" in message) == (fault == "holes" and place == MEMBRANE)


def test_a_surface_has_an_inside_in_space_alone(tmp_path: Path) -> None:
    flat = TEXT.replace("[4, 4, 4]\ncell", "[4, 4, -4]\ncell")
    message = blamed(tmp_path, flat)
    assert "body.filling.shape" in message
    assert "body.medium.outside.0" in message
    assert message.count("the inside of a surface needs a grid that is more than one cell thick along every axis") == 2
    pipe = "shape = { pipe = { centre = [0, 0, 0], outer_radius = 2, inner_radius = 1, height = 1, points = [1, 9, 1] } }"
    inside = TEXT[TEXT.rindex("shape = {") : TEXT.rindex("\nmaterial")]
    assert "a lattice of its own needs a grid" in blamed(tmp_path, flat.replace(inside, pipe))
