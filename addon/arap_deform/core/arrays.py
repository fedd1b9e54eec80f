# SPDX-License-Identifier: GPL-3.0-or-later
"""The types of the arrays that everything here passes on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Float32s = NDArray[np.float32]
Ints = NDArray[np.int32]
