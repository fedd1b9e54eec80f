# SPDX-License-Identifier: GPL-3.0-or-later
"""CGAL, through the library that measure.base.installed builds of peers/cgal_models.cpp."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from ctypes import c_bool, c_char_p, c_int, c_uint, c_void_p
from typing import Any

import numpy as np
from measure.base.contender import HANDLE, PIN, Floats, Make, PosedTask
from measure.base.installed import CGAL_LIBRARY
from measure.base.workers import NotRun

from .steps import CALL_ITERATIONS, settled

SIGNATURES: dict[str, tuple[Any, list[Any]]] = {
    "cgal_version": (c_char_p, []),
    "cgal_error": (c_char_p, []),
    "cgal_bind": (c_void_p, [c_char_p, c_void_p, c_int, c_void_p, c_int, c_void_p, c_int]),
    "cgal_iterate": (c_bool, [c_void_p, c_void_p, c_uint, c_void_p]),
    "cgal_free": (None, [c_void_p]),
}


def loaded() -> ctypes.CDLL:
    library = ctypes.CDLL(str(CGAL_LIBRARY))
    for name, (result, arguments) in SIGNATURES.items():
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    return library


class Arap:
    acts: Sequence[str] = (PIN, HANDLE)

    def __init__(self, task: PosedTask, energy: str) -> None:
        self._task, self._now, self._cgal = task, task.positions, loaded()
        self.version = self._cgal.cgal_version().decode()
        arrays = [np.ascontiguousarray(array) for array in (task.positions, task.triangles, task.constrained)]
        sized = [word for array in arrays for word in (array.ctypes.data, len(array))]
        self._model = self._cgal.cgal_bind(energy.encode(), *sized)
        if not self._model:
            raise NotRun(self._said())

    def __del__(self) -> None:
        self._cgal.cgal_free(self._model)

    def pose(self, step: int) -> None:
        targets = np.ascontiguousarray(self._task.targets[step])

        def iterate(before: Floats) -> Floats:
            now = np.empty_like(before)
            if not self._cgal.cgal_iterate(self._model, targets.ctypes.data, CALL_ITERATIONS, now.ctypes.data):
                raise RuntimeError(self._said())
            return now

        self._now = settled(iterate, self._now)

    def positions(self) -> Floats:
        return self._now

    def _said(self) -> str:
        return str(self._cgal.cgal_error().decode())


MODELS: dict[str, Make] = {
    "CGAL: ARAP, spokes": lambda task: Arap(task, "spokes"),
    "CGAL: ARAP, spokes and rims": lambda task: Arap(task, "spokes_and_rims"),
    "CGAL: ARAP, smooth rotations": lambda task: Arap(task, "smooth_rotations"),
}
INPUTS = dict.fromkeys(MODELS, "The targets of held and moved vertices.")
