// SPDX-License-Identifier: GPL-3.0-or-later

// Bad input: each test plants one fault in a mesh and compares with the same mesh without it.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::InitialGuess;
using arap::SolverError;
using arap::SolveResult;
using arap::StopReason;
using arap::SurfaceArap;

MeshData sound_mesh() { return bumpy_sphere(2); }

Task sound_task() { return bend_task(sound_mesh(), default_bend(sound_mesh())); }

std::vector<Model> cotangent_models() { return {all_models()[0], all_models()[2]}; }

/// An edge away from the handles: a face (a, b, c) and the corner d on the other side of ab.
struct Edge {
  int a, b, c, d, face, other_face;
};

bool has_edge(const std::vector<int>& face, int from, int to) {
  for (size_t k = 0; k < face.size(); ++k)
    if (face[k] == from && face[(k + 1) % face.size()] == to) return true;
  return false;
}

Edge some_edge(const MeshData& triangles) {
  const Task task = bend_task(triangles, {});
  const auto& held = task.constraints.vertices;
  const auto is_free = [&](int v) { return std::find(held.begin(), held.end(), v) == held.end(); };
  for (int f = triangles.n_faces() / 3; f < triangles.n_faces(); ++f) {
    const auto& face = triangles.faces[f];
    if (!std::all_of(face.begin(), face.end(), is_free)) continue;
    for (int g = 0; g < triangles.n_faces(); ++g) {
      const auto& other = triangles.faces[g];
      if (!has_edge(other, face[1], face[0])) continue;
      const int sum = std::accumulate(other.begin(), other.end(), 0);
      return {face[0], face[1], face[2], sum - face[0] - face[1], f, g};
    }
  }
  throw std::runtime_error("no free edge");
}

/// Edge ab cut at `t`, on the side of c only; a triangle (a, b, m) fills what is left, lower by `lift` than the face.
MeshData with_sliver(const MeshData& mesh, double lift = 0, double t = .5) {
  MeshData result = mesh;
  const auto [a, b, c, d, face, other] = some_edge(mesh);
  const Vector3 ab = mesh.vertices[b] - mesh.vertices[a];
  const Vector3 ac = mesh.vertices[c] - mesh.vertices[a];
  const Vector3 inward = (ac - ab * ab.dot(ac) / ab.squaredNorm()).normalized();
  const int m = result.add_vertex(mesh.vertices[a] + t * ab + lift * inward);
  result.faces[face] = {a, m, c};
  result.faces.insert(result.faces.end(), {{m, b, c}, {a, b, m}});
  return result;
}

/// The same vertex on a proper edge: what one cut edge changes in any case.
MeshData with_cut_edge(const MeshData& mesh, double t = .5) {
  MeshData result = with_sliver(mesh, 0, t);
  const Edge edge = some_edge(mesh);
  const int m = mesh.n_vertices();
  result.faces.pop_back();
  result.faces[edge.other_face] = {edge.b, m, edge.d};
  result.faces.push_back({m, edge.a, edge.d});
  return result;
}

/// Vertex a doubled, the second one `away`; the faces on one side of the edges to b and to another neighbour take it,
/// and two triangles fill the edge between the two.
MeshData with_doubled_vertex(const MeshData& mesh, const Vector3& away) {
  MeshData result = mesh;
  const Edge edge = some_edge(mesh);
  const int twin = result.add_vertex(mesh.vertices[edge.a] + away);
  // Walk about a from b: the first two faces go to the twin.
  int from = edge.b;
  for (int step = 0; step < 2; ++step) {
    for (auto& face : result.faces) {
      if (!has_edge(face, edge.a, from)) continue;
      const int next = *std::find_if(face.begin(), face.end(), [&](int v) { return v != edge.a && v != from; });
      std::replace(face.begin(), face.end(), edge.a, twin);
      from = next;
      break;
    }
  }
  result.faces.push_back({edge.a, edge.b, twin});
  result.faces.push_back({twin, from, edge.a});
  return result;
}

