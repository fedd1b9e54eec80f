# SPDX-License-Identifier: GPL-3.0-or-later
# ruff: noqa: PYI021  the one place of the documentation: the compiled objects take theirs from here
"""As-rigid-as-possible deformation of surfaces and of what is inside them, and other models: the native solver.

All models have three acts with three costs, those of the class Model:

    model = SurfaceArap(rest_positions, faces)  # binds a mesh
    model.set_constraints(vertices)  # which vertices are pins and handles: factorizes
    result = model.solve(targets)  # where these go: result.positions; again for each motion of the handles

SurfaceArap, LatticeArap, PoissonEditing and EmbeddedDeformation take polygons, CageArap also a cage around them,
TetArap tetrahedra, as LatticeTets makes them. CageDeformation and WrapDeformation are no Model: they carry points with
a cage or a surface that is given whole, and nothing is left to solve.

Arrays are given in any dtype, byte order and memory order, or as lists. Numbers are read as float64, integers (never
floats or booleans) as int32, which they must fit; arrays that are so already, in C order, are read fastest. All are
copied, but ``out``, which is written to. Results are float64 and int32. What cannot be read raises ValueError that
states the expected and the given dtype or shape; what is no array at all TypeError. Solver failures raise RuntimeError.
Options are given by name.

Every long call releases the GIL and takes ``progress``, called with the fraction done, from 0 up to 1 at its end; it
stops the call by returning False. What it raises, and Ctrl-C, ends the call too. A call that was stopped has changed
nothing.

The methods begin_...() do the same in a thread of the module's own, which never takes the GIL, and return a Job at
once. Whoever draws a window looks at it now and then.

Different objects may work in different threads at once. One object serves one call or job at a time: a second one, from
another thread or from the first one's ``progress``, raises RuntimeError. Another number of threads adds in another
order: poses then differ by their rounding, up to 1e-6 of the size.

Options and results are data: they are compared by ==, copied and pickled. So are models, LatticeTets, CageDeformation,
WrapSurface and WrapDeformation, but for ==: what they were made of is pickled, with the constraints and positions of a
model, and bound again where it is unpickled. That takes as long as the first time, also in copies.

References:
    [SA07] Sorkine, Alexa: As-Rigid-As-Possible Surface Modeling, SGP 2007.
    [CPSS10] Chao, Pinkall, Sanan, Schroeder: A Simple Geometric Model for Elastic Deformations, SIGGRAPH 2010.
    [SSP07] Sumner, Schmid, Pauly: Embedded Deformation for Shape Manipulation, SIGGRAPH 2007.
    [YZX04] Yu, Zhou, Xu, Shi, Bao, Guo, Shum: Mesh Editing with Poisson-Based Gradient Field Manipulation,
        SIGGRAPH 2004.
    [HSL06] Huang, Shi, Liu, Zhou, Wei, Teng, Bao, Guo, Shum: Subspace Gradient Domain Mesh Deformation, SIGGRAPH
        2006.
    [JSW05] Ju, Schaefer, Warren: Mean Value Coordinates for Closed Triangular Meshes, SIGGRAPH 2005.
    [LLC08] Lipman, Levin, Cohen-Or: Green Coordinates, SIGGRAPH 2008.
    [JMD07] Joshi, Meyer, DeRose, Green, Sanocki: Harmonic Coordinates for Character Articulation, SIGGRAPH 2007.
    [CHSB10] Chen, Huang, Sun, Bao: Cage-based Deformation Transfer, Computers & Graphics 34(2), 2010.
    [SP04] Sumner, Popovic: Deformation Transfer for Triangle Meshes, SIGGRAPH 2004.
"""

from collections.abc import Callable, Sequence
from typing import Any, Generic, Literal, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str

Progress: TypeAlias = Callable[[float], bool | None]
_Result_co = TypeVar("_Result_co", covariant=True)

class Cancelled(RuntimeError):
    """A progress callback stopped a call; the object is as it was before. A solve ends with its stop_reason instead.

    A RuntimeError, but no failure: where those of the solver are handled, catch this one first.
    """

class Job(Generic[_Result_co]):
    """Work in a thread of its own, from a method begin_...(). Arrays were copied, but ``out`` of a solve.

    A job that is freed is cancelled and ends by itself. Python's exit waits for the jobs under way. A forked child has
    lost them.
    """

    @property
    def fraction(self) -> float:
        """Fraction done, in [0, 1]."""
    @property
    def is_done(self) -> bool:
        """Whether the work has ended, in whatever way. Only then may its object be used again."""
    def cancel(self) -> None:
        """Asks the work to stop, as a ``progress`` that returns False, and does not wait for it."""

    def wait(self, timeout_s: float = 1e999) -> bool:
        """Waits without the GIL until it is done, or for that many seconds; returns is_done. Hears Ctrl-C."""

    def result(self) -> _Result_co:
        """Waits, and returns or raises what the call without begin_ would.

        Raises RuntimeError if an earlier call had no memory to make the result for Python: then it is lost.
        """

class Options:
    """Options of a SurfaceArap, fixed at bind. A value that is not allowed raises ValueError when it is set."""

    energy: Literal["rotation_nodes", "spokes_and_rims", "spokes"]
    """What one rotation stands for: "rotation_nodes", a round piece of the surface, looks the same at every density of
    the mesh; "spokes_and_rims" [CPSS10] and the classic "spokes" [SA07], a vertex and its edges, get softer the finer
    the mesh."""
    rigidity_radius: float
    """For "rotation_nodes": the distance between them, as a fraction of the bounding-box diagonal, in [1e-6, 1]. Larger
    is stiffer."""
    weights: Literal["cotangent", "uniform"]
    """Edge weights: "cotangent" for surfaces; "uniform" where triangles are so bad that their shape means nothing."""
    threads: int
    """Threads of bind and solve; 0 is as many as pay at this size."""
    join_seams: bool
    """Treats vertices at the same place (an open seam) as one, so that the seam cannot open: see same_places()."""
    def __init__(
        self,
        *,
        energy: Literal["rotation_nodes", "spokes_and_rims", "spokes"] = "rotation_nodes",
        rigidity_radius: float = 0.02,
        weights: Literal["cotangent", "uniform"] = "cotangent",
        threads: int = 0,
        join_seams: bool = False,
    ) -> None: ...

