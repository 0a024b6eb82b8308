"""Meshless shape functions (approximants) of bodies with their own nodes, one file each."""

from pellucid.approximants.nodal.cell_least_squares import CellLeastSquaresModel
from pellucid.approximants.nodal.cell_maximum_entropy import CellMaximumEntropyModel
from pellucid.approximants.nodal.contract import NODAL_APPROXIMANTS as NODAL_APPROXIMANTS
from pellucid.approximants.nodal.linear_simplex import LinearSimplexModel
from pellucid.approximants.nodal.local_maximum_entropy import LocalMaximumEntropyModel
from pellucid.approximants.nodal.moving_least_squares import ModifiedMovingLeastSquaresModel, MovingLeastSquaresModel

NODAL_APPROXIMANTS.add(CellMaximumEntropyModel)
NODAL_APPROXIMANTS.add(CellLeastSquaresModel)
NODAL_APPROXIMANTS.add(LocalMaximumEntropyModel)
NODAL_APPROXIMANTS.add(MovingLeastSquaresModel)
NODAL_APPROXIMANTS.add(ModifiedMovingLeastSquaresModel)
NODAL_APPROXIMANTS.add(LinearSimplexModel)
