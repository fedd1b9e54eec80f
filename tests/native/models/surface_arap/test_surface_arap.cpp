// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/surface_arap.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::Cancelled;
using arap::ConstraintSet;
using arap::InitialGuess;
using arap::InvalidInput;
using arap::SolveResult;
using arap::StopReason;
using arap::SurfaceArap;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// What it says about the mesh.

TEST(SurfaceArap, SaysWhatItWasBoundTo) {
  MeshData mesh = two_spheres(1);
  mesh.add_vertex({9, 9, 9});
  const SurfaceArap solver(mesh.mesh());
  EXPECT_EQ(solver.n_vertices(), mesh.n_vertices());
  EXPECT_EQ(solver.n_parts(), 2);
  EXPECT_EQ(solver.loose_vertices(), std::vector<int>{mesh.n_vertices() - 1});
  EXPECT_EQ(solver.part_of_vertex().front(), 0);
  EXPECT_EQ(solver.part_of_vertex().back(), -1);
  EXPECT_EQ(solver.part_of_vertex()[mesh.n_vertices() - 2], 1);
}

TEST(SurfaceArap, StartsAtRest) {
  const MeshData mesh = bumpy_sphere(1);
  EXPECT_LT(max_distance(SurfaceArap(mesh.mesh()).positions(), mesh.positions()), 1e-15);
}

TEST(SurfaceArap, HardVerticesAreAtTheirTargets) {
  const MeshData mesh = bumpy_sphere(1);
  const Task task = bend_task(mesh, default_bend(mesh));
  const SolveResult result = solve_once(mesh, task, iterations(5));
  EXPECT_LT(max_distance(rows(result.positions, task.constraints.vertices), task.targets), 1e-14);
}

TEST(SurfaceArap, ResultIsWhereTheMeshIs) {
  const MeshData mesh = bumpy_sphere(1);
  const Task task = bend_task(mesh, default_bend(mesh));
  SurfaceArap solver(mesh.mesh());
  solver.set_constraints(task.constraints);
  const SolveResult result = solver.solve(task.targets, iterations(5));
  EXPECT_EQ(solver.positions(), result.positions);
}

TEST(SurfaceArap, OneHardVertexCarriesTheMeshAlongAsItIs) {
  const MeshData mesh = bumpy_sphere(1);
  Task task;
  task.add(7, mesh.vertices[7] + Vector3(1, -.5, .5));
  const SolveResult result = solve_once(mesh, task, to_accuracy(1e-9, InitialGuess::kRest));
  std::vector<int> all(static_cast<size_t>(mesh.n_vertices()));
  std::iota(all.begin(), all.end(), 0);
  EXPECT_LT(off_rigid(mesh.positions(), result.positions, all), 1e-6);
  EXPECT_LT((result.positions.row(7) - task.targets.row(0)).norm(), 1e-12);
  const RigidMotion shift{Matrix3::Identity(), {1, -.5, .5}};
  for (const InitialGuess guess : {InitialGuess::kPrevious, InitialGuess::kHandleRotations})
    EXPECT_LT(
        max_distance(solve_once(mesh, task, iterations(3, guess), exactly()).positions, shift.apply(mesh.positions())),
        1e-9)
        << "one vertex asks for no turn";
}

TEST(SurfaceArap, OrderOfConstraintsDoesNotMatter) {
  const MeshData mesh = bumpy_sphere(1);
  const Task task = bend_task(mesh, default_bend(mesh));
  Task reversed;
  for (int k = task.constraints.size() - 1; k >= 0; --k)
    reversed.add(task.constraints.vertices[k], task.targets.row(k).transpose());
  EXPECT_LT(max_distance(solve_once(mesh, task, iterations(5)).positions,
                         solve_once(mesh, reversed, iterations(5)).positions),
            1e-12);
}

