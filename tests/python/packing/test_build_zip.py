# SPDX-License-Identifier: GPL-3.0-or-later
"""What the add-on's zips hold. The wheels are stand-ins; the real ones are tested as installed zips."""

import ast
import re
import shutil
import zipfile
from pathlib import Path

import build_zip
import pytest

VERSION = build_zip.project_version()
LINUX = "manylinux_2_34_x86_64"
MODULE = "arap_native/_native.so"
LIBRARIES = ("arap_native.libs/libgomp-0a1b2c3d.so.1.0.0", "arap_native.libs/libother-0a1b2c3d.so.5")


@pytest.fixture
def wheels(tmp_path):
    """A function that puts stand-in wheels into a folder and returns it."""
    folder = tmp_path / "wheels"
    folder.mkdir()

    def make(*tags, platform=LINUX, module=b"module"):
        for tag in tags:
            with zipfile.ZipFile(folder / f"arap_native-{VERSION}-{tag}-{tag}-{platform}.whl", "w") as wheel:
                wheel.writestr(MODULE, module)
                for library in LIBRARIES:
                    wheel.writestr(library, b"library")
                wheel.writestr(f"arap_native-{VERSION}.dist-info/licenses/LICENSE", b"licence")
                wheel.writestr(f"arap_native-{VERSION}.dist-info/RECORD", b"record")
        return folder

    return make


def contents(path):
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def build(wheels_dir, out, *kinds):
    return build_zip.build(wheels_dir, out, kinds or ("legacy", "extension"))


def test_legacy_zip_holds_the_wheels_unpacked_by_python(wheels, tmp_path):
    files = contents(build(wheels("cp310", "cp311", "cp313"), tmp_path, "legacy")[0])
    modules = "arap_deform/native_modules"
    assert {name.split("/")[2] for name in files if name.startswith(modules)} == {"cp310", "cp311"}
    for tag in ("cp310", "cp311"):
        assert files[f"{modules}/{tag}/{MODULE}"] == b"module"
        for library in LIBRARIES:
            assert files[f"{modules}/{tag}/{library}"] == b"library"
        assert files[f"{modules}/{tag}/arap_native-{VERSION}.dist-info/licenses/LICENSE"] == b"licence"
    assert all(name.startswith("arap_deform/") for name in files)
    assert not any(name.endswith(("blender_manifest.toml", "RECORD")) for name in files)
    assert b"bl_info" in files["arap_deform/__init__.py"]


def test_extension_zip_holds_the_wheels_and_names_them(wheels, tmp_path):
    files = contents(build(wheels("cp310", "cp311", "cp313"), tmp_path, "extension")[0])
    manifest = files["blender_manifest.toml"].decode()
    names = {f"wheels/arap_native-{VERSION}-{tag}-{tag}-{LINUX}.whl" for tag in ("cp311", "cp313")}
    assert {name for name in files if name.startswith("wheels/")} == names
    assert set(re.findall(r'"\./(wheels/[^"]+)"', manifest)) == names
    assert 'platforms = ["linux-x64"]' in manifest


def test_wheels_come_in_front_of_the_manifests_first_table():
    manifest = build_zip.manifest_with_wheels('id = "x"\n\n[permissions]\nfiles = "y"\n', [Path(f"x-{LINUX}.whl")])
    assert manifest.splitlines() == [
        'id = "x"',
        'platforms = ["linux-x64"]',
        "wheels = [",
        f'  "./wheels/x-{LINUX}.whl",',
        "]",
        "",
        "[permissions]",
        'files = "y"',
    ]


def test_both_zips_hold_the_add_on_and_the_licence_and_nothing_else(wheels, tmp_path):
    legacy, extension = (contents(path) for path in build(wheels("cp311"), tmp_path))
    before, after = (ast.parse(files) for files in (legacy["arap_deform/__init__.py"], extension["__init__.py"]))
    assert b"bl_info" not in extension["__init__.py"]
    assert len(after.body) == len(before.body) - 1
    assert extension["api.py"] == legacy["arap_deform/api.py"]
    assert legacy["arap_deform/LICENSE"] == extension["LICENSE"] == (build_zip.ROOT / "LICENSE").read_bytes()
    hidden = [name for name in (*legacy, *extension) if "__pycache__" in name or "/." in name or name.startswith(".")]
    assert not hidden


def test_same_input_gives_the_same_bytes(wheels, tmp_path):
    folder = wheels("cp310", "cp311")
    first, second = build(folder, tmp_path / "a"), build(folder, tmp_path / "b")
    assert [path.read_bytes() for path in first] == [path.read_bytes() for path in second]


