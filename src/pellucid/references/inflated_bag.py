"""Bags of two square sheets of side 1 m at rest under pressure.

The table is for the domed bag of `lian2014/airbag`, an elastic sheet with Poisson's ratio 0.3 that carries no compression,
by minimization of its energy: `validation/lian2014-airbag/bag.py`. For the inextensible flat bag, the "paper bag problem",
the volume below follows from a construction by Andrew Kepert (https://en.wikipedia.org/wiki/Paper_bag_problem); the maximum
volume is not known exactly.
"""

import numpy as np

from pellucid.references.finite_elements import read

PAPER_BAG = 0.2055
"""Volume of the inextensible flat bag, divided by the cube of its side."""
SIDE, HEIGHT, POISSON_RATIO = 1.0, 0.1, 0.3


def at_rest(pressure: float) -> dict[str, float]:
    """Return `volume` [m³], `height` [m] (half of the full height), `half_width` [m] in the middle of an edge and at a
    `corner`, for a bag with unit side.

    pressure: p/(E t) [1/m], with the pressure p, Young's modulus E and the thickness t. Raises ValueError outside the range
    of the table, 0.01 to 0.1 per metre.
    """
    table = read("inflated_bag")
    known = table["pressure"]
    if not known[0] <= pressure <= known[-1]:
        raise ValueError(
            f"p/(E t) = {pressure:g}/m is not between {known[0]:g}/m and {known[-1]:g}/m, the range of the reference table"
        )
    return {name: float(np.interp(pressure, known, column)) for name, column in table.items() if name != "pressure"}
