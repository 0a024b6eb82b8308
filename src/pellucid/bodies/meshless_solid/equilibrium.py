"""Potential energy, forces and stiffness of a meshless solid at trial positions of its nodes, for its equilibria."""

from collections.abc import Callable

import numpy as np

from pellucid.bodies.meshless_solid.material_forces import ElasticForces
from pellucid.bodies.meshless_solid.solid import LEAST_J
from pellucid.bodies.meshless_solid.stiffness import SolidStiffness
from pellucid.bodies.own_nodes.equilibrium import NodalSystem, Strained
from pellucid.bodies.own_nodes.motion import NodalMotion


class SolidSystem(NodalSystem):
    """An `ElasticSystem` of a meshless solid whose nodal values are prescribed directly.

    rest, position, motion, stiffness, accepted: as for `NodalSystem`; forces: internal forces of the solid.
    """

    def __init__(
        self,
        rest: np.ndarray,
        position: np.ndarray,
        forces: ElasticForces,
        motion: NodalMotion,
        stiffness: float,
        accepted: Callable[[float], None],
    ) -> None:
        self._forces = forces
        super().__init__(rest, position, motion, stiffness, accepted)

    def _strain(self, position: np.ndarray) -> Strained:
        solid = self._forces.solid
        self._forces.find(position - self.rest, self._motion.internal, 0.0)
        least = solid.sums[:, LEAST_J].min()
        if len(solid.block_volume):
            least = min(least, solid.node_sums[:, LEAST_J].min())
        return Strained(self._stored_energy(), bool(least > 0.0))

    def _stored_energy(self) -> float:
        return self._forces.stored()

    def _new_stiffness(self) -> SolidStiffness:
        return SolidStiffness(self._forces.solid, self.rest)