TEST(SurfaceArap, ManyShortSolvesAreOneLongOne) {
  // What a modal act does that goes on refining in timer steps.
  const MeshData mesh = bumpy_sphere(1);
  Task task = bend_task(mesh, default_bend(mesh));
  for (size_t k = 0; k < task.constraints.strengths.size(); k += 2) task.constraints.strengths[k] = .2;
  task.add_patch({20, 21, 30}, {1, 2, 1}, {0, 1.5, 0});
  SurfaceArap solver(mesh.mesh(), exactly());
  solver.set_constraints(task.constraints);
  for (int k = 0; k < 10; ++k) solver.solve(task.targets, plain_iterations(2));
  EXPECT_LT(max_distance(solver.positions(), solve_once(mesh, task, plain_iterations(20), exactly()).positions), 1e-10);
}

TEST(SurfaceArap, StrongerSoftConstraintsPullCloserAndTendToHard) {
  const MeshData mesh = bumpy_sphere(1);
  Task task = hold(mesh, extreme_vertices(mesh.positions(), 2, .2));
  const int v = extreme_vertices(mesh.positions(), 2, -.01).front();
  const Vector3 target = mesh.vertices[v] + Vector3(.2, .3, .5);
  task.add(v, target);
  const Positions hard = solve_once(mesh, task, to_accuracy(1e-10)).positions;
  double gap = 1e300;
  for (const double s : {.01, .1, .5, .9, .99, .999999}) {
    task.constraints.strengths.back() = s;
    const Positions soft = solve_once(mesh, task, to_accuracy(1e-10)).positions;
    const double next = (soft.row(v).transpose() - target).norm();
    EXPECT_LT(next, gap) << s;
    gap = next;
    EXPECT_LT(max_distance(soft, hard), s > .9999 ? 1e-4 : mesh.diagonal());
  }
  EXPECT_LT(gap, 1e-5);
}

TEST(SurfaceArap, HardlyAnySoftnessStaysSolvable) {
  const MeshData mesh = bumpy_sphere(1);
  Task task = bend_task(mesh, default_bend(mesh));
  const Positions hard = solve_once(mesh, task, to_accuracy(1e-9)).positions;
  for (double& s : task.constraints.strengths) s = 1 - 1e-12;
  EXPECT_LT(max_distance(solve_once(mesh, task, to_accuracy(1e-9)).positions, hard), 1e-5);
  for (double& s : task.constraints.strengths) s = 1e-9;
  const SolveResult weak = solve_once(mesh, task, iterations(5));
  EXPECT_TRUE(weak.positions.allFinite());
  EXPECT_LT(max_distance(weak.positions, mesh.positions()), mesh.diagonal());
}

// Stiffness.

TEST(Stiffness, TheSameEverywhereScalesTheEnergyAndMovesNothing) {
  const MeshData mesh = bumpy_sphere(1);
  const Task task = bend_task(mesh, default_bend(mesh));
  for (const Model& model : all_models()) {
    const arap::SolveOptions options = to_accuracy(1e-10);
    const SolveResult normal = solve_once(mesh, task, options, exactly(model.options()));
    for (const double c : {1e-3, 7.0, 1e4}) {
      const std::vector<double> stiffness(static_cast<size_t>(mesh.n_vertices()), c);
      const SolveResult scaled = solve_once(mesh, task, options, exactly(model.options()), with_stiffness(stiffness));
      EXPECT_LT(max_distance(scaled.positions, normal.positions), 1e-7) << model.name() << c;
      EXPECT_NEAR(scaled.energy_before, c * normal.energy_before, 1e-10 * c * normal.energy_before)
          << model.name() << c;
      EXPECT_NEAR(scaled.energy_after, c * normal.energy_after, 1e-10 * c * normal.energy_before) << model.name() << c;
    }
  }
}

