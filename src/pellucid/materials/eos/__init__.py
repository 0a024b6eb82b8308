"""Equations of state: one file each. The kinds that a case can name are registered here, one line each."""

from typing import Annotated

from pellucid.materials.eos.equation import EquationOfStateModel
from pellucid.materials.eos.ideal_gas import IdealGasCase
from pellucid.materials.eos.mie_gruneisen import MieGruneisenCase
from pellucid.materials.eos.stiffened_gas import StiffenedGasCase
from pellucid.materials.eos.tait import TaitCase
from pellucid.registry import Family, OneOf

EQUATIONS_OF_STATE = Family("equation of state", EquationOfStateModel)
EquationOfState = Annotated[EquationOfStateModel, OneOf(EQUATIONS_OF_STATE)]

EQUATIONS_OF_STATE.add(IdealGasCase)
EQUATIONS_OF_STATE.add(StiffenedGasCase)
EQUATIONS_OF_STATE.add(MieGruneisenCase)
EQUATIONS_OF_STATE.add(TaitCase)
