// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/thickness_links.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>
#include <vector>

#include "arap/error.h"
#include "mesh/mirror_symmetry.h"
#include "mesh/surface_orientation.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

using Links = std::vector<std::pair<int, int>>;

Links links_of(const MeshData& mesh, double radius) { return arap::find_thickness_links(mesh.mesh(), radius, {}, 1); }

/// What a meter has been told when act(its whole) has returned.
template <class Act>
double told_by(const Act& act) {
  double told = 0;
  const arap::Progress progress = [&](double fraction) {
    told = fraction;
    return true;
  };
  arap::Meter meter(progress, "");
  act(arap::MeterPart{&meter, 1});
  meter.tell();
  return told;
}

/// Calls act(a part of a meter that the caller has stopped).
template <class Act>
void with_stopped_meter(const Act& act) {
  const arap::Progress refuse = [](double) { return false; };
  arap::Meter meter(refuse, "stopped");
  EXPECT_THROW(meter.tell(), arap::Cancelled);
  act(arap::MeterPart{&meter, 1});
}

/// A plate with the diagonal 1.12, one cell thick.
MeshData plate(int n, double thickness, Faces faces = Faces::kQuads) {
  return box({2 * n, n, 1}, Vector3(1, .5, thickness), faces);
}

/// Vertices of links.
std::set<int> ends_of(const Links& links) {
  std::set<int> ends;
  for (const auto& [a, b] : links) ends.insert({a, b});
  return ends;
}

/// Two fingers along y with a narrow gap in x between them, on a palm below y = 0; the surface of a set of boxes.
struct Fork {
  static constexpr double kThickness = .1;
  static constexpr double kGap = .02;
  MeshData mesh;

  /// @param gap  between the fingers; below 0 they overlap
  explicit Fork(double gap = kGap) {
    const std::vector<double> x{-.13, -.09, -.05, -kGap / 2, kGap / 2, .05, .09, .13};
    const int n_along = 12;
    const auto is_solid = [&](int i, int j, int k) {
      return i >= 0 && i < 7 && j >= 0 && j < n_along && k == 0 && (i != 3 || j < 2);
    };
    const auto corner = [&](int i, int j, int k) {
      return mesh.vertex_at(Vector3(x[i], .1 * (j - 2), kThickness * (k - .5)));
    };
    for (int i = 0; i < 7; ++i)
      for (int j = 0; j < n_along; ++j) {
        if (!is_solid(i, j, 0)) continue;
        for (int axis = 0; axis < 3; ++axis)
          for (const int side : {0, 1}) add_wall({i, j, 0}, axis, side, is_solid, corner);
      }
    for (Vector3& p : mesh.vertices)
      if (p[1] > .05 && std::abs(p[0]) < kGap) p[0] *= gap / kGap;
  }

 private:
  template <class IsSolid, class Corner>
  void add_wall(std::array<int, 3> cell, int axis, int side, const IsSolid& is_solid, const Corner& corner) {
    std::array<int, 3> beside = cell;
    beside[axis] += 2 * side - 1;
    if (is_solid(beside[0], beside[1], beside[2])) return;
    std::vector<int> face;
    for (const auto& [u, v] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
      std::array<int, 3> at = cell;
      at[axis] += side;
      at[(axis + 1) % 3] += u;
      at[(axis + 2) % 3] += v;
      face.push_back(corner(at[0], at[1], at[2]));
    }
    if (side == 0) std::reverse(face.begin(), face.end());
    mesh.faces.push_back(face);
  }
};

TEST(ThicknessLinks, JoinTheWallsOfAThinPlateAndOnlyThese) {
  const double thickness = .02;
  for (const MeshData& mesh : {plate(10, thickness), plate(10, thickness, Faces::kTriangles)}) {
    const Links links = links_of(mesh, .06);
    for (const auto& [a, b] : links) {
      EXPECT_LT(a, b);
      EXPECT_LT(mesh.vertices[a][2] * mesh.vertices[b][2], 0);
      EXPECT_LT((mesh.vertices[a] - mesh.vertices[b]).norm(), .06);
    }
    const std::set<std::pair<int, int>> found(links.begin(), links.end());
    EXPECT_EQ(found.size(), links.size());
    for (int a = 0; a < mesh.n_vertices(); ++a) {
      const Vector3& p = mesh.vertices[a];
      if (p[2] > 0 || std::abs(p[0]) > .49 || std::abs(p[1]) > .24) continue;
      MeshData copy = mesh;
      const int b = copy.vertex_at(Vector3(p[0], p[1], -p[2]));
      EXPECT_TRUE(found.contains(std::minmax(a, b))) << "straight across from vertex " << a;
    }
  }
}

