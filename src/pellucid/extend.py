"""Interface for users' own kinds, which case files can then name: see docs/extending.md.

A class decorated with `register` is a kind of its base class: a material, an equation of state, a rheology, a load, an
initial field, or a signal of a prescribed motion. `reduction` and `quantity` register functions for probes.
`rate_type`, `finite_strain`, `hyperelastic` and `decoupled` decorate laws, `point_state` decorates states of laws, and
`point_function` functions at a point, in which `exp`, `expm1`, `log`, `log1p` and `power` are faster than those of
`math`; `pointwise` marks the functions that they call.
"""

from pellucid.bodies.initial import InitialField
from pellucid.case.probe import quantity, reduction
from pellucid.conditions.loads.contract import Load, PointsView
from pellucid.conditions.signals.displacements import SignalModel
from pellucid.jit import point_function, pointwise
from pellucid.jit.elementary import exp, expm1, log, log1p, power
from pellucid.materials.contract import PointMaterial
from pellucid.materials.coupled import CoupledMaterial
from pellucid.materials.decoupled import BulkMaterial, DecoupledMaterial, decoupled
from pellucid.materials.elastic import ElasticMaterial, ElasticMembraneMaterial
from pellucid.materials.eos.equation import EquationOfStateModel
from pellucid.materials.hyperelastic import FiniteStrainState, HyperelasticMaterial, finite_strain, hyperelastic
from pellucid.materials.law import rate_type
from pellucid.materials.point_state import point_state
from pellucid.materials.rheology import RheologyModel
from pellucid.materials.surface_membrane import SurfaceMembraneMaterial
from pellucid.model import InputFile, Vector, parameter
from pellucid.registry import register

__all__ = [
    "BulkMaterial",
    "CoupledMaterial",
    "DecoupledMaterial",
    "ElasticMaterial",
    "ElasticMembraneMaterial",
    "EquationOfStateModel",
    "FiniteStrainState",
    "HyperelasticMaterial",
    "InitialField",
    "InputFile",
    "Load",
    "PointMaterial",
    "PointsView",
    "RheologyModel",
    "SignalModel",
    "SurfaceMembraneMaterial",
    "Vector",
    "decoupled",
    "exp",
    "expm1",
    "finite_strain",
    "hyperelastic",
    "log",
    "log1p",
    "parameter",
    "point_function",
    "point_state",
    "pointwise",
    "power",
    "quantity",
    "rate_type",
    "reduction",
    "register",
]
