# SPDX-License-Identifier: GPL-3.0-or-later
"""Programs that measure, each in a process of its own: a command in, a line of JSON out."""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path
from signal import Signals
from threading import Timer
from types import TracebackType
from typing import Any, final


class NotRun(Exception):
    """Something cannot be measured here; the text says why."""


class Ended(NotRun):
    """The program that was asked has ended."""


@final
class Worker:
    """A running program; leaving the context ends it."""

    def __init__(
        self, command: Sequence[str | Path], env: dict[str, str] | None = None, timeout_s: float = 600
    ) -> None:
        self._errors = tempfile.TemporaryFile("w+")  # noqa: SIM115  (closed in __exit__)
        self._timeout_s = timeout_s
        self._has_timed_out = False
        try:
            self._process = subprocess.Popen(
                [str(word) for word in command],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._errors,
                text=True,
                env={**os.environ, **(env or {})},
            )
        except OSError as error:
            self._errors.close()
            raise NotRun(f"{command[0]}: {error.strerror}") from error

    def __enter__(self) -> Worker:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._process.kill()
        self._process.communicate()
        self._errors.close()

    def ask(self, command: str, timeout_s: float | None = None, what: str = "") -> dict[str, Any]:
        """The answer to a command.

        Args:
            command: a line.
            timeout_s: in place of the worker's own.
            what: what the command is in words, the command itself if empty.

        Raises:
            Ended: the program ended, with its last words, or took longer than the timeout and was ended.
        """
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        limit_s = self._timeout_s if timeout_s is None else timeout_s
        timer = Timer(limit_s, self._give_up)
        timer.start()
        try:
            print(command, file=self._process.stdin, flush=True)
            line = self._process.stdout.readline()
        except BrokenPipeError:
            line = ""
        finally:
            timer.cancel()
        if not line.endswith("\n"):
            raise Ended(self._last_words(what or command, limit_s))
        answer: dict[str, Any] = json.loads(line)
        return answer

    def _give_up(self) -> None:
        self._has_timed_out = True
        self._process.kill()

    def _last_words(self, command: str, limit_s: float) -> str:
        code = self._process.wait()
        if self._has_timed_out:
            return f"{command} took longer than {limit_s:g} s"
        if code < 0:
            return f"the program was ended by {Signals(-code).name}"
        self._errors.seek(0)
        lines = self._errors.read().strip().splitlines()
        return lines[-1] if lines else f"{command} ended the program, exit code {code}"
