# SPDX-License-Identifier: GPL-3.0-or-later
"""What pickle and copy make objects of the module by. Pickles name it, so it stays where it is."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray


def rebuilt(
    kind: type[Any],
    arguments: dict[str, Any],
    constraints: tuple[ArrayLike | None, ...] | None = None,
    positions: NDArray[np.float64] | None = None,
) -> Any:
    """Calls a class, and brings a model to where it was.

    Args:
        kind: the class.
        arguments: of its constructor.
        constraints: the arguments of set_constraints().
        positions: where the model was.
    """
    made = kind(**arguments)
    if constraints is not None:
        made.set_constraints(*constraints)
    # Models whose unknowns are no vertices come only near to positions that they are set to.
    if positions is not None and not np.array_equal(made.positions, positions):
        made.set_positions(positions)
    return made