class LatticeOptions:
    """Options of a LatticeArap, fixed at bind. A value that is not allowed raises ValueError when it is set."""

    cube_size: float
    """Size of the lattice's cubes as a fraction of the bounding-box diagonal, in [0.001, 1]; 0: from the shape, the
    smaller of 0.02 and a quarter of the median thickness. Coarser is faster and stiffer."""
    keep_volume: float
    """In [0, 1]: how firmly each place inside keeps its volume. 0: as the shape makes it; 1: limbs hardly get thinner,
    at about twice the iterations."""
    threads: int
    """Threads of bind and solve; 0 is as many as pay at this size."""
    join_seams: bool
    """Treats vertices at the same place as one: see Options.join_seams."""
    def __init__(
        self, *, cube_size: float = 0.0, keep_volume: float = 0.0, threads: int = 0, join_seams: bool = False
    ) -> None: ...

class EmbeddedOptions:
    """Options of an EmbeddedDeformation, fixed at bind. A value that is not allowed raises ValueError when set."""

    node_distance: float
    """Distance between nodes, as a fraction of the bounding-box diagonal, in [0.005, 1]. Smaller bends more sharply
    and is slower: half the distance makes four times as many nodes."""
    nodes: Literal["affine", "rigid"]
    """How a node may move: "affine" by any affine map, drawn to a rotation; "rigid" by a rotation and a translation,
    with half the unknowns."""
    weights: Literal["smooth", "nearest"]
    """Which nodes move a vertex: "smooth" all within twice their distance; "nearest" the four nearest, as published,
    which makes bumps."""
    rotation_weight: float
    """Of the term that draws affine nodes to rotations, in [0.1, 1000]."""
    regularization_weight: float
    """Of the term that keeps neighbours together, in [0.1, 1000]."""
    constraint_weight: float
    """Of the constraints, in [0.1, 1000]."""
    threads: int
    """Threads of bind and solve; 0 is as many as pay at this size."""
    def __init__(
        self,
        *,
        node_distance: float = 0.05,
        nodes: Literal["affine", "rigid"] = "affine",
        weights: Literal["smooth", "nearest"] = "smooth",
        rotation_weight: float = 1.0,
        regularization_weight: float = 10.0,
        constraint_weight: float = 100.0,
        threads: int = 0,
    ) -> None: ...

class PoissonOptions:
    """Options of a PoissonEditing, fixed at bind. A value that is not allowed raises ValueError when it is set."""

    propagation: Literal["harmonic", "geodesic"]
    """How the turns and scales of handles spread over the surface: "harmonic" functions know handles that touch, and
    strengths; "geodesic", by 1 / distance along the edges, falls off evenly between two handles."""
    threads: int
    """Threads of bind and solve; 0 is as many as pay at this size."""
    def __init__(self, *, propagation: Literal["harmonic", "geodesic"] = "harmonic", threads: int = 0) -> None: ...

class TetOptions:
    """Options of a TetArap, fixed at bind. A value that is not allowed raises ValueError when it is set."""

    threads: int
    """Threads of bind and solve; 0 is as many as pay at this size."""
    def __init__(self, *, threads: int = 0) -> None: ...

class CageOptions:
    """Options of a CageDeformation, fixed at bind. A value that is not allowed raises ValueError when it is set."""

    coordinates: Literal["mean_value", "green", "harmonic"]
    """How points hang on the cage: "mean_value" [JSW05] follows it closely and meets affine motions exactly, also
    outside of it; "green" [LLC08] keeps shapes, meets similarities only (translation, rotation, even scale), and is for
    points inside; "harmonic" [JMD07] is as mean values, but never below 0 (to a thousandth), and a limb follows its own
    part of the cage."""
    grid_spacing: float
    """For "harmonic": distance of the nodes of its grid, as a fraction of the cage's bounding-box diagonal, in [0.005,
    0.1]. Finer where the cage has narrow places; half of it takes about ten times as long."""
    threads: int
    """Threads of all calls; 0 is as many as pay for so many points."""
    def __init__(
        self,
        *,
        coordinates: Literal["mean_value", "green", "harmonic"] = "mean_value",
        grid_spacing: float = 0.015625,
        threads: int = 0,
    ) -> None: ...

class CageArapOptions:
    """Options of a CageArap, fixed at bind. A value that is not allowed raises ValueError when it is set."""

    energy: Literal["mesh", "cage"]
    """Whose shape resists: "mesh" the surface of the mesh; "cage" that of the cage, which costs less and keeps less of
    the volume of limbs."""
    coordinates: Literal["mean_value", "harmonic"]
    """As CageOptions.coordinates; but "green" is not linear in the cage."""
    grid_spacing: float
    """As CageOptions.grid_spacing."""
    rigidity_radius: float
    """Distance between the rotation nodes of that surface, as a fraction of the mesh's bounding-box diagonal, in [1e-6,
    1]. Larger is stiffer."""
    threads: int
    """Threads of bind and solve; 0 is as many as pay at this size."""
    def __init__(
        self,
        *,
        energy: Literal["mesh", "cage"] = "mesh",
        coordinates: Literal["mean_value", "harmonic"] = "mean_value",
        grid_spacing: float = 0.015625,
        rigidity_radius: float = 0.05,
        threads: int = 0,
    ) -> None: ...

