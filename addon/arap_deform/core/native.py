# SPDX-License-Identifier: GPL-3.0-or-later
"""Loads arap_native, or says exactly why it cannot.

Blender installs the wheel of an extension, so a plain import finds it.
"""

from __future__ import annotations

import importlib
import platform
import sys
from types import ModuleType

import numpy as np

VERSION = "0.1.0"  # of this add-on, and of the module it needs
MODULE = "arap_native"
# Platforms by their names in Blender's extensions: those that a release has zips for.
PLATFORMS = ("windows-x64", "linux-x64", "linux-arm64", "macos-arm64")
SYSTEMS = {"Windows": "windows", "Linux": "linux", "Darwin": "macos"}
MACHINES = {"AMD64": "x64", "x86_64": "x64", "ARM64": "arm64", "arm64": "arm64", "aarch64": "arm64"}

ERRORS = (ValueError, RuntimeError, MemoryError, np.linalg.LinAlgError)
"""What scene and solver raise with a sentence for the user. Any other exception is a fault in the add-on."""

_module: ModuleType | None = None
_problem: str | None = None


def load() -> ModuleType:
    """The module arap_native.

    Raises:
        RuntimeError: problem().
    """
    if problem() or _module is None:
        raise RuntimeError(problem())
    return _module


def sentence_of(error: Exception) -> str:
    """What an error says to the user. Python's own MemoryError and numpy's errors say too little."""
    if isinstance(error, np.linalg.LinAlgError):
        return f"A matrix has no inverse ({error}): give the mesh and its handles a scale, and places that are numbers"
    return str(error) or "There is not enough memory"


def problem() -> str:
    """Why the native module cannot be used, one sentence that says what to do; '' if it can."""
    global _module, _problem  # noqa: PLW0603 - loaded once, at first use
    if _problem is None:
        try:
            _module = _load()
            _problem = ""
        except RuntimeError as error:
            _problem = str(error)
    return _problem


def _load() -> ModuleType:
    loaded = sys.modules.get(MODULE)
    if loaded is not None:
        _check_version(loaded, "Blender still runs solver module", "save your work and restart Blender")
        return loaded
    module = _from_wheel()
    try:
        _check_version(module, "the installed solver module is", "remove the add-on and install its zip again")
    except RuntimeError:
        sys.modules.pop(MODULE, None)
        raise
    return module


def _check_version(module: ModuleType, what: str, remedy: str) -> None:
    found = getattr(module, "__version__", "without a version")
    if found != VERSION:
        place = getattr(module, "__file__", None) or "an unknown place"
        raise RuntimeError(f"ARAP Deform is {VERSION}, but {what} {found} ({place}): {remedy}")


def _from_wheel() -> ModuleType:
    try:
        return importlib.import_module(MODULE)
    except ModuleNotFoundError as error:
        if error.name != MODULE:
            raise _cannot_load(error) from error
        raise RuntimeError(f"The solver module is missing for {_here()}: {_remedy()}") from error
    except ImportError as error:
        raise _cannot_load(error) from error


def _cannot_load(error: ImportError) -> RuntimeError:
    reason = " ".join(str(error).split())
    return RuntimeError(f"The solver module in its wheel cannot be loaded by {_here()} ({reason}): {_remedy()}")


def _remedy() -> str:
    """The zip that fits this system."""
    machine = platform.machine()
    name = f"{SYSTEMS.get(platform.system(), platform.system())}-{MACHINES.get(machine, machine)}"
    if name not in PLATFORMS:
        return f"no zip is made for {name}; build one from the source with make zip"
    return f"install arap_deform-{VERSION}-{name}.zip"


def _here() -> str:
    return f"Python {sys.version_info.major}.{sys.version_info.minor} on {platform.system()} {platform.machine()}"
