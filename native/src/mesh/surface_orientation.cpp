// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/surface_orientation.h"

#include <algorithm>
#include <cstdint>
#include <numbers>
#include <span>

#include "base/offsets.h"
#include "mesh/surface_measures.h"
#include "parallel/parallel.h"

namespace arap {

namespace {

using Row = Eigen::RowVector3d;

/// The directed edges of all faces, grouped by their lower vertex.
class Edges {
 public:
  Edges(const PolygonMesh& mesh, int threads)
      : offsets_(mesh.n_vertices() + 1, 0), has_irregular_(mesh.n_vertices(), 0) {
    const auto for_each = [&](const auto& visit) {
      for (int f = 0; f < mesh.n_faces(); ++f) {
        int from = mesh.face(f).back();
        for (const int to : mesh.face(f)) {
          visit(std::min(from, to), static_cast<std::uint32_t>(std::max(from, to)) << 1U | (from < to ? 1U : 0U));
          from = to;
        }
      }
    };
    for_each([&](int low, std::uint32_t) { ++offsets_[low + 1]; });
    make_offsets(offsets_);
    entries_.resize(offsets_.back());
    std::vector<int> next(offsets_.begin(), offsets_.end() - 1);
    for_each([&](int low, std::uint32_t entry) { entries_[next[low]++] = entry; });
    parallel_for(threads, mesh.n_vertices(), [&](int begin, int end) {
      for (int v = begin; v < end; ++v) {
        std::sort(entries_.begin() + offsets_[v], entries_.begin() + offsets_[v + 1]);
        for_each_irregular_at(v, [&](int) { has_irregular_[v] = 1; });
      }
    });
  }

  /// Calls visit(a, b) for each edge that is not regular.
  template <class Visit>
  void for_each_irregular(const Visit& visit) const {
    for (int v = 0; v < static_cast<int>(has_irregular_.size()); ++v)
      if (has_irregular_[v] != 0) for_each_irregular_at(v, [&](int other) { visit(v, other); });
  }

 private:
  template <class Visit>
  void for_each_irregular_at(int v, const Visit& visit) const {
    for (int k = offsets_[v], end = k; k < offsets_[v + 1]; k = end) {
      const std::uint32_t other = entries_[k] >> 1U;
      while (end < offsets_[v + 1] && entries_[end] >> 1U == other) ++end;
      if (end - k != 2 || entries_[k] == entries_[k + 1]) visit(static_cast<int>(other));
    }
  }

  std::vector<int> offsets_;
  std::vector<std::uint32_t> entries_;  ///< the higher vertex, and in the lowest bit whether the edge ends there
  std::vector<char> has_irregular_;     ///< of each vertex as the lower one of an edge
};

/// Sums over a connected component.
struct Part {
  double area = 0;
  double volume = 0;
  double irregular_length = 0;
  Row inner = Row::Zero();  ///< mean of the vertices, from which the volume is measured: a small hole changes little
  int n_vertices = 0;
};

std::vector<Part> find_parts(const PolygonMesh& mesh) {
  std::vector<Part> parts(mesh.n_parts());
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (const int part = mesh.part_of_vertex()[v]; part >= 0) {
      parts[part].inner += mesh.positions().row(v);
      ++parts[part].n_vertices;
    }
  for (Part& part : parts) part.inner /= std::max(part.n_vertices, 1);
  return parts;
}

/// Adds a face to its component and to the normals of its vertices.
void add_face(const Positions& p, std::span<const int> face, Part& part, Positions& normals) {
  const Row doubled = twice_vector_area(p, face);
  Row middle = Row::Zero();
  for (const int v : face) {
    normals.row(v) += doubled;
    middle += p.row(v);
  }
  part.area += doubled.norm() / 2;
  part.volume += doubled.dot(middle / static_cast<double>(face.size()) - part.inner) / 6;
}

}  // namespace

SurfaceOrientation find_orientation(const PolygonMesh& mesh, int threads) {
  const Positions& p = mesh.positions();
  std::vector<Part> parts = find_parts(mesh);
  SurfaceOrientation result;
  result.normals = Positions::Zero(mesh.n_vertices(), 3);
  for (int f = 0; f < mesh.n_faces(); ++f)
    add_face(p, mesh.face(f), parts[mesh.part_of_vertex()[mesh.face(f)[0]]], result.normals);
  // Row by row: rowwise().normalized() would divide by 0 if faces cancel each other out.
  for (auto normal : result.normals.rowwise()) normal.normalize();
  result.is_manifold.assign(mesh.n_vertices(), 1);
  Edges(mesh, threads).for_each_irregular([&](int a, int b) {
    result.is_manifold[a] = result.is_manifold[b] = 0;
    parts[mesh.part_of_vertex()[a]].irregular_length += (p.row(a) - p.row(b)).norm();
  });
  for (const Part& part : parts) {
    // The largest hole with this circumference is a circle.
    const double missing = part.irregular_length * part.irregular_length / (4 * std::numbers::pi);
    result.has_inside.push_back(static_cast<char>(part.volume > 0 && missing < .01 * part.area));
  }
  return result;
}

}  // namespace arap
