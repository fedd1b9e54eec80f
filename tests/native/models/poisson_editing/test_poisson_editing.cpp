// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/poisson_editing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "arap/error.h"
#include "models/poisson_editing/dense_poisson.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::PoissonEditing;
using arap::PoissonOptions;
using arap::Propagation;
using arap::SolveResult;
using Handles = std::vector<PoissonHandle>;

constexpr double kDegree = std::numbers::pi / 180;

/// The constraints of handles, with their turns and scales.
struct PoissonTask {
  Task task;
  std::vector<Matrix3> rotations;

  explicit PoissonTask(const Handles& handles) {
    for (const PoissonHandle& handle : handles)
      for (size_t k = 0; k < handle.vertices.size(); ++k) {
        task.add(handle.vertices[k], handle.targets.row(static_cast<Eigen::Index>(k)));
        rotations.push_back(handle.scale * handle.rotation());
      }
  }
};

PoissonHandle moved(const MeshData& mesh, const std::vector<int>& vertices, const Vector3& turn = Vector3::Zero(),
                    const Vector3& shift = Vector3::Zero(), double scale = 1) {
  PoissonHandle handle{vertices, rows(mesh.positions(), vertices), turn, scale};
  const Eigen::RowVector3d center = handle.targets.colwise().mean();
  handle.targets = scale * (handle.targets.rowwise() - center) * handle.rotation().transpose();
  handle.targets.rowwise() += center + shift.transpose();
  return handle;
}

std::vector<int> end_of(const MeshData& mesh, double fraction) {
  return extreme_vertices(mesh.positions(), longest_axis(mesh.positions()), fraction, 3);
}

/// The low end stays, the far end moves.
Handles bend(const MeshData& mesh, const Vector3& turn, const Vector3& shift = Vector3::Zero(), double scale = 1) {
  return {moved(mesh, end_of(mesh, .2)), moved(mesh, end_of(mesh, -.2), turn, shift, scale)};
}

Handles some_bend(const MeshData& mesh, double scale = 1) {
  return bend(mesh, Vector3(.9, -.6, .4), mesh.diagonal() * Vector3(.1, .05, -.1), scale);
}

/// All of them in pieces that are farther apart than an edge.
std::vector<MeshData> meshes() {
  return {bar(3, Faces::kQuads),
          bar(2, Faces::kTriangles),
          cylinder(8, 8),
          open_cylinder(9, 8, Faces::kTriangles),
          bumpy_sphere(2),
          quad_sphere(4),
          l_prism(6),
          star_prism(5, 6),
          moebius_strip(20, 2),
          sheared_cylinder(12, 8),
          book(5, Faces::kQuads),
          two_spheres(1)};
}

const std::vector<Propagation> kPropagations = {Propagation::kHarmonic, Propagation::kGeodesic};

PoissonOptions by(Propagation propagation, int threads = 0) {
  PoissonOptions options;
  options.propagation = propagation;
  options.threads = threads;
  return options;
}

SolveResult solve(const MeshData& mesh, const PoissonTask& given, const PoissonOptions& options = {}) {
  PoissonEditing solver(mesh.mesh(), options);
  solver.set_constraints(given.task.constraints);
  return solver.solve(given.task.targets, {}, given.rotations);
}

TEST(PoissonEditing, RestsAndMovesWithOneSimilarity) {
  Random random(5);
  for (const MeshData& mesh : all_small_meshes())
    for (const Propagation propagation : kPropagations)
      for (const double scale : {1.0, 1.7, .3}) {
        const RigidMotion motion = random.rigid_motion(3, mesh.diagonal());
        const auto apply = [&](const Positions& p) { return Positions(scale * motion.apply(p)); };
        Task task = hold(mesh, end_of(mesh, .2));
        PoissonEditing solver(mesh.mesh(), by(propagation));
        solver.set_constraints(task.constraints);
        EXPECT_LT(max_distance(solver.solve(task.targets).positions, mesh.positions()), 1e-12 * mesh.diagonal());
        const std::vector<Matrix3> rotations(static_cast<size_t>(task.targets.rows()), scale * motion.rotation);
        const Positions result = solver.solve(apply(task.targets), {}, rotations).positions;
        const std::vector<int> parts = solver.solve(task.targets).parts_at_rest;
        if (!parts.empty()) continue;
        EXPECT_LT(max_distance(result, apply(mesh.positions())), 1e-9 * mesh.diagonal()) << mesh.name;
      }
}

