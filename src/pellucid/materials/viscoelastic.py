"""Base of viscoelastic solids: a hyperelastic solid in parallel with viscous branches."""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

from pydantic import model_validator

from pellucid.materials.contract import PointMaterial
from pellucid.materials.hyperelastic import HyperelasticMaterial
from pellucid.materials.law import Law
from pellucid.materials.trial import Operation
from pellucid.model import check

ELASTIC = (
    "hyperelastic solid that carries the load at rest; it has the density of the whole material, which may be omitted here"
)


class ViscoelasticMaterial(PointMaterial):
    """Base of viscoelastic solids: a hyperelastic solid, given by the key `elastic`, with viscous branches."""

    creeps: ClassVar[bool] = True

    @abstractmethod
    def hyperelastic(self) -> HyperelasticMaterial:
        """Return the hyperelastic solid that carries the load when the viscous branches have relaxed."""

    def operations(self, law: Law) -> Mapping[Law, Sequence[Operation]]:
        inside = self.hyperelastic()
        return {**super().operations(law), **inside.operations(inside.law())}

    @model_validator(mode="before")
    @classmethod
    def _one_density(cls, data: Any) -> Any:
        if isinstance(data, Mapping) and "density" in data and isinstance(elastic := data.get("elastic"), Mapping):
            return {**data, "elastic": {"density": data["density"], **elastic}}
        return data

    @check
    def _densities_agree(self) -> None:
        inside = self.hyperelastic().density
        if inside != self.density:
            text = f"elastic.density = {inside:g} kg/m^3 differs from density = {self.density:g} kg/m^3"
            raise ValueError(f"{text}: remove `density` from `elastic`")


def lost_so_far(law, state, density):
    """Return the energy dissipated so far per unit mass [J/kg], as implementation of `dissipated_energy` for a law that
    stores it in the state of points."""
    return state.dissipated_energy
