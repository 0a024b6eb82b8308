"""Strain energies and forces of indented bodies, computed with linear and quadratic tetrahedra on the meshes of the gallery
cases: `validation/mountris2019-indentation`.

Neo-Hookean in the coupled form, Young's modulus 3000 Pa, Poisson's ratio 0.49.
"""

from typing import Literal, NamedTuple

import numpy as np

from pellucid.references import finite_elements


class Indented(NamedTuple):
    """Strain energies [J], and forces along the displacement [N], of an indented body, each by linear and by quadratic
    tetrahedra."""

    energy: tuple[float, float]  # by linear, by quadratic tetrahedra [J]
    force: tuple[float, float]  # by linear, by quadratic tetrahedra [N]


def indented(body: Literal["cylinder", "heart"], nodes: int, share: float) -> Indented | None:
    """Return the finite-element reference for a body on the mesh with this number of nodes, at a share (0 to 1) of the full
    displacement of the indenter; None if this state was not computed."""
    table = finite_elements.read(f"indented_{body}")
    rows = np.flatnonzero((table["nodes"] == nodes) & np.isclose(table["share"], share))
    if not len(rows):
        return None
    first, second = (
        [float(table[f"{order}_{what}"][rows[0]]) for what in ("energy", "force")] for order in ("first", "second")
    )
    return Indented((first[0], second[0]), (first[1], second[1]))
