// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/wrap_deformation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "arap/error.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::InvalidInput;
using arap::WrapDeformation;
using arap::WrapOptions;
using arap::WrapSurface;
using Row = Eigen::RowVector3d;

/// Around the mesh, inside and outside, some on vertices and some far away.
Positions points_around(const MeshData& mesh, int n = 60) {
  Random random(5);
  const Positions vertices = mesh.positions();
  Positions points(n, 3);
  for (int k = 0; k < n; ++k) {
    const double reach = k % 3 == 0 ? 0 : k % 3 == 1 ? .05 : 1;
    points.row(k) = vertices.row(k % mesh.n_vertices()) + reach * mesh.diagonal() * random.vector(1).transpose();
  }
  return points;
}

/// Bent about y and made thicker along the way.
Positions bent(const Positions& positions) {
  Positions result = positions;
  for (Eigen::Index k = 0; k < positions.rows(); ++k) {
    const Row p = positions.row(k);
    const double angle = .4 * p[2];
    result.row(k) = Row((1 + p[0]) * std::cos(angle) - 1, p[1] * (1 + .1 * p[2]), (1 + p[0]) * std::sin(angle));
  }
  return result;
}

/// Every face has vertices of its own.
MeshData soup(const MeshData& mesh) {
  MeshData result{"soup of " + mesh.name, {}, {}};
  for (const std::vector<int>& face : mesh.faces) {
    std::vector<int> corners;
    for (const int v : face) corners.push_back(result.add_vertex(mesh.vertices[v]));
    result.faces.push_back(corners);
  }
  return result;
}

/// Surfaces that other wrap deformers refuse, or that have no gradient somewhere.
std::vector<MeshData> dirty_meshes() {
  MeshData inverted = bumpy_sphere(2);
  for (size_t f = 0; f < inverted.faces.size(); f += 3) std::swap(inverted.faces[f][0], inverted.faces[f][1]);
  inverted.name = "every third face inverted";
  MeshData degenerate = bumpy_sphere(2);
  for (size_t f = 0; f < degenerate.faces.size(); f += 4) degenerate.faces[f][1] = degenerate.faces[f][0];
  degenerate.faces.push_back({0, 0, 0});
  degenerate.faces.push_back(degenerate.faces[1]);
  degenerate.add_vertex({9, 9, 9});
  degenerate.name = "degenerate and double faces, a loose vertex";
  MeshData points = bumpy_sphere(2);
  points.faces.clear();
  points.name = "points alone";
  const MeshData line{"a line", {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}}};
  const MeshData place{"one place", {{1, 2, 3}, {1, 2, 3}, {1, 2, 3}}, {{0, 1, 2}}};
  const MeshData vertex{"one vertex", {{1, 2, 3}}, {}};
  const MeshData triangle{"one triangle", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  return {inverted,
          degenerate,
          points,
          line,
          place,
          vertex,
          triangle,
          soup(bumpy_sphere(2)),
          moebius_strip(20, 3),
          bow_tie(),
          book(4, Faces::kQuads),
          cylinder_with_open_seam(12, 8, Faces::kQuads)};
}

std::vector<MeshData> all_surfaces() {
  std::vector<MeshData> meshes = all_small_meshes();
  for (MeshData& mesh : dirty_meshes()) meshes.push_back(std::move(mesh));
  return meshes;
}

TEST(WrapDeformation, AtRestAndUnderSimilaritiesPointsMoveAsTheSurface) {
  const RigidMotion motion = Random(4).rigid_motion(2, 5);
  for (const MeshData& mesh : all_surfaces()) {
    const double size = std::max(mesh.diagonal(), 1.);
    const Positions points = points_around(mesh);
    const WrapDeformation wrap(mesh.mesh(), points);
    EXPECT_LT(max_distance(wrap.deform(mesh.positions()), points), 1e-14 * size) << mesh.name;
    // A line or a point does not tell how it has turned.
    if (mesh.n_vertices() <= 3) continue;
    EXPECT_LT(max_distance(wrap.deform(motion.apply(mesh.positions())), motion.apply(points)), 1e-13 * size)
        << mesh.name;
    EXPECT_LT(max_distance(wrap.deform(.01 * motion.apply(mesh.positions())), .01 * motion.apply(points)), 1e-14 * size)
        << mesh.name;
  }
}

