// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/cage.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "arap/error.h"
#include "support/cages.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::CageCoordinates;
using arap::CageDeformation;
using arap::CageOptions;
using arap::CageWeights;
using arap::InvalidInput;
using Row = Eigen::RowVector3d;

CageOptions of(CageCoordinates coordinates, int threads = 1) {
  CageOptions options;
  options.coordinates = coordinates;
  options.threads = threads;
  return options;
}

constexpr CageCoordinates kBoth[] = {CageCoordinates::kMeanValue, CageCoordinates::kGreen};

TEST(CageDeformation, AtRestAndUnderSimilaritiesPointsMoveAsTheCage) {
  const RigidMotion motion = Random(4).rigid_motion(3, 5);
  for (const MeshData& mesh : all_cages())
    for (const CageCoordinates coordinates : kBoth) {
      const Positions points = points_inside(mesh, 50);
      const CageDeformation cage(mesh.mesh(), points, of(coordinates));
      EXPECT_LT(max_distance(cage.deform(mesh.positions()), points), 1e-14 * mesh.diagonal()) << mesh.name;
      EXPECT_LT(max_distance(cage.deform(motion.apply(mesh.positions())), motion.apply(points)),
                1e-13 * mesh.diagonal())
          << mesh.name;
      EXPECT_LT(max_distance(cage.deform(100 * motion.apply(mesh.positions())), 100 * motion.apply(points)),
                1e-11 * mesh.diagonal())
          << mesh.name;
    }
}

TEST(CageDeformation, MeanValuesMeetAffineMotionsAndGreenDoesNot) {
  Matrix3 A;
  A << 1.5, .3, 0, -.2, .7, .1, .4, 0, 2;
  for (const MeshData& mesh : all_cages()) {
    const Positions points = points_inside(mesh, 50);
    const Positions expected = (points * A.transpose()).rowwise() + Row(1, 2, 3);
    const Positions moved = (mesh.positions() * A.transpose()).rowwise() + Row(1, 2, 3);
    const auto off = [&](CageCoordinates coordinates) {
      return max_distance(CageDeformation(mesh.mesh(), points, of(coordinates)).deform(moved), expected);
    };
    EXPECT_LT(off(CageCoordinates::kMeanValue), 1e-13 * mesh.diagonal()) << mesh.name;
    EXPECT_GT(off(CageCoordinates::kGreen), 1e-2 * mesh.diagonal()) << mesh.name;
  }
}

TEST(CageDeformation, AQuadThatCrossesItselfHasNoPlane) {
  MeshData mesh = cube();
  std::swap(mesh.vertices[4], mesh.vertices[5]);
  const Positions points = points_inside(cube(), 50);
  const CageDeformation cage(mesh.mesh(), points, of(CageCoordinates::kMeanValue));
  EXPECT_LT(max_distance(cage.deform(mesh.positions()), points), 1e-12);
  EXPECT_TRUE(cage.deform(bent(mesh)).allFinite());
}

/// Single precision in the sum, double in the weights that are told.
TEST(CageDeformation, IsTheSumOfTheWeights) {
  for (const MeshData& mesh : all_cages())
    for (const CageCoordinates coordinates : {CageCoordinates::kMeanValue, CageCoordinates::kHarmonic}) {
      const Positions points = points_inside(mesh, 20);
      const Positions moved = bent(mesh);
      CageOptions options = of(coordinates);
      options.grid_spacing = .05;
      const CageDeformation cage(mesh.mesh(), points, options);
      const Positions posed = cage.deform(moved);
      for (int p = 0; p < points.rows(); ++p) {
        const CageWeights weights = cage.weights(p);
        EXPECT_EQ(weights.triangles.size(), 0);
        EXPECT_LT((weights.vertices.transpose() * mesh.positions() - points.row(p)).norm(), 1e-11 * mesh.diagonal());
        EXPECT_LT((weights.vertices.transpose() * moved - posed.row(p)).norm(), 1e-7 * mesh.diagonal()) << mesh.name;
      }
    }
}