TEST(Stiffness, StiffHalfKeepsItsShape) {
  const MeshData mesh = bar(3, Faces::kQuads);
  const Task task = bend_task(mesh, {rotation_about({0, 1, 0}, 1), {-.2, 0, .4}});
  std::vector<double> stiffness;
  std::vector<int> stiff;
  for (int v = 0; v < mesh.n_vertices(); ++v) {
    const bool is_stiff = mesh.vertices[v].x() > -1 && mesh.vertices[v].x() < 0;
    stiffness.push_back(is_stiff ? 1000 : 1);
    if (is_stiff) stiff.push_back(v);
  }
  const Positions rest = mesh.positions();
  const double without = off_rigid(rest, solve_once(mesh, task, to_accuracy(1e-7)).positions, stiff);
  const double with =
      off_rigid(rest, solve_once(mesh, task, to_accuracy(1e-7), {}, with_stiffness(stiffness)).positions, stiff);
  EXPECT_LT(with, .1 * without);
}

TEST(Stiffness, BadValuesAreRefusedByVertex) {
  const MeshData mesh = cube();
  for (const double bad : {0.0, -1.0, kNan, kInfinity}) {
    std::vector<double> stiffness(8, 1);
    stiffness[5] = bad;
    expect_error<InvalidInput>([&] { const SurfaceArap solver(mesh.mesh(), {}, with_stiffness(stiffness)); },
                               {"stiffness", "5", "> 0"});
  }
}

TEST(Stiffness, AnotherLengthIsRefusedWithBothLengths) {
  expect_error<InvalidInput>(
      [] {
        const SurfaceArap solver(cube().mesh(), {}, with_stiffness({1, 1, 1}));
      },
      {"stiffness", "3", "8"});
}

// Symmetry.

/// The task's left half and its mirror image on the right.
Task mirrored_task(const MeshData& mesh, const RigidMotion& motion) {
  const std::vector<int> mirrored = mirror_vertices(mesh);
  const Matrix3 mirror = Vector3(-1, 1, 1).asDiagonal();
  Task task;
  const double right = mesh.positions().col(0).maxCoeff();
  for (int v = 0; v < mesh.n_vertices(); ++v) {
    if (mesh.vertices[v].x() < .75 * right) continue;
    const Vector3 target = motion.apply(mesh.vertices[v]);
    task.add(v, target);
    task.add(mirrored[v], mirror * target);
  }
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (mirrored[v] == v && mesh.vertices[v].z() < 0) task.add(v, mesh.vertices[v]);
  return task;
}

/// Largest distance from the mirror image.
double asymmetry(const MeshData& mesh, const Positions& p) {
  const std::vector<int> mirrored = mirror_vertices(mesh);
  Positions image = rows(p, mirrored);
  image.col(0) *= -1;
  return max_distance(image, p);
}

TEST(Symmetry, MirroredPoseOfASymmetricQuadMeshIsSymmetric) {
  // A gentle one: pushed further the symmetric pose is a saddle, where rounding decides.
  const RigidMotion motion{rotation_about({.3, 1, .5}, .4), {.05, .1, .15}};
  for (const MeshData& mesh : {bar(2, Faces::kQuads), bar(4, Faces::kQuads), quad_sphere(4)}) {
    const Task task = mirrored_task(mesh, motion);
    for (const Model& model : all_models()) {
      const SolveResult result = solve_once(mesh, task, iterations(100), model.options());
      EXPECT_GT(max_distance(result.positions, mesh.positions()), .1);
      EXPECT_LT(asymmetry(mesh, result.positions), 1e-6 * mesh.diagonal()) << mesh.name << model.name();
    }
  }
}

