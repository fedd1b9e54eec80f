# SPDX-License-Identifier: GPL-3.0-or-later
# Types and documentation: __init__.pyi, from which the compiled module takes its docstrings.
from collections.abc import Callable
from typing import TypeAlias

from . import _native
from ._native import (
    CageArap,
    CageArapOptions,
    CageDeformation,
    CageOptions,
    Cancelled,
    EmbeddedDeformation,
    EmbeddedOptions,
    Job,
    LatticeArap,
    LatticeOptions,
    LatticeTets,
    Model,
    Options,
    PoissonEditing,
    PoissonOptions,
    SolveOptions,
    SolveResult,
    SurfaceArap,
    TetArap,
    TetOptions,
    WrapDeformation,
    WrapOptions,
    WrapSurface,
    __version__,
    begin_make_cage,
    make_cage,
    same_places,
    transfer_cage,
)

__doc__ = _native.__doc__

Progress: TypeAlias = Callable[[float], bool | None]

__all__ = [
    "CageArap",
    "CageArapOptions",
    "CageDeformation",
    "CageOptions",
    "Cancelled",
    "EmbeddedDeformation",
    "EmbeddedOptions",
    "Job",
    "LatticeArap",
    "LatticeOptions",
    "LatticeTets",
    "Model",
    "Options",
    "PoissonEditing",
    "PoissonOptions",
    "Progress",
    "SolveOptions",
    "SolveResult",
    "SurfaceArap",
    "TetArap",
    "TetOptions",
    "WrapDeformation",
    "WrapOptions",
    "WrapSurface",
    "__version__",
    "begin_make_cage",
    "make_cage",
    "same_places",
    "transfer_cage",
]
