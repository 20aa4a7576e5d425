"""Names for the types of NumPy's arrays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

BoolArray = NDArray[np.bool_]
CodeArray = NDArray[np.uint8]
FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]
