"""Sensitivity of an output to parameters: first-order variance indices from a random sample."""

from collections.abc import Sequence
from typing import Any, NamedTuple

from pellucid.studies.extra import need
from pellucid.studies.members import DONE

HARMONICS = 4
LEAST = 40
"""Members below which the indices say nothing: half of them, in the resampling, must show the harmonics."""


class Sensitivity(NamedTuple):
    """The share of the variance of an output that one parameter explains alone."""

    output: str
    key: str
    share: float
    interval: float
    """Half the width of its 95 % interval, by resampling."""


def sensitivities(table: Any, keys: Sequence[str], outputs: Sequence[str]) -> list[Sensitivity]:
    """Indices by RBD-FAST (Tarantola, Gatelli & Mara 2006), of members that are done; empty where these are too few.

    `keys` are the parameters that were drawn as numbers; the sample must be one at random, such as a Latin hypercube.
    """
    done = table[table["state"] == DONE]
    if len(done) < LEAST or not keys:
        return []
    analyse = need("SALib.analyze.rbd_fast").analyze
    found = []
    for output in outputs:
        rows = done[done[output].notna()]
        if len(rows) < LEAST:
            continue
        problem = {"num_vars": len(keys), "names": list(keys)}
        result = analyse(problem, rows[list(keys)].to_numpy(float), rows[output].to_numpy(float), M=HARMONICS, seed=0)
        numbers = zip(keys, result["S1"], result["S1_conf"], strict=True)
        found += [Sensitivity(output, key, float(share), float(half)) for key, share, half in numbers]
    return found
