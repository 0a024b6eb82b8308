"""Types that references and the gallery annotate. Reading cases is not needed for the numbers of a reference."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from pellucid.case import Case
else:
    Case = object

__all__ = ["Array", "Case"]

Array = NDArray[np.float64]
