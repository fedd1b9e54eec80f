// SPDX-License-Identifier: GPL-3.0-or-later
#include "cages/harmonic_grid.h"

#include <algorithm>
#include <cmath>

#include "base/available_memory.h"
#include "cholesky/block_ldlt.h"
#include "cholesky/preconditioned_cg.h"
#include "sparse/matrix_assembly.h"

namespace arap {

namespace {

using Row = Eigen::RowVector3d;

/// Nearer to a node the cage counts as if it were so near, in spacings.
constexpr double kNearest = 1e-8;

/// About the middle of the cage, which is 0: mirrored cages have mirrored grids. Throws NotEnoughMemory.
SampleBox samples_around(const Cage& cage, double spacing) {
  SampleBox box;
  box.spacing = spacing;
  double n_samples = 1;
  for (int k = 0; k < 3; ++k) {
    box.counts[k] = static_cast<int>(std::ceil(cage.sides()[k] / spacing)) + 2;
    box.first[k] = -spacing * (box.counts[k] - 1) / 2;
    n_samples *= box.counts[k];
  }
  constexpr double kBytesPerSample = 40;  // which node and crossings it has, and how the cage winds around it
  require_memory(kBytesPerSample * n_samples, "the grid of harmonic coordinates");
  return box;
}

}  // namespace

HarmonicGrid::HarmonicGrid(const Cage& cage, double spacing)
    : cage_(cage), box_(samples_around(cage, spacing)), sources_(cage.n_vertices()) {
  std::vector<std::array<int, 3>> corners;
  for (int t = 0; t < cage.n_triangles(); ++t) {
    const bool is_other_cut = !triangles_.empty() &&
                              cage.face_of_triangle()[t] == cage.face_of_triangle()[triangles_.back()] &&
                              cage.cut_of_triangle()[t] != cage.cut_of_triangle()[triangles_.back()];
    if (is_other_cut) continue;
    triangles_.push_back(t);
    const auto& vertices = cage.triangle(t).vertices;
    corners.push_back({vertices[0], vertices[1], vertices[2]});
  }
  for (int axis = 0; axis < 3; ++axis) crossings_[axis] = find_crossings(cage.vertices(), corners, box_, axis);
  find_nodes();
  find_sources();
}

void HarmonicGrid::find_nodes() {
  const auto n_samples = static_cast<size_t>(box_.counts[0]) * box_.counts[1] * box_.counts[2];
  node_of_sample_.assign(n_samples, -1);
  std::vector<int> winding(n_samples, 0);
  for (int axis = 0; axis < 3; ++axis) {
    crossing_after_[axis].assign(n_samples, {-1, -1});
    for (int c = 0; c < static_cast<int>(crossings_[axis].size()); ++c) {
      const Crossing& crossing = crossings_[axis][c];
      Sample sample{};
      sample[(axis + 1) % 3] = crossing.line[0];
      sample[(axis + 2) % 3] = crossing.line[1];
      sample[axis] = std::max(0, crossing.before);
      auto& [first, last] = crossing_after_[axis][index(sample)];
      if (first < 0) first = c;
      last = c;
      if (axis == 2)
        for (sample[2] = crossing.before + 1; sample[2] < box_.counts[2]; ++sample[2])
          winding[index(sample)] -= crossing.sign;
    }
  }
  constexpr double kBytesPerNode = 250;  // its place, its row of the matrix, and the vectors of a solve
  require_memory(kBytesPerNode * static_cast<double>(std::ranges::count_if(winding, [](int w) { return w > 0; })),
                 "the grid of harmonic coordinates");
  Sample sample{};
  for (sample[0] = 0; sample[0] < box_.counts[0]; ++sample[0])
    for (sample[1] = 0; sample[1] < box_.counts[1]; ++sample[1])
      for (sample[2] = 0; sample[2] < box_.counts[2]; ++sample[2])
        if (winding[index(sample)] > 0) {
          node_of_sample_[index(sample)] = n_nodes();
          places_.push_back(sample);
        }
}

const Crossing* HarmonicGrid::crossing_after(const Sample& sample, int axis, bool is_last) const {
  const int found = crossing_after_[axis][index(sample)][is_last ? 1 : 0];
  return found < 0 ? nullptr : &crossings_[axis][found];
}

HarmonicGrid::Link HarmonicGrid::link(int node, int axis, bool is_up) const {
  Sample lower = places_[node];
  const double place = box_.first[axis] + box_.spacing * lower[axis];
  if (!is_up) --lower[axis];
  if (lower[axis] < 0 || lower[axis] + 1 >= box_.counts[axis]) return {};
  if (const Crossing* crossing = crossing_after(lower, axis, !is_up))
    return {1 / std::max(kNearest, std::abs(crossing->place - place) / box_.spacing), -1, crossing};
  Sample other = places_[node];
  other[axis] += is_up ? 1 : -1;
  const int next = node_of_sample_[index(other)];
  if (next >= 0) return {1, next, nullptr};
  // The cage passes through the next sample and, by rounding, just beyond it.
  Sample beyond = other;
  if (!is_up) --beyond[axis];
  const Crossing* crossing = beyond[axis] < 0 ? nullptr : crossing_after(beyond, axis, !is_up);
  return {crossing == nullptr ? 0.0 : 1.0, -1, crossing};
}

Row HarmonicGrid::place(const Crossing& crossing, int axis) const {
  Row place;
  place[axis] = crossing.place;
  for (int k = 0; k < 2; ++k) {
    const int other = (axis + 1 + k) % 3;
    place[other] = box_.first[other] + box_.spacing * crossing.line[k];
  }
  return place;
}

HatValues HarmonicGrid::hats(const Crossing& crossing, int axis) const {
  const Row at = place(crossing, axis);
  const int t = triangles_[crossing.triangle];
  HatValues values;
  double sum = 0;
  int cut = -1;
  // Of the other cut too, if the quad is flat.
  for (int other = 0; other < cage_.n_triangles(); ++other) {
    if (cage_.face_of_triangle()[other] != cage_.face_of_triangle()[t] || cage_.cut_of_triangle()[other] == cut)
      continue;
    const TrianglePlace place(cage_.triangle(other), at);
    constexpr double kOnSurface = 1e-9;
    const double least_height = *std::min_element(place.heights, place.heights + 3);
    const bool is_on = std::abs(place.depth) < kOnSurface && least_height > -kOnSurface;
    const bool is_own_cut = cage_.cut_of_triangle()[other] == cage_.cut_of_triangle()[t];
    if (is_own_cut ? other != t : !is_on) continue;
    cut = cage_.cut_of_triangle()[other];
    for (int k = 0; k < 3; ++k)
      values.emplace_back(cage_.triangle(other).vertices[k], cage_.triangle(other).share * place.hat(k));
    sum += cage_.triangle(other).share;
  }
  for (auto& [vertex, value] : values) value /= sum;
  return values;
}

void HarmonicGrid::find_sources() {
  for (int node = 0; node < n_nodes(); ++node)
    for (int axis = 0; axis < 3; ++axis)
      for (const bool is_up : {false, true}) {
        const Link to = link(node, axis, is_up);
        if (to.crossing == nullptr) continue;
        for (const auto& [vertex, value] : hats(*to.crossing, axis))
          sources_[vertex].push_back({node, to.conductance * value});
      }
}

void HarmonicGrid::solve_columns(const Workers& workers, const MeterPart& meter, int n_vertices,
                                 const TakeColumns& take) const {
  constexpr double kAccuracy = 1e-10;
  constexpr double kFactorized = .3;
  const auto fill = [&](int node, RowAccumulator<double>& column) {
    double diagonal = 0;
    for (int axis = 0; axis < 3; ++axis)
      for (const bool is_up : {false, true}) {
        const Link to = link(node, axis, is_up);
        diagonal += to.conductance;
        if (to.node >= 0) column[to.node] -= to.conductance;
      }
    column[node] += diagonal > 0 ? diagonal : 1;
  };
  std::unique_ptr<Factorization> factor;
  SparseMatrix A;
  if (n_nodes() > 0) {
    A = assemble_matrix(n_nodes(), workers.threads(), fill, {});
    const BlockLdlt solver(A, workers, choose_isa(), TileFormat::kFloat, meter.part(kFactorized / 2));
    factor = solver.factorize(A, std::vector<char>(static_cast<size_t>(n_nodes()), 0), meter.part(kFactorized / 2));
  }
  for (int first = 0; first < n_vertices; first += 3) {
    Positions values = Positions::Zero(n_nodes(), 3);
    for (int k = 0; k < std::min(3, n_vertices - first); ++k)
      for (const Source& source : sources_[first + k]) values(source.node, k) += source.value;
    if (values.size() > 0 && values.cwiseAbs().maxCoeff() > 0)
      solve_with_cg([&](const Positions& x, Positions& y) { multiply(A, x, y, workers); },
                    [&](Positions& residual, Positions& x) { factor->solve(residual, x); }, values, workers, kAccuracy);
    take(first, values);
    meter.add((1 - kFactorized) * std::min(3, n_vertices - first) / n_vertices);
  }
}

bool HarmonicGrid::Cell::is_whole() const {
  return cage.empty() && std::all_of(nodes.begin(), nodes.end(), [](int node) { return node >= 0; });
}

HarmonicGrid::Cell HarmonicGrid::cell_at(const Row& point) const {
  Cell cell;
  Sample low{};
  for (int k = 0; k < 3; ++k) {
    const double number = (point[k] - box_.first[k]) / box_.spacing;
    // What is at the wall of two cells is in the upper one, also if it is a little below by rounding.
    constexpr double kRounding = 1e-6;
    low[k] = static_cast<int>(std::clamp(std::floor(number + kRounding), 0.0, box_.counts[k] - 2.0));
    cell.place[k] = number - low[k];
  }
  for (int corner = 0; corner < 8; ++corner) {
    const Sample sample{low[0] + corner / 4, low[1] + corner / 2 % 2, low[2] + corner % 2};
    cell.nodes[corner] = node_of_sample_[index(sample)];
    cell.corners[corner] = box_.place(sample);
    for (int axis = 0; axis < 3; ++axis) {
      if (sample[axis] != low[axis]) continue;
      const Crossing* first = crossing_after(sample, axis, false);
      const Crossing* last = crossing_after(sample, axis, true);
      for (const Crossing* crossing : {first, last == first ? nullptr : last})
        if (crossing != nullptr) cell.cage.push_back({place(*crossing, axis), hats(*crossing, axis)});
    }
  }
  return cell;
}

}  // namespace arap
