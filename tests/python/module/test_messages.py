# SPDX-License-Identifier: GPL-3.0-or-later
"""What every function, constructor, method and attribute says of arguments that do not fit: one sentence that names
the argument."""

import inspect
from collections.abc import Callable
from typing import Any

import arap_native
import numpy as np
import pytest
from sample_meshes import ends, tube

MESH = tube()
N = len(MESH.positions)
VERTICES = ends(MESH)
CAGE = arap_native.make_cage(*MESH, cells=4)
TETS = arap_native.LatticeTets(*MESH, cube_size=0.2)
OPTIONS = [name for name in arap_native.__all__ if name.endswith("Options")]

# Nothing of the module takes one of these but where it may be anything.
WRONG = [np.zeros((500, 2)), object(), "x" * 1000, b"x", 10**400, -(10**5000), 1e300j, {}, [[1], []], True, print]


def posed() -> arap_native.SurfaceArap:
    model = arap_native.SurfaceArap(*MESH)
    model.set_constraints(VERTICES)
    return model


def held_tets() -> arap_native.TetArap:
    model = arap_native.TetArap(TETS.rest_positions, TETS.tets)
    model.set_constraints([0, 1, 2])
    return model


def made() -> dict[type, Any]:
    """An object of each class."""
    model = posed()
    objects = [
        model,
        model.solve(MESH.positions[VERTICES]),
        arap_native.SurfaceArap.begin_bind(*MESH),
        arap_native.LatticeArap(*MESH),
        arap_native.PoissonEditing(*MESH),
        arap_native.EmbeddedDeformation(*MESH),
        arap_native.CageArap(*MESH, cage=CAGE),
        held_tets(),
        TETS,
        arap_native.CageDeformation(MESH.positions, *CAGE),
        arap_native.WrapSurface(*MESH),
        arap_native.WrapDeformation(MESH.positions, *MESH),
        *(getattr(arap_native, name)() for name in OPTIONS),
    ]
    return {type(one): one for one in objects}


OBJECTS = made()
RESULT = OBJECTS[arap_native.SolveResult]


def good(owner: type | None) -> dict[str, Any]:
    """An argument that fits, by the name of the parameter, for a function, or for the constructor or a method of a
    class."""
    arguments = {
        **dict(zip(("rest_positions", "faces", "face_sizes"), MESH, strict=True)),
        "points": MESH.positions,
        "cage": CAGE,
        "vertices": VERTICES,
        "targets": MESH.positions[VERTICES],
        "positions": MESH.positions,
        "segments": np.array([[[0.0, 0.0, 1.0], [0.0, 0.0, 3.0]]]),
        "around": [VERTICES],
        "radii": [0.5],
        "of_tets": TETS.rest_positions,
        "cage_positions": CAGE[0],
        "surface_positions": MESH.positions,
        "point": 0,
        "source": CAGE,
        "moved_source": CAGE[0],
        "target": CAGE,
    }
    if owner is arap_native.TetArap:
        rest = TETS.rest_positions
        arguments |= {"rest_positions": rest, "tets": TETS.tets, "positions": rest, "targets": rest[:3]}
        arguments["vertices"] = [0, 1, 2]
    if owner is arap_native.CageDeformation:
        arguments |= {"rest_positions": CAGE[0], "faces": CAGE[1].ravel(), "face_sizes": np.full(len(CAGE[1]), 4)}
    if owner is arap_native.SolveResult:
        arguments |= {name: getattr(RESULT, name) for name in inspect.signature(owner).parameters}
    return arguments


def public_functions() -> dict[str, tuple[Callable[..., Any], type | None]]:
    found: dict[str, tuple[Callable[..., Any], type | None]] = {}
    for name in arap_native.__all__:
        member = getattr(arap_native, name)
        if inspect.isbuiltin(member):
            found[name] = member, None
    for owner, one in OBJECTS.items():
        if owner is not arap_native.Job:
            found[owner.__name__] = owner, owner
        for base in (owner, arap_native.Model) if isinstance(one, arap_native.Model) else (owner,):
            for name in vars(base):
                function = getattr(one, name)
                if not name.startswith("_") and callable(function):
                    found[f"{owner.__name__}.{name}"] = function, owner
    return found


FUNCTIONS = public_functions()


def refusal(function: Callable[..., Any], *arguments: Any, **keywords: Any) -> str:
    """What is said; "" if nothing is refused."""
    try:
        function(*arguments, **keywords)
    except (TypeError, ValueError) as error:
        text = str(error)
        assert 0 < len(text) < 300, text
        assert "\n" not in text
        return text
    return ""


def test_all_are_found():
    assert {"make_cage", "SurfaceArap", "SurfaceArap.solve", "TetArap.begin_bind", "Job.wait"} < set(FUNCTIONS)
    assert len(FUNCTIONS) > 80


