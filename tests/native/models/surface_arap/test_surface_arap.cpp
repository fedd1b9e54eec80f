// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/surface_arap.h"

#include <gtest/gtest.h>

#include <array>
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
using arap::InitialGuess;
using arap::InvalidInput;
using arap::SolveResult;
using arap::StopReason;
using arap::SurfaceArap;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Results.

TEST(SurfaceArap, ResultIsWhereTheMeshIsWithHardVerticesAtTheirTargets) {
  const MeshData mesh = bumpy_sphere(1);
  const Task task = bend_task(mesh, default_bend(mesh));
  SurfaceArap solver(mesh.mesh());
  solver.set_constraints(task.constraints);
  const SolveResult result = solver.solve(task.targets, iterations(5));
  EXPECT_EQ(solver.positions(), result.positions);
  EXPECT_LT(max_distance(rows(result.positions, task.constraints.vertices), task.targets), 1e-14);
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
      const SolveResult scaled = solve_once(mesh, task, options, exactly(model.options()), {stiffness, {}});
      EXPECT_LT(max_distance(scaled.positions, normal.positions), 1e-7) << model.name() << c;
      EXPECT_NEAR(scaled.energy_before, c * normal.energy_before, 1e-10 * c * normal.energy_before)
          << model.name() << c;
      EXPECT_NEAR(scaled.energy_after, c * normal.energy_after, 1e-10 * c * normal.energy_before) << model.name() << c;
    }
  }
}

TEST(Stiffness, BadOnesAreRefused) {
  const auto expect_refused = [](const std::vector<double>& stiffness, std::initializer_list<std::string_view> words) {
    expect_error<InvalidInput>([&] { const SurfaceArap solver(cube().mesh(), {}, {stiffness, {}}); }, words);
  };
  for (const double bad : {0.0, -1.0, kNan, kInfinity})
    expect_refused({1, 1, 1, 1, 1, bad, 1, 1}, {"stiffness", "vertex 5", "between"});
  expect_refused({1, 1, 1}, {"stiffness", "3", "8"});
}

// What costs a factorization.

/// A region of a bumpy sphere that bend_task() leaves free.
std::vector<int> some_region(const MeshData& mesh) {
  std::vector<int> regions(static_cast<size_t>(mesh.n_vertices()), -1);
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (std::abs(mesh.vertices[v][longest_axis(mesh.positions())]) < .2) regions[v] = 0;
  return regions;
}

constexpr std::array kGuesses = {InitialGuess::kPrevious, InitialGuess::kRest, InitialGuess::kNaiveLaplacian,
                                 InitialGuess::kHandleRotations};

