// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/cage_arap/cage_holds.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <span>
#include <utility>

#include "base/eigen_compat.h"
#include "base/union_find.h"
#include "cages/cage_motion.h"
#include "parallel/parallel.h"
#include "sampling/surface_patch.h"

namespace arap {

namespace {

/// How stiff what is hard is, beside the mean of K: a region is met to a thousandth of the size, by a cage that stays
/// smooth.
constexpr double kHardStrength = 1e4;

/// What of a matrix, beside its largest value, moves no held vertex that one would see.
constexpr double kLeast = 1e-8;

/// What the rows of vertices differ by from rounding alone, beside their length.
constexpr double kRounding = 1e-12;

/// A constrained vertex holds a shell that has a larger share of its weights.
constexpr double kLeastShare = 1e-3;

int largest_of(const Eigen::RowVectorXd& values) {
  Eigen::Index largest = 0;
  values.maxCoeff(&largest);
  return static_cast<int>(largest);
}

/// Columns B of which B B^T is N, up to a small part: a Cholesky factor whose pivots are the largest ones left.
struct ThinFactor {
  Eigen::MatrixXd columns;
  std::vector<int> pivots;  ///< the row of the pivot of each column
};

/// @param rounding  what of N's diagonal is not more than that
ThinFactor thin_factor(const Eigen::MatrixXd& N, double rounding, const MeterPart& meter) {
  Eigen::VectorXd left = N.diagonal();
  const double least = std::max(kLeast * left.maxCoeff(), rounding);
  Eigen::MatrixXd B(N.rows(), N.cols());
  std::vector<int> pivots;
  for (Eigen::Index n = 0; n < B.cols(); ++n) {
    Eigen::Index pivot = 0;
    const double value = left.maxCoeff(&pivot);
    if (!(value > least)) break;
    B.col(n) = (N.col(pivot) - B.leftCols(n) * B.row(pivot).head(n).transpose()) / std::sqrt(value);
    left -= B.col(n).cwiseAbs2();
    pivots.push_back(static_cast<int>(pivot));
    meter.add(1. / static_cast<double>(N.cols()));
  }
  return {B.leftCols(std::ssize(pivots)), std::move(pivots)};
}

double strength_of(const ConstraintSet& set, size_t k) {
  const double s = set.strengths.empty() ? 1.0 : set.strengths[k];
  return s < 1 ? std::min(kHardStrength, s / (1 - s)) : kHardStrength;
}

/// A number of the handle of each constrained vertex, by vertex.
std::map<int, int> handles_of(const PolygonMesh& mesh, const std::vector<char>& is_constrained) {
  UnionFind joined(mesh.n_vertices());
  for (int f = 0; f < mesh.n_faces(); ++f) {
    const std::span<const int> face = mesh.face(f);
    for (size_t k = 0; k < face.size(); ++k) {
      const int next = face[(k + 1) % face.size()];
      if (is_constrained[face[k]] != 0 && is_constrained[next] != 0) joined.join(face[k], next);
    }
  }
  std::map<int, int> handle_of_root;
  std::map<int, int> result;
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (is_constrained[v] != 0)
      result[v] = handle_of_root.try_emplace(joined.find(v), static_cast<int>(handle_of_root.size())).first->second;
  return result;
}

}  // namespace

CageHolds::CageHolds(const CagePoints& points, const std::vector<int>& point_of_vertex, const PolygonMesh& mesh,
                     const std::vector<double>& areas, const PolygonMesh& cage, double stiffness,
                     const ConstraintSet& set, const MeterPart& meter)
    : points_(&points), cage_(&cage), is_held_(cage.n_parts(), 0) {
  constexpr double kShells = .05;  // of the time
  hold_shells(point_of_vertex, mesh, set);
  meter.add(kShells);
  add_handles(point_of_vertex, mesh, areas, stiffness, set, meter.part(1 - kShells));
  for (int p = 0; p < set.patches.size(); ++p) add_patch(point_of_vertex, set, p);
  add_shells();
}

void CageHolds::hold_shells(const std::vector<int>& point_of_vertex, const PolygonMesh& mesh,
                            const ConstraintSet& set) {
  std::vector<char> is_constrained(mesh.n_parts(), 0);
  std::vector<int> constrained;
  const auto add = [&](int v) {
    if (point_of_vertex[v] < 0) return;
    constrained.push_back(point_of_vertex[v]);
    is_constrained[mesh.part_of_vertex()[v]] = 1;
  };
  for (const int v : set.vertices) add(v);
  for (size_t k = 0; k < set.patches.vertices.size(); ++k)
    if (set.patches.weights[k] > 0) add(set.patches.vertices[k]);
  std::vector<char> is_home(cage_->n_parts(), 0);
  for (size_t begin = 0; begin < constrained.size(); begin += CagePoints::kRows) {
    const size_t n = std::min<size_t>(CagePoints::kRows, constrained.size() - begin);
    const Eigen::MatrixXd shares = shares_of_shells(std::span(constrained).subspan(begin, n));
    for (Eigen::Index k = 0; k < shares.rows(); ++k) is_home[largest_of(shares.row(k))] = 1;
    for (Eigen::Index shell = 0; shell < shares.cols(); ++shell)
      if (shares.col(shell).maxCoeff() > kLeastShare) is_held_[shell] = 1;
  }
  // Else a part without constraints would be thrown far to bring handles beside it a little nearer to their targets.
  home_of_part_ = homes_of_parts(point_of_vertex, mesh);
  for (int part = 0; part < mesh.n_parts(); ++part)
    if (is_constrained[part] == 0) is_held_[home_of_part_[part]] = is_home[home_of_part_[part]];
}

void CageHolds::add_handles(const std::vector<int>& point_of_vertex, const PolygonMesh& mesh,
                            const std::vector<double>& areas, double stiffness, const ConstraintSet& set,
                            const MeterPart& meter) {
  std::vector<char> is_constrained(mesh.n_vertices(), 0);
  for (const int v : set.vertices) is_constrained[v] = point_of_vertex[v] >= 0 ? 1 : 0;
  const std::map<int, int> handle_of_vertex = handles_of(mesh, is_constrained);
  std::map<int, std::vector<size_t>> entries;
  for (size_t k = 0; k < set.vertices.size(); ++k)
    if (const auto found = handle_of_vertex.find(set.vertices[k]); found != handle_of_vertex.end())
      entries[found->second].push_back(k);
  const std::vector<double> of_cage = vertex_areas(*cage_);
  const double cage_area = std::reduce(of_cage.begin(), of_cage.end()) / cage_->n_vertices();
  for (const auto& [number, of_handle] : entries) {
    Handle handle;
    double area = 0;
    for (const size_t k : of_handle) area += areas[set.vertices[k]];
    const double lacking = std::max(0.0, cage_area - area) / static_cast<double>(of_handle.size());
    handle.weights.resize(std::ssize(of_handle));
    for (const size_t k : of_handle) {
      const int v = set.vertices[k];
      handle.weights[std::ssize(handle.points)] = strength_of(set, k) * (areas[v] + lacking) / cage_area;
      handle.sources.push_back(static_cast<int>(k));
      handle.points.push_back(point_of_vertex[v]);
    }
    const double share = static_cast<double>(of_handle.size()) / static_cast<double>(handle_of_vertex.size());
    add_rows(std::move(handle), stiffness, meter.part(share));
  }
}

void CageHolds::add_rows(Handle handle, double stiffness, const MeterPart& meter) {
  const auto number = static_cast<int>(handles_.size());
  const double sum = handle.weights.sum();
  const Eigen::RowVectorXd mean = points_->transposed(handle.points, handle.weights).transpose() / sum;
  add_row(mean, 2 * stiffness * sum, handle.sources.front(), number);
  if (handle.points.size() > 1) {
    constexpr double kProduct = .9;  // of the time
    const Eigen::MatrixXd N = points_->normal_matrix(handle.points, handle.weights, mean, meter.part(kProduct));
    const double rounding = kRounding * kRounding * sum * mean.squaredNorm();
    auto [columns, pivots] = thin_factor(N, rounding, meter.part(1 - kProduct));
    const Eigen::VectorXd lengths = columns.colwise().norm();
    for (Eigen::Index r = 0; r < columns.cols(); ++r)
      add_row(columns.col(r).transpose() / lengths[r], 2 * stiffness * lengths[r] * lengths[r], handle.sources.front(),
              number);
    handle.to_pulls = columns(pivots, all) * lengths.asDiagonal();
    handle.pivots = std::move(pivots);
  }
  handles_.push_back(std::move(handle));
}

Positions CageHolds::targets_of(const Handle& handle, int first, const Positions& of_set) const {
  const Positions own = of_set(handle.sources, all);
  const auto mean = [&](const Positions& of) {
    return Eigen::RowVector3d(handle.weights.transpose() * of / handle.weights.sum());
  };
  const auto n_others = std::ssize(handle.pivots);
  if (n_others == 0) return mean(own);
  // The substitution loses digits of what is large in it. So it has what the best similarity leaves: rows are exact of
  // that itself.
  const double unit = points_->cage().size();
  const Positions rest = unit * points_->rest()(handle.points, all);
  const AffineMap map = best_similarity(rest, own);
  const Positions cage = map.apply(unit * points_->cage().vertices());
  const Positions left = own - map.apply(rest);
  Positions result(1 + n_others, 3);
  result.row(0) = mean(left);
  const Positions pulling = handle.weights.asDiagonal() * (left.rowwise() - mean(left));
  const Eigen::MatrixXd pulls = points_->transposed(handle.points, pulling)(handle.pivots, all);
  result.bottomRows(n_others) = handle.to_pulls.triangularView<Eigen::Lower>().solve(pulls);
  for (Eigen::Index r = 0; r < result.rows(); ++r) result.row(r) += rows_.rows[first + r].of(cage);
  return result;
}

void CageHolds::add_patch(const std::vector<int>& point_of_vertex, const ConstraintSet& set, int p) {
  std::vector<int> of_patch;
  std::vector<double> weights;
  for (int k = set.patches.offsets[p]; k < set.patches.offsets[p + 1]; ++k) {
    if (!(set.patches.weights[k] > 0)) continue;
    of_patch.push_back(point_of_vertex[set.patches.vertices[k]]);
    weights.push_back(set.patches.weights[k]);
  }
  const auto weight = Eigen::VectorXd::Map(weights.data(), std::ssize(weights));
  const Eigen::RowVectorXd average = points_->transposed(of_patch, weight).transpose() / weight.sum();
  const int source = static_cast<int>(set.vertices.size()) + p;
  add_row(average, LinearRows::kHard, source, static_cast<int>(handles_.size()) + p);
}

void CageHolds::add_shells() {
  const int first = handle_of_row_.empty() ? 0 : handle_of_row_.back() + 1;
  for (int v = 0; v < cage_->n_vertices(); ++v) {
    const int shell = cage_->part_of_vertex()[v];
    if (shell < 0 || is_held_[shell] != 0) continue;
    add_row(Eigen::RowVectorXd::Unit(cage_->n_vertices(), v), LinearRows::kHard, -1, first + shell);
    shell_rows_.push_back(v);
  }
  for (size_t part = 0; part < home_of_part_.size(); ++part)
    if (is_held_[home_of_part_[part]] == 0) parts_at_rest_.push_back(static_cast<int>(part));
}

std::vector<int> CageHolds::homes_of_parts(const std::vector<int>& point_of_vertex, const PolygonMesh& mesh) const {
  std::vector<int> lowest;  // parts are numbered by their lowest vertices
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (mesh.part_of_vertex()[v] == static_cast<int>(lowest.size())) lowest.push_back(point_of_vertex[v]);
  std::vector<int> homes;
  homes.reserve(lowest.size());
  for (const int point : lowest) homes.push_back(largest_of(shares_of_shells(std::span(&point, 1)).row(0)));
  return homes;
}

Eigen::MatrixXd CageHolds::shares_of_shells(std::span<const int> points) const {
  if (cage_->n_parts() == 1) return Eigen::MatrixXd::Ones(std::ssize(points), 1);
  const CagePoints::Rows weights = points_->rows(points);
  Eigen::MatrixXd shares = Eigen::MatrixXd::Zero(weights.rows(), cage_->n_parts());
  for (int v = 0; v < cage_->n_vertices(); ++v)
    if (const int shell = cage_->part_of_vertex()[v]; shell >= 0) shares.col(shell) += weights.col(v).cwiseAbs();
  return shares.array().colwise() / shares.rowwise().sum().array();
}

void CageHolds::add_row(const Eigen::RowVectorXd& row, double weight, int source, int handle) {
  LinearRow sparse;
  for (Eigen::Index k = 0; k < row.size(); ++k)
    if (row[k] != 0) {
      sparse.indices.push_back(static_cast<int>(k));
      sparse.coefficients.push_back(row[k]);
    }
  rows_.add(std::move(sparse), weight);
  handle_of_row_.push_back(handle);
  sources_.push_back(source);
}

Positions CageHolds::targets(const Positions& of_set) const {
  Positions result(rows_.size(), 3);
  Eigen::Index row = 0;
  for (const Handle& handle : handles_) {
    const Positions own = targets_of(handle, static_cast<int>(row), of_set);
    result.middleRows(row, own.rows()) = own;
    row += own.rows();
  }
  for (; row < result.rows() - std::ssize(shell_rows_); ++row) result.row(row) = of_set.row(sources_[row]);
  for (const int v : shell_rows_) result.row(row++) = cage_->positions().row(v);
  return result;
}

}  // namespace arap