class WrapOptions:
    """Options of a WrapDeformation, fixed at bind. A value that is not allowed raises ValueError when it is set."""

    anchors: int
    """Vertices of the surface that a point hangs on, 1 to 64; deep inside they are more."""
    stay_outside: bool
    """Whether points near the surface keep their distance from it, on the side where they were at rest."""
    threads: int
    """Threads of all calls; 0 is as many as pay for so many points."""
    def __init__(self, *, anchors: int = 12, stay_outside: bool = True, threads: int = 0) -> None: ...

class SolveOptions:
    """Options of one solve. A value that is not allowed raises ValueError when it is set."""

    initial_guess: Literal["previous", "rest", "naive_laplacian", "handle_rotations"]
    """Where the iteration starts: the last solve's positions, rest, the naive Laplacian, or the handles' rotations
    propagated over the mesh."""
    acceleration: Literal["conjugate_gradients", "none"]
    """For comparisons only: how an iteration goes on from a local and a global step. Conjugate gradients take far fewer
    iterations to the same minimum; none is plain local/global [SA07]."""
    max_iterations: int
    """Upper bound of iterations, each a global and a local step, >= 1."""
    accuracy: float
    """Stop when every vertex is within this distance of the minimizer, estimated from the last steps; a fraction of the
    bounding-box diagonal at rest. Iterations end in double precision; below 1e-7 all are in it."""
    time_limit_s: float
    """Soft limit of wall-clock time in seconds; infinity is none. A new iteration starts only if the median of the last
    ones says that it will fit; at least one runs. The next solve to the same targets continues where this one
    stopped."""
    def __init__(
        self,
        *,
        initial_guess: Literal["previous", "rest", "naive_laplacian", "handle_rotations"] = "previous",
        acceleration: Literal["conjugate_gradients", "none"] = "conjugate_gradients",
        max_iterations: int = 1000,
        accuracy: float = 1e-6,
        time_limit_s: float = 1e999,  # infinity
    ) -> None: ...

class SolveResult:
    """What a solve did. Energies include soft constraints' terms.

    They are in the square of the input's unit, those of LatticeArap and TetArap in its cube.
    """

    def __init__(
        self,
        positions: NDArray[Any],
        energy_before: float,
        energy_after: float,
        iterations: int,
        step: float,
        stop_reason: Literal["converged", "max_iterations", "time_limit", "cancelled"],
        parts_at_rest: NDArray[np.int32],
        loose_vertices: NDArray[np.int32],
        n_parts: int,
        n_parts_joined: int,
    ) -> None:
        """Of these values, for copies and for tests of what uses results."""

    @property
    def positions(self) -> NDArray[Any]:
        """(n, 3) float64, in the space and unit of the rest positions; or ``out``, float32, if that was given."""
    @property
    def energy_before(self) -> float:
        """Energy at the start of the iteration, after the initial guess."""
    @property
    def energy_after(self) -> float:
        """Energy at ``positions``."""
    @property
    def iterations(self) -> int:
        """Local/global iterations done."""
    @property
    def step(self) -> float:
        """Largest movement of a vertex in the last iteration, as a fraction of the rest diagonal."""
    @property
    def stop_reason(self) -> Literal["converged", "max_iterations", "time_limit", "cancelled"]:
        """What ended the solve."""
    @property
    def parts_at_rest(self) -> NDArray[np.int32]:
        """Connected parts without any constraint, left at rest; see Model.part_of_vertex, and n_parts_joined."""
    @property
    def loose_vertices(self) -> NDArray[np.int32]:
        """Vertices in no face or tetrahedron, left at rest unless constrained."""
    @property
    def n_parts(self) -> int:
        """Number of connected parts of the model."""
    @property
    def n_parts_joined(self) -> int:
        """How many these would be with seams joined, see Model.n_parts_joined."""