/// Expects that a mesh with such a task stays at rest, follows a rigid motion, and lowers the energy step by step.
void expect_sound(const MeshData& mesh, const std::string& what, const Task& task = sound_task()) {
  const Positions rest = mesh.positions();
  const double size = mesh.diagonal();
  Random random(101);
  for (const Model& model : all_models()) {
    const std::string name = what + " " + model.name();
    const Task at_rest = rigid_task(mesh, task.constraints, {});
    EXPECT_LT(max_distance(solve_once(mesh, at_rest, iterations(10), model.options()).positions, rest), 1e-9 * size)
        << name;
    const RigidMotion motion = random.rigid_motion(2, size);
    const Task moved = rigid_task(mesh, task.constraints, motion);
    const SolveResult turned = solve_once(mesh, moved, iterations(1, InitialGuess::kHandleRotations), model.options());
    EXPECT_LT(max_distance(turned.positions, motion.apply(rest)), 1e-6 * size) << name;
    SurfaceArap solver(mesh.mesh(), model.options());
    solver.set_constraints(task.constraints);
    expect_energy_never_rises(solver, mesh, task.targets, 30, name);
    const SolveResult result = solver.solve(task.targets, iterations(1));
    EXPECT_TRUE(result.positions.allFinite()) << name;
    EXPECT_GE(result.energy_after, 0) << name;
  }
}

/// Largest move of a vertex of the sound mesh that the fault causes, as a fraction of the diagonal.
/// With a radius of the same length: a fault may change the box.
double deviation(const MeshData& faulty, const MeshData& sound, const Task& task, arap::Options options) {
  const Positions expected = solve_once(sound, task, to_accuracy(1e-9), options).positions;
  options.rigidity_radius *= sound.mesh().diagonal() / faulty.mesh().diagonal();
  const Positions result = solve_once(faulty, task, to_accuracy(1e-9), options).positions;
  return max_distance(result.topRows(expected.rows()), expected) / sound.diagonal();
}

double deviation(const MeshData& faulty, const arap::Options& options) {
  return deviation(faulty, sound_mesh(), sound_task(), options);
}

Positions bent(const MeshData& mesh, const arap::Options& options = {}) {
  return solve_once(mesh, sound_task(), to_accuracy(1e-9), options).positions;
}

// Degenerate triangles.

TEST(Robustness, SliverThatNothingElseHangsOnIsAsIfItWereNotThere) {
  const MeshData mesh = sound_mesh();
  const Edge edge = some_edge(mesh);
  for (const double t : {0.0, .5, .1, 1.7}) {
    MeshData faulty = mesh;
    const int m = faulty.add_vertex(mesh.vertices[edge.a] + t * (mesh.vertices[edge.b] - mesh.vertices[edge.a]));
    faulty.faces.push_back({edge.a, edge.b, m});
    expect_sound(faulty, "hanging sliver");
    for (const Model& model : cotangent_models()) {
      EXPECT_LT(deviation(faulty, model.options()), 1e-5) << model.name() << t;
      const Positions p = bent(faulty, model.options());
      EXPECT_LT((p.row(m) - (1 - t) * p.row(edge.a) - t * p.row(edge.b)).norm(), .1) << "it goes with its edge";
    }
  }
}

TEST(Robustness, SliverOverVerticesThatAreHeldAnywayIsAsIfItWereNotThere) {
  // Three vertices of a straight row.
  const MeshData mesh = bar(2, Faces::kTriangles);
  const Task task = bend_task(mesh, {rotation_about({.2, 1, 0}, .7), {-.1, .1, .4}});
  MeshData faulty = mesh;
  faulty.faces.push_back({faulty.vertex_at({-.5, 0, .5}), faulty.vertex_at({0, 0, .5}), faulty.vertex_at({.5, 0, .5})});
  ASSERT_EQ(faulty.n_vertices(), mesh.n_vertices());
  for (const Model& model : cotangent_models())
    EXPECT_LT(deviation(faulty, mesh, task, model.options()), 5e-5) << model.name();
}

/// Expects that the sound mesh with the fault moves about as with the same cut without a fault, and that the vertex of
/// the cut, the last one, goes with the middle of a and b.
void expect_no_crack(const MeshData& faulty, const MeshData& proper, const std::string& what, int a, int b) {
  expect_sound(faulty, what);
  for (const Model& model : cotangent_models()) {
    EXPECT_LT(deviation(faulty, model.options()), 1e-6 + 2 * deviation(proper, model.options())) << model.name();
    const Positions p = bent(faulty, model.options());
    EXPECT_LT((p.row(faulty.n_vertices() - 1) - (p.row(a) + p.row(b)) / 2).norm(), 1e-3 * sound_mesh().diagonal())
        << model.name();
  }
}

