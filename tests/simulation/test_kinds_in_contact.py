"""How each two kinds of bodies touch, in space and in a plane: as the table of the documentation states, kind by kind."""

from itertools import combinations_with_replacement
from pathlib import Path

import pytest
from small_cases import SOLID, box, case

from pellucid.bodies.models import BODIES
from pellucid.conditions.contact import why_no_self_contact
from pellucid.conditions.wall import why_no_wall
from pellucid.contact.pairs import ContactPairs
from pellucid.contact.surface_pair import SurfacePair
from pellucid.contact.surface_pairs import SurfacePairs
from pellucid.contact.triangles.pair import TrianglePair
from pellucid.simulation.simulation import Simulation

CELL = 0.25
LIQUID = {"kind": "fluid", "density": 1000.0, "eos": {"kind": "tait", "sound_speed": 20.0, "carries_tension": True}}
SHEET = {"kind": "linear-membrane", "density": 1000.0, "young_modulus": 1e5, "poisson_ratio": 0.3}
LIPID = {"kind": "lipid-film", "density": 0.05, "viscosity": 0.1, "stiffness": 400.0}
DOCS = Path(__file__).parents[2] / "docs" / "physics" / "contact.md"


def points(name, level, plane, material=SOLID, **more):
    low, high = (0.0, CELL) if plane else (0.5, 1.5)
    return [box((0.5, level, low), (1.5, level + 1.0, high), material, None, name, **more)]


def meshless(name, level, plane):
    mesh = {"box": {"lower": (0.5, level, 0.5), "upper": (1.5, level + 1.0, 1.5), "cells": (2, 2, 2)}}
    return [{"name": name, "kind": "meshless-solid", "mesh": mesh, "material": SOLID}]


def membrane(kind, name, level, plane):
    low, depth = (0.0, CELL) if plane else (0.5, 1.0)
    edges = {"corner": (0.5, level, low), "first_edge": (1.0, 0, 0), "second_edge": (0, 0, depth)}
    surface = {"rectangle": edges | {"points": (17, 2) if plane else (9, 9)}}
    return [{"name": name, "kind": kind, "surface": surface, "thickness": 0.05, "material": SHEET}]


def film(name, level, plane):
    """A film about a drop."""
    middle, radius = (1.0, level + 0.5, 0.0 if plane else 1.0), 0.5
    shape = {"ellipse": {"radius": radius, "centre": middle, "nodes": 40}}
    if not plane:
        shape = {"surface": {"sphere": {"centre": middle, "radius": radius, "divisions": 5}}}
    drop = {"sphere": {"centre": (*middle[:2], 0.5 * CELL if plane else 1.0), "radius": 0.9 * radius}}
    return [
        {"name": name, "kind": "fluid-film", "shape": shape, "material": LIPID},
        {"name": f"{name}-drop", "shape": drop, "material": LIQUID},
    ]


EXAMPLES = {
    "material-points": {
        "solid": [points, lambda name, level, plane: points(name, level, plane, rigid=True)],
        "fluid": [lambda name, level, plane: points(name, level, plane, LIQUID)],
    },
    "meshless-solid": {"solid": [meshless]},
    "membrane-elements": {"membrane of elements": [lambda *how: membrane("membrane-elements", *how)]},
    "membrane-points": {"membrane of points": [lambda *how: membrane("membrane-points", *how)]},
    "fluid-film": {"film": [film]},
    "diffusing-field": {},  # it has no grid, on which it could touch
}
COLUMNS = [
    (column, i, build) for kinds in EXAMPLES.values() for column, builds in kinds.items() for i, build in enumerate(builds)
]


def table():
    """What the documentation says, by row and column."""
    rows = [
        line.strip().strip("|").split("|") for line in DOCS.read_text(encoding="utf-8").splitlines() if line.startswith("|")
    ]
    rows = [[entry.strip() for entry in row] for row in rows]
    first = next(i for i, row in enumerate(rows) if row[1:3] == ["solid", "membrane of elements"])
    columns, stated = rows[first][1:], {}
    for row in rows[first + 2 : first + 9]:
        stated |= {(row[0], column): entry for column, entry in zip(columns, row[1:], strict=True)}
    return stated


def test_every_kind_of_body_has_an_example():
    assert EXAMPLES.keys() == BODIES.entries.keys()


PAIRS = list(combinations_with_replacement(COLUMNS, 2))


@pytest.mark.parametrize("plane", [False, True], ids=["space", "plane"])
@pytest.mark.parametrize(("one", "other"), PAIRS, ids=[f"{a[0]}{a[1]}-{b[0]}{b[1]}" for a, b in PAIRS])
def test_two_kinds_touch_as_the_table_states(one, other, plane):
    if plane and meshless in (one[2], other[2]):
        pytest.skip("its mesh is in space")
    low, high = one[2]("low", 0.5, plane), other[2]("high", 2.5, plane)
    bodies = [body | {"field": name} for name, members in (("low", low), ("high", high)) for body in members]
    sim = Simulation(case(*bodies, counts=(8, 16, 1) if plane else (8, 16, 8), cell=CELL), threads=1)
    found = [type(pair) for pair in sim.parts.only(SurfacePairs)._pairs]
    assert len(sim.parts.only(ContactPairs)) + len(found) == 1
    how = "nodes" if not found else "triangles" if found == [TrianglePair] else "surfaces"
    assert how != "surfaces" or found == [SurfacePair]
    stated = table()
    assert how == stated[one[0], other[0]] == stated[other[0], one[0]]
    lines = sim.parts.only(ContactPairs).reasons
    assert len(lines) == (how == "nodes" and "fluid" not in (one[0], other[0]))
    for line in lines:
        assert line.startswith("contact: low and high touch on the nodes of the grid, since ")
        assert "; use " in line


@pytest.mark.parametrize("column", COLUMNS, ids=[f"{column[0]}{column[1]}" for column in COLUMNS])
def test_walls_and_contact_with_itself_are_refused_as_the_table_states(column):
    body = column[2]("low", 0.5, False)
    (model, *_) = case(*body, counts=(8, 16, 8), cell=CELL).body
    stated = table()
    assert (why_no_wall(model) is not None) == (stated["wall", column[0]] == "–")
    meshless_alone = column[0] == "solid" and model.kind != "meshless-solid"
    assert (why_no_self_contact(model, True) is not None) == (stated["itself", column[0]] == "–" or meshless_alone)
