# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the reference of arap_native as a web page, from arap_native/__init__.pyi alone: nothing has to be built.

Usage: api_reference.py OUT.html
"""

import __future__

import sys
from pathlib import Path
from types import ModuleType
from typing import Generic, TypeVar

import numpy.typing as npt
import pdoc.doc
import pdoc.render

STUB = Path(__file__).parent / "arap_native/__init__.pyi"


class ArrayLike:
    """Shown by its name, not as the long union that it stands for."""


class NDArray(Generic[TypeVar("T")]):
    """The same."""


def stub_as_module() -> ModuleType:
    """Runs the stub. A stub names classes before they are there, so annotations are not evaluated."""
    for shown in (ArrayLike, NDArray):
        shown.__module__ = "numpy.typing"
        setattr(npt, shown.__name__, shown)
    module = ModuleType("arap_native")
    module.__file__ = str(STUB)
    sys.modules["arap_native"] = module
    source = STUB.read_text(encoding="utf-8")
    exec(compile(source, STUB, "exec", __future__.annotations.compiler_flag), module.__dict__)  # noqa: S102
    return module


def main() -> None:
    out = Path(sys.argv[1])
    pdoc.render.configure(docformat="google", search=False, show_source=False)
    documented = pdoc.doc.Module(stub_as_module())
    page = pdoc.render.html_module(documented, all_modules={"arap_native": documented})
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
