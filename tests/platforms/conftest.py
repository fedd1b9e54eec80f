# SPDX-License-Identifier: GPL-3.0-or-later
"""Programs of other systems from what .ci/zips made, and how they run; all is kept in build/platforms.

The wheels are those for pip, which have all models: a module more, of the library that the zips have.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig
from collections import Counter
from pathlib import Path
from types import SimpleNamespace

import pytest
from platforms import PLATFORMS

ROOT = Path(__file__).resolve().parents[2]
WORK = ROOT / "build" / "platforms"
LOGS = WORK / "logs"
RELEASE = ROOT / "build" / "dist" / "release"
TESTS = ROOT / "tests" / "python"
VERSION = f"{sys.version_info.major}.{sys.version_info.minor}"  # of the other Pythons too
TAG = VERSION.replace(".", "")

# Output is a pipe: a Windows Python refuses files under Wine.
WINE = ("bash", "-o", "pipefail", "-c", 'wine "$@" 2>&1 | cat', "wine")
PYTEST = ("pytest==9.2.0", "iniconfig", "packaging", "pluggy", "pygments", "colorama")
WINDOWS_PACKAGES = ("panda3d==1.10.16", "numpy==1.26.4", "bpy==4.5.4", *PYTEST)
WINDOWS_MAIN = """
#include <wchar.h>
int Py_Main(int, wchar_t**);
int wmain(int argc, wchar_t** argv) { return Py_Main(argc, argv); }
"""

# Under Wine a process that multiprocessing starts does not come up where the program is pytest. From a script it does.
NOT_UNDER_WINE = ("test_data.py::test_models_go_to_another_process_and_results_come_back",)
# qemu takes no limits of memory and threads, and its own memory hides that of the program.
NATIVE_NOT_UNDER_QEMU = "AvailableMemory.IsWhatTheLimitOfTheProcessLeaves"
NOT_UNDER_QEMU = (
    "test_jobs.py::test_without_a_thread_the_work_is_done_at_once",
    "test_attacks.py::test_a_factor_that_cannot_fit_is_refused_before_memory_runs_out",
    "test_attacks.py::test_too_little_memory_is_said_in_words",
    "test_attacks.py::test_constraints_of_a_cage_that_cannot_fit_are_refused",
    "test_attacks.py::test_a_grid_that_cannot_fit_is_refused_before_it_is_made",
    "test_attacks.py::test_without_threads_the_caller_does_all",
    "test_threads.py::test_two_hundred_solvers_leave_no_memory_behind",
)


EMULATED_S = 0.1
"""A test that takes longer on this machine is left out under an emulator, which takes some fifty times as long."""


def run_into(log, *command, **env):
    told = [ROOT / ".ci" / "told", LOGS / f"{log}.log", *command]
    if subprocess.run(told, cwd=ROOT, env={**os.environ, **env}, check=False).returncode != 0:
        pytest.fail(f"see {LOGS / log}.log", pytrace=False)


def prepare(*command, **env):
    run_into("prepare", *command, **env)


@pytest.fixture
def run(request):
    """Runs a command of this test, in parts with a log for each; tells at the end how many tests passed in it."""
    name = "-".join(re.findall(r"\w+", request.node.name.removeprefix("test_")))
    yield lambda *command, part="", **env: run_into(f"{name}{part}", *command, **env)
    print(f"\n{name}: {counts(log.read_text(errors='replace') for log in LOGS.glob(f'{name}*.log'))}")


def counts(logs):
    """How many tests passed, failed and were skipped: the words of pytest, GoogleTest and the tests in Blender."""
    found = Counter()
    for text in logs:
        last = re.findall(r"^.*\d+ passed.*$", text, re.MULTILINE)[-1:]  # tests that start tests say so before
        for number, word in re.findall(r"(\d+) (passed|failed|skipped)", "".join(last)):
            found[word] += int(number)
        for word, number in re.findall(r"^\[  (PASSED|FAILED|SKIPPED) +\] (\d+) tests?", text, re.MULTILINE):
            found[word.lower()] += int(number)
    return ", ".join(f"{number} {word}" for word, number in sorted(found.items(), reverse=True))


@pytest.fixture(scope="session")
def zig():
    return next((ROOT / "build" / "venv" / "zips").glob("lib/python*/site-packages/ziglang/zig"))


@pytest.fixture(params=["windows-x64", "linux-arm64"])
def native_tests(request, zig):
    """Built in the folder where .ci/zips built the library, with a GoogleTest of their own."""
    folder = WORK / request.param
    assert folder.exists(), f"run .ci/zips {request.param} first"
    gtest = folder / "googletest"
    if not gtest.exists():
        prepare(
            "cmake", "-G", "Ninja", "-S", "/usr/src/googletest", "-B", f"{gtest}-build", "-DBUILD_GMOCK=OFF",
            "--toolchain", ROOT / "cmake" / "toolchains" / "zig.cmake", f"-DARAP_ZIG={zig}",
            f"-DARAP_ZIG_TARGET={PLATFORMS[request.param].zig_target}", f"-DCMAKE_INSTALL_PREFIX={gtest}",
            "-DCMAKE_BUILD_TYPE=Release", "-Dgtest_disable_pthreads=OFF",
        )  # fmt: skip
        prepare("cmake", "--build", f"{gtest}-build", "--target", "install")
    prepare("cmake", "-B", folder, "-DARAP_BUILD_TESTS=ON", f"-DGTest_DIR={next(gtest.glob('lib*/cmake/GTest'))}")
    prepare("cmake", "--build", folder, "--target", "arap_tests")
    program = folder / "tests" / "native" / "arap_tests"
    if request.param == "windows-x64":
        return [*WINE, f"{program}.exe"]
    chosen = f"--gtest_filter={':'.join(quick_native_tests())}-{NATIVE_NOT_UNDER_QEMU}"
    return ["qemu-aarch64-static", "-L", "/usr/aarch64-linux-gnu", program, chosen]


def quick_native_tests():
    """Those that take less than EMULATED_S here."""
    times = WORK / "native.json"
    prepare(ROOT / ".ci" / "build", "release", "arap_tests")
    program = ROOT / "build" / "native" / "release" / "tests" / "native" / "arap_tests"
    prepare(program, "--gtest_brief=1", f"--gtest_output=json:{times}")
    suites = json.loads(times.read_text())["testsuites"]
    tests = ((f"{suite['name']}.{test['name']}", test["time"]) for suite in suites for test in suite["testsuite"])
    return [name for name, time in tests if float(time.removesuffix("s")) < EMULATED_S]


def slow_module_tests():
    """Those that take longer than EMULATED_S here."""
    options = ["-q", "-p", "no:cacheprovider", "--durations=0", f"--durations-min={EMULATED_S}"]
    run_into("durations", sys.executable, "-m", "pytest", *options, "tests/python/module", PYTHONPATH=str(TESTS))
    told = (LOGS / "durations.log").read_text()
    return re.findall(r"^[\d.]+s call +tests/python/module/(.+)$", told, re.MULTILINE)


def install(folder, platform, *packages):
    """Unpacks packages for another system."""
    prepare(
        sys.executable, "-m", "pip", "install", "--disable-pip-version-check", "--no-deps", "--no-compile",
        "--only-binary=:all:", "--platform", PLATFORMS[platform].wheel_tag, "--target", folder, *packages,
    )  # fmt: skip


def install_module(platform, *packages):
    folder = WORK / f"packages-{platform}"
    shutil.rmtree(folder, ignore_errors=True)
    wheel = next((RELEASE / "wheels").glob(f"*-cp{TAG}-*{PLATFORMS[platform].wheel_tag}.whl"))
    install(folder, platform, wheel, *packages)
    return folder


@pytest.fixture(scope="session")
def windows_python(zig):
    """Starts a CPython under Wine.

    The DLLs are the official ones, from a wheel that carries them (panda3d); the standard library is that of this
    Python; python.exe is a few lines of our own.
    """
    folder = WORK / "windows-python"
    stamp, wanted = folder / "wanted.txt", " ".join((VERSION, *WINDOWS_PACKAGES))
    if not stamp.exists() or stamp.read_text() != wanted:
        shutil.rmtree(folder, ignore_errors=True)
        leave = shutil.ignore_patterns("site-packages", "test", "__pycache__", "lib-dynload", "config-*")
        shutil.copytree(sysconfig.get_path("stdlib"), folder / "Lib", ignore=leave)
        packages = folder / "Lib" / "site-packages"
        install(packages, "windows-x64", *WINDOWS_PACKAGES)
        for dll in (packages / "deploy_libs").iterdir():
            dll.rename(folder / dll.name)
        names, source, library = folder / "python.def", folder / "python.c", folder / "libpython.a"
        names.write_text(f"LIBRARY python{TAG}.dll\nEXPORTS\nPy_Main\n")
        source.write_text(WINDOWS_MAIN)
        prepare(zig, "dlltool", "-m", "i386:x86-64", "-d", names, "-l", library)
        options = ["-target", "x86_64-windows-gnu", "-municode", "-O1", "-o", folder / "python.exe"]
        prepare(zig, "cc", *options, source, library)
        stamp.write_text(wanted)
    return [*WINE, folder / "python.exe"]


@pytest.fixture(scope="session")
def arm_root():
    """Debian's Python for ARM and all that it needs. apt keeps its lists and files here: nothing is installed."""
    root, new, apt = WORK / "arm-root", WORK / "arm-root.new", WORK / "arm-apt"
    if not root.exists():
        for folder in ("lists/partial", "archives/partial"):
            (apt / folder).mkdir(parents=True, exist_ok=True)
        (apt / "status").touch()
        settings = {
            "APT::Architecture": "arm64", "APT::Architectures": "arm64", "APT::Sandbox::User": "root",
            "Dir::State": apt, "Dir::State::Lists": apt / "lists", "Dir::State::status": apt / "status",
            "Dir::Cache": apt, "Dir::Cache::archives": apt / "archives", "Debug::NoLocking": 1,
        }  # fmt: skip
        apt_get = ["apt-get", "-q", "-y", *(f"-o{name}={value}" for name, value in settings.items())]
        prepare(*apt_get, "update")
        prepare(*apt_get, "--no-install-recommends", "--download-only", "install", "python3", "python3-numpy")
        for package in (apt / "archives").glob("*.deb"):
            prepare("dpkg-deb", "-x", package, new)
        new.rename(root)
    return root


