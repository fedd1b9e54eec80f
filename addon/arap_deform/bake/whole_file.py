# SPDX-License-Identifier: GPL-3.0-or-later
"""New files that have their name only when they are whole, and disk space that is asked for before work. No bpy."""

from __future__ import annotations

import errno
import secrets
import shutil
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from .estimate import size_text


class WholeFile:
    """A new file beside its place; it takes that, and its name, when it is whole.

    Until then it has a name of its own. So another process that writes the same file writes another one, and the last
    one that is whole stays.

    Attributes:
        path: where it will be.
        part: where it is until then.
        file: open for writing.
    """

    def __init__(self, path: Path) -> None:
        """Makes an empty file in the folder of ``path``. Raises ValueError if that cannot be."""
        self.path = path
        self.part = path.with_name(f".{secrets.token_hex(8)}.part")  # short: a name has 255 bytes at most
        try:
            if path.is_dir():
                raise IsADirectoryError(errno.EISDIR, "Is a directory")  # the same message on every system
            self.file = self.part.open("xb")  # a new file, never the one that a link leads to
        except OSError as error:
            raise ValueError(
                f"{path} cannot be written ({error.strerror}): choose another folder or another name"
            ) from error

    def write(self, data: bytes) -> None:
        """Raises RuntimeError if the disk is full."""
        self._try(lambda: self.file.write(data))

    def finish(self) -> None:
        """It is whole: gives it its name, and replaces an older file. Raises RuntimeError if that fails."""
        self._try(self.file.close)
        self._try(lambda: self.part.replace(self.path))

    def discard(self) -> None:
        """Removes the file; after finish() it does nothing."""
        with suppress(OSError):  # what is not written yet may not fit
            self.file.close()
        self.part.unlink(missing_ok=True)

    def _try(self, act: Callable[[], object]) -> None:
        try:
            act()
        except OSError as error:
            raise self.failure(error.strerror) from error

    def failure(self, reason: str | None) -> RuntimeError:
        """What to raise if writing has failed."""
        return RuntimeError(f"{self.path} could not be written ({reason}): free disk space, or choose another folder")


def check_space(folder: Path, n_bytes: int, what: str, instead: str = "choose another folder") -> None:
    """Raises ValueError if a disk has no room for so many bytes.

    Args:
        what: takes them, as the beginning of a sentence.
        instead: what to do if no space can be freed.
    """
    try:
        free = shutil.disk_usage(folder).free
    except OSError:  # a file system that does not tell: writing will
        return
    if n_bytes > free:
        raise ValueError(
            f"{what} takes {size_text(n_bytes)}, {size_text(n_bytes - free)} more than {folder} has free: "
            f"free disk space there, or {instead}"
        )