TEST(WrapDeformation, ResultsAreFiniteWhateverTheSurfaceDoes) {
  for (const MeshData& mesh : all_surfaces()) {
    const Positions points = points_around(mesh);
    const WrapDeformation wrap(mesh.mesh(), points);
    const Positions rest = mesh.positions();
    const std::vector<Positions> poses = {Positions::Zero(rest.rows(), 3), -rest, 1e90 * rest, bent(rest),
                                          Random(2).noise(mesh.n_vertices(), 1e4)};
    for (const Positions& pose : poses) EXPECT_TRUE(wrap.deform(pose).allFinite()) << mesh.name;
  }
}

TEST(WrapDeformation, VeryFarPointsAndSurfacesOfNextToNoSizeGiveNumbers) {
  const MeshData mesh = bumpy_sphere(2);
  const Positions rest = mesh.positions();
  const Positions points = points_around(mesh);
  for (const double scale : {1e-300, 1e-165, 1e-100, 1e95}) {
    MeshData scaled = mesh;
    for (Vector3& vertex : scaled.vertices) vertex *= scale;
    for (const double of_points : {1e-300, 1., 1e95}) {
      const WrapDeformation wrap(scaled.mesh(), of_points * points);
      for (const double of_pose : {1e-300, 1., 1e95})
        EXPECT_TRUE(wrap.deform(of_pose * bent(rest)).allFinite()) << scale << " " << of_points << " " << of_pose;
    }
  }
}

TEST(WrapDeformation, APointOnAVertexGoesWithIt) {
  const MeshData mesh = bumpy_sphere(2);
  const WrapDeformation wrap(mesh.mesh(), mesh.positions());
  const Positions moved = bent(mesh.positions());
  EXPECT_LT(max_distance(wrap.deform(moved), moved), 1e-6 * mesh.diagonal());
}

TEST(WrapDeformation, AnEvenlyStretchedPlaneStretchesWhatIsInItAndThickensByTheRootOfTheArea) {
  const MeshData mesh = grid(12, Faces::kQuads);
  Positions points(3, 3);
  points << .1, .2, 0, .1, .2, .05, -.21, .03, -.02;
  Positions moved = mesh.positions();
  moved.col(0) *= 4;
  Positions expected = points;
  expected.col(0) *= 4;
  expected.col(2) *= 2;
  WrapOptions options;
  options.stay_outside = false;
  EXPECT_LT(max_distance(WrapDeformation(mesh.mesh(), points, options).deform(moved), expected), 1e-6);
}

TEST(WrapDeformation, MovesSmoothlyAcrossTheSurfaceAndItsEdges) {
  const MeshData mesh = bumpy_sphere(3);
  const Vector3 a = mesh.vertices[mesh.faces[0][0]];
  const Vector3 b = mesh.vertices[mesh.faces[0][1]];
  const Vector3 c = mesh.vertices[mesh.faces[0][2]];
  // Through the middle of the triangle and of its edge.
  for (const Vector3& place : {Vector3((a + b + c) / 3), Vector3((a + b) / 2)})
    for (const Vector3& along : {Vector3(c - a), Vector3((b - a).cross(c - a))}) {
      constexpr int kSteps = 21;
      Positions points(kSteps, 3);
      for (int k = 0; k < kSteps; ++k)
        points.row(k) = (place + 1e-3 * (k - kSteps / 2) * along.normalized()).transpose();
      const Positions moved = WrapDeformation(mesh.mesh(), points).deform(bent(mesh.positions()));
      for (int k = 1; k < kSteps; ++k) EXPECT_NEAR((moved.row(k) - moved.row(k - 1)).norm(), 1e-3, 5e-4);
    }
}

