// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/cage_arap/cage_holds.h"

#include <gtest/gtest.h>

#include <chrono>
#include <numeric>
#include <set>
#include <thread>
#include <vector>

#include "arap/error.h"
#include "sampling/surface_patch.h"
#include "support/helpers.h"
#include "support/meshes.h"

namespace arap_test {
namespace {

using arap::CageHolds;
using arap::CagePoints;

/// A mesh in a box, and what its constraints mean for that.
struct Held {
  /// @param size  of the box, beside the mesh's diagonal
  explicit Held(double size, const arap::MeterPart& meter = {})
      : mesh(data.mesh()),
        cage(box({2, 2, 2}, size * data.diagonal() * Vector3::Ones(), Faces::kQuads).mesh()),
        points(cage, mesh.positions(), {}, {}),
        areas(arap::vertex_areas(mesh)),
        holds(points, numbers(), mesh, areas, cage, kStiffness, task.constraints, meter) {}

  [[nodiscard]] std::vector<int> numbers() const {
    std::vector<int> result(data.n_vertices());
    std::iota(result.begin(), result.end(), 0);
    return result;
  }

  /// Of a cage, with the targets that another one meets.
  [[nodiscard]] double energy(const Positions& at, const Positions& meets) const {
    const Positions carried = points.rows(0, data.n_vertices()) * meets;
    const Positions targets = holds.targets(rows(carried, task.constraints.vertices));
    double sum = 0;
    for (int r = 0; r < holds.rows().size(); ++r)
      sum += holds.rows().weights[r] / 2 * (holds.rows().rows[r].of(at) - targets.row(r)).squaredNorm();
    return sum;
  }

  static constexpr double kStiffness = 3;
  MeshData data = bar(6, Faces::kQuads);
  Task task = hold(data, extreme_vertices(data.positions(), 0, .2));
  arap::PolygonMesh mesh;
  arap::PolygonMesh cage;
  CagePoints points;
  std::vector<double> areas;
  CageHolds holds;
};

/// The sum of what vertices of this strength have, in a cage whose vertices have a larger area than they have together.
double expected_energy(const Held& held, double strength, const Positions& at, const Positions& meets) {
  const std::vector<int>& vertices = held.task.constraints.vertices;
  const std::vector<double> of_cage = arap::vertex_areas(held.cage);
  const double cage_area = std::reduce(of_cage.begin(), of_cage.end()) / held.cage.n_vertices();
  double area = 0;
  for (const int v : vertices) area += held.areas[v];
  const double lacking = std::max(0.0, cage_area - area) / static_cast<double>(vertices.size());
  double sum = 0;
  for (const int v : vertices) {
    const Positions gap = held.points.rows(v, 1) * (at - meets);
    sum += strength * (held.areas[v] + lacking) / cage_area * gap.squaredNorm();
  }
  return Held::kStiffness * sum;
}

TEST(CageHolds, AreTheSumOverTheVertices) {
  constexpr double kHard = 1e4;
  const Held held(1.1);
  const Positions rest = held.cage.positions();
  const Positions moved = rest + Random(5).noise(held.cage.n_vertices(), 1);
  const double expected = expected_energy(held, kHard, rest, moved);
  EXPECT_NEAR(held.energy(rest, moved), expected, 1e-6 * expected);
  EXPECT_LT(held.energy(moved, moved), 1e-18 * expected);
  EXPECT_LT(held.holds.rows().size(), held.cage.n_vertices());
}

TEST(CageHolds, KnowTheTurnOfAHandleThatIsTinyBesideTheCage) {
  constexpr double kHard = 1e4;
  const Held held(1e4);
  const RigidMotion turn{rotation_about({1, 2, 3}, 1), {0, 0, 0}};
  // About the middle of the handle, which stays.
  const Eigen::RowVector3d middle = rows(held.mesh.positions(), held.task.constraints.vertices).colwise().mean();
  const Positions rest = held.cage.positions().rowwise() - middle;
  const Positions moved = turn.apply(rest).rowwise() + middle;
  const double expected = expected_energy(held, kHard, held.cage.positions(), moved);
  EXPECT_NEAR(held.energy(held.cage.positions(), moved), expected, 1e-5 * expected);
}

TEST(CageHolds, TellHowFarTheyAreAndCanBeStopped) {
  using namespace std::chrono_literals;
  std::set<double> told;
  const arap::Progress progress = [&](double fraction) {
    told.insert(fraction);
    std::this_thread::sleep_for(110ms);  // after which the meter tells what comes next
    return told.size() < 4;
  };
  arap::Meter meter(progress, "stopped");
  meter.tell();
  expect_error<arap::Cancelled>([&] { Held(1.1, {&meter, 1}); }, {"stopped"});
  EXPECT_EQ(told.size(), 4);
  EXPECT_LT(*told.rbegin(), 1);
}

}  // namespace
}  // namespace arap_test
