// SPDX-License-Identifier: GPL-3.0-or-later
#include "cages/green.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/cages.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::Cage;
using arap::green_coordinates;
using arap::GreenCoordinates;
using arap::stretched_normals;
using Row = Eigen::RowVector3d;

Row carried(const Cage& cage, const GreenCoordinates& weights, const Positions& moved) {
  return weights.vertices.transpose() * moved + weights.triangles.transpose() * stretched_normals(cage, moved);
}

TEST(Green, WeightsSumToOneAndGiveThePoint) {
  for (const MeshData& mesh : all_cages()) {
    const Cage cage(mesh.mesh());
    const Positions points = points_inside(mesh, 20);
    for (const auto point : points.rowwise()) {
      const Row x = cage.to_cage(point);
      const GreenCoordinates weights = green_coordinates(cage, x);
      EXPECT_TRUE(weights.is_inside) << mesh.name;
      EXPECT_NEAR(weights.vertices.sum(), 1, 1e-13) << mesh.name;
      EXPECT_LT((carried(cage, weights, cage.vertices()) - x).norm(), 1e-13) << mesh.name;
    }
  }
}

TEST(Green, IsTheIntegralsOfTheFundamentalSolution) {
  for (const MeshData& mesh : all_cages()) {
    const Cage cage(mesh.mesh());
    const Positions points = points_inside(mesh, 2);
    for (const auto point : points.rowwise()) {
      const Vector3 x = cage.to_cage(point).transpose();
      const GreenCoordinates weights = green_coordinates(cage, x.transpose());
      const auto of_vertices = [&](int levels) {
        return integrate(cage, levels,
                         [&](const Vector3& y, const Vector3& normal) {
                           return (y - x).dot(normal) / (4 * std::numbers::pi * std::pow((y - x).norm(), 3));
                         })
            .hats;
      };
      const auto of_triangles = [&](int levels) {
        return integrate(cage, levels,
                         [&](const Vector3& y, const Vector3& /*normal*/) {
                           return 1 / (4 * std::numbers::pi * (y - x).norm());
                         })
            .wholes;
      };
      const auto expect_near = [&](const Eigen::VectorXd& actual, const auto& quadrature) {
        const Eigen::VectorXd fine = quadrature(5);
        const double error = (fine - quadrature(4)).cwiseAbs().maxCoeff();
        EXPECT_LT(error, 1e-3) << mesh.name;
        EXPECT_LT((actual - fine).cwiseAbs().maxCoeff(), error) << mesh.name;
      };
      expect_near(weights.vertices, of_vertices);
      expect_near(weights.triangles, of_triangles);
    }
  }
}

TEST(Green, SimilaritiesAreExactAndAffineMapsAreNot) {
  Random random(5);
  for (const MeshData& mesh : all_cages()) {
    const Cage cage(mesh.mesh());
    const Row x = cage.to_cage(points_inside(mesh, 1).row(0));
    const GreenCoordinates weights = green_coordinates(cage, x);
    const RigidMotion motion = random.rigid_motion(3, 2);
    EXPECT_LT((carried(cage, weights, 3 * motion.apply(cage.vertices())) - 3 * motion.apply(Positions(x))).norm(),
              1e-12)
        << mesh.name;
    Matrix3 stretch = Matrix3::Identity();
    stretch(0, 0) = 2;
    EXPECT_GT((carried(cage, weights, cage.vertices() * stretch) - x * stretch).norm(), 1e-3) << mesh.name;
  }
}

TEST(Green, ThePointIsGivenUpToTheFaces) {
  for (const MeshData& mesh : all_cages()) {
    const Cage cage(mesh.mesh());
    for (int t = 0; t < cage.n_triangles(); ++t) {
      const arap::CageTriangle& triangle = cage.triangle(t);
      for (const double off : {1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 5e-12})
        for (const Vector3& hats : {Vector3(.2, .3, .5), Vector3(.5, .5, 0), Vector3(.998, .001, .001)}) {
          Row x = off * Row::Map(triangle.depth);
          for (int k = 0; k < 3; ++k) x += hats[k] * cage.vertices().row(triangle.vertices[k]);
          const GreenCoordinates weights = green_coordinates(cage, x);
          if (!weights.is_inside) continue;  // at an edge, or between both cuts of a quad
          EXPECT_NEAR(weights.vertices.sum(), 1, 1e-11) << mesh.name << " " << off;
          EXPECT_LT((carried(cage, weights, cage.vertices()) - x).norm(), 1e-11) << mesh.name << " " << off;
        }
    }
  }
}

TEST(Green, KnowsWhatIsInside) {
  for (const MeshData& mesh : all_cages()) {
    const Cage cage(mesh.mesh());
    const Positions points = Random(7).noise(60, mesh.diagonal() / 2);
    for (const auto point : points.rowwise()) {
      const Row x = point + (mesh.positions().colwise().maxCoeff() + mesh.positions().colwise().minCoeff()) / 2;
      const double wound = winding(mesh, x.transpose());
      // Near a bent quad it depends on the cut.
      if (std::abs(wound - .5) > .49 && !has_bent_quads(mesh)) {
        EXPECT_EQ(green_coordinates(cage, cage.to_cage(x)).is_inside, wound > .5) << mesh.name;
      }
    }
    for (const auto vertex : cage.vertices().rowwise()) EXPECT_FALSE(green_coordinates(cage, vertex).is_inside);
    const Row on_edge = (cage.vertices().row(mesh.faces[0][0]) + cage.vertices().row(mesh.faces[0][1])) / 2;
    EXPECT_FALSE(green_coordinates(cage, on_edge).is_inside) << mesh.name;
  }
}

TEST(Green, ATriangleWithoutAreaAddsNothing) {
  const Cage cage(tetrahedron().mesh());
  EXPECT_EQ(stretched_normals(cage, Positions::Zero(4, 3)), Positions::Zero(4, 3));
}

}  // namespace
}  // namespace arap_test