TEST(Robustness, SliverInPlaceOfAnEdgeHoldsTheSurfaceTogether) {
  const MeshData mesh = sound_mesh();
  const Edge edge = some_edge(mesh);
  expect_no_crack(with_sliver(mesh), with_cut_edge(mesh), "sliver in the surface", edge.a, edge.b);
}

TEST(Robustness, ZeroLengthEdgeIsAsIfItWereOneVertex) {
  const MeshData mesh = sound_mesh();
  const Edge edge = some_edge(mesh);
  const MeshData proper = with_doubled_vertex(mesh, .3 * (mesh.vertices[edge.c] - mesh.vertices[edge.a]));
  expect_no_crack(with_doubled_vertex(mesh, Vector3::Zero()), proper, "zero-length edge", edge.a, edge.a);
}

TEST(Robustness, NeedleIsAsAnExactlyDegenerateTriangle) {
  const MeshData mesh = sound_mesh();
  const double tiny = 1e-9 * mesh.diagonal();
  for (const double lift : {tiny, -tiny}) {
    for (const Model& model : cotangent_models()) {
      EXPECT_LT(max_distance(bent(with_sliver(mesh, lift), model.options()), bent(with_sliver(mesh), model.options())),
                1e-6)
          << model.name();
      EXPECT_LT(max_distance(bent(with_doubled_vertex(mesh, {lift, 0, lift}), model.options()),
                             bent(with_doubled_vertex(mesh, Vector3::Zero()), model.options())),
                5e-5)
          << model.name();
    }
  }
}

TEST(Robustness, NeedlesOfEveryHeightAreSound) {
  for (double lift = 1e-15; lift < .1; lift *= 40) {
    const MeshData flat = with_sliver(sound_mesh(), lift);
    const MeshData sharp = with_doubled_vertex(sound_mesh(), {lift, 0, lift});
    for (const MeshData& mesh : {flat, sharp}) {
      expect_sound(mesh, "needle of height " + std::to_string(lift));
      for (const Model& model : cotangent_models()) EXPECT_LT(deviation(mesh, model.options()), .01) << lift;
    }
  }
}

TEST(Robustness, SliverOfAPolygonIsSound) {
  // A quad with two corners at one place, one that is a line, one with a corner in the middle of a side; beside each a
  // face that names a vertex twice.
  const MeshData mesh = bumpy_sphere(2);
  const Edge edge = some_edge(mesh);
  for (const double t : {0.0, .5, 1.0}) {
    MeshData faulty = mesh;
    const int m = faulty.add_vertex((1 - t) * mesh.vertices[edge.a] + t * mesh.vertices[edge.b]);
    faulty.faces.insert(faulty.faces.end(), {{edge.a, m, edge.b, edge.c}, {edge.c, edge.c, edge.d}});
    expect_sound(faulty, "polygon with degenerate fans");
  }
}

TEST(Robustness, CornersOnStraightSidesAreSound) {
  const MeshData mesh = sheet_with_collinear_corners();
  const Task task = bend_task(mesh, default_bend(mesh));
  expect_sound(mesh, mesh.name, task);
  for (const Model& model : all_models())
    EXPECT_EQ(solve_once(mesh, task, to_accuracy(1e-8), model.options()).stop_reason, StopReason::kConverged);
}

TEST(Robustness, MeshOfZeroSizeIsSound) {
  const MeshData point{"point", std::vector<Vector3>(6, Vector3(1, 2, 3)), {{0, 1, 2}, {2, 1, 3}, {3, 4, 5}}};
  MeshData line = point;
  for (int v = 0; v < 6; ++v) line.vertices[v] = Vector3(v, 2 * v, 0);
  for (const MeshData& mesh : {point, line}) {
    for (const Model& model : all_models()) {
      Task task = hold(mesh, {0});
      EXPECT_LT(max_distance(solve_once(mesh, task, iterations(3), model.options()).positions, mesh.positions()), 1e-9);
      task.add(5, mesh.vertices[5] + Vector3(0, 0, 1));
      const SolveResult result = solve_once(mesh, task, iterations(3), model.options());
      EXPECT_TRUE(result.positions.allFinite());
      EXPECT_LT((result.positions.row(5) - task.targets.row(1)).norm(), 1e-12);
    }
  }
}

