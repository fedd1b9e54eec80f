# SPDX-License-Identifier: GPL-3.0-or-later
"""The installed package: stub, docstrings, version, licences, the README's example."""

import ast
import importlib.metadata
import inspect
import pydoc
import re
import sys
from pathlib import Path

import arap_native
import numpy as np
import pytest
from sample_meshes import tube

ROOT = Path(__file__).parents[3]
PACKAGE = Path(arap_native.__file__).parent
CLASSES = [
    "CageArap",
    "CageArapOptions",
    "CageDeformation",
    "CageOptions",
    "EmbeddedDeformation",
    "EmbeddedOptions",
    "Job",
    "LatticeArap",
    "LatticeOptions",
    "LatticeTets",
    "Model",
    "Options",
    "PoissonEditing",
    "PoissonOptions",
    "SolveOptions",
    "SolveResult",
    "SurfaceArap",
    "TetArap",
    "TetOptions",
    "WrapDeformation",
    "WrapOptions",
    "WrapSurface",
]


@pytest.fixture(scope="module")
def stub() -> ast.Module:
    return ast.parse((PACKAGE / "__init__.pyi").read_text(encoding="utf-8"))


def stub_names(node: ast.Module | ast.ClassDef) -> set[str]:
    defined = {s.name for s in node.body if isinstance(s, ast.FunctionDef | ast.ClassDef)}
    return defined | {s.target.id for s in node.body if isinstance(s, ast.AnnAssign)}


def stub_class(stub: ast.Module, name: str) -> ast.ClassDef:
    return next(node for node in stub.body if isinstance(node, ast.ClassDef) and node.name == name)


def test_the_package_is_typed():
    assert (PACKAGE / "py.typed").is_file()


def test_the_stub_names_what_is_there(stub):
    assert stub_names(stub) == set(arap_native.__all__)
    assert all(hasattr(arap_native, name) for name in arap_native.__all__)
    for name in CLASSES:
        public = {member for member in vars(getattr(arap_native, name)) if not member.startswith("_")}
        assert stub_names(stub_class(stub, name)) - {"__init__"} == public


def test_the_compiled_objects_have_the_stubs_docstrings(stub):
    assert arap_native.__doc__ == ast.get_docstring(stub)
    for node in stub.body:
        if not isinstance(node, ast.ClassDef):
            continue
        compiled = getattr(arap_native, node.name)
        assert compiled.__doc__ == ast.get_docstring(node)
        for member in node.body:
            if isinstance(member, ast.FunctionDef):
                assert getattr(compiled, member.name).__doc__ == ast.get_docstring(member)


def test_every_public_member_is_described():
    for name in CLASSES:
        for member, value in vars(getattr(arap_native, name)).items():
            assert member.startswith("_") or value.__doc__, f"{name}.{member}"


def test_help_shows_names_and_arguments():
    text = pydoc.plain(pydoc.render_doc(arap_native.SurfaceArap))
    assert "class SurfaceArap" in text
    assert "solve(self, targets, options=None, *, rotations=None, progress=None, out=None)" in text
    assert "Moves the mesh towards the targets." in text
    assert "(n,) int32, connected part of each vertex" in text


def test_signatures_have_the_defaults_in_use():
    for options in (
        arap_native.Options,
        arap_native.LatticeOptions,
        arap_native.PoissonOptions,
        arap_native.EmbeddedOptions,
        arap_native.TetOptions,
        arap_native.CageOptions,
        arap_native.CageArapOptions,
        arap_native.WrapOptions,
        arap_native.SolveOptions,
    ):
        made = options()
        for name, parameter in inspect.signature(options).parameters.items():
            assert parameter.default == getattr(made, name)