TEST(CageDeformation, GreensSumHasTheNormalsToo) {
  const MeshData mesh = icosphere(1);
  const Positions points = points_inside(mesh, 20);
  const Positions moved = bent(mesh);
  const CageDeformation cage(mesh.mesh(), points, of(CageCoordinates::kGreen));
  const Positions posed = cage.deform(moved);
  const auto twice_area = [&](const Positions& p, int f) {
    const std::vector<int>& face = mesh.faces[f];
    return Row(Row(p.row(face[1]) - p.row(face[0])).cross(Row(p.row(face[2]) - p.row(face[0]))));
  };
  ASSERT_EQ(cage.n_triangles(), mesh.n_faces());
  for (int p = 0; p < points.rows(); ++p) {
    const CageWeights weights = cage.weights(p);
    Row sum = weights.vertices.transpose() * moved;
    for (int f = 0; f < mesh.n_faces(); ++f) {
      const std::vector<int>& face = mesh.faces[f];
      const auto edge = [&](const Positions& of, int k) { return Row(of.row(face[k]) - of.row(face[0])); };
      const Row u = edge(mesh.positions(), 1);
      const Row v = edge(mesh.positions(), 2);
      const Row moved_u = edge(moved, 1);
      const Row moved_v = edge(moved, 2);
      const double stretch = std::sqrt(moved_u.squaredNorm() * v.squaredNorm() - 2 * moved_u.dot(moved_v) * u.dot(v) +
                                       moved_v.squaredNorm() * u.squaredNorm()) /
                             (std::sqrt(8.0) * twice_area(mesh.positions(), f).norm() / 2);
      sum += weights.triangles[f] * stretch * twice_area(moved, f).normalized();
    }
    EXPECT_LT((sum - posed.row(p)).norm(), 1e-7 * mesh.diagonal());
  }
}

TEST(CageDeformation, MeanValuesInterpolateTheCageAndGreenDoesNot) {
  for (const MeshData& mesh : all_cages()) {
    const Positions moved = bent(mesh);
    const CageDeformation cage(mesh.mesh(), mesh.positions());
    EXPECT_LT(max_distance(cage.deform(moved), moved), 1e-7 * mesh.diagonal()) << mesh.name;
  }
  const MeshData mesh = cube();
  const Positions inner = (1 - 1e-7) * mesh.positions();
  const auto off = [&](CageCoordinates coordinates) {
    return max_distance(CageDeformation(mesh.mesh(), inner, of(coordinates)).deform(bent(mesh)), bent(mesh));
  };
  EXPECT_LT(off(CageCoordinates::kMeanValue), 1e-5);
  EXPECT_GT(off(CageCoordinates::kGreen), 1e-2);
}

/// Symmetric, though every quad is cut into triangles.
TEST(CageDeformation, MirroredMotionsGiveMirroredResults) {
  const MeshData mesh = cube();
  const Positions points = points_inside(mesh, 30);
  const auto mirrored = [](Positions p) {
    p.col(0) *= -1;
    return p;
  };
  const Positions moved = bent(mesh);
  Positions image(8, 3);
  for (int v = 0; v < 8; ++v)
    for (int w = 0; w < 8; ++w)
      if (mirrored(mesh.positions()).row(w) == mesh.positions().row(v)) image.row(v) = mirrored(moved).row(w);
  for (const CageCoordinates coordinates : kBoth) {
    const Positions once = CageDeformation(mesh.mesh(), points, of(coordinates)).deform(moved);
    const Positions other = CageDeformation(mesh.mesh(), mirrored(points), of(coordinates)).deform(image);
    EXPECT_LT(max_distance(mirrored(once), other), 1e-7);
  }
}