TEST(PoissonEditing, TranslatesExactly) {
  for (const MeshData& mesh : meshes())
    for (const Propagation propagation : kPropagations) {
      const Eigen::RowVector3d shift = mesh.diagonal() * Eigen::RowVector3d(3, -2, 5);
      PoissonTask given(bend(mesh, Vector3::Zero()));
      given.task.targets.rowwise() += shift;
      const Positions expected = mesh.positions().rowwise() + shift;
      EXPECT_LT(max_distance(solve(mesh, given, by(propagation)).positions, expected), 1e-9 * mesh.diagonal());
      given.rotations.clear();
      EXPECT_LT(max_distance(solve(mesh, given, by(propagation)).positions, expected), 1e-9 * mesh.diagonal());
    }
}

TEST(PoissonEditing, WithoutTurnsItIsHarmonicInterpolationOfTheDisplacement) {
  for (const MeshData& mesh : meshes()) {
    Handles handles = some_bend(mesh);
    for (PoissonHandle& handle : handles) handle.turn.setZero();
    Positions shift = Positions::Zero(mesh.n_vertices(), 3);
    for (const PoissonHandle& handle : handles)
      for (size_t k = 0; k < handle.vertices.size(); ++k)
        shift.row(handle.vertices[k]) =
            handle.targets.row(static_cast<Eigen::Index>(k)) - mesh.positions().row(handle.vertices[k]);
    const Positions expected = mesh.positions() + DensePoisson(mesh).with_values(handles, shift, 0 * shift);
    EXPECT_LT(max_distance(solve(mesh, PoissonTask(handles)).positions, expected), 1e-9 * mesh.diagonal()) << mesh.name;
  }
}

/// Without a turn the mesh keeps the gradients it had, and does not stretch evenly.
TEST(PoissonEditing, DoesNotReproduceAffineMaps) {
  const MeshData mesh = cylinder(8, 8);
  Matrix3 A;
  A << 1.5, .4, 0, .1, .7, .3, -.2, .1, 1.2;
  Handles handles = bend(mesh, Vector3::Zero());
  for (PoissonHandle& handle : handles) handle.targets = handle.targets * A.transpose();
  const Positions result = solve(mesh, PoissonTask(handles)).positions;
  EXPECT_GT(max_distance(result, mesh.positions() * A.transpose()), .05 * mesh.diagonal());
}

TEST(PoissonEditing, AgreesWithTheDenseReference) {
  for (const MeshData& mesh : meshes())
    for (const double scale : {1.0, 1.4}) {
      const Handles handles = some_bend(mesh, scale);
      const DensePoisson dense(mesh);
      const PoissonTask given(handles);
      EXPECT_LT(max_distance(solve(mesh, given).positions, dense.solve(handles, dense.harmonic_weights(handles))),
                1e-9 * mesh.diagonal())
          << mesh.name;
      // Distances are in single precision.
      EXPECT_LT(max_distance(solve(mesh, given, by(Propagation::kGeodesic)).positions,
                             dense.solve(handles, dense.geodesic_weights(handles))),
                1e-6 * mesh.diagonal())
          << mesh.name;
    }
}

