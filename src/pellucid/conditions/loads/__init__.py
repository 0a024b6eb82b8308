"""Loads: forces on bodies, one module for each kind. This module lists the kinds that a case can name."""

from typing import Annotated

from pellucid.conditions.loads.contract import LoadModel
from pellucid.conditions.loads.film_pressure import FilmPressure
from pellucid.conditions.loads.forces import BodyForce, PointLoad, Traction
from pellucid.conditions.loads.mean_velocity import MeanVelocity
from pellucid.conditions.loads.rigid_load import RigidForce
from pellucid.conditions.loads.rigid_spring import RigidSpring
from pellucid.registry import Family, OneOf

LOADS = Family("load", LoadModel)
AnyLoad = Annotated[LoadModel, OneOf(LOADS)]

LOADS.add(BodyForce)
LOADS.add(MeanVelocity)
LOADS.add(Traction)
LOADS.add(PointLoad)
LOADS.add(FilmPressure)
LOADS.add(RigidForce)
LOADS.add(RigidSpring)
