"""Types for annotations in references and the gallery.

They are imported for type checking only, because the numbers of a reference can be used without reading cases.
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
