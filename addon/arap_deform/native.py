# SPDX-License-Identifier: GPL-3.0-or-later
"""Loads arap_native, and says exactly why where it cannot."""


def problem() -> str:
    """Why the native module cannot be used, one sentence that says what to do; '' where it can."""
    raise NotImplementedError