class Model:
    """A mesh bound to a model of deformation: what all classes of models have in common. Made by one of these."""

    def set_constraints(
        self,
        vertices: ArrayLike,
        strengths: ArrayLike | None = None,
        patches: tuple[ArrayLike, ArrayLike, ArrayLike] | None = None,
        segments: ArrayLike | None = None,
        *,
        progress: Progress | None = None,
    ) -> None:
        """Sets which vertices are constrained and factorizes; the same set again costs nothing.

        Args:
            vertices: (k,) integers, each at most once.
            strengths: (k,) numbers in (0, 1]; None: all hard. 1 is hard, s < 1 soft: it adds
                omega_i |p'_i - target|^2 to the energy 1/2 <p', K p'> + ..., with omega_i = K_ii s / (1 - s). At 1/3
                the target pulls at a vertex as strongly as its neighbours do. LatticeArap, EmbeddedDeformation and
                CageArap have an omega of their own, see there. A part of the mesh that nothing holds more strongly
                than 1e-9 is refused.
            patches: (offsets, vertices, weights), integers but for the weights: weighted averages held exactly; patch p
                is the entries offsets[p]:offsets[p + 1].
            segments: (s, 2, 3) numbers, head and tail of bones at rest, for models with an inside. What is around one
                moves as one body, but for some of it at each end, where bones meet.
            progress: may stop the work by returning False.

        Raises:
            ValueError: bad input, or nothing constrained. RuntimeError: cannot be factorized. Cancelled. In each
            case the former set stays current.
        """

    def begin_set_constraints(
        self,
        vertices: ArrayLike,
        strengths: ArrayLike | None = None,
        patches: tuple[ArrayLike, ArrayLike, ArrayLike] | None = None,
        segments: ArrayLike | None = None,
    ) -> Job[None]:
        """set_constraints() as a job."""

    def solve(
        self,
        targets: ArrayLike,
        options: SolveOptions | None = None,
        *,
        rotations: ArrayLike | None = None,
        progress: Progress | None = None,
        out: NDArray[np.float32] | None = None,
    ) -> SolveResult:
        """Moves the mesh towards the targets.

        Args:
            targets: (k + n_patches + 4 n_segments, 3) numbers, one row per constrained vertex, then one per patch, then
                four per segment: where its head goes, and head + l x, head + l y and head + l z, with its length l and
                the axes x, y, z.
            options: see SolveOptions.
            rotations: (k + n_patches + 4 n_segments, 3, 3) numbers, the rotation of each target's handle, for the
                initial guess "handle_rotations"; None: estimated from the targets.
            progress: may stop by returning False: then nothing has changed and stop_reason is "cancelled".
            out: (n, 3) float32, takes the positions in place of a new array: for every frame of a drag the same.

        Raises:
            ValueError: no constraints yet, bad shape, or a target that is not finite; the positions stay.
            RuntimeError: the solver failed; the positions stay. ``out`` is as it was, or the positions that stay.
        """

    def begin_solve(
        self,
        targets: ArrayLike,
        options: SolveOptions | None = None,
        *,
        rotations: ArrayLike | None = None,
        out: NDArray[np.float32] | None = None,
    ) -> Job[SolveResult]:
        """solve() as a job. Until it is done, ``out`` is written to at any time."""

    def reset(self) -> None:
        """Back to the rest positions; constraints stay."""

    def set_positions(self, positions: ArrayLike) -> None:
        """Starts the next solve from ``positions``, (n, 3), or from as near to them as the model can be."""
    @property
    def positions(self) -> NDArray[np.float64]:
        """(n, 3) float64 where the mesh is now (a copy)."""
    @property
    def n_vertices(self) -> int:
        """Number of vertices."""
    @property
    def n_parts(self) -> int:
        """Number of connected parts."""
    @property
    def n_parts_joined(self) -> int:
        """How many parts there would be if vertices at the same place were one, see same_places().

        Fewer than n_parts: the mesh has open seams, as most files have along those of a texture, and the model tears
        there. Options.join_seams closes them, or whoever makes the mesh.
        """
    @property
    def part_of_vertex(self) -> NDArray[np.int32]:
        """(n,) int32, connected part of each vertex, -1 for loose ones."""
    @property
    def loose_vertices(self) -> NDArray[np.int32]:
        """Vertices in no face or tetrahedron."""
    @property
    def n_factorizations(self) -> int:
        """Numeric factorizations since bind. New targets add none, but for an EmbeddedDeformation: its steps do."""
    @property
    def threads(self) -> int:
        """Threads in use."""

class SurfaceArap(Model):
    """As-rigid-as-possible deformation of a polygon surface. Construction binds the mesh."""

    def __init__(
        self,
        rest_positions: ArrayLike,
        faces: ArrayLike,
        face_sizes: ArrayLike | None = None,
        *,
        options: Options | None = None,
        stiffness: ArrayLike | None = None,
        rigid_regions: ArrayLike | None = None,
        progress: Progress | None = None,
    ) -> None:
        """Binds a mesh.

        Args:
            rest_positions: (n, 3) numbers.
            faces: (m, k) integers, a row of vertices per face: (m, 3) triangles, (m, 4) quads; or a list of lists, for
                faces of different lengths; or (c,) integers, one face after the other, with ``face_sizes``.
            face_sizes: (f,) integers, the length of each face; None if ``faces`` has a row or list per face.
            options: see Options.
            stiffness: (n,) numbers, 1e-12 to 1e12, scales the cell of a vertex; 1 is normal.
            rigid_regions: (n,) integers, region of each vertex, negative for none; a region moves as one rigid body.
            progress: may stop the bind by returning False.

        Raises:
            ValueError: bad shape, dtype, index, or a position that is not finite (names the vertex).
            Cancelled: ``progress`` returned False.
        """

    @staticmethod
    def begin_bind(
        rest_positions: ArrayLike,
        faces: ArrayLike,
        face_sizes: ArrayLike | None = None,
        *,
        options: Options | None = None,
        stiffness: ArrayLike | None = None,
        rigid_regions: ArrayLike | None = None,
    ) -> Job[SurfaceArap]:
        """Begins to bind a mesh: the constructor as a job."""

    def patch_around(
        self, vertices: ArrayLike, radius: float = 0.0
    ) -> tuple[NDArray[np.int32], NDArray[np.float64], NDArray[np.float64]]:
        """A round patch of the surface, for set_constraints.

        Held as a point handle it pulls a smooth hill, the same at every density of the mesh; a constrained vertex
        would pull a spike.

        Args:
            vertices: (k,) integers, what the patch lies around.
            radius: as a fraction of the rest bounding-box diagonal; 0: 1.5 times Options.rigidity_radius.

        Returns:
            (m,) int32 its vertices, (m,) float64 their weights, of sum 1, and (3,) float64 the average of their rest
            positions, which is the target that moves nothing.

        Raises:
            ValueError: no vertices, an index out of range, a vertex in no face, or a bad radius.
        """

    def begin_patches(
        self, around: Sequence[ArrayLike], radii: ArrayLike
    ) -> Job[list[tuple[NDArray[np.int32], NDArray[np.float64], NDArray[np.float64]]]]:
        """patch_around() for many, as a job: patch i lies around the vertices around[i] and has radius radii[i]."""

    def energy(self, positions: ArrayLike) -> float:
        """Energy that a solve minimizes, at ``positions``, (n, 3), without constraint terms.

        Rotations are the best for these positions, and parts that hard vertices cut from each other have their own;
        each rigid region uses the best-fit rotation of its vertices. Vertices joined by Options.join_seams are
        represented by the first one.
        """

    def energy_gradient(self, positions: ArrayLike) -> NDArray[np.float64]:
        """(n, 3) float64 gradient of energy() at ``positions``; 0 at joined vertices other than the first."""