TEST(CageDeformation, ItDoesNotMatterWhichWayTheCageFaces) {
  for (const MeshData& mesh : all_cages())
    for (const CageCoordinates coordinates : kBoth) {
      const Positions points = points_inside(mesh, 20);
      const CageDeformation once(mesh.mesh(), points, of(coordinates));
      const CageDeformation other(flipped(mesh).mesh(), points, of(coordinates));
      for (int p = 0; p < points.rows(); ++p)
        EXPECT_LT((once.weights(p).vertices - other.weights(p).vertices).cwiseAbs().maxCoeff(), 1e-13) << mesh.name;
      EXPECT_LT(max_distance(once.deform(bent(mesh)), other.deform(bent(mesh))), 1e-7 * mesh.diagonal()) << mesh.name;
    }
}

TEST(CageDeformation, IsTheSameOnEveryNumberOfThreads) {
  const MeshData mesh = bumpy_sphere(1);
  const Positions points = points_inside(mesh, 700);
  for (const CageCoordinates coordinates : kBoth) {
    const Positions expected = CageDeformation(mesh.mesh(), points, of(coordinates, 1)).deform(bent(mesh));
    for (const int threads : {2, 3, 7}) {
      const CageDeformation cage(mesh.mesh(), points, of(coordinates, threads));
      EXPECT_EQ(cage.threads(), threads);
      EXPECT_EQ(cage.deform(bent(mesh)), expected);
    }
  }
}

TEST(CageDeformation, LosesNoDigitsFarFromTheOriginAndInAnyUnit) {
  const MeshData mesh = bumpy_sphere(1);
  const Positions points = points_inside(mesh, 20);
  const Positions moved = bent(mesh);
  const Row away(1 << 20, -(1 << 21), 1 << 19);
  for (const CageCoordinates coordinates : kBoth) {
    const Positions expected = CageDeformation(mesh.mesh(), points, of(coordinates)).deform(moved);
    for (const double unit : {1e-30, 1.0, 1e30}) {
      const auto map = [&](const Positions& p) -> Positions { return unit * (p.rowwise() + away); };
      const MeshData far = transformed(mesh, [&](const Vector3& x) { return Vector3(unit * (x + away.transpose())); });
      const Positions result = CageDeformation(far.mesh(), map(points), of(coordinates)).deform(map(moved));
      EXPECT_LT(max_distance((result / unit).rowwise() - away, expected), 5e-9);
    }
  }
}

TEST(CageDeformation, MayBeAsSmallOrLargeAsNumbersAllow) {
  const MeshData mesh = bumpy_sphere(1);
  const Positions points = points_inside(mesh, 20);
  for (const CageCoordinates coordinates : kBoth) {
    const Positions expected = CageDeformation(mesh.mesh(), points, of(coordinates)).deform(bent(mesh));
    for (const double unit : {1e-99, 1e99}) {
      const MeshData other = transformed(mesh, [&](const Vector3& x) { return Vector3(unit * x); });
      const CageDeformation cage(other.mesh(), unit * points, of(coordinates));
      EXPECT_LT(max_distance(cage.deform(unit * bent(mesh)) / unit, expected), 1e-9) << unit;
    }
  }
}

/// What is in no face has no say.
TEST(CageDeformation, LooseVerticesOfTheCageCarryNothing) {
  MeshData mesh = cube();
  mesh.add_vertex({7, 8, 9});
  const Positions points = points_inside(cube(), 10);
  const CageDeformation cage(mesh.mesh(), points);
  Positions moved = mesh.positions();
  moved.row(8).setConstant(-50);
  EXPECT_LT(max_distance(cage.deform(moved), points), 1e-14);
  EXPECT_EQ(cage.weights(0).vertices[8], 0);
}

TEST(CageDeformation, WritesInSinglePrecision) {
  const MeshData mesh = cube();
  const Positions points = points_inside(mesh, 33);
  const CageDeformation cage(mesh.mesh(), points);
  std::vector<float> out(99);
  cage.deform(bent(mesh), out);
  const Positions expected = cage.deform(bent(mesh));
  for (int k = 0; k < 99; ++k) EXPECT_EQ(out[k], static_cast<float>(expected.data()[k]));
}

