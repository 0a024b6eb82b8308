"""Arrays of numbers, as references and the gallery annotate them."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