TEST(Robustness, ManyNegativeCotangentsBendAsGoodTrianglesDo) {
  // The same vertices; each triangle reaches two columns further along in the next ring.
  const int n = 16;
  const int layers = 10;
  const MeshData good = open_cylinder(n, layers, Faces::kTriangles);
  MeshData sheared = good;
  sheared.faces.clear();
  for (int layer = 0; layer < layers; ++layer) {
    for (int i = 0; i < n; ++i) {
      const int a = layer * n + i;
      const int b = layer * n + (i + 1) % n;
      const int above = (layer + 1) * n + (i + 2) % n;
      sheared.faces.push_back({a, b, above});
      sheared.faces.push_back({b, (layer + 1) * n + (i + 3) % n, above});
    }
  }
  const Task task = bend_task(good, {rotation_about({1, .3, 0}, .5), {0, .2, 0}});
  for (const Model& model : cotangent_models())
    EXPECT_LT(deviation(sheared, good, task, model.options()), .05) << model.name();
}

// Faces that should not be there.

/// Expects that a fault is sound and moves the others by no more than `most`, and with rotation nodes
/// `most_with_nodes`.
void expect_hardly_felt(const MeshData& faulty, const std::string& what, double most, double most_with_nodes) {
  expect_sound(faulty, what);
  for (const Model& model : all_models())
    EXPECT_LT(deviation(faulty, model.options()), model.energy == arap::Energy::kRotationNodes ? most_with_nodes : most)
        << what << model.name();
}

// One face too many changes the choice of nodes, too, which alone moves up to 4e-3 where edges are as long as the
// radius.
constexpr double kMost = 3e-3;
constexpr double kMostWithNodes = 1e-2;

TEST(Robustness, FlippedFacesChangeNothing) {
  MeshData faulty = sound_mesh();
  for (size_t f = 0; f < faulty.faces.size(); f += 7) std::reverse(faulty.faces[f].begin(), faulty.faces[f].end());
  expect_hardly_felt(faulty, "flipped", 1e-9, 1e-9);
}

TEST(Robustness, EveryFaceTwiceIsTheMeshItself) {
  MeshData faulty = sound_mesh();
  const auto faces = faulty.faces;
  faulty.faces.insert(faulty.faces.end(), faces.begin(), faces.end());
  expect_hardly_felt(faulty, "every face twice", 1e-6, 1e-6);
}

TEST(Robustness, DuplicateFaceIsHardlyFelt) {
  const std::vector<int> face = sound_mesh().faces[some_edge(sound_mesh()).face];
  for (const std::vector<int>& copy : {face, std::vector<int>(face.rbegin(), face.rend())}) {
    MeshData faulty = sound_mesh();
    faulty.faces.push_back(copy);
    expect_hardly_felt(faulty, "duplicate", kMost, kMostWithNodes);
  }
}

TEST(Robustness, NonManifoldEdgeIsHardlyFelt) {
  // A fin on an edge, which three faces share then; it goes along as it is.
  MeshData faulty = sound_mesh();
  const Edge edge = some_edge(faulty);
  const int tip = faulty.add_vertex(1.3 * faulty.vertices[edge.a]);
  faulty.faces.push_back({edge.a, edge.b, tip});
  expect_hardly_felt(faulty, "fin", kMost, kMostWithNodes);
}

TEST(Robustness, NonManifoldVertexIsHardlyFelt) {
  // A tetrahedron stands on one vertex.
  MeshData faulty = sound_mesh();
  const int a = some_edge(faulty).a;
  const Vector3 out = faulty.vertices[a];
  const int b = faulty.add_vertex(1.3 * out);
  const int c = faulty.add_vertex(1.2 * out + Vector3(.1, 0, 0));
  const int d = faulty.add_vertex(1.2 * out + Vector3(0, .1, .05));
  faulty.faces.insert(faulty.faces.end(), {{a, b, c}, {a, c, d}, {a, d, b}, {b, d, c}});
  expect_hardly_felt(faulty, "tetrahedron on a vertex", kMost, kMostWithNodes);
  EXPECT_LT(off_rigid(faulty.positions(), bent(faulty), {a, b, c, d}), .02) << "it goes along";
}

// What nothing holds.

