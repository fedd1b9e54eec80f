// SPDX-License-Identifier: GPL-3.0-or-later
#include "cages/harmonic.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/available_memory.h"
#include "cages/green.h"
#include "cages/harmonic_grid.h"
#include "dense/small_matrices.h"
#include "parallel/parallel.h"

namespace arap {

namespace {

using Row = Eigen::RowVector3d;

/// Nearer to the cage a point is on it.
constexpr double kOn = 1e-12;

/// The weights of a point from values at nodes and at vertices.
struct Stencil {
  std::array<int, 8> nodes{};
  std::array<double, 8> factors{};  ///< 0 where there is no node
  HatValues of_vertices;
};

/// A value beside a point: of a node, or of hats.
struct Datum {
  Row place;
  double weight;
  int corner = -1;  ///< of the cell
  HatValues hats;
};

/// The place of a triangle below a point, cut off at its edges.
HarmonicGrid::OnCage place_below(const Cage& cage, const CageTriangle& triangle, const Row& point) {
  const TrianglePlace place(triangle, point);
  std::array<double, 3> values{};
  double sum = 0;
  for (int k = 0; k < 3; ++k) sum += values[k] = std::max(0.0, place.hat(k));
  HarmonicGrid::OnCage below{Row::Zero(), {}};
  for (int k = 0; k < 3; ++k) {
    below.place += values[k] / sum * cage.vertices().row(triangle.vertices[k]);
    below.hats.emplace_back(triangle.vertices[k], values[k] / sum);
  }
  return below;
}

class StencilMaker {
 public:
  StencilMaker(const Cage& cage, const HarmonicGrid& grid, double spacing)
      : cage_(cage), grid_(grid), spacing_(spacing) {}

  /// False: the point is outside.
  [[nodiscard]] bool make(const Row& point, Stencil& stencil) const {
    const HarmonicGrid::Cell cell = grid_.cell_at(point);
    stencil.nodes = cell.nodes;
    if (cell.is_whole()) {
      for (int corner = 0; corner < 8; ++corner) stencil.factors[corner] = trilinear(cell, corner);
      return true;
    }
    std::vector<Datum> data = triangles_near(point);
    const bool is_on = !data.empty() && data.front().weight == kAlone;
    if (!is_on && !(winding_number(cage_, point) > .25)) return false;
    if (!is_on) add_cell(cell, point, data);
    fit(point, data, stencil);
    return true;
  }

 private:
  /// The weight of what the point is on, by its share.
  static constexpr double kAlone = -1;

  static double trilinear(const HarmonicGrid::Cell& cell, int corner) {
    const std::array<int, 3> side{corner / 4, corner / 2 % 2, corner % 2};
    double product = 1;
    for (int k = 0; k < 3; ++k) product *= side[k] == 1 ? cell.place[k] : 1 - cell.place[k];
    return product;
  }

  [[nodiscard]] double weight_at(const Row& place, const Row& point) const {
    return spacing_ * spacing_ / ((place - point).squaredNorm() + 1e-30);
  }

  /// Those nearer than a cell; of those that the point is on, the hats alone.
  [[nodiscard]] std::vector<Datum> triangles_near(const Row& point) const {
    std::vector<Datum> near;
    std::vector<Datum> on;
    for (const CageTriangle& triangle : cage_.triangles()) {
      if (std::abs(TrianglePlace(triangle, point).depth) > spacing_) continue;
      HarmonicGrid::OnCage below = place_below(cage_, triangle, point);
      const double distance = (below.place - point).norm();
      if (distance > spacing_) continue;
      for (auto& [vertex, value] : below.hats) value *= distance <= kOn ? triangle.share : 1;
      const double weight = distance <= kOn ? kAlone : triangle.share * weight_at(below.place, point);
      (distance <= kOn ? on : near).push_back({below.place, weight, -1, std::move(below.hats)});
    }
    return on.empty() ? near : on;
  }

  void add_cell(const HarmonicGrid::Cell& cell, const Row& point, std::vector<Datum>& data) const {
    for (int corner = 0; corner < 8; ++corner)
      if (cell.nodes[corner] >= 0)
        data.push_back({cell.corners[corner], weight_at(cell.corners[corner], point), corner, {}});
    for (const HarmonicGrid::OnCage& met : cell.cage)
      data.push_back({met.place, weight_at(met.place, point), -1, met.hats});
  }

