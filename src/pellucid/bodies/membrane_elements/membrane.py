"""Base class of membranes of elements, on their own nodes or on the grid: fields, areas and contact data."""

import numpy as np

from pellucid.bodies.membrane_elements.surface import ElementSurface
from pellucid.geometry.meshes.cells import Cells
from pellucid.parts.body import Body
from pellucid.parts.capabilities import Membrane


class ElementMembrane(Body, Membrane):
    """Base class of membranes whose nodes are the nodes of an `ElementSurface`; provides fields, areas and contact data of
    the membrane."""

    energy_kind = "strain"
    surface: ElementSurface

    def cells(self) -> Cells:
        return self.surface.cells

    def half_width(self) -> tuple[float, float, float]:
        """Return the distance from the mid-surface at which contact begins [m], and two numbers that are not used (see
        `ContactBody.half_width`).
        """
        return self.surface.contact_reach, 0.0, 0.0

    def check(self, n_steps: int, time: float) -> None:
        super().check(n_steps, time)  # type: ignore[safe-super]  # that of the family
        fault = self.surface.fault()
        if fault is not None:
            self.stop(*fault, n_steps, time)

    def vector_areas(self) -> np.ndarray:
        """Return ∫ N_K n dA around each node K [m²], shape (n, 3), in storage order; N_K is its shape function, n the normal
        of the membrane.
        """
        return self.surface.vector_areas(self.arrays["position"])

    def pressed_areas(self) -> np.ndarray:
        return self.vector_areas()[self.order()]

    def surface_areas(self) -> np.ndarray:
        return self.surface.areas(self.places())

    def facts(self) -> dict[str, float]:
        kept = self.surface.constraints
        drifts = {} if kept is None else kept.drifts(self.surface, self.arrays["position"])
        return {**super().facts(), **drifts}

    @property
    def field_names(self) -> list[str]:
        return self.surface.field_names
