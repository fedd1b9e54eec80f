# SPDX-License-Identifier: GPL-3.0-or-later
# Types and documentation: __init__.pyi, from which the compiled module takes its docstrings.
from collections.abc import Callable
from typing import TypeAlias

from . import _native
from ._native import (
    CageDeformation,
    CageOptions,
    Cancelled,
    Job,
    LatticeArap,
    LatticeOptions,
    Model,
    Options,
    SolveOptions,
    SolveResult,
    SurfaceArap,
    WrapDeformation,
    WrapOptions,
    WrapSurface,
    __version__,
    begin_make_cage,
    make_cage,
    same_places,
)

__doc__ = _native.__doc__

Progress: TypeAlias = Callable[[float], bool | None]

__all__ = [
    "CageDeformation",
    "CageOptions",
    "Cancelled",
    "Job",
    "LatticeArap",
    "LatticeOptions",
    "Model",
    "Options",
    "Progress",
    "SolveOptions",
    "SolveResult",
    "SurfaceArap",
    "WrapDeformation",
    "WrapOptions",
    "WrapSurface",
    "__version__",
    "begin_make_cage",
    "make_cage",
    "same_places",
]

# The models that the Blender add-on does not use: its wheel has none of them.
_EXTRA = (
    "CageArap",
    "CageArapOptions",
    "EmbeddedDeformation",
    "EmbeddedOptions",
    "LatticeTets",
    "PoissonEditing",
    "PoissonOptions",
    "TetArap",
    "TetOptions",
    "transfer_cage",
)
if _native.has_extra_models:
    globals().update({name: getattr(_native, name) for name in _EXTRA})
    __all__ += _EXTRA  # noqa: PLE0605  (the stub has the names)


def __getattr__(name: str) -> object:
    if name in _EXTRA:
        raise AttributeError(f"{__name__} has no {name} in Blender's add-on: install the wheel of arap-native with pip")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