class LatticeArap(Model):
    """As-rigid-as-possible deformation of a surface and what is inside it. Construction binds the mesh.

    A limb that is twisted or bent keeps its volume, which a surface alone does not. The unknowns are the control points
    of a lattice around the mesh, so an iteration costs the same at every density of the mesh. Constrained vertices pull
    the lattice; what it leaves of hard ones is spread over two cubes around them, so these are exactly at their
    targets. A closed part inside of another one and turned the other way is its void, and one part with it. Parts
    without an inside, as sheets, are posed as surfaces beside the others.

    Strengths: omega_v = s / (1 - s) times the area at the vertex over the size of a cube, or more if a cube has little
    area that is constrained.
    """

    def __init__(
        self,
        rest_positions: ArrayLike,
        faces: ArrayLike,
        face_sizes: ArrayLike | None = None,
        *,
        options: LatticeOptions | None = None,
        stiffness: ArrayLike | None = None,
        rigid_regions: ArrayLike | None = None,
        progress: Progress | None = None,
    ) -> None:
        """Binds a mesh.

        Args:
            rest_positions, faces, face_sizes, rigid_regions, progress: as for SurfaceArap.
            options: see LatticeOptions.
            stiffness: (n,) numbers, 1e-12 to 1e12; a cube is as stiff as the vertices in it. 1 is normal.

        Raises:
            ValueError: as for SurfaceArap; or there are no faces, or they have no size.
            Cancelled: ``progress`` returned False.
        """

    @staticmethod
    def begin_bind(
        rest_positions: ArrayLike,
        faces: ArrayLike,
        face_sizes: ArrayLike | None = None,
        *,
        options: LatticeOptions | None = None,
        stiffness: ArrayLike | None = None,
        rigid_regions: ArrayLike | None = None,
    ) -> Job[LatticeArap]:
        """Begins to bind a mesh: the constructor as a job."""

    def segments_outside(self, segments: ArrayLike) -> NDArray[np.int32]:
        """Indices of the segments that can hold nothing, as they pass through nothing that is inside.

        Args:
            segments: (s, 2, 3) numbers, as for set_constraints(), which refuses them.
        """
    def cube_corners(self) -> NDArray[np.float64]:
        """(8 n_cubes, 3) float64 where the corners of the cubes are now, in the space of the rest positions.

        Corner 4 x + 2 y + z of a cube is at its low (0) or high (1) end along each axis. Cubes in which several pieces
        move by themselves are there as often.
        """
    @property
    def n_control_points(self) -> int:
        """Number of control points of the lattice: the unknowns of a solve."""
    @property
    def has_inside(self) -> bool:
        """Whether any part has an inside. If none has, a surface model bends the mesh better."""
    @property
    def sheets(self) -> NDArray[np.int32]:
        """Parts without an inside, which are posed as surfaces; ascending. None, if no part has an inside."""
    @property
    def cube_size(self) -> float:
        """Edge of a cube of the lattice, in the unit of the rest positions."""

class PoissonEditing(Model):
    """Poisson mesh editing of a polygon surface [YZX04]. Construction binds the mesh.

    Each face takes a turn and a scale from the handles, and the surface is the one whose gradients are nearest to those
    of the faces. The model is linear in positions: a solve is one step, in double precision, and its energies are 0. It
    is as good as the turns: handles that are moved without a turn pull cones.

    In solve(), ``rotations`` are the linear parts of the motions of the targets' handles since rest: a rotation times a
    uniform scale > 0. Without them rotations are estimated from the targets, and nothing grows. A handle turns on from
    the last solve by less than half a turn, so in steps it may turn as far as it likes; any initial guess but
    "previous" turns the short way from rest. The result follows from that alone: set_positions() only shows positions
    until the next solve.
    """

    def __init__(
        self,
        rest_positions: ArrayLike,
        faces: ArrayLike,
        face_sizes: ArrayLike | None = None,
        *,
        options: PoissonOptions | None = None,
        progress: Progress | None = None,
    ) -> None:
        """Binds a mesh.

        Args:
            rest_positions, faces, face_sizes, progress: as for SurfaceArap.
            options: see PoissonOptions.

        Raises:
            ValueError: as for SurfaceArap.
            Cancelled: ``progress`` returned False.
        """

    @staticmethod
    def begin_bind(
        rest_positions: ArrayLike,
        faces: ArrayLike,
        face_sizes: ArrayLike | None = None,
        *,
        options: PoissonOptions | None = None,
    ) -> Job[PoissonEditing]:
        """Begins to bind a mesh: the constructor as a job."""

class EmbeddedDeformation(Model):
    """A graph of nodes [SSP07], each with a map of its own, that moves a polygon surface. Construction binds the mesh.

    In solve() an iteration is a Newton step, and energies are pure numbers. Hard constraints are met as well as
    the nodes can. ``rotations`` are not used: a graph finds them.

    Strengths: in place of omega is s / (1 - s) times the number of nodes over that of what is constrained, so a denser
    mesh is held no more strongly.
    """

    def __init__(
        self,
        rest_positions: ArrayLike,
        faces: ArrayLike,
        face_sizes: ArrayLike | None = None,
        *,
        options: EmbeddedOptions | None = None,
        progress: Progress | None = None,
    ) -> None:
        """Binds a mesh.

        Args:
            rest_positions, faces, face_sizes, progress: as for SurfaceArap.
            options: see EmbeddedOptions.

        Raises:
            ValueError: as for SurfaceArap, or a mesh without faces or size.
            Cancelled: ``progress`` returned False.
        """

    @staticmethod
    def begin_bind(
        rest_positions: ArrayLike,
        faces: ArrayLike,
        face_sizes: ArrayLike | None = None,
        *,
        options: EmbeddedOptions | None = None,
    ) -> Job[EmbeddedDeformation]:
        """Begins to bind a mesh: the constructor as a job."""
    @property
    def n_nodes(self) -> int:
        """Number of nodes."""
    @property
    def nodes(self) -> NDArray[np.float64]:
        """(n_nodes, 3) float64 where the nodes are at rest."""