def test_one_extension_takes_several_platforms(wheels, tmp_path):
    wheels("cp311")
    wheels("cp311", platform="win_amd64")
    folder = wheels("cp311", platform="macosx_15_0_arm64")
    manifest = contents(build(folder, tmp_path, "extension")[0])["blender_manifest.toml"].decode()
    assert 'platforms = ["linux-x64", "macos-arm64", "windows-x64"]' in manifest


def test_legacy_zip_refuses_platforms_that_collide(wheels, tmp_path):
    wheels("cp311", platform="macosx_15_0_x86_64")
    folder = wheels("cp311", platform="macosx_15_0_arm64", module=b"another")
    with pytest.raises(ValueError, match=f"both bring {MODULE}: pack one of them"):
        build(folder, tmp_path, "legacy")


@pytest.mark.parametrize(
    ("tag", "platform", "kind", "message"),
    [
        ("cp311", "musllinux_1_2_x86_64", "extension", "no Blender runs on platform musllinux_1_2_x86_64"),
        ("cp313", LINUX, "legacy", r"holds no wheel arap_native-\S+ for any of cp310, cp311: run make wheel"),
        ("cp311", "linux_x86_64", "legacy", "runs on this machine only: take one that auditwheel repaired"),
    ],
)
def test_refuses_wheels_that_no_blender_can_use(wheels, tmp_path, tag, platform, kind, message):
    with pytest.raises(ValueError, match=message):
        build(wheels(tag, platform=platform), tmp_path, kind)


@pytest.fixture
def copied_source(tmp_path, monkeypatch):
    """A copy of the add-on and of CMakeLists.txt that a test may spoil."""
    shutil.copytree(build_zip.SOURCE, tmp_path / "addon" / "arap_deform")
    for name in ("CMakeLists.txt", "LICENSE"):
        shutil.copy(build_zip.ROOT / name, tmp_path / name)
    monkeypatch.setattr(build_zip, "ROOT", tmp_path)
    monkeypatch.setattr(build_zip, "SOURCE", tmp_path / "addon" / "arap_deform")
    return tmp_path


def spoil(path: Path, pattern: str, replacement: str) -> None:
    text = path.read_text(encoding="utf-8")
    spoilt, n = re.subn(pattern, replacement, text, count=1, flags=re.MULTILINE)
    assert n == 1
    path.write_text(spoilt, encoding="utf-8")


@pytest.mark.parametrize(
    ("file", "pattern", "replacement", "message"),
    [
        (
            "addon/arap_deform/__init__.py",
            r'"version": \([^)]*\)',
            '"version": (9, 9, 9)',
            r"bl_info in arap_deform/__init__.py states version 9\.9\.9, CMakeLists\.txt .*: make them equal",
        ),
        (
            "addon/arap_deform/blender_manifest.toml",
            r'^version = ".*"',
            'version = "9.9.9"',
            r"blender_manifest\.toml states version 9\.9\.9, CMakeLists\.txt .*: make them equal",
        ),
        ("addon/arap_deform/__init__.py", r"^bl_info = ", "info = ", "has no bl_info"),
        ("CMakeLists.txt", r"project\(arap VERSION", "project(arap", "has no line 'project\\(arap VERSION"),
    ],
)
def test_refuses_versions_that_differ(wheels, copied_source, file, pattern, replacement, message):
    folder = wheels("cp311")
    spoil(copied_source / file, pattern, replacement)
    with pytest.raises(ValueError, match=message):
        build(folder, copied_source / "out", "legacy")


def test_a_release_has_an_extension_for_each_platform(wheels, tmp_path):
    wheels("cp310", "cp311", "cp313")
    folder = wheels("cp310", "cp311", "cp313", platform="win_amd64", module=b"another")
    for wheel in folder.glob("*win_amd64.whl"):  # the names of modules differ by platform
        with zipfile.ZipFile(wheel, "w") as archive:
            archive.writestr("arap_native/_native.pyd", b"another")
    legacy, windows, linux = build_zip.build(folder, tmp_path, ("legacy", "extension"), is_release=True)
    assert [path.name for path in (windows, linux)] == [
        f"arap_deform-{VERSION}-{platform}.zip" for platform in ("windows-x64", "linux-x64")
    ]
    assert 'platforms = ["windows-x64"]' in contents(windows)["blender_manifest.toml"].decode()
    assert {name for name in contents(linux) if name.startswith("wheels/")} == {
        f"wheels/arap_native-{VERSION}-{tag}-{tag}-{LINUX}.whl" for tag in ("cp311", "cp313")
    }
    modules = {name for name in contents(legacy) if name.endswith(("_native.so", "_native.pyd"))}
    assert len(modules) == 4
