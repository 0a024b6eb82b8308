"""Bodies that are indented, by linear and quadratic tetrahedra on the meshes of cases: `validation/mountris2019-indentation`.

Neo-Hookean in the coupled form, Young's modulus 3000 Pa, Poisson's ratio 0.49.
"""

from typing import Literal, NamedTuple

import numpy as np

from pellucid.references import finite_elements


class Indented(NamedTuple):
    """Strain energy [J] and force along the way [N] by tetrahedra of first and of second order."""

    energy: tuple[float, float]
    force: tuple[float, float]


def indented(body: Literal["cylinder", "heart"], nodes: int, share: float) -> Indented | None:
    """On the mesh with so many nodes, at a share of the whole displacement; None where that was not computed."""
    table = finite_elements.read(f"indented_{body}")
    rows = np.flatnonzero((table["nodes"] == nodes) & np.isclose(table["share"], share))
    if not len(rows):
        return None
    first, second = (
        [float(table[f"{order}_{what}"][rows[0]]) for what in ("energy", "force")] for order in ("first", "second")
    )
    return Indented((first[0], second[0]), (first[1], second[1]))