TEST(Symmetry, MirroredPoseOfSymmetricConcavePolygonsIsSymmetric) {
  // A gentle one: pushed further the symmetric pose of these thin walls is a saddle, where rounding decides.
  const RigidMotion motion{rotation_about({.3, 1, .5}, .3), {.05, .1, .1}};
  const MeshData plain =
      prism({{-.6, -.5}, {-.2, -.15}, {.2, -.15}, {.6, -.5}, {.6, .5}, {.1, .2}, {-.1, .2}, {-.6, .5}}, 2, 5);
  // Here some corners of the caps are on one line with others, so some triangles of their fans are degenerate.
  const MeshData with_lines =
      prism({{-.6, -.5}, {-.2, -.1}, {.2, -.1}, {.6, -.5}, {.6, .5}, {.1, .2}, {-.1, .2}, {-.6, .5}}, 2, 5);
  for (const MeshData& mesh : {plain, with_lines}) {
    const Task task = mirrored_task(mesh, motion);
    for (const Model& model : all_models()) {
      const SolveResult result = solve_once(mesh, task, iterations(100), model.options());
      EXPECT_GT(max_distance(result.positions, mesh.positions()), .05);
      EXPECT_LT(asymmetry(mesh, result.positions), 1e-6 * mesh.diagonal()) << model.name();
    }
  }
}

TEST(Symmetry, FirstCornersOfFacesDoNotMatter) {
  for (const MeshData& mesh : {quad_sphere(3), l_prism(3), star_prism(5, 3)}) {
    MeshData relabelled = mesh;
    for (size_t f = 0; f < relabelled.faces.size(); ++f) {
      auto& face = relabelled.faces[f];
      std::rotate(face.begin(), face.begin() + static_cast<long>(f % face.size()), face.end());
    }
    std::reverse(relabelled.faces.begin(), relabelled.faces.end());
    const Task task = bend_task(mesh, default_bend(mesh));
    EXPECT_LT(max_distance(solve_once(mesh, task, iterations(20)).positions,
                           solve_once(relabelled, task, iterations(20)).positions),
              1e-9)
        << mesh.name;
  }
}

// What costs a factorization.

TEST(Factorizations, OneForEachSetOfConstraintsAndStrengths) {
  const MeshData mesh = bumpy_sphere(1);
  Task task = bend_task(mesh, default_bend(mesh));
  SurfaceArap solver(mesh.mesh());
  const int bound = solver.n_factorizations();
  solver.set_constraints(task.constraints);
  EXPECT_EQ(solver.n_factorizations(), bound + 1);
  solver.set_constraints(task.constraints);
  EXPECT_EQ(solver.n_factorizations(), bound + 1) << "the same set";
  for (const double scale : {1.0, 1.1, 1.2}) solver.solve(scale * task.targets, iterations(3));
  EXPECT_EQ(solver.n_factorizations(), bound + 1) << "new targets";
  solver.set_constraints(task.constraints);
  EXPECT_EQ(solver.n_factorizations(), bound + 1) << "the same set after solves";
  solver.reset();
  solver.set_positions(mesh.positions());
  solver.solve(task.targets, iterations(3, InitialGuess::kRest));
  EXPECT_EQ(solver.n_factorizations(), bound + 1) << "reset, set_positions, another guess";
  task.constraints.strengths[2] = .5;
  solver.set_constraints(task.constraints);
  EXPECT_EQ(solver.n_factorizations(), bound + 2) << "a strength";
  task.add(mesh.n_vertices() / 2, {0, 0, 0});
  solver.set_constraints(task.constraints);
  EXPECT_EQ(solver.n_factorizations(), bound + 3) << "a vertex more";
  task.add_patch({20, 21}, {1, 1}, {0, 0, 0});
  solver.set_constraints(task.constraints);
  EXPECT_EQ(solver.n_factorizations(), bound + 4) << "a patch more";
}

TEST(Factorizations, ANewSetOfConstraintsLeavesNothingOfTheOldOne) {
  const MeshData mesh = bumpy_sphere(1);
  const Task first = bend_task(mesh, default_bend(mesh));
  Task second = hold(mesh, {0, 20});
  second.add(40, mesh.vertices[40] * 1.5, .7);
  SurfaceArap solver(mesh.mesh());
  solver.set_constraints(first.constraints);
  solver.solve(first.targets, iterations(5, InitialGuess::kNaiveLaplacian));
  solver.set_constraints(second.constraints);
  for (const InitialGuess guess : {InitialGuess::kRest, InitialGuess::kNaiveLaplacian, InitialGuess::kHandleRotations})
    EXPECT_EQ(solver.solve(second.targets, iterations(5, guess)).positions,
              solve_once(mesh, second, iterations(5, guess)).positions);
}

