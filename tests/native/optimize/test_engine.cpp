// SPDX-License-Identifier: GPL-3.0-or-later
// The engine without a surface: ARAP on tetrahedra, held by vertices and by rows.
#include "optimize/engine.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "support/dense.h"
#include "support/helpers.h"
#include "support/tet_arap.h"

namespace arap_test {
namespace {

using arap::LinearRow;
using arap::LinearRows;
using arap::ModelConstraints;

/// The model as it is written down, dense and in double.
struct DenseTets {
  const TetMesh& mesh;

  [[nodiscard]] Matrix3 gradient(const Positions& p, int t) const {
    Matrix3 F = Matrix3::Zero();
    const Eigen::Matrix<double, 4, 3> g = gradients(mesh, t);
    for (int j = 0; j < 4; ++j) F += p.row(mesh.tets()[t][j]).transpose() * g.row(j);
    return F;
  }
  [[nodiscard]] double energy(const Positions& p) const {
    double sum = 0;
    for (int t = 0; t < static_cast<int>(mesh.tets().size()); ++t) {
      const Matrix3 F = gradient(p, t);
      sum += tet_volume(mesh, t) * (F - best_rotation(F)).squaredNorm();
    }
    return sum;
  }
  [[nodiscard]] static double row_energy(const LinearRows& rows, const Positions& targets, const Positions& p) {
    double sum = 0;
    for (int r = 0; r < rows.size(); ++r)
      if (!std::isinf(rows.weights[r]))
        sum += .5 * rows.weights[r] * (rows.rows[r].of(p) - targets.row(r)).squaredNorm();
    return sum;
  }
  /// Local/global until nothing moves: hard rows by multipliers, soft ones in the matrix.
  [[nodiscard]] Positions solve(const LinearRows& rows, const Positions& targets) const {
    const auto n = mesh.positions().rows();
    Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n, n);
    Positions soft = Positions::Zero(n, 3);
    std::vector<int> hard;
    for (int t = 0; t < static_cast<int>(mesh.tets().size()); ++t) {
      const Eigen::Matrix<double, 4, 3> g = gradients(mesh, t);
      for (int j = 0; j < 4; ++j)
        for (int k = 0; k < 4; ++k)
          K(mesh.tets()[t][j], mesh.tets()[t][k]) += 2 * tet_volume(mesh, t) * g.row(j).dot(g.row(k));
    }
    for (int r = 0; r < rows.size(); ++r) {
      if (std::isinf(rows.weights[r])) {
        hard.push_back(r);
        continue;
      }
      const auto& [indices, coefficients] = rows.rows[r];
      for (size_t a = 0; a < indices.size(); ++a) {
        soft.row(indices[a]) += rows.weights[r] * coefficients[a] * targets.row(r);
        for (size_t b = 0; b < indices.size(); ++b)
          K(indices[a], indices[b]) += rows.weights[r] * coefficients[a] * coefficients[b];
      }
    }
    const auto m = static_cast<Eigen::Index>(hard.size());
    Eigen::MatrixXd saddle = Eigen::MatrixXd::Zero(n + m, n + m);
    saddle.topLeftCorner(n, n) = K;
    Positions right(n + m, 3);
    for (Eigen::Index k = 0; k < m; ++k) {
      const LinearRow& row = rows.rows[hard[k]];
      for (size_t a = 0; a < row.indices.size(); ++a) saddle(n + k, row.indices[a]) += row.coefficients[a];
      right.row(n + k) = targets.row(hard[k]);
    }
    saddle.topRightCorner(n, m) = saddle.bottomLeftCorner(m, n).transpose();
    const auto solve = solver_of(saddle);
    Positions p = mesh.positions();
    for (int k = 0; k < 20000; ++k) {
      right.topRows(n) = soft;
      for (int t = 0; t < static_cast<int>(mesh.tets().size()); ++t) {
        const Matrix3 R = best_rotation(gradient(p, t));
        const Eigen::Matrix<double, 4, 3> g = gradients(mesh, t);
        for (int j = 0; j < 4; ++j)
          right.row(mesh.tets()[t][j]) += 2 * tet_volume(mesh, t) * (R * g.row(j).transpose()).transpose();
      }
      const Positions next = solve(right).topRows(n);
      const double step = max_distance(next, p);
      p = next;
      if (step < 1e-12) break;
    }
    return p;
  }
};

/// Points of tetrahedra at both ends of a bar as rows, the far ones moved.
struct Pull {
  LinearRows rows;
  Positions targets;

