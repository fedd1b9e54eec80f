# SPDX-License-Identifier: GPL-3.0-or-later
"""What .ci/zips made, on other systems: Windows under Wine, Linux on ARM under qemu."""

import os
from concurrent.futures import ThreadPoolExecutor


def test_poses(python, linux_poses, run):
    """They are those of Linux on x86-64."""
    run(*python.command, "tests/platforms/same_poses.py", "compare", linux_poses, PYTHONPATH=python.path)


def test_module(python, run):
    left_out = [f"--deselect=tests/python/module/{test}" for test in python.left_out]
    options = ["-u", "-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/python/module", *left_out]
    run(*python.command, *options, PYTHONPATH=python.path)


def test_zip_in_blender_on_windows(windows_python, windows_zip, run):
    """Renders need a screen."""
    screen = ["xvfb-run", "-a", "-s", "-screen 0 800x600x24"]
    run(*screen, *windows_python, "tests/blender/run.py", "--", f"Z:{windows_zip}")


def test_native(native_tests, run):
    """A share of them on each processor: an emulator runs them slowly."""
    n = os.cpu_count() or 1

    def run_share(k):
        run(*native_tests, "--gtest_brief=1", part=f"-{k}", GTEST_TOTAL_SHARDS=str(n), GTEST_SHARD_INDEX=str(k))

    with ThreadPoolExecutor(n) as pool:
        shares = [pool.submit(run_share, k) for k in range(n)]
    for share in shares:
        share.result()