/// Handles that are many, or touch with turns of their own, are spread in another way.
TEST(PoissonEditing, AgreesWithTheDenseReferenceForManyHandles) {
  const MeshData mesh = bumpy_sphere(2);
  const DensePoisson dense(mesh);
  Random random(6);
  for (const int step : {7, 40}) {
    Handles handles;
    for (int v = 0; v + 1 < mesh.n_vertices(); v += step)
      handles.push_back(moved(mesh, {v, v + 1}, random.vector(1), random.vector(.3), random.uniform(.8, 1.3)));
    EXPECT_LT(max_distance(solve(mesh, PoissonTask(handles)).positions,
                           dense.solve(handles, dense.harmonic_weights(handles))),
              1e-9);
  }
  const std::vector<int> tip = end_of(mesh, -.2);
  const auto middle = tip.begin() + std::ssize(tip) / 2;
  Handles touching{moved(mesh, end_of(mesh, .2)), moved(mesh, {tip.begin(), middle}, Vector3(.5, 0, 0)),
                   moved(mesh, {middle, tip.end()}, Vector3(0, -.4, .3), Vector3(0, .2, 0))};
  EXPECT_LT(max_distance(solve(mesh, PoissonTask(touching)).positions,
                         dense.solve(touching, dense.harmonic_weights(touching))),
            1e-9);
}

TEST(PoissonEditing, MeetsConstraints) {
  for (const MeshData& mesh : meshes())
    for (const Propagation propagation : kPropagations) {
      const PoissonTask given(some_bend(mesh));
      const Positions result = solve(mesh, given, by(propagation)).positions;
      EXPECT_LT(max_distance(values_of(given.task.constraints, result), given.task.targets), 1e-14 * mesh.diagonal());
    }
}

TEST(PoissonEditing, PatchesAreMetAndSoftVerticesGiveWay) {
  const MeshData mesh = bumpy_sphere(2);
  for (const Propagation propagation : kPropagations) {
    double before = 0;
    for (const double strength : {.05, .5, .95, 1.0}) {
      Task task = hold(mesh, end_of(mesh, .2));
      task.constraints.strengths.assign(task.constraints.vertices.size(), 1);
      const int tip = end_of(mesh, -.01).back();
      task.add(tip, mesh.vertices[tip] + Vector3(0, 0, .5), strength);
      const std::vector<int> members = extreme_vertices(mesh.positions(), 1, .05, 3);
      const std::vector<double> weights(members.size(), 1 / static_cast<double>(members.size()));
      const Vector3 target = average(mesh.positions(), members, weights) + Vector3(.1, .2, 0);
      task.add_patch(members, weights, target);
      PoissonEditing solver(mesh.mesh(), by(propagation));
      solver.set_constraints(task.constraints);
      const Positions result = solver.solve(task.targets).positions;
      EXPECT_LT((average(result, members, weights) - target).norm(), 1e-10);
      const double way = result(tip, 2) - mesh.vertices[tip][2];
      EXPECT_GT(way, before) << strength;
      before = way;
    }
    EXPECT_NEAR(before, .5, 1e-12);
  }
}

/// What twists the far end of a bar.
Handles twisted(const MeshData& mesh, double degrees) { return bend(mesh, degrees * kDegree * Vector3::UnitX()); }

TEST(PoissonEditing, TwistsBeyondHalfATurnInSteps) {
  const MeshData mesh = bar(4, Faces::kQuads);
  const DensePoisson dense(mesh);
  const Eigen::MatrixXd weights = dense.harmonic_weights(twisted(mesh, 0));
  for (const bool is_given : {true, false}) {
    PoissonEditing solver(mesh.mesh());
    solver.set_constraints(PoissonTask(twisted(mesh, 0)).task.constraints);
    const auto solve_to = [&](double degrees, arap::InitialGuess guess) {
      const PoissonTask given(twisted(mesh, degrees));
      return solver.solve(given.task.targets, iterations(1, guess), is_given ? given.rotations : std::vector<Matrix3>())
          .positions;
    };
    const auto off = [&](const Positions& result, double degrees) {
      return max_distance(result, dense.solve(twisted(mesh, degrees), weights));
    };
    for (const int degrees : {90, 180, 270, 360, 450, 540, 420, 300, 270})
      EXPECT_LT(off(solve_to(degrees, arap::InitialGuess::kPrevious), degrees), 1e-9) << degrees;
    EXPECT_LT(off(solve_to(270, arap::InitialGuess::kRest), -90), 1e-9);
    EXPECT_LT(off(solve_to(180 + 60, arap::InitialGuess::kPrevious), -120), 1e-9);
    solver.reset();
    EXPECT_LT(max_distance(solver.positions(), mesh.positions()), 1e-15);
    EXPECT_LT(off(solve_to(270, arap::InitialGuess::kPrevious), -90), 1e-9);
    EXPECT_EQ(solver.n_factorizations(), 1);
  }
}

