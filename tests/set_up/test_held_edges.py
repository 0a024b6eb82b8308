"""What is told of edges of membranes that bend: a single row of held nodes is a hinge, a clamp lies at a row of nodes."""

import pytest

from pellucid.case import loads
from pellucid.set_up.first_look import look
from pellucid.set_up.held_edges import held_edges

STRIP = """
schema = 1
title = "A strip"
gravity = [0, 0, -1]
[time]
end = 1
[grid]
lower = [-0.6, -0.4, -1]
upper = [1.4, 0.6, 0.4]
cell = 0.2
[[body]]
name = "strip"
kind = "membrane-points"
surface = { rectangle = { corner = [-0.1, 0, 0], first_edge = [1.1, 0, 0], second_edge = [0, 0.2, 0], points = [12, 3] } }
thickness = "1 mm"
material = { kind = "linear-membrane", density = 1000, young_modulus = 1e5, poisson_ratio = 0 }
bending = { rigidity = 0.2 }
"""
ELEMENTS = STRIP.replace('"membrane-points"', '"membrane-elements"\nelements = "triangles"')
BOX = "{{ box = {{ lower = [-1, -1, -1], upper = [{}, 1, 1] }} }}\n"
MOTION = '[[motion]]\nname = "jaws"\nbody = "strip"\nhold = ["x", "y", "z"]\npart = '
SUPPORT = '[[support]]\nname = "jaws"\nwhere = '


@pytest.mark.parametrize("body", [STRIP, ELEMENTS], ids=["points", "elements"])
@pytest.mark.parametrize(("label", "holds"), [("motion `jaws`", MOTION), ("support `jaws`", SUPPORT)])
def test_a_single_row_is_a_hinge(body, label, holds):
    (text,) = look(loads(body + holds + BOX.format(-0.05)))
    assert text.startswith(f"{label} constrains a single row of 3 nodes on the rim of body strip: for bending this is a hinge")
    assert "ends at the second row, 0.1 m from the rim" in text
    assert not list(held_edges(loads(body + holds + BOX.format(0.05 - 0.049))))  # as the text says


@pytest.mark.parametrize(
    "conditions",
    [
        MOTION.replace('["x", "y", "z"]', '["z"]') + BOX.format(-0.05),  # a knife edge
        MOTION + BOX.format(2.0),  # all of it
        MOTION + "{ box = { lower = [-1, -1, -1], upper = [-0.05, 0.01, 1] } }\n",  # a corner
    ],
    ids=["knife edge", "all", "one node"],
)
def test_what_is_no_clamp_or_a_whole_one_is_not_told(conditions):
    assert not list(held_edges(loads(ELEMENTS + conditions)))


def test_a_surface_without_bending_or_rim_has_no_hinge():
    assert not list(held_edges(loads(STRIP.replace("bending =", "# bending =") + MOTION + BOX.format(-0.05))))


def test_the_boundary_of_a_disc_is_a_hinge():
    disc = "surface = { disc = { centre = [0.4, 0.1, -0.3], normal = [0, 0, 1], radius = 0.4, rings = 6 } }\nthickness"
    text = ELEMENTS.partition("surface =")[0] + disc + ELEMENTS.partition("thickness")[2] + MOTION + '"boundary"\n'
    (told,) = held_edges(loads(text))
    assert "a single row of 36 nodes" in told


def test_a_row_in_a_plane_of_symmetry_is_no_hinge():
    text = ELEMENTS.replace("[-0.6, -0.4, -1]", "[-0.1, -0.4, -1]").replace("[1.4, 0.6, 0.4]", "[1.5, 0.6, 0.4]")
    symmetric = '[[support]]\nwhere = "x-lower"\nfix = "normal"\n'
    assert not list(held_edges(loads(text + symmetric + MOTION + BOX.format(-0.05))))


@pytest.mark.parametrize("holds", [MOTION, SUPPORT])
def test_the_distance_of_a_clamp_from_the_edge_of_its_region_is_told(holds):
    """Of 24 columns the second and third lie 52 mm and 4.3 mm before 0."""
    fine = STRIP.replace("[12, 3]", "[24, 6]").replace("cell = 0.2", "cell = 0.1") + holds
    (text,) = look(loads(fine + BOX.format(0.001)))
    assert "ends 0.00535 m beyond the last constrained row of nodes of body strip" in text
    assert "so its free length is 1.004 m" in text
    assert not list(held_edges(loads(fine + BOX.format(-0.004))))
