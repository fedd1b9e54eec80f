# SPDX-License-Identifier: GPL-3.0-or-later
"""The programs that the benchmarks drive, and what is said of those that cannot run."""

import sys

import pytest
from measure.machine import instruction_sets
from measure.workers import NotRun, Worker


def test_instruction_sets_are_those_that_bind():
    def bind(isa: str) -> None:
        if isa not in ("baseline", "avx2"):
            raise NotRun(f"ARAP_ISA = {isa}")

    assert instruction_sets(bind) == (["baseline", "avx2"], {"avx512": "ARAP_ISA = avx512"})


def test_a_library_that_takes_any_instruction_set_has_no_choice():
    assert instruction_sets(lambda isa: None) == ([""], {})


ECHO = 'import sys\nfor line in sys.stdin: print(\'{"said": "%s"}\' % line.strip(), flush=True)'


def test_a_worker_answers_each_command(python):
    with Worker([python, "-c", ECHO]) as worker:
        assert worker.ask("one") == {"said": "one"}
        assert worker.ask("two") == {"said": "two"}


def test_a_worker_that_fails_gives_its_last_words(python):
    with (
        Worker([python, "-c", "import sys; sys.exit('first\\nno such mesh')"]) as worker,
        pytest.raises(NotRun) as reason,
    ):
        worker.ask("bind")
    assert str(reason.value) == "no such mesh"


def test_half_an_answer_is_none(python):
    command = [python, "-c", "import sys; sys.stdout.write('{'); sys.exit('no memory')"]
    with Worker(command) as worker, pytest.raises(NotRun, match="no memory"):
        worker.ask("bind")


def test_a_worker_that_ends_silently_gives_its_exit_code(python):
    with Worker([python, "-c", "raise SystemExit(3)"]) as worker, pytest.raises(NotRun, match="exit code 3"):
        worker.ask("bind")


def test_a_worker_that_takes_too_long_is_ended(python):
    command = [python, "-c", "import time; time.sleep(60)"]
    with Worker(command, timeout_s=0.2) as worker, pytest.raises(NotRun, match=r"bind took longer than 0\.2 s"):
        worker.ask("bind")


def test_a_program_that_is_not_there_is_not_run():
    with pytest.raises(NotRun, match="no-such-program: No such file"):
        Worker(["no-such-program"])


@pytest.fixture
def python():
    return sys.executable


def test_a_library_that_cannot_be_set_up_is_a_row_with_the_reason(monkeypatch, tmp_path):
    from measure import peers

    def cannot(*names: str) -> None:
        raise NotRun(f"{names[0] if names else 'CGAL'} cannot be installed")

    monkeypatch.setattr(peers, "_python_of", cannot)
    monkeypatch.setattr(peers, "_cgal", cannot)
    monkeypatch.setattr(peers, "our_instruction_sets", lambda files: (["baseline", "avx2"], {"avx512": "not here"}))
    found, rows = peers.contenders(peers.Files(tmp_path / "task", tmp_path / "positions"), threads=2)
    assert [(c.library, c.isa, c.energy) for c in found] == [
        ("ours", isa, energy)
        for isa in ("avx2", "baseline")
        for energy in ("rotation_nodes", "spokes", "spokes_and_rims")
    ]
    assert found[0].env["ARAP_ISA"] == "avx2"
    assert rows == [
        {"library": "ours", "isa": "avx512", "not_run": "not here"},
        {"library": "libigl", "not_run": "libigl cannot be installed"},
        {"library": "open3d", "not_run": "open3d cannot be installed"},
        {"library": "cgal", "not_run": "CGAL cannot be installed"},
    ]