TEST(WrapDeformation, DoublesMoveAsOneSurface) {
  const MeshData whole = bumpy_sphere(2);
  const MeshData parts = soup(whole);
  // Near points: of the coarse vertices for far ones others are chosen if the order is another one.
  const Positions points = whole.positions() + Random(7).noise(whole.n_vertices(), .03 * whole.diagonal());
  const Positions expected = WrapDeformation(whole.mesh(), points).deform(bent(whole.positions()));
  EXPECT_LT(max_distance(WrapDeformation(parts.mesh(), points).deform(bent(parts.positions())), expected), 1e-3);
}

TEST(WrapDeformation, AFingersRingTakesNothingFromTheNextFinger) {
  const MeshData mesh = hand(.02);
  const Positions rest = mesh.positions();
  // Around the end of the first finger; the gap is narrower than its faces.
  std::vector<Vector3> ring;
  const double top = rest.col(2).maxCoeff();
  for (const Vector3& v : mesh.vertices)
    if (v.x() < 0 && v.z() > top - .3) ring.emplace_back(v + Vector3(v.x() > -.05 ? .005 : 0, 0, 0));
  Positions points(static_cast<Eigen::Index>(ring.size()), 3);
  for (size_t k = 0; k < ring.size(); ++k) points.row(static_cast<Eigen::Index>(k)) = ring[k].transpose();
  Positions moved = rest;
  for (Eigen::Index v = 0; v < rest.rows(); ++v)
    if (rest(v, 0) > 0 && rest(v, 2) > top - 1) moved(v, 0) += rest(v, 2) - top + 1;
  EXPECT_LT(max_distance(WrapDeformation(mesh.mesh(), points).deform(moved), points), .02);
}

/// In double, as coordinates of a map in metres are.
TEST(WrapDeformation, LosesNothingFarFromTheOrigin) {
  const MeshData mesh = bumpy_sphere(3);
  const Positions points = points_around(mesh);
  const Positions moved = bent(mesh.positions());
  const Row away(5e5, 5.4e6, 300);
  const MeshData there = transformed(mesh, [&](const Vector3& x) { return Vector3(x + away.transpose()); });
  const Positions expected = WrapDeformation(mesh.mesh(), points).deform(moved);
  const Positions result = WrapDeformation(there.mesh(), points.rowwise() + away).deform(moved.rowwise() + away);
  EXPECT_LT(max_distance(result.rowwise() - away, expected), 1e-6 * mesh.diagonal());
}

/// The sides of a bar are stretched and pressed where it bends. What is in its middle must not choose one of them.
TEST(WrapDeformation, WhatIsDeepInsideKeepsItsShape) {
  constexpr double kAngle = 1.57;
  const auto bend = [](const Positions& rest) {
    constexpr double kRadius = 2 / kAngle;  // of the middle half of a bar of length 4
    Positions result(rest.rows(), 3);
    for (Eigen::Index k = 0; k < rest.rows(); ++k) {
      const double angle = std::clamp(rest(k, 0) / kRadius, -kAngle / 2, kAngle / 2);
      const double beyond = rest(k, 0) - kRadius * angle;
      const double radius = kRadius - rest(k, 2);
      result.row(k) = Row(radius * std::sin(angle) + beyond * std::cos(angle), rest(k, 1),
                          kRadius - radius * std::cos(angle) + beyond * std::sin(angle));
    }
    return result;
  };
  const MeshData bone = box({40, 2, 2}, {3.6, .15, .15}, Faces::kQuads);
  const Positions at_rest = bone.positions();
  for (const Faces faces : {Faces::kQuads, Faces::kTriangles})
    for (const int n : {2, 3, 4, 8, 16}) {
      MeshData bar = box({4 * n, n, n}, {4, 1, 1}, faces);
      for (const bool is_turned : {false, true}) {
        if (is_turned)
          for (std::vector<int>& face : bar.faces) std::reverse(face.begin(), face.end());
        const Positions moved = WrapDeformation(bar.mesh(), at_rest).deform(bend(bar.positions()));
        for (const std::vector<int>& face : bone.faces)
          for (size_t k = 0; k < face.size(); ++k) {
            const int a = face[k];
            const int b = face[(k + 1) % face.size()];
            const double stretch = (moved.row(a) - moved.row(b)).norm() / (at_rest.row(a) - at_rest.row(b)).norm();
            EXPECT_GT(stretch, .8) << n;
            EXPECT_LT(stretch, 1.3) << n;
          }
      }
    }
}

