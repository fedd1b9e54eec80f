// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/constraints.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>

#include "arap/error.h"
#include "base/format_message.h"
#include "mesh/mesh_vertices.h"

namespace arap {

namespace {

void require_index(const char* what, std::ptrdiff_t entry, int vertex, int n_vertices) {
  if (vertex >= 0 && vertex < n_vertices) return;
  throw InvalidInput(
      text(what, " entry ", entry, " is vertex ", vertex, ", but the mesh has vertices 0 to ", n_vertices - 1));
}

void validate_vertices(const ConstraintSet& set, int n_vertices) {
  if (!set.strengths.empty() && set.strengths.size() != set.vertices.size())
    throw InvalidInput(text("strengths has ", set.strengths.size(), " entries, but vertices has ", set.vertices.size(),
                            "; give one strength per vertex, or none: all hard"));
  std::vector<int> entry_of_vertex(n_vertices, -1);
  for (std::ptrdiff_t k = 0; k < std::ssize(set.vertices); ++k) {
    const int vertex = set.vertices[k];
    require_index("vertices", k, vertex, n_vertices);
    int& entry = entry_of_vertex[vertex];
    if (entry >= 0)
      throw InvalidInput(text("vertex ", vertex, " is constrained twice, by entries ", entry, " and ", k,
                              "; merge them into one target"));
    entry = static_cast<int>(k);
    if (set.strengths.empty()) continue;
    const double strength = set.strengths[k];
    if (!(strength > 0 && strength <= 1))
      throw InvalidInput(text("strengths[", k, "] = ", strength, " of vertex ", vertex,
                              ", must be above 0 and at most 1; leave free vertices out"));
  }
}

void validate_patches(const Patches& patches, int n_vertices) {
  if (patches.offsets.empty()) {
    if (!patches.vertices.empty()) throw InvalidInput("patches have vertices but no offsets");
    return;
  }
  if (patches.weights.size() != patches.vertices.size())
    throw InvalidInput(text("patch weights has ", patches.weights.size(), " entries, but patch vertices has ",
                            patches.vertices.size(), "; give one weight per vertex"));
  if (patches.offsets.front() != 0 || patches.offsets.back() != std::ssize(patches.vertices))
    throw InvalidInput(text("patch offsets go from ", patches.offsets.front(), " to ", patches.offsets.back(),
                            ", must go from 0 to the number of patch vertices, ", patches.vertices.size()));
  for (int p = 0; p < patches.size(); ++p) {
    const int begin = patches.offsets[p];
    const int end = patches.offsets[p + 1];
    if (end < begin || end > std::ssize(patches.vertices))
      throw InvalidInput(text("patch ", p, ": offsets must not fall"));
    double sum = 0;
    for (int k = begin; k < end; ++k) {
      require_index("patch vertices", k, patches.vertices[k], n_vertices);
      const double weight = patches.weights[k];
      if (!(weight >= 0) || std::isinf(weight))
        throw InvalidInput(
            text("patch ", p, ": weight of vertex ", patches.vertices[k], " is ", weight, ", must be finite and >= 0"));
      sum += weight;
    }
    if (!(sum > 0) || std::isinf(sum))
      throw InvalidInput(
          text("patch ", p, " has no weight, or an infinite one; give at least one vertex a finite weight above 0"));
  }
}

void validate_segments(const std::vector<Segment>& segments) {
  for (std::ptrdiff_t s = 0; s < std::ssize(segments); ++s) {
    const auto& [head, tail] = segments[s];
    if (!is_within_range(head.transpose()) || !is_within_range(tail.transpose()))
      throw InvalidInput(text("segment ", s, ": head and tail must be finite and below 1e100"));
    const double largest = std::max(head.cwiseAbs().maxCoeff(), tail.cwiseAbs().maxCoeff());
    if (!((tail - head).norm() > 1e-14 * largest))
      throw InvalidInput(text("segment ", s, " has no length; move its head or its tail"));
  }
}

}  // namespace

Positions Segment::rest_targets() const {
  Positions result(kTargets, 3);
  result.row(0) = head.transpose();
  for (int axis = 0; axis < 3; ++axis)
    result.row(1 + axis) = head.transpose() + (tail - head).norm() * Eigen::RowVector3d::Unit(axis);
  return result;
}

void Patches::add(const Patch& patch) {
  if (offsets.empty()) offsets.push_back(0);
  vertices.insert(vertices.end(), patch.vertices.begin(), patch.vertices.end());
  weights.insert(weights.end(), patch.weights.begin(), patch.weights.end());
  offsets.push_back(static_cast<int>(vertices.size()));
}

void ConstraintSet::validate(int n_vertices) const {
  validate_vertices(*this, n_vertices);
  validate_patches(patches, n_vertices);
  validate_segments(segments);
  if (n_targets() == 0) throw InvalidInput("nothing is constrained; constrain at least one vertex, patch or segment");
}

}  // namespace arap
