// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "arap/mesh.h"

#include "base/option_bounds.h"
#include "base/union_find.h"
#include "geometry/duplicate_points.h"
#include "mesh/surface_measures.h"
#include "parallel/meter.h"

namespace arap {

namespace {

/// As part of the diagonal: below all that is modelled, above what a change of units and axes rounds.
constexpr double kOfDiagonal = 1e-6;

/// As part of a coordinate: two steps of single precision each way. Nothing finer was ever there.
constexpr double kOfSingles = 4.8e-7;

/// The same of double precision.
constexpr double kOfDoubles = 9e-16;

/// As part of the diagonal: what is rounded to more than that has no seams to join, only edges to lose.
constexpr double kMostOfSingles = 1e-2;

/// The same as part of a short edge: a survey in half metres has single precision's last digit in each of its edges.
constexpr double kOfShortEdge = 0.25;

/// The largest coordinate of vertices in faces that single precision may have rounded, as it has all of a single's
/// digits: whole metres have fewer, and are exact. 0 if any coordinate has more, as doubles have.
double largest_single(const PolygonMesh& mesh) {
  double largest = 0;
  for (int v = 0; v < mesh.n_vertices(); ++v) {
    if (mesh.n_faces() > 0 && mesh.part_of_vertex()[v] < 0) continue;
    for (const double x : mesh.positions().row(v)) {
      const auto single = static_cast<float>(x);
      if (static_cast<double>(single) != x) return 0;
      if ((std::bit_cast<std::uint32_t>(single) & 1U) != 0) largest = std::max(largest, std::abs(x));
    }
  }
  return largest;
}

/// A quarter of the edges of faces are shorter along all axes, not counting those that are no longer than `none`, as
/// in faces whose corners coincide. Infinite if there is no edge.
double short_edge(const PolygonMesh& mesh, double none) {
  std::vector<double> lengths;
  lengths.reserve(mesh.n_corners());
  for (int f = 0; f < mesh.n_faces(); ++f) {
    int from = mesh.face(f).back();
    for (const int to : mesh.face(f)) {
      const double length = (mesh.positions().row(from) - mesh.positions().row(to)).cwiseAbs().maxCoeff();
      if (length > none) lengths.push_back(length);
      from = to;
    }
  }
  if (lengths.empty()) return std::numeric_limits<double>::infinity();
  const auto quarter = lengths.begin() + std::ssize(lengths) / 4;
  std::nth_element(lengths.begin(), quarter, lengths.end());
  return *quarter;
}

}  // namespace

std::vector<int> PolygonMesh::same_places(int threads, const Progress& progress) const {
  require_threads(threads);
  Meter meter(progress, "the search for vertices at the same place was cancelled");
  const Eigen::AlignedBox3d box = surface_box(*this);
  const double diagonal = box.diagonal().norm();
  const double largest = std::max(box.min().cwiseAbs().maxCoeff(), box.max().cwiseAbs().maxCoeff());
  double distance = std::max(kOfDiagonal * diagonal, kOfDoubles * largest);
  const double of_singles = std::min(kOfSingles * largest_single(*this), kMostOfSingles * diagonal);
  if (of_singles > distance)
    distance = std::max(distance, std::min(of_singles, kOfShortEdge * short_edge(*this, distance)));
  std::vector<int> places = coincident_with(positions_, distance, threads, {&meter, 1});
  meter.reach(1);
  return places;
}

int PolygonMesh::n_parts_joined(int threads) const {
  if (n_parts_ < 2) return n_parts_;
  const std::vector<int> places = same_places(threads);
  std::vector<int> part_at(places.size(), -1);
  UnionFind joined(n_parts_);
  int n_joins = 0;
  for (size_t v = 0; v < places.size(); ++v) {
    const int part = part_of_vertex_[v];
    if (part < 0) continue;
    int& here = part_at[places[v]];
    if (here < 0) here = part;
    if (joined.find(here) == joined.find(part)) continue;
    joined.join(here, part);
    ++n_joins;
  }
  return n_parts_ - n_joins;
}

}  // namespace arap
