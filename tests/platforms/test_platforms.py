# SPDX-License-Identifier: GPL-3.0-or-later
"""What .ci/zips made, on other systems: Windows under Wine, Linux on ARM under qemu."""

import os
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path


def test_poses(python, linux_poses, run):
    """They are those of Linux on x86-64."""
    run(*python.command, "tests/platforms/same_poses.py", "compare", linux_poses, PYTHONPATH=python.path)


def test_module(python, run):
    left_out = [f"--deselect=tests/python/module/{test}" for test in python.left_out]
    files = sorted(str(path) for path in Path("tests/python/module").glob("test_*.py"))
    options = ["-u", "-m", "pytest", "-q", "-p", "no:cacheprovider", *left_out]
    in_shares(lambda k, n: run(*python.command, *options, *files[k::n], part=f"-{k}", PYTHONPATH=python.path))


def test_zip_in_blender_on_windows(windows_python, windows_zip, run):
    """Renders need a screen."""
    screen = ["xvfb-run", "-a", "-s", "-screen 0 800x600x24"]
    run(*screen, *windows_python, "tests/blender/run.py", "--", f"Z:{windows_zip}")


def test_native(native_tests, run):
    def run_share(k, n):
        run(*native_tests, part=f"-{k}", GTEST_TOTAL_SHARDS=str(n), GTEST_SHARD_INDEX=str(k))

    in_shares(run_share)


def in_shares(run_share):
    """A share of the tests on each processor: an emulator runs them slowly."""
    n = os.cpu_count() or 1
    with ThreadPoolExecutor(n) as pool:
        shares = [pool.submit(run_share, k, n) for k in range(n)]
    for share in shares:
        share.result()