@pytest.mark.parametrize("model", arap_native.Model.__subclasses__())
def test_every_model_is_bound_alike(model):
    """By a mesh, and by name options, what only some have, and progress at last."""
    mesh = ["rest_positions", "tets"] if model is arap_native.TetArap else ["rest_positions", "faces", "face_sizes"]
    parameters = inspect.signature(model).parameters
    names = list(parameters)
    keywords = [name for name, parameter in parameters.items() if parameter.kind is parameter.KEYWORD_ONLY]
    assert names == [*mesh, *keywords]
    assert keywords[1:-1] in ([], ["stiffness", "rigid_regions"], ["cage"])
    assert (keywords[0], keywords[-1]) == ("options", "progress")
    assert list(inspect.signature(model.begin_bind).parameters) == names[:-1]


def test_a_polygon_mesh_is_given_alike_everywhere(stub):
    meshes = [
        names[names.index("rest_positions") :][:3]
        for function in ast.walk(stub)
        if isinstance(function, ast.FunctionDef)
        and "rest_positions" in (names := [argument.arg for argument in function.args.args])
        and "tets" not in names
    ]
    assert meshes == [["rest_positions", "faces", "face_sizes"]] * len(meshes)
    assert len(meshes) >= 12


def test_names_are_public_ones():
    for name in CLASSES:
        assert repr(getattr(arap_native, name)) == f"<class 'arap_native.{name}'>"
    assert repr(arap_native.Cancelled) == "<class 'arap_native.Cancelled'>"
    assert arap_native.Cancelled.__mro__[1] is RuntimeError


def test_the_page_of_the_package_is_not_blank():
    metadata = importlib.metadata.metadata("arap-native")
    assert metadata["Author"] == "ARAP Deform contributors"
    assert metadata["Description-Content-Type"] == "text/markdown"
    page = metadata.get_payload()
    assert page.startswith("# arap_native\n")
    assert not re.findall(r"\]\((?!https?://)", page), "links to files lead nowhere there"
    classes = {
        name for name in CLASSES if not name.endswith(("Options", "Result", "Surface")) and name not in ("Job", "Model")
    }
    assert all(f"`{name}`" in page for name in classes)


def test_the_version_is_that_of_the_wheel():
    assert arap_native.__version__ == importlib.metadata.version("arap-native")


def test_the_licences_of_everything_inside_are_in_the_wheel():
    files = importlib.metadata.files("arap-native")
    texts = {file.name: file.read_text(encoding="utf-8") for file in files if "licenses" in file.parts}
    assert "GNU GENERAL PUBLIC LICENSE" in texts["LICENSE"]
    notices = texts["THIRD_PARTY_LICENSES.txt"]
    for title in (
        "Mozilla Public License Version 2.0",
        "Wenzel Jakob",
        "GCC RUNTIME LIBRARY EXCEPTION",
    ):
        assert title in notices


@pytest.mark.skipif(sys.platform != "linux", reason="other systems' wheels bring other libraries")
def test_the_wheel_brings_the_libraries_whose_licences_it_names():
    files = importlib.metadata.files("arap-native")
    brought = {re.match("[a-z]+", file.name).group() for file in files if file.parts[0] == "arap_native.libs"}
    has_own_threads = any(file.name == "zig-LICENSE" for file in files)  # a wheel of a release, built without OpenMP
    assert brought == (set() if has_own_threads else {"libgomp"})


def test_the_listing_of_the_librarys_page_works_as_written(tmp_path, monkeypatch):
    page = (ROOT / "docs" / "library.md").read_text(encoding="utf-8")
    listing = page.split("\n\n", 1)[1].split("\nEvery model")[0]
    mesh = tube()
    monkeypatch.chdir(tmp_path)
    along = (mesh.positions[:, 2] - mesh.positions[:, 2].min()) / np.ptp(mesh.positions[:, 2])
    names = {
        "positions": np.column_stack([6.0 * along, mesh.positions[:, :2]]),
        "faces": np.split(mesh.corner_vertices, np.cumsum(mesh.face_sizes)[:-1]),
    }
    exec("\n".join(line.removeprefix("    ") for line in listing.splitlines()), names)
    posed = np.load("posed.npy")
    assert posed[names["handle"]] == pytest.approx(names["positions"][names["handle"]] + [0, 0, 1])
    assert posed[names["pins"]] == pytest.approx(names["positions"][names["pins"]])
