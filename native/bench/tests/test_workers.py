# SPDX-License-Identifier: GPL-3.0-or-later
"""The programs that the benchmarks drive, and what is said of those that cannot run."""

import sys

import pytest
from measure.base.machine import instruction_sets
from measure.base.workers import NotRun, Worker


def test_instruction_sets_are_those_that_bind():
    def bind(isa: str) -> None:
        if isa not in ("baseline", "avx2"):
            raise NotRun(f"ARAP_ISA = {isa}")

    assert instruction_sets(bind) == (["baseline", "avx2"], {"avx512": "ARAP_ISA = avx512"})


ECHO = 'import sys\nfor line in sys.stdin: print(\'{"said": "%s"}\' % line.strip(), flush=True)'


def test_a_worker_answers_each_command():
    with Worker([sys.executable, "-c", ECHO]) as worker:
        assert worker.ask("one") == {"said": "one"}
        assert worker.ask("two") == {"said": "two"}


@pytest.mark.parametrize(
    ("program", "reason"),
    [
        ("import sys; sys.exit('first\\nno such mesh')", "^no such mesh$"),
        ("import sys; sys.stdout.write('{'); sys.exit('no memory')", "^no memory$"),  # half an answer is none
        ("raise SystemExit(3)", "exit code 3"),
        ("import os; os.abort()", "^the program was ended by SIGABRT$"),
        ("import time; time.sleep(60)", r"bind took longer than 0\.2 s"),
    ],
)
def test_why_a_worker_does_not_answer(program, reason):
    timeout_s = 0.2 if "sleep" in program else 600
    with Worker([sys.executable, "-c", program], timeout_s=timeout_s) as worker, pytest.raises(NotRun, match=reason):
        worker.ask("bind")


def test_a_program_that_is_not_there_is_not_run():
    with pytest.raises(NotRun, match="no-such-program: No such file"):
        Worker(["no-such-program"])