// Refusals; each leaves the solver as it was.

TEST(Refusals, SolveBeforeConstraints) {
  SurfaceArap solver(cube().mesh());
  expect_error<InvalidInput>([&] { solver.solve(Positions::Zero(1, 3)); }, {"set_constraints"});
}

TEST(Refusals, TargetsOfAnotherLength) {
  const MeshData mesh = bumpy_sphere(1);
  Task task = hold(mesh, {0, 1, 2});
  task.add_patch({20, 21}, {1, 1}, {0, 0, 0});
  SurfaceArap solver(mesh.mesh());
  solver.set_constraints(task.constraints);
  for (const int n : {0, 3, 5})
    expect_error<InvalidInput>([&] { solver.solve(Positions::Zero(n, 3)); }, {"targets", std::to_string(n), "4"});
}

TEST(Refusals, NonFiniteTargetKeepsTheLastGoodPose) {
  const MeshData mesh = bumpy_sphere(1);
  const Task task = bend_task(mesh, default_bend(mesh));
  for (const double bad : {kNan, kInfinity, -kInfinity}) {
    SurfaceArap solver(mesh.mesh());
    solver.set_constraints(task.constraints);
    const Positions good = solver.solve(task.targets, iterations(5)).positions;
    Positions targets = 1.1 * task.targets;
    targets(4, 1) = bad;
    expect_error<InvalidInput>([&] { solver.solve(targets, iterations(5)); },
                               {"target", "vertex " + std::to_string(task.constraints.vertices[4])});
    EXPECT_EQ(solver.positions(), good);
    EXPECT_EQ(solver.solve(task.targets, iterations(3)).positions, [&] {
      SurfaceArap other(mesh.mesh());
      other.set_constraints(task.constraints);
      other.solve(task.targets, iterations(5));
      return other.solve(task.targets, iterations(3)).positions;
    }());
  }
}

TEST(Refusals, PositionsBeyondTheRangeOfTheFloatsTheyAreWrittenTo) {
  const MeshData mesh = bumpy_sphere(1);
  const Task task = bend_task(mesh, default_bend(mesh));
  SurfaceArap solver(mesh.mesh());
  solver.set_constraints(task.constraints);
  const Positions good = solver.solve(task.targets, iterations(5)).positions;
  std::vector<float> out(3 * static_cast<size_t>(mesh.n_vertices()));
  expect_error<arap::SolverError>([&] { solver.solve(1e39 * task.targets, iterations(1), {}, {}, out); },
                                  {"no longer finite", "last good pose is kept"});
  EXPECT_EQ(solver.positions(), good);
  for (int v = 0; v < mesh.n_vertices(); ++v)
    for (int d = 0; d < 3; ++d) EXPECT_EQ(out[3 * v + d], static_cast<float>(good(v, d)));
}

TEST(Refusals, PositionsThatDoNotFit) {
  const MeshData mesh = cube();
  SurfaceArap solver(mesh.mesh());
  const Positions before = solver.positions();
  expect_error<InvalidInput>([&] { solver.set_positions(Positions::Zero(7, 3)); }, {"positions", "7", "8"});
  Positions bad = mesh.positions();
  bad(3, 2) = kNan;
  expect_error<InvalidInput>([&] { solver.set_positions(bad); }, {"positions", "vertex 3"});
  EXPECT_EQ(solver.positions(), before);
}

TEST(Refusals, EnergyOfPositionsThatDoNotFit) {
  const SurfaceArap solver(cube().mesh());
  expect_error<InvalidInput>([&] { static_cast<void>(solver.energy(Positions::Zero(7, 3))); }, {"positions", "7", "8"});
  expect_error<InvalidInput>([&] { static_cast<void>(solver.energy_gradient(Positions::Zero(9, 3))); },
                             {"positions", "9", "8"});
}

