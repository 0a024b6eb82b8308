"""Cases set up without compiling anything, for what only a simulation knows."""

import warnings
from typing import Any

from pellucid.case import Case
from pellucid.case.memory import n_points

MOST_POINTS = 1000
"""Of cases that are set up for this, which takes a second or two."""


class _WouldCompileError(Exception):
    """A kernel is not in the cache."""


def set_up_quickly(case: "Case") -> Any:
    """The simulation of a case; None of a large one, of one that goes on from another run, or where kernels would have to be
    compiled."""
    if case.start is not None or n_points(case) > MOST_POINTS:
        return None
    from numba.core.event import Listener, install_listener

    from pellucid.simulation.simulation import Simulation

    class Refuser(Listener):  # type: ignore[misc]
        def on_start(self, event: Any) -> None:
            raise _WouldCompileError

        def on_end(self, event: Any) -> None:
            pass

    with install_listener("numba:compile", Refuser()), warnings.catch_warnings(action="ignore"):
        try:
            return Simulation(case)
        except _WouldCompileError:
            return None