TEST(CageDeformation, TellsWhatItIsAndMoves) {
  const MeshData mesh = cube();
  CageDeformation cage(mesh.mesh(), points_inside(mesh, 33), of(CageCoordinates::kGreen));
  EXPECT_EQ(cage.n_points(), 33);
  EXPECT_EQ(cage.n_vertices(), 8);
  EXPECT_EQ(cage.n_triangles(), 24);
  EXPECT_EQ(cage.threads(), 1);
  const CageDeformation moved = std::move(cage);
  EXPECT_EQ(moved.weights(32).triangles.size(), 24);
}

TEST(CageDeformation, ProgressRisesToOneAndMayStop) {
  const MeshData mesh = cube();
  std::vector<double> told;
  const Positions points = points_inside(mesh, 33);
  const CageDeformation cage(mesh.mesh(), points, {}, [&](double fraction) {
    told.push_back(fraction);
    return true;
  });
  ASSERT_FALSE(told.empty());
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  EXPECT_EQ(told.back(), 1);
  expect_error<arap::Cancelled>([&] { CageDeformation(mesh.mesh(), points, {}, [](double) { return false; }); },
                                {"weights of the cage", "cancelled"});
}

TEST(CageDeformationErrors, SayWhatIsWrong) {
  const MeshData mesh = cube();
  const Positions points = points_inside(mesh, 3);
  const auto make = [&](const Positions& some, const CageOptions& options = {}) {
    return [&mesh, some, options] { CageDeformation(mesh.mesh(), some, options); };
  };
  expect_error<InvalidInput>(make(points, of(CageCoordinates::kGreen, -1)), {"threads = -1", "0", "1024"});
  expect_error<InvalidInput>(make(Positions(0, 3)), {"points is empty", "at least one"});
  CageOptions options = of(CageCoordinates::kHarmonic);
  options.grid_spacing = .004;
  expect_error<InvalidInput>(make(points, options), {"grid_spacing = 0.004", "0.005", "0.1"});
  Positions bad = points;
  bad(1, 2) = std::numeric_limits<double>::quiet_NaN();
  expect_error<InvalidInput>(make(bad), {"points: row 1", "nan", "finite"});
  MeshData open = mesh;
  open.faces.pop_back();
  expect_error<InvalidInput>([&] { CageDeformation(open.mesh(), points); }, {"cage is not closed"});
  const CageDeformation cage(mesh.mesh(), points);
  expect_error<InvalidInput>([&] { static_cast<void>(cage.deform(points)); }, {"cage_positions", "3", "8"});
  Positions moved = mesh.positions();
  moved(5, 0) = std::numeric_limits<double>::infinity();
  expect_error<InvalidInput>([&] { static_cast<void>(cage.deform(moved)); }, {"cage_positions", "vertex 5", "finite"});
  std::vector<float> few(5);
  expect_error<InvalidInput>([&] { cage.deform(mesh.positions(), few); }, {"out", "5", "9"});
  std::vector<float> out(9);
  expect_error<InvalidInput>([&] { cage.deform(1e60 * mesh.positions(), out); }, {"single precision", "far away"});
  bad(1, 2) = 1e35;
  expect_error<InvalidInput>(make(bad), {"points: row 1", "1e30 times the cage's size", "leave it out"});
  for (const int point : {-1, 3})
    expect_error<InvalidInput>([&] { static_cast<void>(cage.weights(point)); }, {"point", "0 to 2"});
}

TEST(CageDeformationErrors, GreenTellsWhatIsNotInside) {
  const MeshData mesh = cube();
  Positions points(12, 3);
  points << points_inside(mesh, 2), .5, 0, 0, .5, .5, .5, points_inside(mesh, 2), Random(1).noise(6, .1).array() + 2;
  expect_error<InvalidInput>([&] { CageDeformation(mesh.mesh(), points, of(CageCoordinates::kGreen)); },
                             {"8 of 12 points", "(2, 3, 6, 7, 8, ...)", "not inside", "larger", "mean value"});
  EXPECT_EQ(CageDeformation(mesh.mesh(), points).n_points(), 12);
}

}  // namespace
}  // namespace arap_test
