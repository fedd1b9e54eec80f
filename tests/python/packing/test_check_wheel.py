# SPDX-License-Identifier: GPL-3.0-or-later
"""What the check of wheels finds. The tools that read modules are stand-ins; .ci/zips runs it on the real ones."""

import zipfile

import check_wheel
import pytest

LICENCES = ("zig/lib/libcxx/LICENSE.TXT", "zig/lib/libunwind/LICENSE.TXT", "zig/lib/libc/glibc/LICENSES", "zig/mingw")


@pytest.fixture
def faults(tmp_path, monkeypatch):
    """A function that gives the faults of a wheel for what the tools would say of its module."""

    def check(tag, said, licences=LICENCES, content=b"module"):
        path = tmp_path / f"arap_native-1-cp313-cp313-{tag}.whl"
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("arap_native/_native.so", content)
            for name in licences:
                archive.writestr(f"arap_native-1.dist-info/licenses/{name}", b"text")
        monkeypatch.setattr(check_wheel, "tool", lambda name, *arguments: said.get(arguments[0], said.get(name, "")))
        return list(check_wheel.wheel_faults(path))

    return check


def needed(*libraries):
    return "NeededLibraries [\n" + "".join(f"  {library}\n" for library in libraries) + "]\n"


def test_what_every_windows_has_is_no_fault(faults):
    libraries = needed("KERNEL32.dll", "api-ms-win-crt-heap-l1-1-0.dll", "python313.dll")
    assert faults("win_amd64", {"--needed-libs": libraries}) == []


def test_a_library_that_not_every_system_has_is_named(faults):
    assert faults("win_amd64", {"--needed-libs": needed("libomp140.dll")}) == [
        "links to libomp140.dll, which not every system has"
    ]


def test_a_glibc_newer_than_promised_is_named(faults):
    said = {"--needed-libs": needed("libc.so.6"), "--version-info": "Name: GLIBC_2.17\nName: GLIBC_2.34\n"}
    assert faults("manylinux_2_28_x86_64", said) == ["asks for glibc 2.34, but its name promises 2.28"]


def test_a_macos_module_without_signature_or_with_unknown_names_is_named(faults):
    said = {
        "--needed-libs": needed("/usr/lib/libSystem.B.dylib"),
        "--macho": " minos 12.0\n",
        "llvm-nm": "  U _new_one\n",
    }
    first, second, third = faults("macosx_11_0_arm64", {**said, "-u": "  U _PyList_New\n  U _new_one\n"})
    assert first == "asks for macOS 12.0, but its name promises 11.0"
    assert second.startswith("has no signature")
    assert third.startswith("uses new_one: look up whether macOS 11.0 has it")


def test_a_licence_that_is_missing_is_named(faults):
    assert faults("win_amd64", {}, LICENCES[:2]) == ["lacks the licence of mingw, which is linked in"]


def test_a_path_of_the_machine_is_named(faults):
    root = str(check_wheel.Path(check_wheel.__file__).resolve().parents[1])
    assert faults("win_amd64", {}, content=root.encode()) == [f"has a path of the machine that built it inside: {root}"]