TEST(Robustness, LooseVerticesStayAndAreReported) {
  MeshData faulty = sound_mesh();
  const int n = faulty.n_vertices();
  faulty.add_vertex({3, 3, 3});
  faulty.add_vertex({0, 0, 0});
  const SolveResult result = solve_once(faulty, sound_task(), to_accuracy(1e-9));
  EXPECT_EQ(result.loose_vertices, (std::vector<int>{n, n + 1}));
  EXPECT_TRUE(result.parts_at_rest.empty()) << "loose vertices are no part";
  EXPECT_LT(max_distance(result.positions.bottomRows(2), faulty.positions().bottomRows(2)), 1e-12);
  EXPECT_LT(max_distance(result.positions.topRows(n), bent(sound_mesh())), 1e-7);
}

TEST(Robustness, LooseVertexThatIsConstrainedGoesToItsTarget) {
  MeshData faulty = sound_mesh();
  const int n = faulty.n_vertices();
  faulty.add_vertex({3, 3, 3});
  faulty.add_vertex({4, 3, 3});
  Task task = sound_task();
  task.add(n, {5, 6, 7});
  task.add(n + 1, {5, 6, 8}, .5);
  for (const InitialGuess guess :
       {InitialGuess::kRest, InitialGuess::kNaiveLaplacian, InitialGuess::kHandleRotations}) {
    const SolveResult result = solve_once(faulty, task, iterations(3, guess));
    EXPECT_LT((result.positions.row(n) - Eigen::RowVector3d(5, 6, 7)).norm(), 1e-12);
    EXPECT_TRUE(result.positions.allFinite()) << "nothing scales a soft pull on a loose vertex";
  }
}

TEST(Robustness, MeshWithoutFacesFollowsOnlyWhereConstrained) {
  const MeshData mesh{"points", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {}};
  Task task;
  task.add(1, {5, 5, 5});
  const SolveResult result = solve_once(mesh, task, {});
  EXPECT_EQ(result.stop_reason, StopReason::kConverged);
  EXPECT_LT(max_distance(result.positions, Positions{{0, 0, 0}, {5, 5, 5}, {0, 1, 0}}), 1e-12);
  EXPECT_EQ(result.loose_vertices, (std::vector<int>{0, 1, 2}));
}

TEST(Robustness, PartWithoutConstraintStaysAndIsReported) {
  const MeshData sound = sound_mesh();
  const int n = sound.n_vertices();
  const MeshData faulty =
      join(sound, transformed(sound, [](const Vector3& p) { return Vector3(.5 * p + Vector3(0, 4, 0)); }));
  Task both_held = sound_task();
  for (int v = n; v < 2 * n; ++v) both_held.add(v, faulty.vertices[v]);
  for (const Model& model : all_models()) {
    const SolveResult result = solve_once(faulty, sound_task(), to_accuracy(1e-9), model.options());
    EXPECT_EQ(result.parts_at_rest, std::vector<int>{1});
    EXPECT_LT(max_distance(result.positions.bottomRows(n), faulty.positions().bottomRows(n)), 1e-12);
    // Not with the part alone: the nodes of that are others, as radii are parts of the diagonal of the whole mesh.
    const Positions expected = solve_once(faulty, both_held, to_accuracy(1e-9), model.options()).positions;
    EXPECT_LT(max_distance(result.positions, expected), 1e-6) << model.name();
  }
}

TEST(Robustness, PartThatLosesItsConstraintGoesBackToRest) {
  const MeshData mesh = two_spheres(1);
  const int n = mesh.n_vertices() / 2;
  Task both = hold(mesh, {0, 1, n, n + 1});
  both.targets.array() += 1;
  SurfaceArap solver(mesh.mesh());
  solver.set_constraints(both.constraints);
  EXPECT_TRUE(solver.solve(both.targets, iterations(3)).parts_at_rest.empty());
  const Task one = hold(mesh, {0, 1});
  solver.set_constraints(one.constraints);
  const SolveResult result = solver.solve(one.targets, iterations(3));
  EXPECT_EQ(result.parts_at_rest, std::vector<int>{1});
  EXPECT_LT(max_distance(result.positions.bottomRows(n), mesh.positions().bottomRows(n)), 1e-12);
}

// Large numbers.

