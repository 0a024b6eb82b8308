"""Sensitivity of an output to parameters: first-order variance indices from a random sample."""

from collections.abc import Sequence
from typing import Any, NamedTuple

from pellucid.studies.extra import need
from pellucid.studies.members import DONE

HARMONICS = 4
LEAST = 40
"""Smallest number of members for which indices are computed: in the resampling, half of them must resolve the harmonics."""


class Sensitivity(NamedTuple):
    """First-order sensitivity index: the share of the variance of an output (result column) that one parameter (`key`) alone
    explains."""

    output: str  # name of the result column
    key: str  # dotted key of the parameter
    share: float  # the index, about 0 to 1
    interval: float
    """Half width of the 95 % confidence interval, by resampling."""


def sensitivities(table: Any, keys: Sequence[str], outputs: Sequence[str]) -> list[Sensitivity]:
    """Compute first-order sensitivity indices of the finished runs by RBD-FAST (Tarantola, Gatelli & Mara 2006); empty for too
    few runs.

    table: pandas table of the runs. keys: parameters that were sampled as numbers; the sample must be random, such as a Latin
    hypercube. outputs: names of result columns.
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
