// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/input_checks.h"

#include <algorithm>
#include <string>

#include "parallel/parallel.h"

namespace arap {

namespace {

/// What row k of the targets belongs to.
std::string target_name(const ConstraintSet& set, int k) {
  const int n_vertices = static_cast<int>(set.vertices.size());
  const int of_patch = k - n_vertices;
  if (of_patch < 0) return text("row ", k, ", vertex ", set.vertices[k], ",");
  const int of_segment = of_patch - set.patches.size();
  if (of_segment < 0) return text("row ", k, ", patch ", of_patch, ",");
  return text("row ", k, ", segment ", of_segment / Segment::kTargets, ",");
}

}  // namespace

void require_rows(const char* what, Eigen::Index rows, Eigen::Index expected) {
  if (rows != expected) throw InvalidInput(text(what, " has ", rows, " rows, expected ", expected));
}

void require_movable_patches(const Patches& patches, const std::vector<int>& part_of_vertex) {
  for (int p = 0; p < patches.size(); ++p)
    for (int k = patches.offsets[p]; k < patches.offsets[p + 1]; ++k)
      if (patches.weights[k] > 0 && part_of_vertex[patches.vertices[k]] < 0)
        throw InvalidInput(text("patch ", p, " contains loose vertex ", patches.vertices[k],
                                ", which nothing can move; leave it out"));
}

void require_strength(const ConstraintSet& set, const std::vector<int>& part_of_vertex) {
  constexpr double kWeakest = 1e-9;
  if (set.strengths.empty() || !set.segments.empty()) return;
  const auto n_parts = part_of_vertex.empty() ? 0 : 1 + *std::max_element(part_of_vertex.begin(), part_of_vertex.end());
  std::vector<double> strongest(n_parts, 0);
  const auto hold = [&](int vertex, double strength) {
    const int part = part_of_vertex[vertex];
    if (part >= 0) strongest[part] = std::max(strongest[part], strength);
  };
  for (size_t k = 0; k < set.vertices.size(); ++k) hold(set.vertices[k], set.strengths[k]);
  for (size_t k = 0; k < set.patches.vertices.size(); ++k)
    if (set.patches.weights[k] > 0) hold(set.patches.vertices[k], 1);
  for (const int v : set.vertices)
    if (part_of_vertex[v] >= 0 && strongest[part_of_vertex[v]] < kWeakest)
      throw InvalidInput(text("vertex ", v, " is in a part whose largest strength is ", strongest[part_of_vertex[v]],
                              ", which is lost in rounding below 1e-9; hold that part more strongly or leave it out"));
}

void require_no_segments(const ConstraintSet& set) {
  if (!set.segments.empty())
    throw InvalidInput("segments need a model with an inside, which this one has not; use LatticeArap");
}

void require_targets(const ConstraintSet& set, const Positions& targets, std::span<const Matrix3> rotations) {
  require_rows("targets", targets.rows(), set.n_targets());
  require_finite("targets", targets, [&](int k) { return target_name(set, k); });
  if (!rotations.empty()) require_rows("rotations", rotations.size(), set.n_targets());
  for (size_t k = 0; k < rotations.size(); ++k)
    if (!rotations[k].allFinite()) throw InvalidInput(text("rotations[", k, "] is not finite"));
}

void require_out(std::span<const float> out, int n_vertices) {
  const auto n_numbers = 3 * static_cast<size_t>(n_vertices);
  if (!out.empty() && out.size() != n_numbers)
    throw InvalidInput(text("out has ", out.size(), " numbers, must have three per vertex, ", n_numbers));
}

void require_constrained(bool has_constraints) {
  if (!has_constraints)
    throw InvalidInput("nothing is constrained; call set_constraints with at least one vertex before solve");
}

bool all_finite(const Positions& x, const Workers& workers) {
  return parallel_all<4096>(workers, static_cast<int>(x.rows()),
                            [&](int begin, int end) { return x.middleRows(begin, end - begin).allFinite(); });
}

}  // namespace arap
