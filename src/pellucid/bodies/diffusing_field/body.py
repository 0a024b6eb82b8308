"""A concentration that diffuses on fixed nodes, advanced by the generalised trapezoidal rule."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu

from pellucid.approximants.radial.stencils import StencilError
from pellucid.bodies.diffusing_field.weak_forms import WeakForm, on_closed_surface, on_line
from pellucid.bodies.initial import add_initial_state
from pellucid.energy import FIRST_LOAD, StepWork, Totals, no_work
from pellucid.errors import CaseError, Problem
from pellucid.geometry.meshes.cells import Cells
from pellucid.grid.points import NOT_FINITE
from pellucid.parts.body import Placement
from pellucid.parts.families import NodalBody

if TYPE_CHECKING:
    from pellucid.bodies.diffusing_field.model import DiffusingFieldCase

OWN_FIELDS = ("id", "position", "velocity", "mass", "volume", "concentration")


class DiffusingField(NodalBody):
    """A concentration c on fixed nodes.

    A step solves (M + α Δt D K) δ = -Δt D K c for the change δ at the nodes that are not prescribed, with the diffusivity D and
    the matrices M and K of `weak_forms`. The change is the unknown so that round-off is relative to the change: if the columns
    of K sum to zero, the amount Σ_I (M c)_I is conserved.
    """

    energy_kind = "internal"

    def __init__(self, case: "DiffusingFieldCase", placement: Placement) -> None:
        self.name, self._domain, self._alpha = case.name, case.domain, case.alpha
        self._columns = FIRST_LOAD + placement.n_loads
        form, position = _weak_form(case), case.domain.positions()
        n = len(position)
        self._content, self._outflow = form.content, case.material.diffusivity * form.outflow
        volume = form.share  # of a cross-section of 1 m² or a thickness of 1 m
        self.arrays = {
            "id": np.arange(n),
            "position": position,
            "velocity": np.zeros((n, 3)),
            "mass": case.material.density * volume,
            "volume": volume,
            "concentration": np.full(n, case.concentration),
        }
        add_initial_state(case.name, case.initial, self.arrays)
        held = np.zeros(n, bool)
        if (line := case.domain.line) is not None:
            for node, value in ((0, line.at_lower), (-1, line.at_upper)):
                if value is not None:
                    held[node], self.arrays["concentration"][node] = True, value
        self._free = np.flatnonzero(~held)
        self._density, self._dt = case.material.density, 0.0
        self.totals = Totals()

    # the step

    def predict(self, dt: float) -> None:
        """Do nothing: the nodes are fixed."""

    def correct(self, remap: bool) -> None:
        """Do nothing: the nodes are fixed."""

    def update(self, dt: float) -> None:
        if dt != self._dt:
            matrix = csc_array((self._content + self._alpha * dt * self._outflow)[self._free][:, self._free])
            self._solver, self._dt = splu(matrix, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}), dt
        c = self.arrays["concentration"]
        c[self._free] += self._solver.solve(-dt * (self._outflow @ c)[self._free])

    def renew_totals(self) -> None:
        """Do nothing: the body has no sums of momentum and energy, and does not limit the time step."""

    def check(self, n_steps: int, time: float) -> None:
        """Raise `RunStopped` if a concentration is not finite. n_steps, time: steps and time [s] of the run, for the
        message.
        """
        wrong = np.flatnonzero(~np.isfinite(self.arrays["concentration"]))
        if wrong.size:
            self.stop(NOT_FINITE, int(wrong[0]), n_steps, time)

    def work(self) -> StepWork:
        return no_work(self._columns, 0)

    # results

    def state_arrays(self) -> dict[str, np.ndarray]:
        return self.arrays

    def load_state(self, state: Mapping[str, np.ndarray]) -> None:
        self.arrays["concentration"][self._free] = state["concentration"][self._free]
        self.renew_totals()

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        for name, array in self.arrays.items():
            array[...] = arrays[name]

    @property
    def field_names(self) -> list[str]:
        """Return the names of the nodal fields in the results: the body's own fields, `density` (of the substance that
        contains the solute), and the amount of solute at each node.
        """
        return [*OWN_FIELDS, "density", "amount"]

    def field(self, name: str) -> np.ndarray:
        if name == "amount":
            return self.arrays["volume"] * self.arrays["concentration"]
        if name == "density":
            return np.full(self.n_points, self._density)
        if name not in self.arrays:
            raise self.no_field(name)
        return self.arrays[name]

    def cells(self) -> Cells:
        if self._domain.line is None:
            return Cells(triangles=self._domain.chosen().triangulate().triangles)
        number = np.arange(self.n_points - 1)
        return Cells(lines=np.stack([number, number + 1], axis=1))


def _weak_form(case: "DiffusingFieldCase") -> WeakForm:
    """Return the matrices M and K (see `WeakForm`) for the line or surface of a case. Raises CaseError if there are no shape
    functions at a node.
    """
    try:
        if case.domain.line is not None:
            return on_line(case.domain.line, case.radial, case.window)
        return on_closed_surface(case.domain.chosen().triangulate(), case.radial)
    except StencilError as error:
        place = ", ".join(f"{value:.4g}" for value in case.domain.positions()[error.number])
        text = f"the stencil of the node at ({place}) m {error.text}"
        raise CaseError(Problem(text, f"body.{case.name}.radial")) from error
