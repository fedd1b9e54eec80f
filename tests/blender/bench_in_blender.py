# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs a measurement in a Blender, with the installed zip, and ends it."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

import run


def in_blender(act: Callable[[str, list[str]], None]) -> NoReturn:
    """Runs a measurement in Blender, with the add-on of the zip after "--".

    Args:
        act: gets the add-on's package and what follows the zip.
    """
    if run.USER_FOLDER not in os.environ:
        run.start_again()
    code = 1
    try:
        zip_path, *more = sys.argv[sys.argv.index("--") + 1 :]
        act(run.install(Path(zip_path).resolve()), more)
        code = 0
    finally:
        shutil.rmtree(os.environ[run.USER_FOLDER], ignore_errors=True)
        if code:
            sys.excepthook(*sys.exc_info())
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)
