# SPDX-License-Identifier: GPL-3.0-or-later
"""Installs a zip of the add-on into a throw-away user folder and runs the tests beside this file on it.

    blender -b --factory-startup --python-exit-code 1 --python tests/blender/run.py -- ZIP [NAME]
    python tests/blender/run.py -- ZIP [NAME]                                                   (a Python with bpy)

NAME: only tests whose full name contains it. Ends with unittest's summary, a line 'N passed, N failed' and exit code
1 if a test failed.
"""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile
import traceback
import unittest
from collections.abc import Iterator
from pathlib import Path

USER_FOLDER = "ARAP_TEST_USER_FOLDER"


def start_again() -> None:
    """Replaces this process by one whose user folder is a throw-away one: Blender looks for it when it starts."""
    folder = tempfile.mkdtemp(prefix="arap-test-")
    command = [sys.executable, *sys.argv]
    if "bpy" in sys.modules:
        import bpy

        command = [bpy.app.binary_path, *sys.argv[1:]]
    environment = {**os.environ, "BLENDER_USER_RESOURCES": folder, USER_FOLDER: folder}
    if sys.platform == "win32":  # there, a process that replaces itself ends, and what it becomes has no output
        sys.exit(subprocess.run(command, env=environment, check=False).returncode)
    os.execve(command[0], command, environment)


def install(zip_path: Path) -> str:
    """Installs and enables as a user does; returns the name of the add-on's package."""
    import bpy

    bpy.ops.extensions.package_install_files(filepath=str(zip_path), repo="user_default", enable_on_install=True)
    return "bl_ext.user_default.arap_deform"


def found(folder: Path) -> Iterator[unittest.TestCase]:
    """All tests in this folder and its rooms. Two rooms may have files of one name."""
    import support

    for path in sorted(folder.rglob("test_*.py")):
        name = ".".join(path.relative_to(folder).with_suffix("").parts)
        spec = importlib.util.spec_from_file_location(name, path)
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module
        spec.loader.exec_module(module)
        yield from support.flattened(unittest.defaultTestLoader.loadTestsFromModule(module))


def run(zip_path: Path, name: str) -> int:
    package = install(zip_path)
    if package not in sys.modules:
        raise RuntimeError(f"{zip_path} was installed, but its package {package} was not enabled")
    sys.path.insert(0, str(Path(__file__).parent))
    import support

    support.ZIP = zip_path
    support.PACKAGE = package
    suite = unittest.TestSuite(test for test in found(Path(__file__).parent) if name in test.id())
    result = unittest.TextTestRunner(stream=sys.stdout, verbosity=2).run(suite)
    n_failed = len(result.failures) + len(result.errors) + len(result.unexpectedSuccesses)
    n_skipped = len(result.skipped)
    for test, reason in result.skipped:
        print(f"NOT RUN: {test.id()}: {reason}")
    skipped = f", {n_skipped} not run" if n_skipped else ""
    print(f"{result.testsRun - n_failed - n_skipped} passed, {n_failed} failed{skipped}")
    return 1 if n_failed or not result.testsRun else 0


def main() -> None:
    if USER_FOLDER not in os.environ:
        start_again()
    code = 1
    try:
        arguments = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
        if not arguments:
            raise SystemExit("run.py: give the zip behind --")
        code = run(Path(arguments[0]).resolve(), arguments[1] if len(arguments) > 1 else "")
    except BaseException:  # noqa: BLE001 - whatever it is, the exit code must say that it failed
        traceback.print_exc()
    finally:
        shutil.rmtree(os.environ[USER_FOLDER], ignore_errors=True)
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)  # bpy prints thousands of lines about leaks at a usual exit


if __name__ == "__main__":
    main()
