# SPDX-License-Identifier: GPL-3.0-or-later
"""What a library prints from C++, where it says there why it refuses."""

from __future__ import annotations

import os
import tempfile
from types import TracebackType
from typing import final


@final
class Printed:
    """Takes what goes to the standard output and to the standard error while the context lasts."""

    def __enter__(self) -> Printed:
        self._file = tempfile.TemporaryFile("w+")
        self._kept = [(number, os.dup(number)) for number in (1, 2)]
        for number, _ in self._kept:
            os.dup2(self._file.fileno(), number)
        self._text = ""
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        for number, kept in self._kept:
            os.dup2(kept, number)
            os.close(kept)
        self._file.seek(0)
        self._text = self._file.read()
        self._file.close()

    def after(self, mark: str) -> str:
        """The rest of the last line that has the mark; empty where none has."""
        found = [line.partition(mark)[2].strip() for line in self._text.splitlines() if mark in line]
        return found[-1] if found else ""