// Reset and set_positions.

TEST(Reset, GoesBackToRestAndKeepsTheConstraints) {
  const MeshData mesh = bumpy_sphere(1);
  const Task task = bend_task(mesh, default_bend(mesh));
  SurfaceArap solver(mesh.mesh());
  const Positions rest = solver.positions();
  solver.set_constraints(task.constraints);
  const Positions posed = solver.solve(task.targets, iterations(5)).positions;
  solver.reset();
  EXPECT_EQ(solver.positions(), rest);
  EXPECT_EQ(solver.solve(task.targets, iterations(5)).positions, posed);
}

TEST(SetPositions, ComeBack) {
  const MeshData mesh = bumpy_sphere(1);
  SurfaceArap solver(mesh.mesh());
  const Positions p = Random(91).noise(mesh.n_vertices(), 3);
  solver.set_positions(p);
  EXPECT_LT(max_distance(solver.positions(), p), 1e-14);
}

TEST(SetPositions, LeaveNothingOfTheFormerPose) {
  const MeshData mesh = bumpy_sphere(1);
  const Task task = bend_task(mesh, default_bend(mesh));
  const Positions p = Random(92).rigid_motion(1, 0).apply(mesh.positions());
  SurfaceArap fresh(mesh.mesh());
  SurfaceArap used(mesh.mesh());
  for (SurfaceArap* each : {&fresh, &used}) each->set_constraints(task.constraints);
  used.solve(task.targets, iterations(20));
  for (SurfaceArap* each : {&fresh, &used}) each->set_positions(p);
  EXPECT_EQ(used.solve(task.targets, iterations(3)).positions, fresh.solve(task.targets, iterations(3)).positions);
}

TEST(SurfaceArap, MayBeMoved) {
  const MeshData mesh = bumpy_sphere(1);
  const Task task = bend_task(mesh, default_bend(mesh));
  SurfaceArap first(mesh.mesh());
  first.set_constraints(task.constraints);
  SurfaceArap second(std::move(first));
  SurfaceArap third(cube().mesh());
  third = std::move(second);
  EXPECT_EQ(third.solve(task.targets, iterations(5)).positions, solve_once(mesh, task, iterations(5)).positions);
}

// Progress and cancel.

/// Counts its calls and stops the work, or throws, at one of them.
struct Watcher {
  int calls = 0;
  int stop_at = -1;
  int throw_at = -1;
  double last = 0;
  std::thread::id thread = std::this_thread::get_id();

  arap::Progress progress() {
    return [this](double fraction) {
      EXPECT_GE(fraction, last) << "progress never goes back";
      EXPECT_LE(fraction, 1);
      EXPECT_EQ(std::this_thread::get_id(), thread);
      last = fraction;
      ++calls;
      if (calls == throw_at) throw std::domain_error("from the callback");
      return calls != stop_at;
    };
  }
};

TEST(Progress, EveryLongCallReports) {
  const MeshData mesh = bumpy_sphere(2);
  const Task task = bend_task(mesh, default_bend(mesh));
  Watcher bind;
  SurfaceArap solver(mesh.mesh(), {}, {}, bind.progress());
  EXPECT_GT(bind.calls, 0);
  Watcher factorize;
  solver.set_constraints(task.constraints, factorize.progress());
  EXPECT_GT(factorize.calls, 0);
  Watcher solve;
  solver.solve(task.targets, iterations(10), {}, solve.progress());
  EXPECT_GE(solve.calls, 9) << "after each iteration but perhaps the last";
  const Positions expected = solve_once(mesh, task, iterations(10)).positions;
  EXPECT_EQ(solver.positions(), expected) << "watching changes nothing";
}

