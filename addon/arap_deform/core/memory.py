# SPDX-License-Identifier: GPL-3.0-or-later
"""What is freed goes back to the system."""

from __future__ import annotations

import ctypes
import sys


def trim() -> None:
    """Gives freed memory back. The C library of Linux keeps it for the process; those of other systems do not."""
    if sys.platform == "linux":
        malloc_trim = getattr(ctypes.CDLL(None), "malloc_trim", None)  # only glibc has it
        if malloc_trim is not None:
            malloc_trim(0)