TEST(WrapDeformation, FarPointsDoNotFollowOneTriangle) {
  const MeshData mesh = grid(40, Faces::kQuads);
  Positions points(2, 3);
  points << 0, 0, .5, 0, 0, .001;
  // One vertex near the middle rises, and its faces stand steep.
  Positions moved = mesh.positions();
  int middle = 0;
  moved.rowwise().squaredNorm().minCoeff(&middle);
  moved(middle, 2) += .02;
  const Positions off = WrapDeformation(mesh.mesh(), points).deform(moved) - points;
  EXPECT_LT(off.row(0).norm(), .02);
  EXPECT_GT(off.row(1).norm(), .01);
}

TEST(WrapDeformation, PiecesStayRigid) {
  const MeshData mesh = bumpy_sphere(2);
  const Positions points = points_around(mesh, 90);
  std::vector<int> pieces(90, -1);
  std::vector<std::vector<int>> of_piece(3);
  for (int p = 0; p < 60; ++p) {
    pieces[p] = 7 * (p % 3);
    of_piece[p % 3].push_back(p);
  }
  const WrapDeformation wrap(mesh.mesh(), points, {}, pieces);
  EXPECT_EQ(wrap.n_pieces(), 3);
  const Positions moved = wrap.deform(bent(mesh.positions()));
  const Positions free = WrapDeformation(mesh.mesh(), points).deform(bent(mesh.positions()));
  for (const std::vector<int>& piece : of_piece) {
    const RigidMotion best = best_rigid_motion(rows(points, piece), rows(free, piece));
    EXPECT_LT(max_distance(rows(moved, piece), best.apply(rows(points, piece))), 1e-12);
  }
  EXPECT_EQ(moved.bottomRows(30), free.bottomRows(30));
}

TEST(WrapDeformation, ThreadsDoNotChangeTheResult) {
  const MeshData mesh = bumpy_sphere(4);
  const Positions points = points_around(mesh, 9000);
  std::vector<int> pieces(9000, -1);
  for (int p = 0; p < 3000; ++p) pieces[p] = p % 5;
  WrapOptions options;
  options.threads = 1;
  const WrapDeformation one(mesh.mesh(), points, options, pieces);
  options.threads = 3;
  const WrapDeformation three(mesh.mesh(), points, options, pieces);
  EXPECT_EQ(three.threads(), 3);
  const Positions moved = bent(mesh.positions());
  EXPECT_EQ(one.deform(moved), three.deform(moved));
}

TEST(WrapDeformation, SinglePrecisionIsTheResultRounded) {
  const MeshData mesh = bumpy_sphere(2);
  const Positions points = points_around(mesh);
  const WrapDeformation wrap(mesh.mesh(), points);
  const Positions moved = bent(mesh.positions());
  std::vector<float> out(points.size());
  wrap.deform(moved, out);
  const Positions result = wrap.deform(moved);
  for (Eigen::Index k = 0; k < result.size(); ++k)
    EXPECT_EQ(out[static_cast<size_t>(k)], static_cast<float>(result.data()[k]));

  const std::vector<float> singles(moved.data(), moved.data() + moved.size());
  std::vector<float> from_singles(points.size());
  wrap.deform(singles, from_singles);
  wrap.deform(Positions(moved.cast<float>().cast<double>()), out);
  EXPECT_EQ(from_singles, out);
  EXPECT_EQ(wrap.n_points(), 60);
  EXPECT_EQ(wrap.n_vertices(), mesh.n_vertices());
}