TEST(Progress, BindMayBeCancelledAtEveryCall) {
  const MeshData mesh = bumpy_sphere(2);
  Watcher count;
  { const SurfaceArap solver(mesh.mesh(), {}, {}, count.progress()); }
  for (int stop = 1; stop <= count.calls; ++stop) {
    Watcher watcher{.stop_at = stop};
    EXPECT_THROW(SurfaceArap(mesh.mesh(), {}, {}, watcher.progress()), Cancelled) << stop;
    EXPECT_EQ(watcher.calls, stop) << "nothing is called after the stop";
    Watcher thrower{.throw_at = stop};
    EXPECT_THROW(SurfaceArap(mesh.mesh(), {}, {}, thrower.progress()), std::domain_error) << stop;
  }
}

TEST(Progress, SetConstraintsMayBeCancelledAtEveryCallAndTheFormerSetStays) {
  const MeshData mesh = bumpy_sphere(2);
  const Task former = bend_task(mesh, default_bend(mesh));
  Task other = hold(mesh, {0, 1, 2, 3, 4});
  other.add_patch({20, 21, 22}, {1, 1, 1}, {0, 0, 0});
  other.add_patch({30, 31, 32}, {1, 1, 1}, {0, 0, 0});
  SurfaceArap solver(mesh.mesh());
  solver.set_constraints(former.constraints);
  solver.solve(former.targets, iterations(3));
  Watcher count;
  {
    SurfaceArap copy(mesh.mesh());
    copy.set_constraints(other.constraints, count.progress());
  }
  const Positions before = solver.positions();
  const int n_factorizations = solver.n_factorizations();
  for (int stop = 1; stop <= count.calls; ++stop) {
    Watcher watcher{.stop_at = stop};
    EXPECT_THROW(solver.set_constraints(other.constraints, watcher.progress()), Cancelled) << stop;
    Watcher thrower{.throw_at = stop};
    EXPECT_THROW(solver.set_constraints(other.constraints, thrower.progress()), std::domain_error) << stop;
    EXPECT_EQ(solver.positions(), before);
    EXPECT_EQ(solver.n_factorizations(), n_factorizations);
    solver.set_constraints(former.constraints);
    EXPECT_EQ(solver.n_factorizations(), n_factorizations) << "the former set is still the current one";
  }
  SurfaceArap untouched(mesh.mesh());
  untouched.set_constraints(former.constraints);
  untouched.solve(former.targets, iterations(3));
  EXPECT_EQ(solver.solve(former.targets, iterations(3)).positions,
            untouched.solve(former.targets, iterations(3)).positions);
}

TEST(Progress, FirstSetConstraintsMayBeCancelledAndThenNoneIsCurrent) {
  const MeshData mesh = cube();
  SurfaceArap solver(mesh.mesh());
  EXPECT_THROW(solver.set_constraints(hold(mesh, {0}).constraints, [](double) { return false; }), Cancelled);
  expect_error<InvalidInput>([&] { solver.solve(Positions::Zero(1, 3)); }, {"set_constraints"});
}

TEST(Progress, SolveMayBeCancelledAtEveryCallAndThePoseStays) {
  const MeshData mesh = bumpy_sphere(2);
  const Task task = bend_task(mesh, default_bend(mesh));
  for (const InitialGuess guess :
       {InitialGuess::kPrevious, InitialGuess::kRest, InitialGuess::kNaiveLaplacian, InitialGuess::kHandleRotations}) {
    SurfaceArap solver(mesh.mesh());
    solver.set_constraints(task.constraints);
    const Positions before = solver.solve(task.targets, iterations(3)).positions;
    Watcher count;
    {
      SurfaceArap copy(mesh.mesh());
      copy.set_constraints(task.constraints);
      copy.solve(1.2 * task.targets, iterations(4, guess), {}, count.progress());
    }
    for (int stop = 1; stop <= count.calls; ++stop) {
      Watcher watcher{.stop_at = stop};
      const SolveResult result = solver.solve(1.2 * task.targets, iterations(4, guess), {}, watcher.progress());
      EXPECT_EQ(result.stop_reason, StopReason::kCancelled) << stop;
      EXPECT_EQ(result.positions, before);
      EXPECT_EQ(solver.positions(), before);
      Watcher thrower{.throw_at = stop};
      EXPECT_THROW(solver.solve(1.2 * task.targets, iterations(4, guess), {}, thrower.progress()), std::domain_error);
      EXPECT_EQ(solver.positions(), before);
    }
    SurfaceArap untouched(mesh.mesh());
    untouched.set_constraints(task.constraints);
    untouched.solve(task.targets, iterations(3));
    EXPECT_EQ(solver.solve(task.targets, plain_iterations(3)).positions,
              untouched.solve(task.targets, plain_iterations(3)).positions)
        << "rotations too are as they were";
  }
}

