// SPDX-License-Identifier: GPL-3.0-or-later
#include "cages/harmonic.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cages/harmonic_grid.h"
#include "cages/mean_value.h"
#include "support/cages.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::Cage;
using arap::WeightBlocks;
using Row = Eigen::RowVector3d;

Positions to_cage(const Cage& cage, Positions points) {
  for (auto point : points.rowwise()) point = cage.to_cage(point);
  return points;
}

/// Weights of points of the cage's space, (n, n_vertices).
Eigen::MatrixXd weights_of(const Cage& cage, const Positions& points, double spacing = 1. / 32, int threads = 1) {
  WeightBlocks weights(static_cast<int>(points.rows()), cage.n_vertices());
  EXPECT_TRUE(harmonic_weights(cage, spacing, points, arap::Workers(threads), {}, weights).empty());
  Eigen::MatrixXd result(points.rows(), cage.n_vertices());
  for (int p = 0; p < points.rows(); ++p) {
    Eigen::VectorXd of_point = weights.of_point(p);
    repair_weights(cage, points.row(p), of_point);
    result.row(p) = of_point.transpose();
  }
  return result;
}

TEST(Harmonic, WeightsSumToOneGiveThePointAndAreNotNegative) {
  for (const MeshData& mesh : all_cages()) {
    const Cage cage(mesh.mesh());
    const Positions points = to_cage(cage, points_inside(mesh, 60));
    const Eigen::MatrixXd w = weights_of(cage, points);
    EXPECT_LT((w.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-13) << mesh.name;
    EXPECT_LT(max_distance(w * cage.vertices(), points), 1e-12) << mesh.name;
    EXPECT_GT(w.minCoeff(), -1e-3) << mesh.name;
  }
}

TEST(Harmonic, InterpolatesOnTheCage) {
  for (const MeshData& mesh : all_cages()) {
    if (has_bent_quads(mesh)) continue;  // the grid has one of their cuts
    const Cage cage(mesh.mesh());
    Positions points(cage.n_vertices() + cage.n_triangles(), 3);
    points.topRows(cage.n_vertices()) = cage.vertices();
    for (int t = 0; t < cage.n_triangles(); ++t) {
      const auto& corners = cage.triangle(t).vertices;
      points.row(cage.n_vertices() + t) = .2 * cage.vertices().row(corners[0]) + .3 * cage.vertices().row(corners[1]) +
                                          .5 * cage.vertices().row(corners[2]);
    }
    const Eigen::MatrixXd w = weights_of(cage, points);
    for (int p = 0; p < points.rows(); ++p)
      EXPECT_LT((w.row(p).transpose() - mean_value_coordinates(cage, points.row(p))).cwiseAbs().maxCoeff(), 1e-6)
          << mesh.name << ", point " << p;
  }
}

/// On a sphere, the mean over the inside of a concentric one is the value in the middle, and that is the mean over the
/// sphere: the same for all vertices of a regular cage.
TEST(Harmonic, InTheMiddleOfARegularCageAllVerticesCountAlike) {
  for (const MeshData& mesh : {tetrahedron(), cube(), icosphere(0)}) {
    const Cage cage(mesh.mesh());
    const Eigen::MatrixXd w = weights_of(cage, Positions::Zero(1, 3));
    EXPECT_LT((w.array() - 1. / mesh.n_vertices()).abs().maxCoeff(), 1e-2 / mesh.n_vertices()) << mesh.name;
  }
}

/// The hats of a tetrahedron go on inside as linear functions, which the grid has exactly.
TEST(Harmonic, InATetrahedronItIsLinear) {
  const Cage cage(tetrahedron().mesh());
  const arap::HarmonicGrid grid(cage, 1. / 32);
  Eigen::MatrixXd at_nodes = Eigen::MatrixXd::Zero(grid.n_nodes(), 6);
  grid.solve(arap::Workers(1), {}, [&](int first, const Positions& values) { at_nodes.middleCols(first, 3) = values; });
  int n_whole = 0;
  const Positions points = to_cage(cage, points_inside(tetrahedron(), 100));
  for (const auto point : points.rowwise()) {
    const arap::HarmonicGrid::Cell cell = grid.cell_at(point);
    if (!cell.is_whole()) continue;
    ++n_whole;
    Eigen::VectorXd w = Eigen::VectorXd::Zero(6);
    for (int corner = 0; corner < 8; ++corner) {
      double share = 1;
      for (int k = 0; k < 3; ++k) share *= (corner >> (2 - k)) % 2 == 1 ? cell.place[k] : 1 - cell.place[k];
      w += share * at_nodes.row(cell.nodes[corner]).transpose();
    }
    EXPECT_LT((w.head(4) - mean_value_coordinates(cage, point)).cwiseAbs().maxCoeff(), 1e-8);
  }
  EXPECT_GT(n_whole, 50);
}

TEST(Harmonic, FinerGridsComeNearer) {
  for (const MeshData& mesh : {cube(), icosphere(1), l_cage()}) {
    const Cage cage(mesh.mesh());
    const Positions points = to_cage(cage, points_inside(mesh, 50));
    const Eigen::MatrixXd finest = weights_of(cage, points, 1. / 64);
    const auto off = [&](double spacing) { return (weights_of(cage, points, spacing) - finest).cwiseAbs().maxCoeff(); };
    EXPECT_LT(off(1. / 32), .02) << mesh.name;
    EXPECT_LT(off(1. / 32), off(1. / 12)) << mesh.name;
  }
}

/// However far away: the grid is around what has faces.
TEST(Harmonic, LooseVerticesOfTheCageChangeNothing) {
  const MeshData mesh = icosphere(1);
  const Cage cage(mesh.mesh());
  const Positions points = to_cage(cage, points_inside(mesh, 20));
  const Eigen::MatrixXd expected = weights_of(cage, points);
  for (const double away : {30., 1e9}) {
    MeshData with_loose = mesh;
    with_loose.add_vertex(away * Vector3(1, -.5, .3));
    const Eigen::MatrixXd weights = weights_of(Cage(with_loose.mesh()), points);
    EXPECT_EQ(weights.leftCols(mesh.n_vertices()), expected) << away;
    EXPECT_TRUE(weights.rightCols(1).isZero(0)) << away;
  }
}

/// Where mean values reach around a corner, harmonic weights do not.
TEST(Harmonic, ALimbFollowsItsOwnPart) {
  const MeshData mesh = l_cage(4);
  const Cage cage(mesh.mesh());
  Positions point(1, 3);
  point << 3, .25, .1;  // the end of one arm
  point = to_cage(cage, point);
  const Eigen::MatrixXd w = weights_of(cage, point);
  const Eigen::VectorXd mean_values = mean_value_coordinates(cage, point.row(0));
  double of_harmonic = 0;
  double of_mean_values = 0;
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (mesh.vertices[v].y() > 3.9) {  // of the other arm
      of_harmonic += std::abs(w(0, v));
      of_mean_values += std::abs(mean_values[v]);
    }
  EXPECT_LT(of_harmonic, of_mean_values / 10);
}

/// Without a node inside, the cage alone says what a point hangs on.
TEST(Harmonic, ACageMayBeThinnerThanACell) {
  const MeshData mesh = box({2, 2, 1}, {1, 1, .01}, Faces::kQuads);
  const Cage cage(mesh.mesh());
  Positions points(3, 3);
  points << 0, 0, 0, .2, .1, .001, -.3, .3, -.002;
  const Eigen::MatrixXd w = weights_of(cage, points, .1);
  EXPECT_LT(max_distance(w * cage.vertices(), points), 1e-10);
  EXPECT_LT((w.rowwise().sum().array() - 1).abs().maxCoeff(), 1e-12);
  EXPECT_GT(w.minCoeff(), -1e-2);
}

TEST(Harmonic, TellsWhatIsOutside) {
  const Cage cage(cube().mesh());
  Positions points(3, 3);
  points << 0, 0, 0, .3, 0, 0, .2, .9, .1;
  WeightBlocks weights(3, 8);
  EXPECT_EQ(harmonic_weights(cage, .05, points, arap::Workers(1), {}, weights), (std::vector{1, 2}));
}

TEST(Harmonic, IsTheSameAgain) {
  const Cage cage(bumpy_sphere(1).mesh());
  const Positions points = to_cage(cage, points_inside(bumpy_sphere(1), 30));
  EXPECT_EQ(weights_of(cage, points, .05, 2), weights_of(cage, points, .05, 2));
  EXPECT_LT((weights_of(cage, points, .05, 2) - weights_of(cage, points, .05, 1)).cwiseAbs().maxCoeff(), 1e-6);
}

}  // namespace
}  // namespace arap_test
