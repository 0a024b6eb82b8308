"""Equations of state: one file each."""

from typing import Annotated

from pydantic import Discriminator, Tag

from pellucid.materials.eos.ideal_gas import IdealGasCase
from pellucid.materials.eos.mie_gruneisen import MieGruneisenCase
from pellucid.materials.eos.stiffened_gas import StiffenedGasCase
from pellucid.materials.eos.tait import TaitCase
from pellucid.model import kind_of

EquationOfState = Annotated[
    Annotated[IdealGasCase, Tag("ideal-gas")]
    | Annotated[StiffenedGasCase, Tag("stiffened-gas")]
    | Annotated[MieGruneisenCase, Tag("mie-gruneisen")]
    | Annotated[TaitCase, Tag("tait")],
    Discriminator(kind_of),
]