def needed(name: str) -> dict[str, Any]:
    """Good arguments for what has no default."""
    function, owner = FUNCTIONS[name]
    arguments = good(owner)
    parameters = inspect.signature(function).parameters.values()
    return {p.name: arguments[p.name] for p in parameters if p.default is p.empty or p.name == "face_sizes"}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_keyword_that_is_none_of_its_own_is_named(name):
    function, _ = FUNCTIONS[name]
    for keyword in ("energy_", "no" * 1000, "\ud800"):
        assert refusal(function, **{keyword: np.zeros((500, 3))})
    said = refusal(function, colour=MESH.positions)
    assert said.startswith(f"{name.rpartition('.')[2]}() got an unexpected keyword argument 'colour'")


@pytest.mark.parametrize("name", FUNCTIONS)
def test_too_many_arguments_are_counted(name):
    function, _ = FUNCTIONS[name]
    assert "arguments by position, 40 are given" in refusal(function, *[MESH.positions] * 40)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_what_is_missing_is_named(name):
    function, _ = FUNCTIONS[name]
    for missing in needed(name).keys() - {"face_sizes"}:
        arguments = {key: value for key, value in needed(name).items() if key != missing}
        assert refusal(function, **arguments) == f"{name.rpartition('.')[2]}() is missing the argument '{missing}'"


@pytest.mark.parametrize("name", FUNCTIONS)
def test_an_argument_of_a_wrong_type_is_named(name):
    function, _ = FUNCTIONS[name]
    for parameter in inspect.signature(function).parameters:
        values = [value for value in WRONG if parameter != "around" or not isinstance(value, list)]
        said = [refusal(function, **(needed(name) | {parameter: value})) for value in values]
        assert any(said), parameter
        # A field of patches is named by itself.
        own = "patch" if parameter == "patches" else parameter
        assert all(own in text for text in said if text), [text for text in said if own not in text]


@pytest.mark.parametrize("owner", [*OBJECTS, arap_native.Model], ids=lambda owner: owner.__name__)
def test_methods_and_attributes_refuse_what_is_no_object_of_theirs(owner):
    for name, member in vars(owner).items():
        if isinstance(member, property):
            said = refusal(member.fget, MESH.positions)
        elif name in ("__repr__", "__reduce__"):
            said = refusal(getattr(owner, name), MESH.positions)
        elif name == "__eq__":
            said = refusal(getattr(owner, name), MESH.positions, None)
        elif inspect.isroutine(member) and not isinstance(member, staticmethod) and not name.startswith("_"):
            parameters = inspect.signature(getattr(owner, name)).parameters.values()
            arguments = {p.name: None for p in parameters if p.default is p.empty and p.name != "self"}
            said = refusal(getattr(owner, name), MESH.positions, **arguments)
        else:
            continue
        assert said.startswith("self is of type ndarray, expected "), (name, said)


@pytest.mark.parametrize("name", OPTIONS)
def test_options_name_the_attribute(name):
    options = getattr(arap_native, name)()
    for attribute in inspect.signature(type(options)).parameters:
        before = getattr(options, attribute)
        for value in WRONG:
            if type(value) is type(before) and value is True:
                continue
            assert refusal(setattr, options, attribute, value).startswith(attribute)
            assert refusal(type(options), **{attribute: value}).startswith(attribute)
        assert getattr(options, attribute) == before


@pytest.mark.parametrize("model", [*arap_native.Model.__subclasses__(), arap_native.CageDeformation])
def test_options_are_given_by_name_in_all_classes(model):
    by_position = [value for name, value in needed(model.__name__).items() if name != "cage"]
    keywords = {"cage": CAGE} if model is arap_native.CageArap else {}
    refused = []
    for name in OPTIONS:
        options = getattr(arap_native, name)()
        assert "options" in refusal(model, *by_position, options, **keywords)
        said = refusal(model, *by_position, options=options, **keywords)
        assert not said or said.startswith(f"options is of type {name}, expected ")
        refused += [name] if said else []
    assert len(refused) == len(OPTIONS) - 1, "but its own"


def test_an_option_given_as_an_argument_is_named():
    assert refusal(arap_native.SurfaceArap, *MESH, energy="spokes") == (
        "SurfaceArap() got an unexpected keyword argument 'energy'; it takes rest_positions, faces, face_sizes, "
        "options, stiffness, rigid_regions, progress"
    )
    assert refusal(arap_native.SurfaceArap, *MESH[:2], arap_native.Options()) == (
        "face_sizes is of type Options: options are given by name, SurfaceArap(..., options=...)"
    )
    assert refusal(arap_native.SurfaceArap, *MESH, rest_positions=MESH.positions) == (
        "SurfaceArap() got the argument 'rest_positions' twice, by its position and by its name"
    )


def test_a_number_that_does_not_fit_is_shown_with_its_bounds():
    assert refusal(arap_native.Options, threads=2**31) == (
        "threads = 2147483648 does not fit, must be from -2147483648 to 2147483647"
    )
    assert "accuracy = 1000000" in refusal(arap_native.SolveOptions, accuracy=10**400)
