"""What users need to add kinds of their own, which case files can then name: see docs/extending.md.

A class decorated with `register` is a kind of what its base class says: a material, an equation of state, a load, an initial
field, a signal of a prescribed motion. `reduction` and `quantity` register functions for probes.
"""

from pellucid.bodies.initial.contract import InitialField
from pellucid.case.probe import quantity, reduction
from pellucid.conditions.loads.contract import Load, PointsView
from pellucid.conditions.signals.contract import SignalModel
from pellucid.materials.contract import PointMaterial
from pellucid.materials.elastic import ElasticMaterial
from pellucid.materials.elastic_membrane import ElasticMembraneMaterial
from pellucid.materials.eos.contract import EquationOfStateModel
from pellucid.model import InputFile, Vector, parameter
from pellucid.registry import register

__all__ = [
    "ElasticMaterial",
    "ElasticMembraneMaterial",
    "EquationOfStateModel",
    "InitialField",
    "InputFile",
    "Load",
    "PointMaterial",
    "PointsView",
    "SignalModel",
    "Vector",
    "parameter",
    "quantity",
    "reduction",
    "register",
]