TEST(Robustness, SolveWhoseNumbersOverflowStopsAtOnceAndKeepsTheLastGoodPose) {
  // Steps are in single precision.
  Task task = sound_task();
  task.add(some_edge(sound_mesh()).a, {0, 0, 1e60});
  for (const InitialGuess guess : {InitialGuess::kPrevious, InitialGuess::kRest}) {
    SurfaceArap solver(sound_mesh().mesh());
    solver.set_constraints(task.constraints);
    const Positions before = solver.positions();
    int n_iterations = 0;
    const auto count = [&](double) { return ++n_iterations > 0; };
    expect_error<SolverError>([&] { solver.solve(task.targets, iterations(100, guess), {}, count); },
                              {"no longer finite"});
    EXPECT_LE(n_iterations, 2);
    EXPECT_TRUE(solver.positions() == before);
  }
}

TEST(Robustness, HugeTargetThatNothingFreeHangsOnIsFollowed) {
  Task task = sound_task();
  task.targets(3, 2) = 1e60;
  const SolveResult result = solve_once(sound_mesh(), task, iterations(3));
  EXPECT_EQ(result.positions(task.constraints.vertices[3], 2), 1e60);
  EXPECT_TRUE(result.positions.allFinite());
}

TEST(Robustness, SolveEndsWhereFarTargetsLeaveNoDigitsForTheAccuracy) {
  for (const double distance : {1e3, 1e6, 1e12, 1e29}) {
    Task task = sound_task();
    task.targets.bottomRows(1).array() += distance;
    const SolveResult result = solve_once(sound_mesh(), task, to_accuracy(1e-9));
    EXPECT_EQ(result.stop_reason, StopReason::kConverged) << distance;
    EXPECT_LT(result.step, 1e-12 * distance);
  }
}

// Scale and place.

TEST(Robustness, ScaleOnlyScalesTheResult) {
  for (const MeshData& mesh : {sound_mesh(), with_sliver(sound_mesh())})
    for (const Model& model : all_models()) {
      const SolveResult expected = solve_once(mesh, sound_task(), iterations(30), model.options());
      const int n_iterations = solve_once(mesh, sound_task(), {}, model.options()).iterations;
      for (const double scale : {1e-5, 1e5, 1e-30, 1e30}) {
        const MeshData scaled = transformed(mesh, [&](const Vector3& p) { return Vector3(scale * p); });
        Task task = sound_task();
        task.targets *= scale;
        const SolveResult result = solve_once(scaled, task, iterations(30), model.options());
        EXPECT_LT(max_distance(result.positions / scale, expected.positions), 1e-9) << model.name() << scale;
        EXPECT_NEAR(result.energy_after / scale / scale, expected.energy_after, 1e-9 * expected.energy_after);
        EXPECT_NEAR(result.step, expected.step, 1e-9) << "a fraction of the diagonal";
        EXPECT_EQ(solve_once(scaled, task, {}, model.options()).iterations, n_iterations) << model.name() << scale;
      }
    }
}

TEST(Robustness, FarFromTheOriginIsTheSameThere) {
  const MeshData mesh = sound_mesh();
  const Vector3 far = Vector3(1, -1, .5).normalized() * 1e4 * mesh.diagonal();
  const MeshData faulty = transformed(mesh, [&](const Vector3& p) { return Vector3(p + far); });
  Task task = sound_task();
  task.targets.rowwise() += far.transpose();
  for (const Model& model : all_models()) {
    const SolveResult result = solve_once(faulty, task, iterations(30), model.options());
    const SolveResult expected = solve_once(mesh, sound_task(), iterations(30), model.options());
    const Positions back = result.positions.rowwise() - far.transpose();
    EXPECT_LT(max_distance(back, expected.positions), 1e-8 * mesh.diagonal()) << model.name();
    EXPECT_NEAR(result.energy_after, expected.energy_after, 1e-7 * expected.energy_after) << model.name();
  }
}

// Open seams.

TEST(Robustness, OpenSeamHeldTogetherIsTheClosedMesh) {
  const MeshData closed = open_cylinder(10, 6, Faces::kTriangles);
  const MeshData open = cylinder_with_open_seam(10, 6, Faces::kTriangles);
  const Task task = bend_task(closed, {rotation_about({1, .4, .3}, .8), {.1, .3, 0}});
  for (const Model& model : all_models()) {
    arap::Options options = model.options();
    const Positions expected = solve_once(closed, task, iterations(40), options).positions;
    const Positions cracked = solve_once(open, task, iterations(40), options).positions;
    options.join_seams = true;
    const Positions joined = solve_once(open, task, iterations(40), options).positions;
    ASSERT_EQ(joined.rows(), open.n_vertices());
    EXPECT_LT(max_distance(joined.topRows(closed.n_vertices()), expected), 1e-9) << model.name();
    double crack = 0;
    for (int layer = 0; layer <= 6; ++layer) {
      EXPECT_EQ(joined.row(10 * layer), joined.row(70 + layer)) << model.name();
      crack = std::max(crack, (cracked.row(10 * layer) - cracked.row(70 + layer)).norm());
    }
    EXPECT_GT(crack, 1e-3) << model.name() << ": otherwise the test tests nothing";
  }
}

