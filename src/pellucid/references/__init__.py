"""Exact solutions and measured data that gallery cases are compared with, and types for their annotations."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from pellucid.case import Case
else:
    Case = object


__all__ = ["Array", "Case"]

Array = NDArray[np.float64]