class CageArap(Model):
    """As-rigid-as-possible deformation of a cage by vertices of the mesh that hangs on it. Construction binds both.

    A subspace, as in [HSL06], with rotations of nodes.
    The unknowns are the vertices of the cage, and rotations those of nodes, so an iteration costs the same at every
    density of the mesh. The cage brings hard vertices as near to their targets as it can, a region to about a
    thousandth of the size. Loose vertices stay, and so do connected shells of the cage that no constrained vertex
    feels, or that are around parts without constraints. What is in them is at rest with harmonic coordinates. With mean
    values it may move a little, as it feels all shells.

    Strengths: omega_v = k a_v s / (1 - s), k the mean of K_ii, a_v the area at the vertex over that at a vertex of the
    cage. If connected constrained vertices have less than 1 of these together, each gets as much more. For hard ones
    s / (1 - s) is 1e4.
    """

    def __init__(
        self,
        rest_positions: ArrayLike,
        faces: ArrayLike,
        face_sizes: ArrayLike | None = None,
        *,
        options: CageArapOptions | None = None,
        cage: tuple[ArrayLike, ...],
        progress: Progress | None = None,
    ) -> None:
        """Binds a mesh and its cage.

        Args:
            rest_positions, faces, face_sizes, progress: as for SurfaceArap.
            options: see CageArapOptions.
            cage: its rest_positions and faces, as make_cage() returns them and CageDeformation takes them.

        Raises:
            ValueError: as for SurfaceArap and CageDeformation, or a mesh without faces or size.
            Cancelled: ``progress`` returned False.
        """

    @staticmethod
    def begin_bind(
        rest_positions: ArrayLike,
        faces: ArrayLike,
        face_sizes: ArrayLike | None = None,
        *,
        options: CageArapOptions | None = None,
        cage: tuple[ArrayLike, ...],
    ) -> Job[CageArap]:
        """Begins to bind a mesh and its cage: the constructor as a job."""

    def cage_positions(self) -> NDArray[np.float64]:
        """(n_cage_vertices, 3) float64 where the cage is now."""
    @property
    def n_cage_vertices(self) -> int:
        """Number of vertices of the cage: the unknowns of a solve."""

class TetArap(Model):
    """As-rigid-as-possible deformation of tetrahedra. Construction binds the mesh.

    The energy is the sum over the tetrahedra of volume times stiffness times |F - R|^2, with F the deformation gradient
    and R the rotation nearest to it. A point inside of a tetrahedron is constrained as a patch: its four vertices with
    the point's barycentric coordinates as weights.
    """

    def __init__(
        self,
        rest_positions: ArrayLike,
        tets: ArrayLike,
        *,
        options: TetOptions | None = None,
        stiffness: ArrayLike | None = None,
        rigid_regions: ArrayLike | None = None,
        progress: Progress | None = None,
    ) -> None:
        """Binds a mesh.

        Args:
            rest_positions: (n, 3) numbers.
            tets: (m, 4) integers, the vertices of each tetrahedron; either orientation serves.
            options: see TetOptions.
            stiffness: (n,) numbers, 1e-12 to 1e12; a tetrahedron has the geometric mean of its vertices'. 1 is normal.
            rigid_regions, progress: as for SurfaceArap.

        Raises:
            ValueError: bad shape, dtype or position; or a tetrahedron that names a vertex that is not there or
                one twice, or has no volume (names the tetrahedron).
            Cancelled: ``progress`` returned False.
        """

    @staticmethod
    def begin_bind(
        rest_positions: ArrayLike,
        tets: ArrayLike,
        *,
        options: TetOptions | None = None,
        stiffness: ArrayLike | None = None,
        rigid_regions: ArrayLike | None = None,
    ) -> Job[TetArap]:
        """Begins to bind a mesh: the constructor as a job."""

    def energy(self, positions: ArrayLike) -> float:
        """Energy that a solve minimizes, at ``positions``, (n, 3), without constraint terms.

        Rotations are the best for these positions; each rigid region uses the best-fit rotation of its vertices.
        """

    def energy_gradient(self, positions: ArrayLike) -> NDArray[np.float64]:
        """(n, 3) float64 gradient of energy() at ``positions``."""

class LatticeTets:
    """Tetrahedra around a surface and what is inside it, for a TetArap to pose the surface by.

    They are the cubes of the lattice of LatticeArap, cut into six each. What is not connected within a cube has a copy
    of it each, as two fingers have, and cubes that hang together share corners. Cubes at the surface are whole. A
    closed part inside of another one and turned the other way is its void.

        tets = LatticeTets(rest_positions, faces)
        model = TetArap(tets.rest_positions, tets.tets)
        model.set_constraints([], patches=tets.patches(vertices))
        posed = tets.embed(model.solve(targets).positions)  # targets: of these vertices
    """

    def __init__(
        self,
        rest_positions: ArrayLike,
        faces: ArrayLike,
        face_sizes: ArrayLike | None = None,
        cube_size: float = 0.0,
        *,
        progress: Progress | None = None,
    ) -> None:
        """Cuts the inside of a surface.

        Args:
            rest_positions, faces, face_sizes: the surface, n vertices, as for SurfaceArap.
            cube_size: as LatticeOptions.cube_size.
            progress: may stop the work by returning False.

        Raises:
            ValueError: bad arrays or ``cube_size``, too many cubes, or a mesh without faces or size.
            Cancelled: ``progress`` returned False.
        """

    def patches(self, vertices: ArrayLike) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.float64]]:
        """The constraints that hold vertices of the surface, for ``patches`` of Model.set_constraints().

        Args:
            vertices: (k,) integers, of the surface. Each makes a patch of four vertices of its tetrahedron.

        Returns:
            (k + 1,) int32 offsets, (4 k,) int32 vertices of the tetrahedra, and (4 k,) float64 weights.

        Raises:
            ValueError: bad array, or a vertex that is loose or not there.
        """

    def embed(self, of_tets: ArrayLike) -> NDArray[np.float64]:
        """Where the vertices of the surface are when those of the tetrahedra are here.

        Args:
            of_tets: (t, 3) numbers, in place of ``rest_positions``.

        Returns:
            (n, 3) float64; loose vertices are at rest.

        Raises:
            ValueError: bad shape or dtype.
        """
    @property
    def rest_positions(self) -> NDArray[np.float64]:
        """(t, 3) float64, the vertices of the tetrahedra at rest."""
    @property
    def tets(self) -> NDArray[np.int32]:
        """(k, 4) int32, the vertices of each tetrahedron, all of positive volume."""
    @property
    def tet_of_vertex(self) -> NDArray[np.int32]:
        """(n,) int32, of each vertex of the surface the tetrahedron that it is in; -1: it is loose."""
    @property
    def coordinates(self) -> NDArray[np.float64]:
        """(n, 4) float64 where it is in there: barycentric coordinates, >= 0, of sum 1; all 0 if it is loose."""