TEST(ThicknessLinks, ThereAreNoneWhereWallsAreFurtherApartThanTheRadius) {
  EXPECT_TRUE(links_of(plate(10, .1), .09).empty());
  EXPECT_FALSE(links_of(plate(10, .1), .11).empty());
}

/// Whether a vertex belongs to the left finger, by its position in an open fork.
bool is_left(const MeshData& open, int vertex) { return open.vertices[vertex][0] < 0; }

TEST(ThicknessLinks, NoneJoinsFingersWithAGapOrThatTouchOrOverlap) {
  const Fork open;
  for (const double depth : {-Fork::kGap, 0., 1e-12, 1e-9, 1e-7, 1e-5, 1e-4, 1e-3, .01, .03}) {
    const Fork fork(-depth);
    const Links links = links_of(fork.mesh, 1.5 * Fork::kThickness);
    EXPECT_GT(links.size(), 20u) << "in the fingers";
    for (const auto& [a, b] : links) {
      if (open.mesh.vertices[a][1] <= .05 && open.mesh.vertices[b][1] <= .05) continue;
      EXPECT_EQ(is_left(open.mesh, a), is_left(open.mesh, b)) << a << ", " << b << " overlap by " << depth;
    }
  }
}

TEST(ThicknessLinks, NoneJoinsOverlappingLimbs) {
  // A thin sheet below the surface of a thick plate; they are one part, as they have a corner in common.
  const MeshData thick = plate(10, .1);
  const auto links_with_sheet_at = [&](double height) {
    const MeshData thin =
        transformed(plate(10, .01), [&](const Vector3& x) { return Vector3(.8 * x[0], .8 * x[1], x[2] + height); });
    MeshData mesh = join(thick, thin);
    for (auto& face : mesh.faces) std::replace(face.begin(), face.end(), thick.n_vertices(), 0);
    return links_of(mesh, .06);
  };
  EXPECT_FALSE(links_with_sheet_at(.5).empty());
  for (const auto& [a, b] : links_with_sheet_at(.03)) EXPECT_EQ(a < thick.n_vertices(), b < thick.n_vertices());
}

TEST(ThicknessLinks, NoneJoinsParts) {
  const double thickness = .03;
  for (const double distance : {thickness, 1.1 * thickness, .8 * thickness}) {
    const MeshData lower = plate(8, thickness);
    const MeshData upper = transformed(lower, [&](const Vector3& x) { return Vector3(x[0], x[1], x[2] + distance); });
    const Links links = links_of(join(lower, upper), .1);
    EXPECT_FALSE(links.empty());
    for (const auto& [a, b] : links) EXPECT_EQ(a < lower.n_vertices(), b < lower.n_vertices());
  }
}

/// An open sheet bent into a hairpin whose legs are `gap` apart.
MeshData hairpin(double gap) {
  return transformed(grid(20, Faces::kQuads), [&](const Vector3& x) {
    const double reach = std::numbers::pi / 4 * gap;
    if (std::abs(x[0]) < reach) {
      const double turn = x[0] / reach * std::numbers::pi / 2;
      return Vector3(-gap / 2 * std::cos(turn), x[1], gap / 2 * std::sin(turn));
    }
    return Vector3(std::abs(x[0]) - reach, x[1], std::copysign(gap / 2, x[0]));
  });
}

TEST(ThicknessLinks, OpenSheetsHaveNone) {
  for (const MeshData& mesh : {grid(10, Faces::kQuads), open_cylinder(12, 8, Faces::kQuads), moebius_strip(24, 3),
                               book(6, Faces::kQuads), hairpin(.05)}) {
    EXPECT_TRUE(links_of(mesh, .2 * mesh.diagonal()).empty()) << mesh.name;
    MeshData turned = mesh;
    for (auto& face : turned.faces) std::reverse(face.begin(), face.end());
    EXPECT_TRUE(links_of(turned, .2 * mesh.diagonal()).empty()) << mesh.name;
  }
}

