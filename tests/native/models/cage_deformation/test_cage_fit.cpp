// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <limits>
#include <thread>
#include <vector>

#include "arap/cage.h"
#include "arap/error.h"
#include "support/cages.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::CageCoordinates;
using arap::CageDeformation;
using arap::CageOptions;
using arap::InvalidInput;

CageOptions fit_options(CageCoordinates coordinates) {
  CageOptions options;
  options.coordinates = coordinates;
  options.grid_spacing = .05;
  return options;
}

constexpr CageCoordinates kLinear[] = {CageCoordinates::kMeanValue, CageCoordinates::kHarmonic};

TEST(CageFit, FindsTheCageThatMovedThePoints) {
  for (const MeshData& mesh : all_cages())
    for (const CageCoordinates coordinates : kLinear) {
      const CageDeformation cage(mesh.mesh(), points_inside(mesh, 400), fit_options(coordinates));
      const Positions moved = bent(mesh);
      const Positions found = cage.fit(cage.deform(moved), 1e-9);
      EXPECT_LT(max_distance(found, moved), 1e-2 * mesh.diagonal()) << mesh.name;
      EXPECT_LT(max_distance(cage.deform(found), cage.deform(moved)), 1e-4 * mesh.diagonal()) << mesh.name;
    }
}

TEST(CageFit, IsExactForTurnsScalesAndShiftsHoweverSmooth) {
  const RigidMotion motion = Random(4).rigid_motion(3, 5);
  for (const MeshData& mesh : all_cages())
    for (const double smoothness : {1e-9, 1e-2}) {
      // Also where one point tells little.
      for (const int n : {3, 50}) {
        const Positions points = points_inside(mesh, n);
        const CageDeformation cage(mesh.mesh(), points);
        EXPECT_LT(max_distance(cage.fit(2 * motion.apply(points), smoothness), 2 * motion.apply(mesh.positions())),
                  1e-9 * mesh.diagonal())
            << mesh.name;
      }
    }
}

TEST(CageFit, OnePointMovesTheWholeCage) {
  const MeshData mesh = icosphere(1);
  const CageDeformation cage(mesh.mesh(), points_inside(mesh, 1));
  const Eigen::RowVector3d shift(1, 2, 3);
  EXPECT_LT(max_distance(cage.fit(points_inside(mesh, 1).rowwise() + shift), mesh.positions().rowwise() + shift), 1e-9);
}

TEST(CageFit, DoesNotHangOnTheUnitNorOnTheNumberOfPoints) {
  const MeshData mesh = bumpy_sphere(1);
  const Positions points = points_inside(mesh, 30);
  const Positions targets = CageDeformation(mesh.mesh(), points).deform(bent(mesh)) + Random(3).noise(30, .01);
  const Positions expected = CageDeformation(mesh.mesh(), points).fit(targets, 1e-4);
  const MeshData large = transformed(mesh, [](const Vector3& x) { return Vector3(100 * x); });
  EXPECT_LT(max_distance(CageDeformation(large.mesh(), 100 * points).fit(100 * targets, 1e-4) / 100, expected), 1e-6);
  const CageDeformation twice(mesh.mesh(), points.replicate(2, 1));
  EXPECT_LT(max_distance(twice.fit(targets.replicate(2, 1), 1e-4), expected), 1e-9);
}

TEST(CageFit, SmoothnessDrawsTheCageToTheMotionOfThePoints) {
  const MeshData mesh = bumpy_sphere(1);
  const Positions points = points_inside(mesh, 200);
  const CageDeformation cage(mesh.mesh(), points);
  const Positions targets = cage.deform(bent(mesh));
  double last = 0;
  for (const double smoothness : {1e-9, 1e-6, 1e-3, 1.0}) {
    const double left = (cage.deform(cage.fit(targets, smoothness)) - targets).norm();
    EXPECT_GT(left, last);
    last = left;
  }
}

TEST(CageFit, LooseVerticesOfTheCageChangeNothing) {
  const MeshData mesh = icosphere(1);
  MeshData with_loose = mesh;
  for (int k = 0; k < mesh.n_vertices(); ++k) with_loose.add_vertex({30, 20, 10});
  const Positions points = points_inside(mesh, 30);
  const Positions moved = points + Random(3).noise(30, .2);
  const Positions expected = CageDeformation(mesh.mesh(), points).fit(moved, 1e-2);
  const Positions result = CageDeformation(with_loose.mesh(), points).fit(moved, 1e-2);
  EXPECT_LT(max_distance(result.topRows(mesh.n_vertices()), expected), 1e-9);
}

TEST(CageFit, SeveralThreadsMayFitAtOnce) {
  const MeshData mesh = bumpy_sphere(1);
  const CageDeformation cage(mesh.mesh(), points_inside(mesh, 100));
  const Positions targets = cage.deform(bent(mesh));
  const Positions expected = CageDeformation(mesh.mesh(), points_inside(mesh, 100)).fit(targets);
  std::vector<Positions> found(4);
  std::vector<std::thread> threads;
  for (int k = 0; k < 4; ++k) threads.emplace_back([&, k] { found[k] = cage.fit(targets, k % 2 == 0 ? 1e-6 : 1e-3); });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(found[0], expected);
  EXPECT_EQ(found[2], expected);
  EXPECT_EQ(found[1], found[3]);
}

TEST(CageFit, SaysWhatIsWrong) {
  const MeshData mesh = cube();
  const Positions points = points_inside(mesh, 5);
  const auto fit = [&](const Positions& positions, double smoothness, CageCoordinates coordinates) {
    static_cast<void>(CageDeformation(mesh.mesh(), points, fit_options(coordinates)).fit(positions, smoothness));
  };
  expect_error<InvalidInput>([&] { fit(mesh.positions(), 1, CageCoordinates::kMeanValue); },
                             {"positions has 8 rows, expected 5"});
  Positions nowhere = points;
  nowhere(2, 0) = std::numeric_limits<double>::quiet_NaN();
  expect_error<InvalidInput>([&] { fit(nowhere, 1, CageCoordinates::kMeanValue); },
                             {"positions: row 2", "must be finite"});
  expect_error<InvalidInput>([&] { fit(points, 0, CageCoordinates::kMeanValue); },
                             {"smoothness = 0, must be >= 1e-12 and <= 1"});
  expect_error<InvalidInput>([&] { fit(points, 1, CageCoordinates::kGreen); },
                             {"Green coordinates are not linear in the cage, so no cage can be fitted"});
}

}  // namespace
}  // namespace arap_test
