"""Loads: forces on bodies, one file each. The kinds that a case can name are listed here: one line each."""

from typing import Annotated

from pellucid.conditions.loads.body_force import BodyForce
from pellucid.conditions.loads.contract import Load
from pellucid.registry import Family, OneOf

LOADS = Family("load", Load)
AnyLoad = Annotated[Load, OneOf(LOADS)]

LOADS.add(BodyForce)
