"""Who knows how loops over points run: the drivers, and a short list of kernels that do not fit one loop."""

import re
from pathlib import Path

import pellucid

PACKAGE = Path(pellucid.__file__).parent
DRIVERS = "jit/", "grid/passes/"
ON_BLOCKS = {
    "bodies/membrane_elements/forces.py",  # elements in columns, in place of points
    "bodies/membrane_elements/quadrilateral.py",
    "bodies/membrane_points/blocks.py",  # five stages, and loops over the triangles about a point
    "bodies/membrane_points/kernels.py",
    "grid/particle_to_grid.py",  # affine fields of points, in the rows of four points
    "conditions/driven_points.py",  # the unit of work is a run with one motion
}
BY_COLOUR = {
    "bodies/membrane_points/surface.py",
    "conditions/driven_points.py",
    "conditions/open_walls.py",
    "conditions/pressure_on_walls.py",
    "conditions/surface_tension/colour.py",
    "contact/detection.py",
    "grid/even_points.py",
    "grid/full_cells.py",
    "grid/own_nodes_field.py",
    "grid/transfer.py",
}


def files_with(pattern):
    found = {str(path.relative_to(PACKAGE)) for path in PACKAGE.rglob("*.py") if re.search(pattern, path.read_text("utf-8"))}
    return {name for name in found if not name.startswith(DRIVERS)}


def test_columns_of_blocks_are_the_drivers_affair():
    assert files_with(r"pellucid\.jit\.(columns|rows)\b|passes\.blocks\b") == ON_BLOCKS


def test_loops_by_colour_are_few():
    assert files_with(r"\b(joint|parallel|parallel_loop)_by_colour\b") == BY_COLOUR