/// A handle that comes to a twisted bar turns with what is there.
TEST(PoissonEditing, ANewHandleTakesTheTurnOfItsPlace) {
  const MeshData mesh = bar(4, Faces::kQuads);
  PoissonEditing solver(mesh.mesh());
  Handles handles = twisted(mesh, 0);
  for (int degrees = 0; degrees <= 450; degrees += 90) {
    handles = twisted(mesh, degrees);
    const PoissonTask given(handles);
    solver.set_constraints(given.task.constraints);
    solver.solve(given.task.targets, {}, given.rotations);
  }
  std::vector<int> middle;
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (std::abs(mesh.vertices[v][0]) < 1e-9) middle.push_back(v);
  handles.push_back(moved(mesh, middle, 225 * kDegree * Vector3::UnitX()));
  const PoissonTask given(handles);
  solver.set_constraints(given.task.constraints);
  const Positions result = solver.solve(given.task.targets, {}, given.rotations).positions;
  const DensePoisson dense(mesh);
  EXPECT_LT(max_distance(result, dense.solve(handles, dense.harmonic_weights(handles))), 1e-9);
}

TEST(PoissonEditing, TurnsAreEstimatedFromTargets) {
  for (const MeshData& mesh : {bumpy_sphere(2), cylinder(10, 8), bar(3, Faces::kQuads)})
    for (const Propagation propagation : kPropagations) {
      PoissonTask given(some_bend(mesh));
      const Positions expected = solve(mesh, given, by(propagation)).positions;
      given.rotations.clear();
      EXPECT_LT(max_distance(solve(mesh, given, by(propagation)).positions, expected), 1e-9 * mesh.diagonal());
    }
}

/// Geodesic: of two handles that touch, what is nearer to one has its turn.
TEST(PoissonEditing, HandlesMayTouch) {
  const MeshData mesh = bar(3, Faces::kQuads);
  std::vector<int> left;
  std::vector<int> right;
  for (int v = 0; v < mesh.n_vertices(); ++v) {
    if (std::abs(mesh.vertices[v][0]) > .2 * mesh.diagonal()) continue;
    (mesh.vertices[v][0] < 0 ? left : right).push_back(v);
  }
  const RigidMotion turn{rotation_about(Vector3::UnitX(), .7), Vector3::Zero()};
  PoissonTask given({moved(mesh, left), moved(mesh, right, .7 * Vector3::UnitX())});
  for (const Propagation propagation : kPropagations) {
    const Positions result = solve(mesh, given, by(propagation)).positions;
    for (int v = 0; v < mesh.n_vertices(); ++v) {
      const Vector3 expected = mesh.vertices[v][0] < 0 ? mesh.vertices[v] : turn.apply(mesh.vertices[v]);
      EXPECT_LT((result.row(v).transpose() - expected).norm(), 1e-9) << v;
    }
  }
}

TEST(PoissonEditing, ThePathDoesNotCount) {
  const MeshData mesh = bumpy_sphere(2);
  const PoissonTask given(some_bend(mesh));
  PoissonEditing solver(mesh.mesh());
  solver.set_constraints(given.task.constraints);
  const Positions direct = solver.solve(given.task.targets, {}, given.rotations).positions;
  const PoissonTask other(bend(mesh, Vector3(-.5, .3, 1), Vector3(2, 3, 4)));
  solver.solve(other.task.targets, {}, other.rotations);
  solver.set_positions(Random(3).noise(mesh.n_vertices(), 1));
  EXPECT_EQ(solver.solve(given.task.targets, {}, given.rotations).positions, direct);
}

