"""Meshless shape functions (approximants) of bodies with their own nodes."""

from pellucid.approximants.nodal.contract import NODAL_APPROXIMANTS as NODAL_APPROXIMANTS
from pellucid.approximants.nodal.least_squares import (
    CellLeastSquaresModel,
    ModifiedMovingLeastSquaresModel,
    MovingLeastSquaresModel,
)
from pellucid.approximants.nodal.linear_simplex import LinearSimplexModel
from pellucid.approximants.nodal.maximum_entropy import CellMaximumEntropyModel, LocalMaximumEntropyModel

NODAL_APPROXIMANTS.add(CellMaximumEntropyModel)
NODAL_APPROXIMANTS.add(CellLeastSquaresModel)
NODAL_APPROXIMANTS.add(LocalMaximumEntropyModel)
NODAL_APPROXIMANTS.add(MovingLeastSquaresModel)
NODAL_APPROXIMANTS.add(ModifiedMovingLeastSquaresModel)
NODAL_APPROXIMANTS.add(LinearSimplexModel)