@pytest.fixture(scope="session")
def windows(windows_python):
    path = f"Z:{install_module('windows-x64')};Z:{TESTS}"
    return SimpleNamespace(command=windows_python, path=path, left_out=NOT_UNDER_WINE)


@pytest.fixture(scope="session")
def arm(arm_root):
    """By a script: programs for ARM cannot start each other, but they can start that."""
    packages = install_module("linux-arm64", *PYTEST)
    libraries = ":".join(f"{arm_root}/usr/lib/aarch64-linux-gnu/{name}" for name in ("blas", "lapack"))
    emulator = f"qemu-aarch64-static -L {arm_root} -E LD_LIBRARY_PATH={libraries}"
    script = WORK / "arm-python"
    script.write_text(f'#!/bin/sh\nexec {emulator} {arm_root}/usr/bin/python{VERSION} "$@"\n')
    script.chmod(0o755)
    (packages / "sitecustomize.py").write_text(f"import sys\nsys.executable = {str(script)!r}\n")
    left_out = [*NOT_UNDER_QEMU, *slow_module_tests()]
    return SimpleNamespace(command=[script], path=f"{packages}:{TESTS}", left_out=left_out)


@pytest.fixture(params=["windows", "arm"])
def python(request):
    """The command that starts it, the path for modules, and what it cannot run."""
    return request.getfixturevalue(request.param)


@pytest.fixture(scope="session")
def linux_poses():
    path = WORK / "poses.npz"
    prepare(sys.executable, "tests/platforms/same_poses.py", "write", path, PYTHONPATH=str(TESTS))
    return path


@pytest.fixture(scope="session")
def windows_zip():
    return next(RELEASE.glob("arap_deform-*-windows-x64.zip"))
