// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/triangulation.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <utility>

namespace arap {

namespace {

/// Weight of ties. As the height of a triangle goes to 0 its cotangent energy tends to such a tie with unbounded
/// weight; this is the weight at a height of 1/40 of the longest edge.
constexpr double kTieWeight = 10;

/// Keeps vertices connected, too weak to be seen.
constexpr double kWeakWeight = 1e-3;

/// A degenerate triangle is a needle if its shortest edge is below this part of the longest, else a cap.
constexpr double kNeedleEdge = 1e-2;

class Triangulator {
 public:
  Triangulator(const PolygonMesh& mesh, EdgeWeights weights) : mesh_(mesh), weights_(weights) {}

  Triangulation run() {
    size_t n_triangles = 0;
    for (int f = 0; f < mesh_.n_faces(); ++f) {
      const size_t n = mesh_.face(f).size();
      n_triangles += fans_of(n) * (n - 2);
    }
    result_.triangles.reserve(n_triangles);
    for (face_ = 0; face_ < mesh_.n_faces(); ++face_) add_face(mesh_.face(face_));
    strengthen_glue();
    return std::move(result_);
  }

 private:
  void add_face(std::span<const int> face) {
    const auto n = static_cast<int>(face.size());
    const auto n_fans = static_cast<int>(fans_of(face.size()));
    for (int fan = 0; fan < n_fans; ++fan) {
      const int apex = n <= 4 ? fan : static_cast<int>(static_cast<int64_t>(fan) * n / n_fans);
      for (int k = 1; k + 1 < n; ++k)
        add_triangle({corner(face, apex), corner(face, apex + k), corner(face, apex + k + 1)}, 1.0 / n_fans, n == 3);
    }
  }

  /// Opposite corners of a quad have the same fan, and all corners of a triangle.
  static size_t fans_of(size_t n_corners) {
    return n_corners <= 4 ? n_corners - 2 : std::clamp(kMostFanTriangles / n_corners, kFewestFans, n_corners);
  }

  static int corner(std::span<const int> face, int k) { return face[k % face.size()]; }

  void add_triangle(std::array<int, 3> v, double share, bool is_whole_face) {
    if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) {
      add_collapsed(v, share);
      return;
    }
    if (weights_ == EdgeWeights::kUniform) {
      result_.triangles.push_back({v, face_, {0.5 * share, 0.5 * share, 0.5 * share}});
      return;
    }
    const std::array<Vector3, 3> p{point(v[0]), point(v[1]), point(v[2])};
    std::array<double, 3> lengths{};
    for (size_t k = 0; k < 3; ++k) lengths[k] = (p[(k + 1) % 3] - p[(k + 2) % 3]).norm();
    const double longest = *std::max_element(lengths.begin(), lengths.end());
    const double area_twice = (p[1] - p[0]).cross(p[2] - p[0]).norm();
    if (area_twice <= kDegenerateHeight * longest * longest) {
      add_degenerate(v, p, lengths, share, is_whole_face);
      return;
    }
    std::array<double, 3> weights = half_cotangents(p[0], p[1], p[2]);
    for (double& weight : weights) weight *= share;
    result_.triangles.push_back({v, face_, weights});
  }

  /// A triangle with a repeated corner: at most an edge.
  void add_collapsed(const std::array<int, 3>& v, double share) {
    const int other = v[0] != v[1] ? v[1] : v[2];
    if (v[0] != other) add_edge(v[0], other, kWeakWeight * share);
  }

  /// Half for the rotation of each end, so that the order of the corners does not matter.
  void add_edge(int a, int b, double weight) {
    result_.ties.push_back({{a, b, b}, face_, {1, -1, 0}, 0.5 * weight});
    result_.ties.push_back({{b, a, a}, face_, {1, -1, 0}, 0.5 * weight});
  }

  void add_degenerate(const std::array<int, 3>& v, const std::array<Vector3, 3>& p,
                      const std::array<double, 3>& lengths, double share, bool is_whole_face) {
    const auto shortest = std::min_element(lengths.begin(), lengths.end()) - lengths.begin();
    const auto longest = std::max_element(lengths.begin(), lengths.end()) - lengths.begin();
    const size_t a = (longest + 1) % 3;
    const size_t b = (longest + 2) % 3;
    add_edge(v[a], v[b], kWeakWeight * share);
    if (lengths[shortest] <= kNeedleEdge * lengths[longest]) {
      add_edge(v[(shortest + 1) % 3], v[(shortest + 2) % 3], kTieWeight * share);
      return;
    }
    // A cap: the middle vertex is on the longest edge. In a larger face other fans hold it, and a strong tie would make
    // a straight row of corners stiff. A triangle face may be the only connection: see strengthen_glue().
    const Vector3 edge = p[b] - p[a];
    const double t = (p[longest] - p[a]).dot(edge) / edge.squaredNorm();
    if (is_whole_face) caps_.push_back(result_.ties.size());
    result_.ties.push_back({{v[longest], v[a], v[b]}, face_, {1, t - 1, -t}, kWeakWeight * share});
  }

  using Edge = std::pair<int, int>;
  using Corners = std::vector<int>;

  static Edge edge_of(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

  static Corners sorted(std::span<const int> face) {
    Corners corners(face.begin(), face.end());
    std::sort(corners.begin(), corners.end());
    return corners;
  }

  /// A cap that connects other faces at its longest edge with other faces at its short edges gets the full weight. If
  /// the surface is connected without it, the cap must have no influence.
  void strengthen_glue() {
    if (caps_.empty()) return;
    std::map<Edge, std::set<Corners>> faces_of_edge;
    for (const size_t cap : caps_)
      for (size_t k = 0; k < 3; ++k)
        faces_of_edge[edge_of(result_.ties[cap].vertices[k], result_.ties[cap].vertices[(k + 1) % 3])];
    for (int f = 0; f < mesh_.n_faces(); ++f) {
      const std::span<const int> face = mesh_.face(f);
      for (int k = 0; k < std::ssize(face); ++k) {
        const auto found = faces_of_edge.find(edge_of(face[k], corner(face, k + 1)));
        if (found != faces_of_edge.end()) found->second.insert(sorted(face));
      }
    }
    for (const size_t cap : caps_) {
      Tie& tie = result_.ties[cap];
      const auto [middle, a, b] = tie.vertices;
      const Corners own = sorted(tie.vertices);
      const auto joins_others = [&](int from, int to) {
        const std::set<Corners>& faces = faces_of_edge[edge_of(from, to)];
        return faces.size() > faces.count(own);
      };
      if (joins_others(a, b) && (joins_others(a, middle) || joins_others(middle, b))) tie.weight = kTieWeight;
    }
  }

  [[nodiscard]] Vector3 point(int v) const { return mesh_.positions().row(v).transpose(); }

  const PolygonMesh& mesh_;
  EdgeWeights weights_;
  Triangulation result_;
  int face_ = 0;              ///< the one at hand
  std::vector<size_t> caps_;  ///< ties of triangle faces whose middle vertex is on the longest edge
};

}  // namespace

std::array<double, 3> half_cotangents(const Vector3& a, const Vector3& b, const Vector3& c) {
  const double area_twice = (b - a).cross(c - a).norm();
  return {0.5 * (b - a).dot(c - a) / area_twice, 0.5 * (c - b).dot(a - b) / area_twice,
          0.5 * (a - c).dot(b - c) / area_twice};
}

Triangulation triangulate(const PolygonMesh& mesh, EdgeWeights weights) { return Triangulator(mesh, weights).run(); }

}  // namespace arap
