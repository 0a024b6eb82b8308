"""Materials: one file each, with the parameters a user gives, the law, its wave speed and its energy."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Union

from pydantic import Discriminator, Tag

from pellucid.materials.contract import PointMaterial
from pellucid.materials.elastic_membrane import ElasticMembraneMaterial
from pellucid.materials.fluid import FluidMaterial
from pellucid.materials.linear_elastic import LinearElasticMaterial
from pellucid.materials.linear_membrane import LinearMembraneMaterial
from pellucid.materials.neo_hookean import NeoHookeanMaterial
from pellucid.materials.neo_hookean_membrane import NeoHookeanMembraneMaterial
from pellucid.model import Model, kind_of

MATERIALS: dict[str, type[PointMaterial]] = {
    "fluid": FluidMaterial,
    "linear-elastic": LinearElasticMaterial,
    "neo-hookean": NeoHookeanMaterial,
}
MEMBRANE_MATERIALS: dict[str, type[ElasticMembraneMaterial]] = {
    "linear-membrane": LinearMembraneMaterial,
    "neo-hookean-membrane": NeoHookeanMembraneMaterial,
}


def _one_of(models: Mapping[str, type[Model]]) -> Any:
    """A table of any of these models, told apart by its `kind`."""
    members = [Annotated[model, Tag(kind)] for kind, model in models.items()]
    return Annotated[Union[tuple(members)], Discriminator(kind_of)]  # noqa: UP007 - their number is not known here


if TYPE_CHECKING:
    Material = PointMaterial
    MembraneMaterial = ElasticMembraneMaterial
else:
    Material = _one_of(MATERIALS)
    MembraneMaterial = _one_of(MEMBRANE_MATERIALS)
