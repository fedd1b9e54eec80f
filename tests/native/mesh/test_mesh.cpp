// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "arap/error.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::InvalidInput;
using arap::PolygonMesh;

Positions square() { return Positions{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}; }

TEST(PolygonMesh, FacesComeBackAsTheyWentIn) {
  const PolygonMesh mesh(Positions{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {2, 0, 0}}, {0, 1, 2, 3, 2, 1, 4},
                         {4, 3});
  EXPECT_EQ(mesh.n_vertices(), 5);
  EXPECT_EQ(mesh.n_faces(), 2);
  const auto face = [&](int f) { return std::vector<int>(mesh.face(f).begin(), mesh.face(f).end()); };
  EXPECT_EQ(face(0), (std::vector<int>{0, 1, 2, 3}));
  EXPECT_EQ(face(1), (std::vector<int>{2, 1, 4}));
}

TEST(PolygonMesh, MoreVerticesThanCanBeCountedAreRefused) {
  expect_error<InvalidInput>(
      [] { static_cast<void>(PolygonMesh(Positions(100'000'001, 3), {}, {})); },
      {"the mesh has 100000001 vertices and 0 corners of faces", "at most 100000000 and 500000000"});
}

TEST(PolygonMesh, DiagonalIsThatOfTheBoundingBox) {
  EXPECT_DOUBLE_EQ(cube().mesh().diagonal(), std::sqrt(3.0));
  EXPECT_EQ(PolygonMesh(Positions::Constant(3, 3, 7), {0, 1, 2}, {3}).diagonal(), 0);
}

TEST(PolygonMesh, PartsAreNumberedByTheirLowestVertex) {
  // Faces name the part with the higher vertices first.
  MeshData mesh = two_spheres(0);
  std::reverse(mesh.faces.begin(), mesh.faces.end());
  const PolygonMesh built = mesh.mesh();
  EXPECT_EQ(built.n_parts(), 2);
  for (int v = 0; v < mesh.n_vertices(); ++v) EXPECT_EQ(built.part_of_vertex()[v], v < 12 ? 0 : 1);
}

TEST(PolygonMesh, PartsThatShareOneVertexAreOnePart) {
  EXPECT_EQ(bow_tie().mesh().n_parts(), 1);
  EXPECT_EQ(book(2, Faces::kQuads).mesh().n_parts(), 1);
}

TEST(PolygonMesh, LooseVerticesAreListedAndBelongToNoPart) {
  const PolygonMesh mesh(Positions::Random(6, 3), {1, 3, 4}, {3});
  EXPECT_EQ(mesh.loose_vertices(), (std::vector<int>{0, 2, 5}));
  EXPECT_EQ(mesh.part_of_vertex(), (std::vector<int>{-1, 0, -1, 0, 0, -1}));
  EXPECT_EQ(mesh.n_parts(), 1);
}

TEST(PolygonMesh, EveryKindOfFaceIsAccepted) {
  for (const MeshData& mesh : all_small_meshes()) EXPECT_NO_THROW(static_cast<void>(mesh.mesh())) << mesh.name;
  EXPECT_NO_THROW(static_cast<void>(sheet_with_collinear_corners().mesh()));
  EXPECT_NO_THROW(PolygonMesh(square(), {0, 1, 2, 0, 1, 2, 2, 1, 0}, {3, 3, 3})) << "duplicate and flipped faces";
  EXPECT_NO_THROW(PolygonMesh(square(), {0, 1, 1, 2, 2, 2}, {3, 3})) << "a face that names a vertex twice";
  EXPECT_NO_THROW(PolygonMesh(square(), {}, {})) << "no faces";
}

TEST(PolygonMesh, WhatIsWrongIsRefusedByPlace) {
  const auto expect_refused = [](const Positions& positions, const std::vector<int>& corner_vertices,
                                 const std::vector<int>& face_sizes, std::initializer_list<std::string_view> words) {
    expect_error<InvalidInput>([&] { PolygonMesh(positions, corner_vertices, face_sizes); }, words);
  };
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), kInfinity, -kInfinity, 1e300})
    for (int axis = 0; axis < 3; ++axis) {
      Positions positions = square();
      positions(2, axis) = bad;
      expect_refused(positions, {0, 1, 2}, {3}, {"rest_positions", "vertex 2", "finite"});
    }
  expect_refused(Positions(0, 3), {}, {}, {"rest_positions", "at least one vertex"});
  for (const int bad : {-1, 4, 1 << 30})
    expect_refused(square(), {0, 1, 2, 0, bad, 3}, {3, 3}, {"face 1", std::to_string(bad), "0 to 3"});
  for (const int bad : {2, 1, 0, -3})
    expect_refused(square(), {0, 1, 2, 0, 1}, {3, bad}, {"face_sizes[1]", std::to_string(bad), ">= 3"});
  expect_refused(square(), {0, 1, 2, 3}, {3}, {"4 corners", "face_sizes", "3"});
  expect_refused(square(), {0, 1, 2, 3}, {3, 3}, {"4 corners", "face_sizes", "6"});
  const int huge = std::numeric_limits<int>::max();
  expect_refused(square(), {0, 1, 2, 3}, {huge, huge, huge}, {"face_sizes"});
}

}  // namespace
}  // namespace arap_test
