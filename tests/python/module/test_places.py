# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a mesh is, and what lies about beside it, changes no result: far from the origin, with stray vertices."""

from collections.abc import Callable
from typing import Literal

import arap_native
import numpy as np
import pytest
from numpy.typing import NDArray
from sample_meshes import Mesh, ends, tube

Floats = NDArray[np.float64]
Faces = NDArray[np.int32]

# A map in metres: a mesh of five of them is a millionth of that. Doubles have a billionth of the mesh there.
FAR_AWAY = np.array([500_000.0, 5_400_000.0, 300.0])
TO_THE_END = arap_native.SolveOptions(accuracy=1e-9, max_iterations=5000)


class Case:
    """A tube in a cage.

    Attributes:
        shift: (3,) where both are.
        stray: how far away a vertex in no face lies beside each; 0: there is none.
    """

    def __init__(self, shift: Floats, stray: float = 0.0) -> None:
        self.shift, self._strays = shift, np.full((int(stray > 0.0), 3), stray)

    def with_stray(self, positions: Floats) -> Floats:
        """The positions of a mesh, moved, and of its stray vertex."""
        return np.concatenate([positions, self._strays]) + self.shift

    @property
    def mesh(self) -> Mesh:
        return tube()._replace(positions=self.with_stray(tube().positions))

    @property
    def cage(self) -> tuple[Floats, Faces]:
        positions, faces = arap_native.make_cage(*tube(), cells=6)
        return self.with_stray(positions), faces

    @property
    def bent_cage(self) -> Floats:
        return self.with_stray(bent(arap_native.make_cage(*tube(), cells=6)[0]))

    def solved(self, model: arap_native.Model) -> Floats:
        held = ends(tube())
        model.set_constraints(held)
        return model.solve(bent(tube().positions)[held] + self.shift, TO_THE_END).positions


def bent(positions: Floats) -> Floats:
    x, y, z = positions.T
    return np.column_stack([x + 0.1 * z * z, y, z - 0.3 * x * z])


def surface(case: Case) -> Floats:
    return case.solved(arap_native.SurfaceArap(*case.mesh, options=arap_native.Options(join_seams=True)))


def lattice(case: Case) -> Floats:
    return case.solved(arap_native.LatticeArap(*case.mesh, options=arap_native.LatticeOptions(join_seams=True)))


def poisson(case: Case) -> Floats:
    return case.solved(arap_native.PoissonEditing(*case.mesh))


def embedded(case: Case) -> Floats:
    return case.solved(arap_native.EmbeddedDeformation(*case.mesh))


def cage_arap(case: Case) -> Floats:
    options = arap_native.CageArapOptions(coordinates="harmonic", grid_spacing=0.05)
    return case.solved(arap_native.CageArap(*case.mesh, options=options, cage=case.cage))


def tets(case: Case) -> Floats:
    around, held = arap_native.LatticeTets(*case.mesh, cube_size=0.1), ends(tube())
    model = arap_native.TetArap(around.rest_positions, around.tets)
    model.set_constraints([], patches=around.patches(held))
    return around.embed(model.solve(bent(tube().positions)[held] + case.shift, TO_THE_END).positions)


def carried(case: Case, coordinates: Literal["mean_value", "green", "harmonic"]) -> Floats:
    options = arap_native.CageOptions(coordinates=coordinates, grid_spacing=0.05)
    model = arap_native.CageDeformation(tube().positions + case.shift, *case.cage, options=options)
    return model.deform(case.bent_cage)


def mean_values(case: Case) -> Floats:
    return carried(case, "mean_value")


def green(case: Case) -> Floats:
    return carried(case, "green")


def harmonic(case: Case) -> Floats:
    return carried(case, "harmonic")


def fitted(case: Case) -> Floats:
    model = arap_native.CageDeformation(tube().positions + case.shift, *case.cage)
    return model.fit(bent(tube().positions) + case.shift)


def transferred(case: Case) -> Floats:
    positions, faces = case.cage
    thicker = (positions - case.shift) * [2.0, 1.5, 1.0] + case.shift
    return arap_native.transfer_cage((positions, faces), case.bent_cage, (thicker, faces))


def made_cage(case: Case) -> Floats:
    return arap_native.make_cage(*case.mesh, cells=6)[0]


def wrapped(case: Case) -> Floats:
    points = tube().positions * [1.2, 0.5, 1.0] + case.shift
    return arap_native.WrapDeformation(points, *case.mesh).deform(case.with_stray(bent(tube().positions)))


MODELS = (surface, lattice, poisson, embedded, cage_arap, tets)
CARRIERS = (mean_values, green, harmonic, fitted, transferred, made_cage, wrapped)
every_case = pytest.mark.parametrize("result", [*MODELS, *CARRIERS], ids=lambda function: function.__name__)


@every_case
def test_far_from_the_origin_is_as_near_to_it(result: Callable[[Case], Floats]):
    expected = result(Case(np.zeros(3)))
    assert result(Case(FAR_AWAY)) - FAR_AWAY == pytest.approx(expected, abs=1e-6 * tube().diagonal)


@every_case
def test_a_stray_vertex_changes_nothing(result: Callable[[Case], Floats]):
    expected = result(Case(np.zeros(3)))
    found = result(Case(np.zeros(3), stray=1e4))[: len(expected)]
    assert found == pytest.approx(expected, abs=1e-9 * tube().diagonal)