class CageDeformation:
    """Points that a coarse closed mesh around them carries. Construction computes their weights.

    No Model, since nothing is constrained or solved: deform() is given all vertices of the cage, and a point goes to
    the sum of its weights times their positions, with "green" also times the stretched normals of the triangles. Calls
    may run in several threads at once.
    """

    def __init__(
        self,
        points: ArrayLike,
        rest_positions: ArrayLike,
        faces: ArrayLike,
        face_sizes: ArrayLike | None = None,
        *,
        options: CageOptions | None = None,
        progress: Progress | None = None,
    ) -> None:
        """Computes the weights of points in a cage.

        Args:
            points: (n, 3) numbers at rest, at least one.
            rest_positions, faces, face_sizes: the cage, arrays as for SurfaceArap: triangles and quads,
                closed, oriented alike, outwards or inwards.
            options: see CageOptions.
            progress: may stop the work by returning False.

        Raises:
            ValueError: bad arrays; a cage that is not closed, not oriented alike, or has other faces; with "green"
                and "harmonic" points that are not inside (says how many and which).
            Cancelled: ``progress`` returned False.
        """

    @staticmethod
    def begin_bind(
        points: ArrayLike,
        rest_positions: ArrayLike,
        faces: ArrayLike,
        face_sizes: ArrayLike | None = None,
        *,
        options: CageOptions | None = None,
    ) -> Job[CageDeformation]:
        """Begins to compute the weights: the constructor as a job."""

    def deform(self, cage_positions: ArrayLike, *, out: NDArray[np.float32] | None = None) -> NDArray[Any]:
        """Where the points go when the cage's vertices are at these positions.

        Args:
            cage_positions: (n_vertices, 3) numbers.
            out: (n, 3) float32, takes the result in place of a new array: for every frame of a drag the same.

        Returns:
            (n, 3) float64; or ``out``.

        Raises:
            ValueError: bad shape, a position that is not finite, or a result beyond single precision in ``out``.
        """

    def fit(
        self, positions: ArrayLike, smoothness: float = 1e-6, *, progress: Progress | None = None
    ) -> NDArray[np.float64]:
        """Where the cage must be so that the points come to these positions, as well as they can [CHSB10].

        Args:
            positions: (n, 3).
            smoothness: 1e-12 to 1, how smoothly the cage moves where points tell little.
            progress: may stop the work by returning False.

        Returns:
            (n_vertices, 3) float64.

        Raises:
            ValueError: bad shape, a position that is not finite, a bad smoothness; or "green", which is not linear in
                the cage.
            Cancelled: ``progress`` returned False.
        """

    def weights(self, point: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The weights of a point, in double.

        Returns:
            (n_vertices,) float64 of the cage's vertices, of sum 1, and (n_triangles,) float64 of its triangles, in the
            unit of the positions; the latter is empty but with "green".
        """
    @property
    def n_points(self) -> int:
        """Number of points."""
    @property
    def n_vertices(self) -> int:
        """Number of vertices of the cage."""
    @property
    def n_triangles(self) -> int:
        """Number of triangles of the cage; a convex quad has four, those of both diagonals, with half a weight each."""
    @property
    def threads(self) -> int:
        """Threads in use."""

class WrapSurface:
    """A surface at rest, ready for binds of points: what they need of it, whatever the points are.

    That is nearly all of the work where the surface is large and the points are few, so many binds to one surface share
    it. It takes about 150 bytes a vertex; what is bound needs only the mesh of it, 50 bytes a vertex, to be pickled.
    Calls may run in several threads at once.
    """

    def __init__(
        self,
        rest_positions: ArrayLike,
        faces: ArrayLike,
        face_sizes: ArrayLike | None = None,
        *,
        threads: int = 0,
        progress: Progress | None = None,
    ) -> None:
        """Prepares a surface, which may be any, see WrapDeformation.

        Args:
            rest_positions, faces, face_sizes: the surface at rest, arrays as for SurfaceArap.
            threads: 0: as many as pay for so many vertices.
            progress: may stop the work by returning False.

        Raises:
            ValueError: bad arrays or ``threads``.
            Cancelled: ``progress`` returned False.
            MemoryError: there is less memory than that needs.
        """

    @staticmethod
    def begin_prepare(
        rest_positions: ArrayLike,
        faces: ArrayLike,
        face_sizes: ArrayLike | None = None,
        *,
        threads: int = 0,
    ) -> Job[WrapSurface]:
        """Begins to prepare a surface: the constructor as a job."""

    def bind(
        self,
        points: ArrayLike,
        *,
        options: WrapOptions | None = None,
        piece_of_point: ArrayLike | None = None,
        progress: Progress | None = None,
    ) -> WrapDeformation:
        """Binds points to the surface: what WrapDeformation() does, arguments and errors as there."""

    def begin_bind(
        self, points: ArrayLike, *, options: WrapOptions | None = None, piece_of_point: ArrayLike | None = None
    ) -> Job[WrapDeformation]:
        """Begins to bind points: bind() as a job, which keeps the surface as long as it needs it."""

    @property
    def n_vertices(self) -> int:
        """Number of vertices of the surface."""

class WrapDeformation:
    """Points that a deforming surface carries along: clothes, hair cards, eyes. Construction binds them.

    A wrap deformer: a point follows the surface's vertices near it, how they move, turn and grow. Deep inside, as on a
    bone, these are the walls all around. The surface may be any: open, not manifold, turned inside out, loose
    triangles, points without faces. No Model, since nothing is constrained or solved: deform() is given all vertices of
    the surface. Calls may run in several threads at once.
    """

    def __init__(
        self,
        points: ArrayLike,
        rest_positions: ArrayLike,
        faces: ArrayLike,
        face_sizes: ArrayLike | None = None,
        *,
        options: WrapOptions | None = None,
        piece_of_point: ArrayLike | None = None,
        progress: Progress | None = None,
    ) -> None:
        """Binds points to a surface that nothing else is bound to, see also WrapSurface.

        Args:
            points: (n, 3) numbers at rest, at least one; on the surface, inside or outside of it.
            rest_positions, faces, face_sizes: the surface at rest, arrays as for SurfaceArap.
            options: see WrapOptions.
            piece_of_point: (n,) integers. Points of the same number >= 0 move as one rigid body, the best fit to what
                they would do without; -1: the point bends with the surface, as all do by default.
            progress: may stop the work by returning False.

        Raises:
            ValueError: bad arrays.
            Cancelled: ``progress`` returned False.
            MemoryError: there is less memory than that needs.
        """

    @staticmethod
    def begin_bind(
        points: ArrayLike,
        rest_positions: ArrayLike,
        faces: ArrayLike,
        face_sizes: ArrayLike | None = None,
        *,
        options: WrapOptions | None = None,
        piece_of_point: ArrayLike | None = None,
    ) -> Job[WrapDeformation]:
        """Begins to bind points: the constructor as a job."""

    def deform(self, surface_positions: ArrayLike, *, out: NDArray[np.float32] | None = None) -> NDArray[Any]:
        """Where the points go when the surface's vertices are at these positions.

        Args:
            surface_positions: (n_vertices, 3) numbers.
            out: (n, 3) float32, takes the result in place of a new array: for every frame of a drag the same.

        Returns:
            (n, 3) float64; or ``out``.

        Raises:
            ValueError: bad shape, a position that is not finite, or a result beyond single precision in ``out``.
        """
    @property
    def n_points(self) -> int:
        """Number of points."""
    @property
    def n_vertices(self) -> int:
        """Number of vertices of the surface."""
    @property
    def n_pieces(self) -> int:
        """Number of rigid pieces."""
    @property
    def threads(self) -> int:
        """Threads in use."""

def make_cage(
    rest_positions: ArrayLike,
    faces: ArrayLike,
    face_sizes: ArrayLike | None = None,
    cells: int = 10,
    *,
    progress: Progress | None = None,
) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """A cage of quads around a mesh, for a CageDeformation: the outside of the cubes that it is in or near, smoothed.

    The mesh may be open, or of several parts; holes smaller than a cube are closed. It is nowhere nearer to the cage
    than a seventh of a cube.

    Args:
        rest_positions, faces, face_sizes, progress: the mesh, as for SurfaceArap.
        cells: cubes along the longest side of its bounding box, 2 to 50.

    Returns:
        (c, 3) float64 positions and (f, 4) int32 faces.

    Raises:
        ValueError: bad arrays or ``cells``, or a mesh without faces or size.
        Cancelled: ``progress`` returned False.
    """

def begin_make_cage(
    rest_positions: ArrayLike,
    faces: ArrayLike,
    face_sizes: ArrayLike | None = None,
    cells: int = 10,
) -> Job[tuple[NDArray[np.float64], NDArray[np.int32]]]:
    """Begins to make a cage: make_cage() as a job."""

def transfer_cage(
    source: tuple[ArrayLike, ...],
    moved_source: ArrayLike,
    target: tuple[ArrayLike, ...],
    *,
    progress: Progress | None = None,
) -> NDArray[np.float64]:
    """Moves a cage as another one of the same faces has been moved: deformation transfer [SP04].

    After CageDeformation.fit() of a shape and before CageDeformation.deform() of another, it carries a deformation from
    the one to the other. Where the source has turned, grown and moved, the target turns and grows alike, about its own
    middle, which moves as the source's does. Of several shells each goes as its own in the source: one that did not
    move stays.

    Args:
        source: the cage at rest, as for CageArap.
        moved_source: (n_vertices, 3).
        target: the cage to move, at rest, of the same faces.
        progress: may stop the work by returning False.

    Returns:
        (n_vertices, 3) float64 of the target.

    Raises:
        ValueError: bad arrays, other faces, or no faces.
        Cancelled: ``progress`` returned False.
    """

def same_places(
    rest_positions: ArrayLike,
    faces: ArrayLike,
    face_sizes: ArrayLike | None = None,
    *,
    progress: Progress | None = None,
) -> NDArray[np.int32]:
    """For each vertex the first one at its place, (n,) int32.

    Along each axis a vertex may differ from the first one by 1e-6 of the bounding-box diagonal, or by what rounds so
    far from the origin: single precision, if all coordinates are that. So a seam that an import has torn is one place.
    The arguments are those of SurfaceArap.
    """
