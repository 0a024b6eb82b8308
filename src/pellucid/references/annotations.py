"""Types for annotations in references and the gallery.

They are imported for type checking only, so that references can be evaluated without importing the data model of cases.
"""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from pellucid.case import Case
else:
    Case = object

__all__ = ["Array", "Case"]

Array = NDArray[np.float64]