  /// @param n  rows at each end
  Pull(const TetMesh& mesh, int n, double weight, const RigidMotion& motion) {
    Random random(5);
    std::vector<Eigen::RowVector3d> places;
    const double end = mesh.positions().col(0).maxCoeff();
    for (const bool is_far : {false, true})
      for (int found = 0, t = 0; found < n; t = (t + 1) % static_cast<int>(mesh.tets().size())) {
        Eigen::Vector4d coordinates = random.noise(2, 1).reshaped<Eigen::RowMajor>().head<4>().array().abs() + .01;
        coordinates /= coordinates.sum();
        const LinearRow row = point_in(mesh, t, coordinates);
        const Vector3 place = row.of(mesh.positions()).transpose();
        if (is_far ? place.x() < .75 * end : place.x() > .25 * end) continue;
        rows.add(row, weight);
        places.emplace_back((is_far ? motion.apply(place) : place).transpose());
        ++found;
      }
    targets.resize(2L * n, 3);
    for (Eigen::Index k = 0; k < targets.rows(); ++k) targets.row(k) = places[k];
  }

  [[nodiscard]] ModelConstraints constraints() const { return {{}, rows}; }
  [[nodiscard]] double gap(const Positions& p) const {
    double largest = 0;
    for (int r = 0; r < rows.size(); ++r) largest = std::max(largest, (rows.rows[r].of(p) - targets.row(r)).norm());
    return largest;
  }
};

RigidMotion bend() { return {rotation_about({.2, 1, .3}, .7), {-.05, .1, .2}}; }

arap::SolveOptions converged() { return to_accuracy(1e-9, arap::InitialGuess::kRest); }

TEST(Engine, EnergyIsTheSumOverTetrahedra) {
  const TetMesh mesh = tet_blocks(3, 2, 2);
  TetEngine model(mesh);
  const DenseTets dense{mesh};
  const Positions p = mesh.positions() + Random(2).noise(static_cast<int>(mesh.positions().rows()), .05);
  Positions gradient;
  EXPECT_NEAR(model.engine().evaluate(p, gradient), dense.energy(p), 1e-12);
  EXPECT_LT(max_distance(gradient, differences([&](const Positions& at) { return dense.energy(at); }, p, 1e-5)), 1e-8);
}

TEST(Engine, RowsEndWhereTheDenseReferenceDoesWithItsEnergy) {
  const TetMesh mesh = tet_blocks(4, 2, 2);
  for (const double weight : {.05, 1.0, LinearRows::kHard}) {
    const Pull pull(mesh, 5, weight, bend());
    TetEngine model(mesh);
    model.set_constraints(pull.constraints());
    const double energy = model.solve(pull.targets, converged()).energy_after;
    const DenseTets dense{mesh};
    const Positions& p = model.positions();
    EXPECT_LT(max_distance(p, dense.solve(pull.rows, pull.targets)), 1e-6) << weight;
    EXPECT_NEAR(energy, dense.energy(p) + DenseTets::row_energy(pull.rows, pull.targets, p), 1e-12) << weight;
  }
}

TEST(Engine, ManyHardRowsAreMet) {
  const TetMesh mesh = tet_blocks(8, 4, 4);
  const Pull pull(mesh, 60, LinearRows::kHard, bend());
  for (const auto* factory : {kOwnSolver, exact_solver()}) {
    TetEngine model(mesh, 2, {}, factory);
    model.set_constraints(pull.constraints());
    model.solve(pull.targets, converged());
    EXPECT_LT(pull.gap(model.positions()), 1e-8);
    // Hard rows of which one is too wide for the matrix go another way, all to the same end.
    Pull with_averages = pull;
    with_averages.rows = {};
    for (int r = 0; r < pull.rows.size(); ++r) {
      LinearRow row = pull.rows.rows[r];
      for (int k = 0; r % 30 == 0 && k < 70; ++k) {
        row.indices.push_back(row.indices[0]);
        row.coefficients.push_back(0);
      }
      with_averages.rows.add(row, LinearRows::kHard);
    }
    TetEngine other(mesh, 1, {}, factory);
    other.set_constraints(with_averages.constraints());
    other.solve(pull.targets, converged());
    EXPECT_LT(max_distance(model.positions(), other.positions()), 1e-6);
  }
}

TEST(Engine, EnergyNeverRises) {
  const TetMesh mesh = tet_blocks(6, 3, 3);
  for (const double weight : {.01, 1.0, 1e3, LinearRows::kHard})
    for (const int n : {8, 60}) {
      const Pull pull(mesh, n, weight, bend());
      TetEngine model(mesh);
      model.set_constraints(pull.constraints());
      double last = std::numeric_limits<double>::infinity();
      for (int k = 1; k <= 12; ++k) {
        const double energy = model.solve(pull.targets, iterations(k, arap::InitialGuess::kRest)).energy_after;
        EXPECT_LE(energy, last + 1e-12) << weight << " " << n << " " << k;
        last = energy;
      }
    }
}

TEST(Engine, RowOfOneUnknownIsAVertex) {
  const TetMesh mesh = tet_blocks(4, 2, 2);
  const auto n = static_cast<int>(mesh.positions().rows());
  Positions targets = mesh.positions()(std::vector<int>{0, 1, 2, n - 1}, arap::all);
  targets.row(3) += Eigen::RowVector3d(.1, .2, 0);
  for (const bool is_hard : {true, false}) {
    const double strength = is_hard ? 1 : .4;
    TetEngine by_vertex(mesh);
    by_vertex.set_constraints({{{0, 1, 2, n - 1}, {1, 1, 1, strength}, {}}, {}});
    arap::PreparedModel plain;
    const double stiffness = assemble(plain, mesh).energy.K.coeff(n - 1, n - 1);
    ModelConstraints constraints{{{0, 1, 2}, {}, {}}, {}};
    constraints.rows.add({{n - 1}, {2}}, is_hard ? LinearRows::kHard : .5 * stiffness * .4 / .6);
    Positions of_row = targets;
    of_row.row(3) *= 2;
    TetEngine by_row(mesh);
    by_row.set_constraints(constraints);
    for (int k = 0; k < 3; ++k) {
      by_vertex.solve(targets, iterations(4));
      by_row.solve(of_row, iterations(4));
    }
    EXPECT_LT(max_distance(by_vertex.positions(), by_row.positions()), is_hard ? 1e-14 : 1e-4) << is_hard;
    by_vertex.solve(targets, converged());
    by_row.solve(of_row, converged());
    EXPECT_LT(max_distance(by_vertex.positions(), by_row.positions()), 1e-7) << is_hard;
  }
}

TEST(Engine, HardRowOfSumOneIsAPatch) {
  const TetMesh mesh = tet_blocks(4, 2, 2);
  const auto n = static_cast<int>(mesh.positions().rows());
  const ModelConstraints by_patch{{{0, 1, 2}, {}, {{0, 3}, {n - 3, n - 2, n - 1}, {.25, .25, .5}}}, {}};
  ModelConstraints by_row{{{0, 1, 2}, {}, {}}, {}};
  by_row.rows.add({{n - 3, n - 2, n - 1}, {.25, .25, .5}}, LinearRows::kHard);
  Positions targets = mesh.positions()(std::vector<int>{0, 1, 2, n - 1}, arap::all);
  targets.row(3) += Eigen::RowVector3d(.1, .2, 0);
  TetEngine patch(mesh);
  TetEngine row(mesh);
  patch.set_constraints(by_patch);
  row.set_constraints(by_row);
  patch.solve(targets, iterations(5));
  row.solve(targets, iterations(5));
  EXPECT_EQ(patch.positions(), row.positions());
}

TEST(Engine, RowsMovedByOneRigidMotionMoveAllByIt) {
  const TetMesh mesh = tet_blocks(6, 3, 3);
  const RigidMotion motion = Random(8).rigid_motion(2, .5);
  for (const double weight : {.1, LinearRows::kHard})
    for (const int n : {8, 60}) {
      Pull pull(mesh, n, weight, {});
      pull.targets = motion.apply(pull.targets);
      for (const auto guess : {arap::InitialGuess::kPrevious, arap::InitialGuess::kHandleRotations}) {
        // Few hard rows are as patches: a drag does not ask them how far they rotate.
        if (std::isinf(weight) && n == 8 && guess == arap::InitialGuess::kPrevious) continue;
        TetEngine model(mesh);
        model.set_constraints(pull.constraints());
        model.solve(pull.targets, iterations(1, guess));
        EXPECT_LT(max_distance(model.positions(), motion.apply(mesh.positions())), 1e-6) << weight << " " << n;
      }
    }
}

TEST(Engine, DragOfRowsFollowsThem) {
  const TetMesh mesh = tet_blocks(6, 3, 3);
  for (const double weight : {.3, LinearRows::kHard})
    for (const int n : {8, 60}) {
      const Pull there(mesh, n, weight, bend());
      const Pull rest(mesh, n, weight, {});
      TetEngine model(mesh);
      model.set_constraints(there.constraints());
      for (int frame = 1; frame <= 10; ++frame)
        model.solve(rest.targets + frame / 10. * (there.targets - rest.targets), iterations(3));
      model.solve(there.targets, to_accuracy(1e-9));
      TetEngine at_once(mesh);
      at_once.set_constraints(there.constraints());
      at_once.solve(there.targets, converged());
      EXPECT_LT(max_distance(model.positions(), at_once.positions()), 1e-6) << weight << " " << n;
    }
}

/// Rows of this weight pull at a region beyond `border`, a part of the length; the rows nearest to it name others too.
void expect_that_rows_rotate_a_region(double border, double weight, bool is_anchored) {
  SCOPED_TRACE(testing::Message() << border << " " << weight << " " << is_anchored);
  const TetMesh mesh = tet_blocks(6, 3, 3);
  std::vector<int> regions(static_cast<size_t>(mesh.positions().rows()), -1);
  std::vector<int> members;
  for (int v = 0; v < static_cast<int>(mesh.positions().rows()); ++v)
    if (mesh.positions()(v, 0) > border * mesh.positions().col(0).maxCoeff()) {
      regions[v] = 0;
      members.push_back(v);
    }
  const Pull pull(mesh, 12, weight, bend());
  ModelConstraints constraints = pull.constraints();
  Positions targets = pull.targets;
  if (is_anchored) {
    constraints.set.vertices = {members.back()};
    targets.resize(pull.targets.rows() + 1, 3);
    targets << mesh.positions().row(members.back()), pull.targets;
  }
  TetEngine model(mesh, 1, regions);
  model.set_constraints(constraints);
  model.solve(targets, to_accuracy(1e-10, arap::InitialGuess::kRest));
  const Positions& p = model.positions();
  EXPECT_LT(off_rigid(mesh.positions(), p, members), 1e-12);
  // At the minimum no motion of the region lowers the energy.
  Positions gradient;
  const auto energy = [&](const Positions& at) {
    return model.engine().evaluate(at, gradient) + DenseTets::row_energy(pull.rows, pull.targets, at);
  };
  const double least = energy(p);
  const Vector3 fixed = p.row(members.back()).transpose();
  for (int axis = 0; axis < 3; ++axis)
    for (const double by : {-1e-3, 1e-3}) {
      Positions rotated = p;
      const Matrix3 R = rotation_about(Vector3::Unit(axis), by);
      for (const int v : members) rotated.row(v) = (R * (p.row(v).transpose() - fixed) + fixed).transpose();
      EXPECT_GT(energy(rotated), least) << axis << " " << by;
      Positions moved = p;
      for (const int v : members) moved(v, axis) += by;
      if (!is_anchored) {
        EXPECT_GT(energy(moved), least) << axis << " " << by;
      }
    }
}

TEST(Engine, RowsOfAnyWeightRotateARegion) {
  for (const double border : {.7, .8})
    for (const double weight : {.2, 20., 500., 2e4})
      for (const bool is_anchored : {false, true}) expect_that_rows_rotate_a_region(border, weight, is_anchored);
}

TEST(Engine, RefusesRowsThatNameNothing) {
  TetEngine model(tet_blocks(2, 1, 1));
  ModelConstraints constraints;
  constraints.rows.add({{0, 99}, {1, 1}}, 1);
  expect_error<arap::InvalidInput>([&] { model.set_constraints(constraints); }, {"row 0", "unknown 99"});
}

}  // namespace
}  // namespace arap_test