TEST(WrapDeformation, RefusesWhatIsWrong) {
  const MeshData mesh = tetrahedron();
  const Positions points = points_around(mesh, 3);
  const auto bind = [&](const Positions& given, const WrapOptions& options, const std::vector<int>& pieces) {
    return WrapDeformation(mesh.mesh(), given, options, pieces);
  };
  WrapOptions options;
  options.anchors = 65;
  expect_error<InvalidInput>([&] { bind(points, options, {}); }, {"anchors = 65, must be >= 1 and <= 64"});
  expect_error<InvalidInput>([&] { WrapSurface(mesh.mesh(), -1); }, {"threads = -1"});
  expect_error<InvalidInput>([&] { bind({}, {}, {}); }, {"points is empty", "for the surface to move"});
  expect_error<InvalidInput>([&] { bind(points, {}, {0, 1}); }, {"piece_of_point has 2 rows, expected 3"});
  expect_error<InvalidInput>([&] { bind(points, {}, {0, -2, 1}); }, {"piece_of_point[1] = -2, must be >= -1"});
  const WrapDeformation wrap = bind(points, {}, {});
  expect_error<InvalidInput>([&] { static_cast<void>(wrap.deform(points)); },
                             {"surface_positions has 3 rows, expected 4"});
  std::vector<float> out(9);
  expect_error<InvalidInput>([&] { wrap.deform(out, out); },
                             {"surface_positions has 9 numbers, must have three per vertex, 12"});
  Positions infinite = mesh.positions();
  infinite(2, 1) = std::numeric_limits<double>::infinity();
  expect_error<InvalidInput>([&] { wrap.deform(infinite, out); }, {"surface_positions: vertex 2 is ("});
  expect_error<InvalidInput>([&] { wrap.deform(1e60 * mesh.positions(), out); },
                             {"surface_positions", "range of single"});
}

TEST(WrapDeformation, ProgressMayStopTheBind) {
  const MeshData mesh = bumpy_sphere(2);
  const auto stop = [](double) { return false; };
  expect_error<arap::Cancelled>([&] { WrapSurface(mesh.mesh(), 1, stop); }, {"preparing the surface was cancelled"});
  const WrapSurface surface(mesh.mesh());
  expect_error<arap::Cancelled>([&] { WrapDeformation(surface, points_around(mesh), {}, {}, stop); },
                                {"binding the points to the surface was cancelled"});
}

TEST(WrapDeformation, ProgressGoesOnFromTheSurfaceToThePoints) {
  const MeshData mesh = bumpy_sphere(2);
  std::vector<double> told;
  const arap::Progress progress = [&](double fraction) {
    told.push_back(fraction);
    return true;
  };
  WrapDeformation(mesh.mesh(), points_around(mesh), {}, {}, progress);
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  EXPECT_EQ(std::count(told.begin(), told.end(), .5), 1);
  EXPECT_EQ(told.back(), 1);
}

TEST(WrapSurface, IsSharedByBindsAndNotNeededByWhatIsBound) {
  for (const MeshData& mesh : all_surfaces()) {
    SCOPED_TRACE(mesh.name);
    const Positions points = points_around(mesh);
    const Positions few = points.topRows(7);
    const WrapOptions smooth{.anchors = 5, .stay_outside = false};
    auto surface = std::make_unique<WrapSurface>(mesh.mesh());
    EXPECT_EQ(surface->n_vertices(), mesh.n_vertices());
    const WrapDeformation all(*surface, points);
    const WrapDeformation some(*surface, few, smooth);
    surface = nullptr;
    const Positions moved = bent(mesh.positions());
    EXPECT_EQ(all.deform(moved), WrapDeformation(mesh.mesh(), points).deform(moved));
    EXPECT_EQ(some.deform(moved), WrapDeformation(mesh.mesh(), few, smooth).deform(moved));
  }
}

}  // namespace
}  // namespace arap_test