TEST(Progress, CancelledSolveWithRegionsLeavesTheirPlaces) {
  const MeshData mesh = bar(2, Faces::kQuads);
  const Task task = bend_task(mesh, default_bend(mesh));
  std::vector<int> regions;
  for (const Vector3& p : mesh.vertices) regions.push_back(std::abs(p.x()) < .7 ? 0 : -1);
  SurfaceArap solver(mesh.mesh(), {}, with_regions(regions));
  SurfaceArap untouched(mesh.mesh(), {}, with_regions(regions));
  for (SurfaceArap* each : {&solver, &untouched}) {
    each->set_constraints(task.constraints);
    each->solve(task.targets, iterations(3));
  }
  int calls = 0;
  solver.solve(1.3 * task.targets, iterations(10), {}, [&](double) { return ++calls < 5; });
  EXPECT_EQ(solver.positions(), untouched.positions());
  EXPECT_EQ(solver.solve(task.targets, plain_iterations(3)).positions,
            untouched.solve(task.targets, plain_iterations(3)).positions);
}

// Threads.

TEST(Threads, SmallMeshesTakeOneAndAFixedNumberIsKept) {
  EXPECT_EQ(SurfaceArap(cube().mesh()).threads(), 1);
  for (const int threads : {1, 2, 3}) {
    arap::Options options;
    options.threads = threads;
    EXPECT_EQ(SurfaceArap(cube().mesh(), options).threads(), threads);
  }
}

TEST(Threads, DoNotChangeTheResult) {
  const MeshData mesh = bumpy_sphere(4);
  const Task task = bend_task(mesh, default_bend(mesh));
  for (const Model& model : {all_models()[0], all_models()[2]}) {
    arap::Options options = model.options();
    options.threads = 1;
    const SolveResult one = solve_once(mesh, task, to_accuracy(1e-9), options);
    options.threads = 2;
    const SolveResult two = solve_once(mesh, task, to_accuracy(1e-9), options);
    EXPECT_LT(max_distance(one.positions, two.positions), 1e-6 * mesh.diagonal());
    EXPECT_NEAR(one.energy_after, two.energy_after, 1e-10 * one.energy_after);
    EXPECT_EQ(solve_once(mesh, task, to_accuracy(1e-9), options).positions, two.positions) << "run by run the same";
  }
}

TEST(Threads, SeveralSolversAtOnceDoNotDisturbEachOther) {
  const MeshData mesh = bumpy_sphere(3);
  const auto run = [&mesh](int k) {
    const Task task = bend_task(mesh, {rotation_about({1, .1 * k, .3}, .2 + .2 * k), {.1 * k, 0, .2}});
    arap::Options options;
    options.threads = 1 + k % 2;
    return solve_once(mesh, task, iterations(15), options).positions;
  };
  std::vector<Positions> results(4);
  std::vector<std::thread> threads;
  for (int k = 0; k < 4; ++k) threads.emplace_back([&, k] { results[k] = run(k); });
  for (std::thread& thread : threads) thread.join();
  for (int k = 0; k < 4; ++k) EXPECT_EQ(results[k], run(k));
}

}  // namespace
}  // namespace arap_test