  /// The linear function that fits the data best, at the point.
  void fit(const Row& point, const std::vector<Datum>& data, Stencil& stencil) const {
    double sum = 0;
    Eigen::Matrix4d products = Eigen::Matrix4d::Zero();
    const auto terms = [&](const Datum& datum) {
      Eigen::Vector4d h;
      h << 1, (datum.place - point).transpose() / spacing_;
      return h;
    };
    for (const Datum& datum : data) products += datum.weight * terms(datum) * terms(datum).transpose();
    const Eigen::Vector4d linear = solve_shortest(products, Eigen::Vector4d::UnitX(), 1e-6);
    for (const Datum& datum : data) {
      const double factor = datum.weight == kAlone ? 1 : datum.weight * linear.dot(terms(datum));
      if (datum.corner >= 0) stencil.factors[datum.corner] = factor;
      if (datum.corner >= 0) sum += factor;
      for (const auto& [vertex, value] : datum.hats) {
        stencil.of_vertices.emplace_back(vertex, factor * value);
        sum += factor * value;
      }
    }
    for (double& factor : stencil.factors) factor /= sum;
    for (auto& [vertex, value] : stencil.of_vertices) value /= sum;
  }

  const Cage& cage_;
  const HarmonicGrid& grid_;
  double spacing_;
};

/// Fills in the weights of three vertices.
void put_columns(const std::vector<Stencil>& stencils, int first, int n_vertices, const Positions& values,
                 const Workers& workers, WeightBlocks& weights) {
  parallel_for(workers, static_cast<int>(stencils.size()), [&](int begin, int end) {
    for (int p = begin; p < end; ++p) {
      Row sum = Row::Zero();
      for (int corner = 0; corner < 8; ++corner)
        if (stencils[p].factors[corner] != 0)
          sum += stencils[p].factors[corner] * values.row(stencils[p].nodes[corner]);
      for (const auto& [vertex, value] : stencils[p].of_vertices)
        if (vertex >= first && vertex < first + 3) sum[vertex - first] += value;
      for (int k = 0; k < std::min(3, n_vertices - first); ++k) weights.at(p, first + k) = static_cast<float>(sum[k]);
    }
  });
}

}  // namespace

void repair_weights(const Cage& cage, const Row& point, Eigen::VectorXd& weights) {
  Eigen::MatrixX4d H(weights.size(), 4);
  H << Eigen::VectorXd::Ones(weights.size()), cage.vertices().rowwise() - point;
  const Eigen::Vector4d off = Eigen::Vector4d::UnitX() - H.transpose() * weights;
  const Eigen::Matrix4d products = H.transpose() * weights.cwiseAbs().asDiagonal() * H;
  // Of a point on a face the matrix is singular, and nothing is off across.
  weights += weights.cwiseAbs().asDiagonal() * (H * solve_shortest(products, off, 1e-9));
}

std::vector<int> harmonic_weights(const Cage& cage, double spacing, const Positions& points, const Workers& workers,
                                  const MeterPart& meter, WeightBlocks& weights) {
  const HarmonicGrid grid(cage, spacing);
  const StencilMaker maker(cage, grid, spacing);
  const auto n = static_cast<int>(points.rows());
  constexpr double kBytesPerPoint = 400;
  require_memory(kBytesPerPoint * n, "harmonic coordinates of so many points");
  std::vector<Stencil> stencils(static_cast<size_t>(n));
  std::vector<char> is_outside(static_cast<size_t>(n), 0);
  parallel_for(workers, n, [&](int begin, int end) {
    for (int p = begin; p < end; ++p) is_outside[p] = maker.make(points.row(p), stencils[p]) ? 0 : 1;
  });
  std::vector<int> outside;
  for (int p = 0; p < n; ++p)
    if (is_outside[p] != 0) outside.push_back(p);
  if (!outside.empty()) return outside;
  grid.solve(workers, meter, [&](int first, const Positions& values) {
    put_columns(stencils, first, cage.n_vertices(), values, workers, weights);
  });
  parallel_for(workers, n, [&](int begin, int end) {
    for (int p = begin; p < end; ++p) {
      Eigen::VectorXd of_point = weights.of_point(p).cwiseMax(0);
      repair_weights(cage, points.row(p), of_point);
      for (int v = 0; v < cage.n_vertices(); ++v) weights.at(p, v) = static_cast<float>(of_point[v]);
    }
  });
  return {};
}

}  // namespace arap