TEST(PoissonEditing, DegenerateFacesHaveNoSay) {
  for (const Faces faces : {Faces::kTriangles, Faces::kQuads}) {
    const MeshData mesh = grid(8, faces, [](double x, double y) { return .2 * x * y; });
    MeshData with_slivers = mesh;
    with_slivers.faces.push_back({0, 1, 2});  // in a row
    with_slivers.faces.push_back({20, 21, 20});
    with_slivers.faces.push_back({30, 30, 30, 30});
    const PoissonTask given(some_bend(mesh));
    const Positions result = solve(with_slivers, given).positions;
    EXPECT_TRUE(result.allFinite());
    EXPECT_LT(max_distance(result, solve(mesh, given).positions), 1e-3 * mesh.diagonal());
  }
}

TEST(PoissonEditing, PartsWithoutConstraintsAndLooseVerticesStayAtRest) {
  MeshData mesh = join(bumpy_sphere(1),
                       transformed(bumpy_sphere(1), [](const Vector3& x) { return Vector3(x[0] + 4, x[1], x[2]); }));
  const int loose = mesh.add_vertex({40, 50, 60});
  const MeshData sphere = bumpy_sphere(1);
  for (const Propagation propagation : kPropagations) {
    const PoissonTask given(some_bend(sphere));
    const SolveResult result = solve(mesh, given, by(propagation));
    const int n = sphere.n_vertices();
    EXPECT_LT(max_distance(result.positions.topRows(n), solve(sphere, given, by(propagation)).positions), 1e-6);
    EXPECT_LT(max_distance(result.positions.bottomRows(n + 1), mesh.positions().bottomRows(n + 1)), 1e-14);
    EXPECT_EQ(result.parts_at_rest, std::vector<int>{1});
    EXPECT_EQ(result.loose_vertices, std::vector<int>{loose});
    Task alone;
    alone.add(loose, {41, 50, 60}, .3);
    PoissonEditing solver(mesh.mesh(), by(propagation));
    solver.set_constraints(alone.constraints);
    EXPECT_LT((solver.solve(alone.targets).positions.row(loose) - Eigen::RowVector3d(41, 50, 60)).norm(), 1e-12);
  }
}

TEST(PoissonEditing, IsTheSameOnEveryNumberOfThreads) {
  const MeshData mesh = bumpy_sphere(5);
  const PoissonTask given(some_bend(mesh));
  for (const Propagation propagation : kPropagations) {
    const Positions one = solve(mesh, given, by(propagation, 1)).positions;
    const Positions two = solve(mesh, given, by(propagation, 2)).positions;
    EXPECT_LT(max_distance(two, one), 1e-10 * mesh.diagonal());
    EXPECT_EQ(solve(mesh, given, by(propagation, 2)).positions, two);
  }
  EXPECT_EQ(PoissonEditing(mesh.mesh(), by(Propagation::kHarmonic, 2)).threads(), 2);
}

TEST(PoissonEditing, HasTheActsOfASurface) {
  const MeshData mesh = bumpy_sphere(2);
  const PoissonTask given(some_bend(mesh));
  PoissonEditing solver(mesh.mesh());
  EXPECT_EQ(solver.n_vertices(), mesh.n_vertices());
  EXPECT_EQ(solver.n_parts(), 1);
  EXPECT_EQ(solver.n_factorizations(), 0);
  solver.set_constraints(given.task.constraints);
  solver.set_constraints(given.task.constraints);
  const SolveResult result = solver.solve(given.task.targets, {}, given.rotations);
  EXPECT_EQ(result.stop_reason, arap::StopReason::kConverged);
  EXPECT_EQ(result.iterations, 1);
  EXPECT_EQ(solver.positions(), result.positions);
  EXPECT_EQ(solver.n_factorizations(), 1);
  std::vector<float> out(3 * static_cast<size_t>(mesh.n_vertices()));
  EXPECT_EQ(solver.solve(given.task.targets, {}, given.rotations, {}, out).positions.rows(), 0);
  EXPECT_NEAR(out[0], result.positions(0, 0), 1e-6);
  const SolveResult cancelled = solver.solve(2 * given.task.targets, {}, {}, [](double done) { return done < .4; });
  EXPECT_EQ(cancelled.stop_reason, arap::StopReason::kCancelled);
  EXPECT_EQ(cancelled.positions, result.positions);
  PoissonEditing taken = std::move(solver);
  EXPECT_EQ(taken.positions(), result.positions);
  const Positions noise = Random(3).noise(mesh.n_vertices(), 1);
  taken.set_positions(noise);
  EXPECT_LT(max_distance(taken.positions(), noise), 1e-14);
}

