"""What follows from the declarations of nodal fields: memory, views, clearing; and that there are no others."""

import ast
import re
from collections import Counter
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
import pytest

import pellucid
from nodal_field_table import SETS
from pellucid.grid.chunks import CHUNK
from pellucid.grid.clearing import Clearing
from pellucid.grid.lattice import Nodes
from pellucid.grid.nodal_conditions import ExternalAction
from pellucid.grid.nodal_fields import (
    FOUND,
    MAX,
    MIN,
    REMAP,
    RUN,
    STEP,
    SUM,
    NodalField,
    aligned_rows,
    allocate,
    bytes_of,
    declared,
    fields_of,
    with_fields,
    with_memory,
)

SOURCES = Path(pellucid.__file__).parent
N = 2 * CHUNK + 3
ALL_ROWS = np.array([0, N])


class Mixed(NamedTuple):
    total: Annotated[np.ndarray, NodalField(3, SUM, STEP, "N", "a sum")]
    nearest: Annotated[np.ndarray, NodalField(1, MIN, STEP, "m", "a smallest one")]
    both: Annotated[np.ndarray, NodalField(2, (MAX, SUM), REMAP, "m, m", "of either kind")]
    found: Annotated[np.ndarray, NodalField(1, FOUND, RUN, "", "a flag", np.uint8)]
    channels: Annotated[np.ndarray, NodalField(3, SUM, STEP, "N", "several", several=True)]


def test_memory_is_as_declared_and_nothing_is_given_yet():
    arrays = allocate(Mixed, 5, several=2)
    assert [array.shape for array in arrays] == [(5, 3), (5,), (5, 2), (5,), (2, 5, 3)]
    assert [array.dtype for array in arrays] == [float, float, float, np.uint8, float]
    assert np.all(arrays.nearest == np.inf)
    assert np.all(arrays.both == [-np.inf, 0.0])
    assert not arrays.total.any()
    assert not arrays.channels.any()
    assert bytes_of(Nodes) == sum({id(array.base): array.nbytes for array in allocate(Nodes, 1)[:6]}.values()) + 1 + 3 * 2


def test_views_show_their_part_of_a_field_of_any_memory():
    nodes = allocate(Nodes, 4)
    nodes.inertia[:] = np.arange(16)
    assert np.array_equal(nodes.mass, [3, 7, 11, 15])
    assert np.array_equal(nodes.momentum[2], [8, 9, 10])
    moved = with_fields(nodes, {"forces": aligned_rows(4).reshape(-1)})
    moved.force[:] = 7.0
    assert np.array_equal(moved.forces.reshape(-1, 4), np.tile([7, 7, 7, 0], (4, 1)))
    assert not nodes.force.any()
    assert moved.mass.base is nodes.mass.base


def test_memory_is_made_once_for_what_is_asked_for():
    nobody = allocate(ExternalAction, 0, several=2)
    assert {array.size for array in nobody} == {0}
    asked = with_memory(nobody, 6, "loads", "driven_mass")
    assert asked.loads.shape == (2, 6, 3)
    assert asked.driven_mass.shape == (6, 3)
    assert asked.absorption.shape == (0, 3)
    again = with_memory(asked, 6, "loads", "absorption")
    assert again.loads is asked.loads
    assert again.absorption.shape == (6, 3)


def filled(generator):
    nodes = allocate(Nodes, N)
    for array in (nodes.inertia, nodes.forces, nodes.velocities):
        array.reshape(-1, 4)[:] = generator.choice([0.0, -0.0, 1.0, np.nan], (N, 4))
    return nodes


def test_what_is_cleared_in_each_step_is_zero_to_the_bit():
    nodes, arrays = filled(np.random.default_rng(1)), allocate(Mixed, N, several=1)
    for array in arrays:
        array[...] = 1
    before = nodes.velocities.copy()
    Clearing(STEP, ALL_ROWS, nodes, arrays)()
    assert not nodes.inertia.view(np.int64).any()
    assert not nodes.forces.view(np.int64).any()
    assert np.array_equal(nodes.velocities, before, equal_nan=True)
    assert not arrays.total.any()
    assert not arrays.channels.any()
    assert np.all(arrays.nearest == np.inf)
    assert np.all(arrays.both == 1.0)
    assert np.all(arrays.found == 1)


@pytest.mark.parametrize("listed", [np.array([1, CHUNK, N - 1]), np.zeros(0, np.int64)])
def test_listed_nodes_alone_are_cleared(listed):
    nodes = filled(np.random.default_rng(2))
    expected = nodes.inertia.reshape(-1, 4).copy()
    expected[listed] = 0.0
    Clearing(STEP, ALL_ROWS, nodes)(listed)
    assert np.array_equal(nodes.inertia.reshape(-1, 4), expected, equal_nan=True)


def test_momentum_is_cleared_without_mass_for_the_next_mapping():
    nodes = filled(np.random.default_rng(3))
    forces, mass = nodes.forces.copy(), nodes.mass.copy()
    Clearing(REMAP, ALL_ROWS, nodes)()
    assert not nodes.momentum.any()
    assert np.array_equal(nodes.mass, mass, equal_nan=True)
    assert np.array_equal(nodes.forces, forces, equal_nan=True)


def test_fields_to_which_points_give_have_names_of_their_own():
    given = Counter(name for kind in SETS for name, one in fields_of(kind).items() if one.combine != FOUND)
    assert max(given.values()) == 1


def declaring() -> set[str]:
    """The classes in the sources whose members are annotated with fields."""
    found = set()
    for path in SOURCES.rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        if "Annotated[" in text and "nodal_fields import" in text:
            for node in ast.walk(ast.parse(text)):
                if isinstance(node, ast.ClassDef) and re.search(
                    r"Annotated\[\s*np\.ndarray", ast.get_source_segment(text, node) or ""
                ):
                    found.add(node.name)
    return found


def test_the_table_has_every_set_that_declares_fields():
    assert declaring() == {kind.__name__ for kind in SETS}
    assert all(declared(kind) for kind in SETS)


def test_no_array_over_nodes_is_made_beside_the_declarations():
    made = re.compile(r"np\.(zeros|empty|full|ones)\([^\n]*\bgrid\.n_nodes")
    places = {path.relative_to(SOURCES).as_posix() for path in SOURCES.rglob("*.py") if made.search(path.read_text("utf-8"))}
    own = {"bodies/membranes/on_grid.py"}  # sums near clamps of membranes
    assert places == own, "declare them"