TEST(ThicknessLinks, FacesThatAreTurnedAroundHaveNone) {
  const MeshData mesh = plate(10, .02);
  const auto with_turned = [&](const auto& is_turned) {
    MeshData result = mesh;
    for (int f = 0; f < mesh.n_faces(); ++f)
      if (is_turned(f)) std::reverse(result.faces[f].begin(), result.faces[f].end());
    return links_of(result, .06);
  };
  EXPECT_TRUE(with_turned([](int) { return true; }).empty()) << "inside out";
  EXPECT_TRUE(with_turned([](int f) { return f % 2 == 0; }).empty()) << "every other";
  EXPECT_TRUE(with_turned([&](int f) { return mesh.vertices[mesh.faces[f][0]][2] > 0; }).empty()) << "one wall";
}

TEST(ThicknessLinks, AFewBadFacesLoseOnlyTheirOwn) {
  const MeshData mesh = plate(20, .02);
  const std::set<int> all = ends_of(links_of(mesh, .06));
  const std::vector<int> face = mesh.faces[mesh.n_faces() / 2];
  const auto expect_others = [&](const MeshData& worse) {
    const std::set<int> ends = ends_of(links_of(worse, .06));
    for (const int v : face) EXPECT_FALSE(ends.contains(v));
    EXPECT_GT(ends.size(), all.size() - 10);
  };
  MeshData turned = mesh;
  std::reverse(turned.faces[mesh.n_faces() / 2].begin(), turned.faces[mesh.n_faces() / 2].end());
  expect_others(turned);
  MeshData hole = mesh;
  hole.faces.erase(hole.faces.begin() + mesh.n_faces() / 2);
  expect_others(hole);
  MeshData doubled = mesh;
  doubled.faces.push_back(face);
  expect_others(doubled);
}

TEST(SurfaceOrientation, FacesThatCancelOutLeaveNoNormal) {
  MeshData mesh = cube();
  const int tip = mesh.add_vertex(Vector3(0, 0, 2));
  mesh.faces.push_back({0, 1, tip});
  mesh.faces.push_back({1, 0, tip});
  const Positions normals = arap::find_orientation(mesh.mesh(), 1).normals;
  EXPECT_EQ(normals.row(tip), Eigen::RowVector3d(0, 0, 0));
  for (int v = 0; v < tip; ++v) EXPECT_NEAR(normals.row(v).norm(), 1, 1e-12) << v;
}

TEST(ThicknessLinks, AreDefinedOnMeshesOfEveryKind) {
  for (MeshData& mesh : all_small_meshes()) {
    mesh.add_vertex(mesh.vertices[0]);
    mesh.add_vertex(Vector3(1, 2, 3));
    mesh.faces.push_back({0, 1, mesh.n_vertices() - 2});  // no area: its first and last corner are at one place
    const arap::PolygonMesh polygons = mesh.mesh();
    for (const double radius : {1e-4, .05, .3, 2.}) {
      for (const auto& [a, b] : links_of(mesh, radius * mesh.diagonal())) {
        EXPECT_EQ(polygons.part_of_vertex()[a], polygons.part_of_vertex()[b]) << mesh.name;
        EXPECT_LT((mesh.vertices[a] - mesh.vertices[b]).norm(), radius * mesh.diagonal()) << mesh.name;
        EXPECT_LT(b, mesh.n_vertices() - 1) << "a loose vertex of " << mesh.name;
      }
    }
  }
}

TEST(ThicknessLinks, ImagesOfLinksAreLinks) {
  for (const Faces faces : {Faces::kQuads, Faces::kTriangles}) {
    const MeshData mesh = transformed(plate(9, .02, faces),
                                      [](const Vector3& x) { return Vector3(x[0], x[1], x[2] * (1.5 - x[0] * x[0])); });
    const auto mirrors = arap::find_mirrors(mesh.mesh(), 2);
    ASSERT_EQ(mirrors.size(), 3u);
    const Links links = arap::find_thickness_links(mesh.mesh(), .06, mirrors, 1);
    const std::set<std::pair<int, int>> found(links.begin(), links.end());
    EXPECT_FALSE(found.empty());
    for (const auto& mirror : mirrors)
      for (const auto& [a, b] : links) EXPECT_TRUE(found.contains(std::minmax({mirror[a], mirror[b]})));
  }
}