TEST(Robustness, ASeamThatRoundingHasTornApartIsJoinedToo) {
  const MeshData closed = open_cylinder(10, 6, Faces::kTriangles);
  MeshData open = cylinder_with_open_seam(10, 6, Faces::kTriangles);
  const double torn = 5e-7 * closed.diagonal();
  for (int v = closed.n_vertices(); v < open.n_vertices(); ++v) open.vertices[v] += torn * Vector3(1, -1, 1);
  const Task task = bend_task(closed, {rotation_about({1, .4, .3}, .8), {.1, .3, 0}});
  const Positions expected = solve_once(closed, task, iterations(40)).positions;
  const Positions joined = solve_once(open, task, iterations(40), {.join_seams = true}).positions;
  EXPECT_LT(max_distance(joined.topRows(closed.n_vertices()), expected), 1e-9);
}

TEST(Robustness, BothSidesOfAJoinedSeamMayBeConstrained) {
  const MeshData closed = open_cylinder(10, 6, Faces::kTriangles);
  const MeshData open = cylinder_with_open_seam(10, 6, Faces::kTriangles);
  Task task = bend_task(closed, {rotation_about({1, .4, .3}, .8), {.1, .3, 0}});
  const arap::Options options{.join_seams = true};
  const auto& held = task.constraints.vertices;
  const auto entry = std::find(held.begin(), held.end(), 0) - held.begin();
  ASSERT_LT(entry, task.constraints.n_targets());
  Task both = task;
  both.add(70, task.targets.row(entry).transpose());
  for (const InitialGuess guess :
       {InitialGuess::kRest, InitialGuess::kHandleRotations, InitialGuess::kNaiveLaplacian}) {
    const Positions expected = solve_once(closed, task, iterations(20, guess)).positions;
    const Positions result = solve_once(open, both, iterations(20, guess), options).positions;
    EXPECT_LT(max_distance(result.topRows(closed.n_vertices()), expected), 1e-8);
  }
}

TEST(Robustness, JoinedSeamWithStiffnessAndRegions) {
  const MeshData open = cylinder_with_open_seam(10, 6, Faces::kTriangles);
  const Task task = bend_task(open, {rotation_about({1, .4, .3}, .5), {.1, .2, 0}});
  const arap::Options options{.join_seams = true};
  arap::VertexProperties properties;
  properties.stiffness.assign(static_cast<size_t>(open.n_vertices()), 2);
  properties.rigid_regions.assign(static_cast<size_t>(open.n_vertices()), -1);
  std::vector<int> inside;
  for (int v = 0; v < open.n_vertices(); ++v) {
    if (std::abs(open.vertices[v].z()) > .4) continue;
    properties.rigid_regions[v] = 0;
    inside.push_back(v);
  }
  const Positions result = solve_once(open, task, iterations(20), options, properties).positions;
  EXPECT_LT(off_rigid(open.positions(), result, inside), 1e-6);
}

// A large mesh.

TEST(Robustness, MeshOf173ThousandVertices) {
  const MeshData mesh =
      grid(415, Faces::kQuads, [](double x, double y) { return .1 * std::sin(5 * x) * std::cos(4 * y); });
  ASSERT_GT(mesh.n_vertices(), 173000);
  const RigidMotion motion = Random(102).rigid_motion(1, 1);
  std::vector<int> held = extreme_vertices(mesh.positions(), 0, .02);
  const std::vector<int> others = extreme_vertices(mesh.positions(), 0, -.02);
  held.insert(held.end(), others.begin(), others.end());
  const Task task = rigid_task(mesh, hold(mesh, held).constraints, motion);
  const SolveResult result = solve_once(mesh, task, iterations(1, InitialGuess::kHandleRotations));
  EXPECT_LT(max_distance(result.positions, motion.apply(mesh.positions())), 1e-6 * mesh.diagonal());
}

}  // namespace
}  // namespace arap_test