TEST(PoissonEditing, ACancelledChangeOfConstraintsChangesNothing) {
  const MeshData mesh = bumpy_sphere(2);
  const PoissonTask given(some_bend(mesh));
  for (const Propagation propagation : kPropagations) {
    PoissonEditing solver(mesh.mesh(), by(propagation));
    solver.set_constraints(given.task.constraints);
    const Positions expected = solver.solve(given.task.targets, {}, given.rotations).positions;
    for (const double stop : {.0, .3})
      expect_error<arap::Cancelled>(
          [&] {
            solver.set_constraints({{0, 1}, {}, {}}, [&](double done) { return done < stop; });
          },
          {"the change of constraints was cancelled"});
    EXPECT_EQ(solver.solve(given.task.targets, {}, given.rotations).positions, expected);
  }
}

TEST(PoissonEditingErrors, SayWhatIsWrong) {
  using arap::InvalidInput;
  const MeshData data = bumpy_sphere(0);
  const arap::PolygonMesh mesh = data.mesh();
  expect_error<InvalidInput>([&] { const PoissonEditing solver(mesh, by(Propagation::kHarmonic, -1)); },
                             {"threads = -1", "0", "1024"});
  expect_error<arap::Cancelled>([&] { const PoissonEditing solver(mesh, {}, [](double) { return false; }); },
                                {"binding was cancelled"});
  PoissonEditing solver(mesh);
  expect_error<InvalidInput>([&] { solver.solve(mesh.positions()); }, {"nothing is constrained", "set_constraints"});
  expect_error<InvalidInput>([&] { solver.set_constraints({{99}, {}, {}}); }, {"99"});
  expect_error<InvalidInput>(
      [&] {
        solver.set_constraints({{0}, {}, {}, {{{0, 0, 0}, {1, 0, 0}}}});
      },
      {"segments need a model with an inside"});
  expect_error<InvalidInput>([&] { solver.set_positions(Positions::Zero(3, 3)); }, {"positions", "3", "12"});
  solver.set_constraints({{0, 1}, {}, {}});
  const Positions targets = mesh.positions().topRows(2);
  const auto solve_with = [&](const Matrix3& second) { solver.solve(targets, {}, std::vector{second, second}); };
  expect_error<InvalidInput>([&] { solver.solve(mesh.positions()); }, {"targets has 12 rows, expected 2"});
  expect_error<InvalidInput>([&] { solver.solve(targets, {}, std::vector<Matrix3>(3, Matrix3::Identity())); },
                             {"rotations has 3 rows, expected 2"});
  expect_error<InvalidInput>([&] { solve_with(std::numeric_limits<double>::quiet_NaN() * Matrix3::Identity()); },
                             {"rotations[0] is not finite"});
  expect_error<InvalidInput>([&] { solve_with(-Matrix3::Identity()); }, {"rotations[0] has determinant -1", "above 0"});
  expect_error<InvalidInput>([&] { solve_with(Matrix3::Zero()); }, {"rotations[0] has determinant 0", "above 0"});
  std::vector<float> out(5);
  expect_error<InvalidInput>([&] { solver.solve(targets, {}, {}, {}, out); }, {"out has 5 numbers", "36"});
}

}  // namespace
}  // namespace arap_test