TEST(ThicknessLinks, TellWhatIsDoneAndMayBeStopped) {
  const MeshData mesh = plate(40, .012, Faces::kTriangles);
  EXPECT_NEAR(
      told_by([&](const arap::MeterPart& meter) { EXPECT_EQ(arap::find_mirrors(mesh.mesh(), 2, meter).size(), 3u); }),
      1, 1e-9);
  EXPECT_NEAR(told_by([&](const arap::MeterPart& meter) {
                EXPECT_FALSE(arap::find_thickness_links(mesh.mesh(), .03, {}, 2, meter).empty());
              }),
              1, 1e-9);
  EXPECT_THROW(with_stopped_meter(
                   [&](const arap::MeterPart& meter) { static_cast<void>(arap::find_mirrors(mesh.mesh(), 2, meter)); }),
               arap::Cancelled);
  EXPECT_THROW(with_stopped_meter([&](const arap::MeterPart& meter) {
                 static_cast<void>(arap::find_thickness_links(mesh.mesh(), .03, {}, 2, meter));
               }),
               arap::Cancelled);
}

TEST(ThicknessLinks, DoNotDependOnTheNumberOfThreads) {
  const MeshData mesh = plate(40, .012, Faces::kTriangles);
  EXPECT_EQ(arap::find_thickness_links(mesh.mesh(), .03, {}, 1), arap::find_thickness_links(mesh.mesh(), .03, {}, 2));
}

TEST(ThicknessLinks, AreFewHoweverDenseTheMesh) {
  // A vertex for each quarter of the radius along and across, on either wall, and as many at the rim.
  const double radius = .1;
  const double most = 4 * (4 / radius + 2) * (2 / radius + 2);
  EXPECT_LT(links_of(plate(60, .02), radius).size(), most);
  EXPECT_LT(links_of(plate(120, .02), radius).size(), most);
}

std::set<int> seen_by(const arap::RotationNodes& nodes, int vertex) {
  return {nodes.nodes.begin() + nodes.offsets[vertex], nodes.nodes.begin() + nodes.offsets[vertex + 1]};
}

TEST(ThicknessLinks, WallsOfAThinPlateShareNodes) {
  for (const int n : {10, 50}) {
    MeshData mesh = plate(n, .02, Faces::kTriangles);
    const arap::RotationNodes nodes = choose_nodes(mesh, .06);
    for (int a = 0; a < mesh.n_vertices(); ++a) {
      const Vector3& p = mesh.vertices[a];
      const int b = mesh.vertex_at(Vector3(p[0], p[1], -p[2]));
      double shared = 0;
      for (int k = nodes.offsets[a]; k < nodes.offsets[a + 1]; ++k)
        shared += seen_by(nodes, b).contains(nodes.nodes[k]) ? nodes.weights[k] : 0;
      EXPECT_GT(shared, .7) << "vertex " << a << " of " << mesh.n_vertices();
    }
  }
}

TEST(ThicknessLinks, ABentPlateDoesNotPassThroughItself) {
  const double thickness = .012;
  MeshData mesh = plate(40, thickness, Faces::kTriangles);
  Task task;
  const Matrix3 turn = rotation_about(Vector3::UnitY(), -std::numbers::pi / 2) * rotation_about(Vector3::UnitX(), .7);
  for (int v = 0; v < mesh.n_vertices(); ++v) {
    const Vector3& p = mesh.vertices[v];
    if (p[0] < -.44) task.add(v, p);
    if (p[0] > .44) task.add(v, turn * (p - Vector3(.5, 0, 0)) + Vector3(.14, 0, .64));
  }
  arap::SolveOptions options;
  options.initial_guess = arap::InitialGuess::kHandleRotations;
  const Positions p = solve_once(mesh, task, options).positions;
  Positions normals = Positions::Zero(mesh.n_vertices(), 3);
  for (const auto& face : mesh.faces) {
    const Eigen::RowVector3d along = p.row(face[1]) - p.row(face[0]);
    const Eigen::RowVector3d normal = along.cross(Eigen::RowVector3d(p.row(face[2]) - p.row(face[0])));
    for (const int v : face) normals.row(v) += normal;
  }
  std::vector<double> kept;
  for (int a = 0; a < mesh.n_vertices(); ++a) {
    const Vector3 rest = mesh.vertices[a];
    if (rest[2] < 0) continue;
    const int b = mesh.vertex_at(Vector3(rest[0], rest[1], -rest[2]));
    kept.push_back((p.row(a) - p.row(b)).dot(normals.row(a).normalized()) / thickness);
  }
  std::sort(kept.begin(), kept.end());
  EXPECT_GT(kept.front(), 0);
  EXPECT_GT(kept[kept.size() / 2], .8);
}

}  // namespace
}  // namespace arap_test