TEST(Factorizations, OneForEachSetOfConstraintsAndStrengths) {
  const MeshData mesh = bumpy_sphere(1);
  for (const std::vector<int>& regions : {std::vector<int>(), some_region(mesh)}) {
    Task task = bend_task(mesh, default_bend(mesh));
    SurfaceArap solver(mesh.mesh(), {}, with_regions(regions));
    const int bound = solver.n_factorizations();
    solver.set_constraints(task.constraints);
    EXPECT_EQ(solver.n_factorizations(), bound + 1);
    solver.set_constraints(task.constraints);
    EXPECT_EQ(solver.n_factorizations(), bound + 1) << "the same set";
    for (const InitialGuess guess : kGuesses) solver.solve(task.targets, iterations(1, guess));
    const int solved = solver.n_factorizations();
    EXPECT_EQ(solved, bound + 2) << "the naive Laplacian has a system of its own";
    for (const InitialGuess guess : kGuesses) solver.solve(1.1 * task.targets, iterations(3, guess));
    solver.set_constraints(task.constraints);
    solver.reset();
    solver.set_positions(mesh.positions());
    EXPECT_EQ(solver.n_factorizations(), solved) << "new targets, the same set after solves, another pose";
    task.constraints.strengths[2] = .5;
    solver.set_constraints(task.constraints);
    EXPECT_EQ(solver.n_factorizations(), solved + 1) << "a strength";
    task.add(mesh.n_vertices() / 2, {0, 0, 0});
    solver.set_constraints(task.constraints);
    EXPECT_EQ(solver.n_factorizations(), solved + 2) << "a vertex more";
    task.add_patch({20, 21}, {1, 1}, {0, 0, 0});
    solver.set_constraints(task.constraints);
    EXPECT_EQ(solver.n_factorizations(), solved + 3) << "a patch more";
  }
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

TEST(Refusals, NameWhatIsWrongAndKeepTheLastGoodPose) {
  const MeshData mesh = bumpy_sphere(1);
  Task task = hold(mesh, {0, 17, 2});
  task.add_patch({20, 21}, {1, 1}, {0, 0, 0});
  task.add_patch({30, 31}, {1, 1}, {0, 0, 0});
  SurfaceArap solver(mesh.mesh());
  SurfaceArap untouched(mesh.mesh());
  expect_error<InvalidInput>([&] { solver.solve(task.targets); }, {"set_constraints"});
  for (SurfaceArap* each : {&solver, &untouched}) {
    each->set_constraints(task.constraints);
    each->solve(task.targets, iterations(5));
  }
  const auto solve_with = [&](int row, double bad) {
    return [&, row, bad] {
      Positions targets = task.targets;
      targets(row, 1) = bad;
      solver.solve(targets, iterations(5));
    };
  };
  const auto solve_turned = [&](const std::vector<Matrix3>& rotations) {
    return [&, rotations] { solver.solve(task.targets, iterations(1, InitialGuess::kHandleRotations), rotations); };
  };
  for (const double bad : {kNan, kInfinity, -kInfinity, 1e200}) {
    expect_error<InvalidInput>(solve_with(1, bad), {"target", "vertex 17"});
    expect_error<InvalidInput>(solve_with(4, bad), {"target", "patch 1"});
  }
  for (const int n : {0, 3, 6})
    expect_error<InvalidInput>([&] { solver.solve(Positions::Zero(n, 3)); }, {"targets", std::to_string(n), "5"});
  std::vector<Matrix3> rotations(5, Matrix3::Identity());
  rotations[1](0, 2) = kNan;
  expect_error<InvalidInput>(solve_turned(rotations), {"rotation", "1"});
  rotations.resize(2);
  expect_error<InvalidInput>(solve_turned(rotations), {"rotations", "2", "5"});
  const Positions too_few = Positions::Zero(7, 3);
  Positions not_finite = mesh.positions();
  not_finite(3, 2) = kNan;
  expect_error<InvalidInput>([&] { solver.set_positions(too_few); }, {"positions", "7", "42"});
  expect_error<InvalidInput>([&] { solver.set_positions(not_finite); }, {"positions", "vertex 3"});
  expect_error<InvalidInput>([&] { static_cast<void>(solver.energy(too_few)); }, {"positions", "7", "42"});
  expect_error<InvalidInput>([&] { static_cast<void>(solver.energy_gradient(too_few)); }, {"positions", "7", "42"});
  EXPECT_EQ(solver.positions(), untouched.positions());
  EXPECT_EQ(solver.solve(task.targets, iterations(3)).positions,
            untouched.solve(task.targets, iterations(3)).positions);
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

// Reset and set_positions.

TEST(Reset, GoesBackToRestFromAPoseOrPositionsThatWereSetAndKeepsTheConstraints) {
  const MeshData mesh = bumpy_sphere(1);
  const Task task = bend_task(mesh, default_bend(mesh));
  SurfaceArap solver(mesh.mesh());
  const Positions rest = solver.positions();
  EXPECT_LT(max_distance(rest, mesh.positions()), 1e-15);
  solver.set_constraints(task.constraints);
  const Positions posed = solver.solve(task.targets, iterations(5)).positions;
  solver.reset();
  EXPECT_EQ(solver.positions(), rest);
  EXPECT_EQ(solver.solve(task.targets, iterations(5)).positions, posed) << "the former targets are forgotten";
  const Positions set = Random(91).noise(mesh.n_vertices(), 3);
  solver.set_positions(set);
  EXPECT_LT(max_distance(solver.positions(), set), 1e-14);
  solver.reset();
  EXPECT_EQ(solver.positions(), rest);
  EXPECT_EQ(solver.solve(task.targets, iterations(5)).positions, posed);
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

TEST(Progress, OfASolveIsTheWayToItsAccuracy) {
  const MeshData mesh = bumpy_sphere(2);
  const Task task = bend_task(mesh, default_bend(mesh));
  SurfaceArap solver(mesh.mesh());
  solver.set_constraints(task.constraints);
  Watcher watcher;
  const SolveResult result = solver.solve(task.targets, {.max_iterations = 100000}, {}, watcher.progress());
  EXPECT_EQ(result.stop_reason, StopReason::kConverged);
  EXPECT_GT(watcher.last, .5);
}

TEST(Progress, ASolveBeyondNumbersMayBeCancelledToo) {
  MeshData mesh = bumpy_sphere(2);
  for (Vector3& vertex : mesh.vertices) vertex *= 1e-80;
  const Task task = bend_task(mesh, default_bend(mesh));
  SurfaceArap solver(mesh.mesh());
  solver.set_constraints(task.constraints);
  solver.solve(task.targets, iterations(3));
  const Positions before = solver.positions();
  EXPECT_THROW(solver.solve(1e179 * task.targets, iterations(3)), arap::SolverError);
  Watcher watcher{.stop_at = 1};
  const SolveResult result = solver.solve(1e179 * task.targets, iterations(3), {}, watcher.progress());
  EXPECT_EQ(result.stop_reason, StopReason::kCancelled);
  EXPECT_EQ(result.positions, before);
}

TEST(Progress, SolveMayBeCancelledAtEveryCallAndThePoseStays) {
  const MeshData mesh = bumpy_sphere(2);
  const Task task = bend_task(mesh, default_bend(mesh));
  const Positions far = bend_task(mesh, {rotation_about({0, 1, 0}, 2), Vector3::Zero()}).targets;
  for (const std::vector<int>& regions : {std::vector<int>(), some_region(mesh)})
    for (const InitialGuess guess : kGuesses) {
      const auto posed = [&] {
        SurfaceArap solver(mesh.mesh(), {}, with_regions(regions));
        solver.set_constraints(task.constraints);
        solver.solve(task.targets, iterations(3));
        return solver;
      };
      Watcher count;
      posed().solve(far, iterations(4, guess), {}, count.progress());
      SurfaceArap solver = posed();
      const Positions before = solver.positions();
      for (int stop = 1; stop <= count.calls; ++stop) {
        Watcher watcher{.stop_at = stop};
        const SolveResult result = solver.solve(far, iterations(4, guess), {}, watcher.progress());
        EXPECT_EQ(result.stop_reason, StopReason::kCancelled) << stop;
        EXPECT_EQ(result.positions, before);
        EXPECT_EQ(solver.positions(), before);
        Watcher thrower{.throw_at = stop};
        EXPECT_THROW(solver.solve(far, iterations(4, guess), {}, thrower.progress()), std::domain_error);
        EXPECT_EQ(solver.positions(), before);
      }
      SurfaceArap untouched = posed();
      for (SurfaceArap* each : {&solver, &untouched}) each->solve(task.targets, plain_iterations(3));
      EXPECT_EQ(solver.positions(), untouched.positions()) << "rotations too are as they were";
      for (SurfaceArap* each : {&solver, &untouched}) each->solve(far, iterations(3));
      EXPECT_EQ(solver.positions(), untouched.positions()) << "a far move too";
    }
}

// Threads.

TEST(Threads, SmallMeshesTakeOneAndAFixedNumberIsKept) {
  EXPECT_EQ(SurfaceArap(cube().mesh()).threads(), 1);
  for (const int threads : {1, 2, 3}) {
    const arap::Options options{.threads = threads};
    EXPECT_EQ(SurfaceArap(cube().mesh(), options).threads(), threads);
  }
}

TEST(Threads, DoNotChangeTheResult) {
  const MeshData mesh = bumpy_sphere(4);
  Task task = bend_task(mesh, default_bend(mesh));
  for (const int v : {100, 700, 1500, 2200})
    task.add_patch({v, v + 1, v + 2}, {1, 2, 1}, mesh.vertices[v] + Vector3(.1, .05, .02));
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
