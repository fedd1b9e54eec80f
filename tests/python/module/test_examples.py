# SPDX-License-Identifier: GPL-3.0-or-later
"""The examples in Python run and print what they should. Those in C++: tests/native/CMakeLists.txt."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[3] / "native/examples"
PRINTS = dict(line.split(": ", 1) for line in (EXAMPLES / "prints.txt").read_text().splitlines())


@pytest.mark.parametrize("name", PRINTS)
def test_an_example_prints_what_it_should(name, tmp_path):
    script = EXAMPLES / f"python/{name}.py"
    command = [sys.executable, "-W", "error", script]
    run = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert run.stderr == ""
    assert re.search(PRINTS[name], run.stdout)


def test_every_example_is_run():
    scripts = {path.stem for path in (EXAMPLES / "python").glob("*.py")} - {"shapes"}
    assert scripts == {path.stem for path in EXAMPLES.glob("*.cpp")} == set(PRINTS)
