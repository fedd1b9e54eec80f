// SPDX-License-Identifier: GPL-3.0-or-later
#include "cages/mean_value.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/cages.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::Cage;
using arap::mean_value_coordinates;
using Row = Eigen::RowVector3d;

Row in_cage(const Cage& cage, const Vector3& point) { return cage.to_cage(point.transpose()); }

/// Points of a face: hats of a triangle's corners.
constexpr double kPlaces[][3] = {{.2, .3, .5}, {.6, .4, 0}, {.5, .5, 0}, {1, 0, 0}, {.999, .0005, .0005}};

TEST(MeanValue, WeightsSumToOneAndGiveThePoint) {
  for (const MeshData& mesh : all_cages()) {
    const Cage cage(mesh.mesh());
    Positions points(40, 3);
    points << points_inside(mesh, 20), Random(3).noise(20, 2 * mesh.diagonal());  // many of them outside
    for (const auto point : points.rowwise()) {
      const Row x = cage.to_cage(point);
      const Eigen::VectorXd w = mean_value_coordinates(cage, x);
      EXPECT_NEAR(w.sum(), 1, 1e-13) << mesh.name;
      EXPECT_LT((w.transpose() * cage.vertices() - x).norm(), 1e-12) << mesh.name;
    }
  }
}

TEST(MeanValue, IsTheIntegralOfTheHats) {
  for (const MeshData& mesh : all_cages()) {
    const Cage cage(mesh.mesh());
    const Positions points = points_inside(mesh, 2);
    for (const auto point : points.rowwise()) {
      const Vector3 x = cage.to_cage(point).transpose();
      const auto kernel = [&](const Vector3& y, const Vector3& normal) {
        return (y - x).dot(normal) / std::pow((y - x).squaredNorm(), 2);
      };
      Eigen::VectorXd coarse = integrate(cage, 4, kernel).hats;
      Eigen::VectorXd fine = integrate(cage, 5, kernel).hats;
      coarse /= coarse.sum();
      fine /= fine.sum();
      const double error = (fine - coarse).cwiseAbs().maxCoeff();
      EXPECT_LT(error, 1e-3) << mesh.name;
      EXPECT_LT((mean_value_coordinates(cage, x.transpose()) - fine).cwiseAbs().maxCoeff(), error) << mesh.name;
    }
  }
}

TEST(MeanValue, IsWhatThePrintedAlgorithmGives) {
  for (const MeshData& mesh : all_cages()) {
    const Cage cage(mesh.mesh());
    const Positions points = points_inside(mesh, 20);
    for (const auto point : points.rowwise()) {
      const Row x = cage.to_cage(point);
      EXPECT_LT((mean_value_coordinates(cage, x) - printed_mean_values(cage, x.transpose())).cwiseAbs().maxCoeff(),
                1e-12)
          << mesh.name;
    }
  }
}

/// Beside a triangle in its plane the printed algorithm loses all digits. Long double has three more.
TEST(MeanValue, KeepsItsDigitsInThePlaneOfATriangle) {
  const bool has_more_digits = std::numeric_limits<long double>::digits > 60;
  const Cage cage(l_cage().mesh());
  for (const double off : {1e-2, 1e-4, 1e-6, 1e-7}) {
    if (off < 1e-4 && !has_more_digits) continue;
    const Row x = in_cage(cage, {.3, .5 + off, .4});  // behind the inner wall at y = .5
    EXPECT_LT((mean_value_coordinates(cage, x) - printed_mean_values(cage, x.transpose())).cwiseAbs().maxCoeff(), 2e-11)
        << off;
  }
  const Eigen::VectorXd there = mean_value_coordinates(cage, in_cage(cage, {.3, .5, .4}));
  for (const double off : {1e-8, 1e-9, 1e-11, 1e-12, 1e-14, 1e-16})
    EXPECT_LT((mean_value_coordinates(cage, in_cage(cage, {.3, .5 + off, .4})) - there).cwiseAbs().maxCoeff(),
              10 * off + 1e-14)
        << off;
}

TEST(MeanValue, InterpolatesOnFacesEdgesAndVertices) {
  for (const MeshData& mesh : all_cages()) {
    const Cage cage(mesh.mesh());
    for (int t = 0; t < cage.n_triangles(); ++t) {
      if (mesh.faces[cage.face_of_triangle()[t]].size() > 3) continue;  // on quads see below
      for (const auto& hats : kPlaces) {
        Row x = Row::Zero();
        Eigen::VectorXd expected = Eigen::VectorXd::Zero(cage.n_vertices());
        for (int k = 0; k < 3; ++k) {
          x += hats[k] * cage.vertices().row(cage.triangle(t).vertices[k]);
          expected[cage.triangle(t).vertices[k]] = hats[k];
        }
        EXPECT_LT((mean_value_coordinates(cage, x) - expected).cwiseAbs().maxCoeff(), 1e-12) << mesh.name;
      }
    }
  }
}

TEST(MeanValue, InTheMiddleOfAQuadAllCornersCountAlike) {
  const Cage cage(cube().mesh());
  const Eigen::VectorXd w = mean_value_coordinates(cage, in_cage(cage, {.5, 0, 0}));
  for (int v = 0; v < 8; ++v) EXPECT_NEAR(w[v], cage.vertices()(v, 0) > 0 ? .25 : 0, 1e-15);
}

/// From 1e-1 down to rounding: on the way the weights go over into those of the face, and always give the point.
TEST(MeanValue, IsContinuousAtFacesEdgesAndVertices) {
  for (const MeshData& mesh : all_cages()) {
    const Cage cage(mesh.mesh());
    const arap::CageTriangle& triangle = cage.triangle(cage.n_triangles() - 1);
    const Row normal = -Row::Map(triangle.depth);
    for (const auto& hats : kPlaces) {
      Row foot = Row::Zero();
      for (int k = 0; k < 3; ++k) foot += hats[k] * cage.vertices().row(triangle.vertices[k]);
      const Eigen::VectorXd at_foot = mean_value_coordinates(cage, foot);
      for (double off = 1e-1; off > 1e-16; off /= 10)
        for (const double side : {-1, 1}) {
          const Row x = foot + side * off * normal;
          const Eigen::VectorXd w = mean_value_coordinates(cage, x);
          EXPECT_LT((w.transpose() * cage.vertices() - x).norm(), 1e-11) << mesh.name << " " << off;
          // A bent quad has two surfaces there; between them the weights change fast.
          if (!has_bent_quads(mesh) && off < 1e-3) {
            EXPECT_LT((w - at_foot).cwiseAbs().maxCoeff(), 100 * off + 1e-11) << mesh.name << " " << off;
          }
        }
    }
  }
}

TEST(MeanValue, KeepsItsDigitsFarAway) {
  Random random(6);
  for (const MeshData& mesh : all_cages()) {
    const Cage cage(mesh.mesh());
    for (const double distance : {29.99, 30.01, 1e3, 1e5, 1e12, 1e30}) {
      const Row x = distance * random.vector(1).normalized().transpose();
      const Eigen::VectorXd w = mean_value_coordinates(cage, x);
      EXPECT_LT((w.transpose() * cage.vertices() - x).norm(), 5e-9 * distance) << mesh.name << " " << distance;
      EXPECT_NEAR(w.sum(), 1, 5e-9 * distance) << mesh.name << " " << distance;
    }
    // From both sides of where the formula changes, a ten thousandth apart.
    const Row x = random.vector(1).normalized().transpose();
    const Eigen::VectorXd near = mean_value_coordinates(cage, 29.9999 * x);
    const Eigen::VectorXd far = mean_value_coordinates(cage, 30.0001 * x);
    EXPECT_LT((near - far).norm(), 1e-5 * far.norm()) << mesh.name;
  }
}

}  // namespace
}  // namespace arap_test
