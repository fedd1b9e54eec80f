// SPDX-License-Identifier: GPL-3.0-or-later
#include "constraints/rigid_regions.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <utility>

#include "dense/small_matrices.h"
#include "geometry/rotation.h"

namespace arap {

namespace {

/// s with <[w]x, A> = -<w, s> for every w.
Vector3 twist(const Matrix3& A) { return {A(1, 2) - A(2, 1), A(2, 0) - A(0, 2), A(0, 1) - A(1, 0)}; }

}  // namespace

std::vector<int> without_single_vertices(std::vector<int> region_of_vertex) {
  std::map<int, int> n_members;
  for (const int region : region_of_vertex) ++n_members[region];
  for (int& region : region_of_vertex)
    if (n_members[region] == 1) region = -1;
  return region_of_vertex;
}

RigidRegions::RigidRegions(const std::vector<int>& region_of_vertex, const CellEnergy& energy, const Positions& rest)
    : energy_(&energy), rest_(&rest) {
  std::map<int, std::vector<int>> members_of_label;
  for (size_t v = 0; v < region_of_vertex.size(); ++v)
    if (region_of_vertex[v] >= 0) members_of_label[region_of_vertex[v]].push_back(static_cast<int>(v));
  if (members_of_label.empty()) return;
  unknown_of_vertex_.resize(rest.rows());
  for (size_t v = 0; v < unknown_of_vertex_.size(); ++v) unknown_of_vertex_[v] = static_cast<int>(v);
  is_member_.assign(rest.rows(), 0);
  for (auto& [label, members] : members_of_label) {
    for (const int v : members) {
      unknown_of_vertex_[v] = members.front();
      is_member_[v] = 1;
    }
    regions_.push_back({.members = std::move(members),
                        .border = {},
                        .cells = {},
                        .vertices_outside = {},
                        .cells_outside = {},
                        .anchors = {},
                        .pulls = {}});
  }
}

void RigidRegions::read_cells(const Cells& cells) {
  cells_ = &cells;
  cells_with_members_.clear();
  if (empty()) return;
  for (Region& region : regions_) {
    region.cells.clear();
    region.border.clear();
    region.vertices_outside.clear();
    region.cells_outside.clear();
  }
  find_cells();
  std::vector<char> has_members(cells_->size(), 0);
  for (Region& region : regions_) {
    find_border(region);
    find_outside(region);
    for (const int c : region.cells) has_members[c] = 1;
    for (const CellOutside& outside : region.cells_outside) has_members[outside.cell] = 1;
  }
  for (int c = 0; c < cells_->size(); ++c)
    if (has_members[c] != 0) cells_with_members_.push_back(c);
}

void RigidRegions::renumber(const std::vector<int>& new_of_old) {
  std::vector<int> unknown_of_vertex(unknown_of_vertex_.size());
  for (size_t v = 0; v < unknown_of_vertex_.size(); ++v)
    unknown_of_vertex[new_of_old[v]] = new_of_old[unknown_of_vertex_[v]];
  unknown_of_vertex_ = std::move(unknown_of_vertex);
  std::fill(is_member_.begin(), is_member_.end(), 0);
  for (Region& region : regions_)
    for (int& v : region.members) {
      v = new_of_old[v];
      is_member_[v] = 1;
    }
}

void RigidRegions::find_cells() {
  std::vector<int> region_of_unknown(unknown_of_vertex_.size(), -1);
  for (size_t r = 0; r < regions_.size(); ++r) region_of_unknown[regions_[r].members.front()] = static_cast<int>(r);
  for (int c = 0; c < cells_->size(); ++c) {
    const int home = cells_->home(c);
    const int r = home < 0 ? -1 : region_of_unknown[unknown_of_vertex_[home]];
    if (r >= 0) regions_[r].cells.push_back(c);
  }
}

void RigidRegions::find_border(Region& region) const {
  for (const int v : region.members) {
    bool reaches_out = false;
    for (SparseMatrix::InnerIterator it(energy_->K, v); it && !reaches_out; ++it)
      reaches_out = !is_member(static_cast<int>(it.row()), region);
    if (reaches_out) region.border.push_back(v);
  }
}

void RigidRegions::find_outside(Region& region) const {
  std::map<int, Vector3> vertices;
  std::map<int, CellOutside> cells;
  for (const int c : region.cells)
    cells_->for_each_vertex(c, [&](int v, const Vector3& q) {
      if (!is_member(v, region)) vertices.try_emplace(v, Vector3::Zero()).first->second += q;
    });
  for (const int v : region.members)
    cells_->for_each_cell(v, [&](int c, const Vector3& q) {
      if (has_cell(c, region)) return;
      CellOutside& cell = cells.try_emplace(c, CellOutside{.cell = c}).first->second;
      cell.q += q;
      cell.moment += q * rest(v).transpose();
    });
  for (const auto& [v, q] : vertices) region.vertices_outside.push_back({v, q});
  for (const auto& [c, outside] : cells) region.cells_outside.push_back(outside);
}

SparseMatrix RigidRegions::reduce(const SparseMatrix& K) const {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(K.nonZeros() + K.rows());
  for (int v = 0; v < static_cast<int>(K.rows()); ++v) entries.emplace_back(v, v, 0.0);
  for (int column = 0; column < static_cast<int>(K.cols()); ++column)
    for (SparseMatrix::InnerIterator it(K, column); it; ++it)
      entries.emplace_back(unknown_of(static_cast<int>(it.row())), unknown_of(column), it.value());
  SparseMatrix reduced(K.rows(), K.cols());
  reduced.setFromTriplets(entries.begin(), entries.end());
  // The rows of K sum to 0. The sum over a whole region is rounding where 0 is meant, so its diagonal comes from the
  // border.
  for (const Region& region : regions_) {
    const int unknown = region.members.front();
    double border = 0;
    for (SparseMatrix::InnerIterator it(reduced, unknown); it; ++it)
      if (it.row() != unknown) border -= it.value();
    reduced.coeffRef(unknown, unknown) = border;
  }
  return reduced;
}

void RigidRegions::reduce(Positions& x) const {
  for (const Region& region : regions_)
    for (size_t k = 1; k < region.members.size(); ++k) {
      x.row(region.members.front()) += x.row(region.members[k]);
      x.row(region.members[k]).setZero();
    }
}

Positions RigidRegions::member_rows(const Positions& x) const {
  size_t n = 0;
  for (const Region& region : regions_) n += region.members.size();
  Positions rows(n, 3);
  Eigen::Index next = 0;
  for (const Region& region : regions_)
    for (const int v : region.members) rows.row(next++) = x.row(v);
  return rows;
}

void RigidRegions::set_member_rows(const Positions& rows, Positions& x) const {
  Eigen::Index next = 0;
  for (const Region& region : regions_)
    for (const int v : region.members) x.row(v) = rows.row(next++);
}

void RigidRegions::expand(Positions& x) const {
  for (const Region& region : regions_)
    for (const int v : region.members) x.row(v) = x.row(region.members.front());
}

bool RigidRegions::has_member(const LinearRow& row) const {
  return std::any_of(row.indices.begin(), row.indices.end(), [&](int v) { return has_member(v); });
}

int RigidRegions::region_of(const LinearRow& patch) const {
  constexpr double kHalf = 0.5 + 1e-9;  // rounding does not decide whose an even patch is
  for (int r = 0; r < size(); ++r) {
    double share = 0;
    for (size_t k = 0; k < patch.indices.size(); ++k)
      if (is_member(patch.indices[k], regions_[r])) share += patch.coefficients[k];
    if (share > kHalf) return r;
  }
  return -1;
}

void RigidRegions::set_constraints(const std::vector<char>& is_hard, const Eigen::VectorXd& soft_diagonal,
                                   const std::vector<RegionPoint>& patches, const LinearRows& rows) {
  for (Region& region : regions_) {
    region.anchors.clear();
    find_pulls(region, rows);
    for (const int v : region.members)
      if (is_hard[v] != 0) region.anchors.push_back({rest(v), v, -1});
  }
  for (int p = 0; p < std::ssize(patches); ++p) regions_[patches[p].region].anchors.push_back({patches[p].rest, -1, p});
  for (Region& region : regions_) {
    if (!region.anchors.empty()) find_anchor_rank(region);
    choose_center(region, soft_diagonal);
  }
}

void RigidRegions::find_pulls(Region& region, const LinearRows& rows) const {
  region.pulls.clear();
  for (int r = 0; r < rows.size(); ++r) {
    Pull pull{.row = r, .weight = rows.weights[r], .share = 0, .moment = Vector3::Zero(), .elsewhere = {}};
    const auto& [indices, coefficients] = rows.rows[r];
    for (size_t k = 0; k < indices.size(); ++k) {
      if (is_member(indices[k], region)) {
        pull.share += coefficients[k];
        pull.moment += coefficients[k] * rest(indices[k]);
      } else {
        pull.elsewhere.indices.push_back(indices[k]);
        pull.elsewhere.coefficients.push_back(coefficients[k]);
      }
    }
    if (pull.elsewhere.indices.size() < indices.size()) region.pulls.push_back(std::move(pull));
  }
}

void RigidRegions::find_anchor_rank(Region& region) {
  const auto n = static_cast<double>(region.anchors.size());
  Vector3 mean = Vector3::Zero();
  for (const Anchor& anchor : region.anchors) mean += anchor.rest / n;
  Matrix3 scatter = Matrix3::Zero();
  for (const Anchor& anchor : region.anchors) scatter += (anchor.rest - mean) * (anchor.rest - mean).transpose();
  const auto [values, vectors] = symmetric_eigen(scatter);
  // Below these the anchors count as one point, or as a line: 1e-6 of the mesh, which has size 1.
  region.anchor_rank = values[2] <= 1e-12 ? 0 : (values[1] <= 1e-12 * values[2] ? 1 : 2);
  region.anchor_axis = vectors.col(2);
}

// The terms of the energy that join the region's motion (R, t) with itself are, with c the center,
//     1/2 kappa |t|^2 + <t, R mixed>,  mixed = sum_{j,k in r} K_jk (p_j - c) + sum_j 2 omega_j (p_j - c)
//             + sum_rows w share arm - sum_{cells in r, k in r} q_ck.
// Rows of K and of q sum to 0, so the sums over the inside are minus those over the outside: only what joins the two
// counts.
void RigidRegions::choose_center(Region& region, const Eigen::VectorXd& soft_diagonal) const {
  double kappa = 0;
  Vector3 moment = Vector3::Zero();
  Vector3 mean = Vector3::Zero();
  for (const int v : region.border) {
    double inside = 0;
    for (SparseMatrix::InnerIterator it(energy_->K, v); it; ++it)
      if (!is_member(static_cast<int>(it.row()), region)) inside -= it.value();
    kappa += inside;
    moment += inside * rest(v);
  }
  for (const int v : region.members) {
    kappa += soft_diagonal[v];
    moment += soft_diagonal[v] * rest(v);
    mean += rest(v) / static_cast<double>(region.members.size());
  }
  for (const Pull& pull : region.pulls) {
    kappa += pull.weight * pull.share * pull.share;
    moment += pull.weight * pull.share * pull.moment;
  }
  for (const VertexOutside& outside : region.vertices_outside) moment += outside.q;
  if (!region.anchors.empty()) {
    region.center.setZero();
    for (const Anchor& anchor : region.anchors)
      region.center += anchor.rest / static_cast<double>(region.anchors.size());
  } else {
    region.center = kappa > 0 ? Vector3(moment / kappa) : mean;
  }
  region.mixed = region.anchors.empty() ? Vector3(Vector3::Zero()) : Vector3(moment - kappa * region.center);
}

Vector3 RigidRegions::carried(const RegionPoint& point, const std::vector<Placement>& placements) const {
  const Placement& placement = placements[point.region];
  return placement.rotation * (point.rest - regions_[point.region].center) + placement.translation;
}

std::vector<Placement> RigidRegions::fit_placements(const Positions& positions) const {
  std::vector<Placement> placements;
  placements.reserve(regions_.size());
  for (const Region& region : regions_) {
    Vector3 mean_rest = Vector3::Zero();
    Vector3 mean = Vector3::Zero();
    for (const int v : region.members) {
      mean_rest += rest(v) / static_cast<double>(region.members.size());
      mean += positions.row(v).transpose() / static_cast<double>(region.members.size());
    }
    Matrix3 S = Matrix3::Zero();
    for (const int v : region.members) S += (positions.row(v).transpose() - mean) * (rest(v) - mean_rest).transpose();
    Placement placement;
    placement.rotation = nearest_rotation(S, Matrix3::Identity());
    placement.translation = mean + placement.rotation * (region.center - mean_rest);
    placements.push_back(placement);
  }
  return placements;
}

void RigidRegions::place(const Region& region, const Matrix3& linear, const RegionTargets& targets,
                         Placement& placement) {
  if (region.anchors.empty()) {
    placement.rotation = nearest_rotation(-linear, placement.rotation);
    return;
  }
  placement.translation.setZero();
  for (const Anchor& anchor : region.anchors)
    placement.translation += anchor.target(targets) / static_cast<double>(region.anchors.size());
  Matrix3 S = Matrix3::Zero();
  for (const Anchor& anchor : region.anchors)
    S += (anchor.target(targets) - placement.translation) * (anchor.rest - region.center).transpose();
  const Vector3 direction = S * region.anchor_axis;
  if (region.anchor_rank == 2)
    placement.rotation = nearest_rotation(S, placement.rotation);
  else if (region.anchor_rank == 1 && direction.norm() > 1e-12)
    placement.rotation =
        nearest_rotation_with_axis(-linear, region.anchor_axis, direction.normalized(), placement.rotation);
  else
    placement.rotation = nearest_rotation(-linear, placement.rotation);
}

void RigidRegions::place_anchored(const RegionTargets& targets, std::vector<Placement>& placements) const {
  for (size_t r = 0; r < regions_.size(); ++r) {
    if (regions_[r].anchors.empty()) continue;
    const Matrix3 keep = -placements[r].rotation;
    place(regions_[r], keep, targets, placements[r]);
  }
}

void RigidRegions::write(const Region& region, const Placement& placement, Positions& positions) const {
  for (const int v : region.members) positions.row(v) = place_of(v, region, placement);
}

void RigidRegions::write(const std::vector<Placement>& placements, Positions& positions) const {
  for (size_t r = 0; r < regions_.size(); ++r) write(regions_[r], placements[r], positions);
}

void RigidRegions::read_translations(std::vector<Placement>& placements, const Positions& positions) const {
  for (size_t r = 0; r < regions_.size(); ++r) {
    const int v = regions_[r].members.front();
    placements[r].translation = positions.row(v).transpose() - placements[r].rotation * (rest(v) - regions_[r].center);
  }
}

// L with E = <R, L> + terms without R; see the header. Soft constraints and patches are added by the caller.
Matrix3 RigidRegions::linear_term(const Region& region, const Placement& placement, const Positions& positions,
                                  const CellPasses& passes) const {
  Matrix3 L = placement.translation * region.mixed.transpose();
  for (const int v : region.border) {
    Vector3 pull = Vector3::Zero();
    for (SparseMatrix::InnerIterator it(energy_->K, v); it; ++it)
      if (!is_member(static_cast<int>(it.row()), region)) pull += it.value() * positions.row(it.row()).transpose();
    L += pull * (rest(v) - region.center).transpose();
  }
  for (const auto& [cell, q, moment] : region.cells_outside)
    L -= passes.rotation(cell).toRotationMatrix() * (moment - q * region.center.transpose());
  for (const auto& [vertex, q] : region.vertices_outside) L -= positions.row(vertex).transpose() * q.transpose();
  return L;
}

void RigidRegions::fit_rotation(int region, const RegionTargets& targets, const Eigen::VectorXd& soft_diagonal,
                                const Matrix3& pull, Placement& placement, CellPasses& passes,
                                Positions& positions) const {
  const Region& fitted = regions_[region];
  Matrix3 L = linear_term(fitted, placement, positions, passes) + pull;
  for (const int v : fitted.members)
    if (soft_diagonal[v] > 0)
      L -= soft_diagonal[v] * targets.vertices.row(v).transpose() * (rest(v) - fitted.center).transpose();
  for (const Pull& by : fitted.pulls) {
    const Vector3 left = (targets.rows.row(by.row) - by.elsewhere.of(positions)).transpose();
    L -= by.weight * left * by.arm(fitted.center).transpose();
  }
  place(fitted, L, targets, placement);
  write(fitted, placement, positions);
  passes.move_vertices(fitted.members, positions);
  const Eigen::Quaterniond rotation(placement.rotation);
  for (const int c : fitted.cells) passes.set_rotation(c, rotation);
}

Vector3 RigidRegions::arm_of(int region, const LinearRow& average) const {
  Vector3 arm = Vector3::Zero();
  for (size_t k = 0; k < average.indices.size(); ++k)
    if (is_member(average.indices[k], regions_[region]))
      arm += average.coefficients[k] * (rest(average.indices[k]) - regions_[region].center);
  return arm;
}

Vector3 RigidRegions::pull_along(int region, const Eigen::Ref<const Eigen::VectorXd>& response) const {
  const Region& pulled = regions_[region];
  Vector3 pull = Vector3::Zero();
  for (const int v : pulled.border)
    for (SparseMatrix::InnerIterator it(energy_->K, v); it; ++it)
      if (!is_member(static_cast<int>(it.row()), pulled))
        pull -= it.value() * response[it.row()] * (rest(v) - pulled.center);
  for (const Pull& by : pulled.pulls)
    for (size_t k = 0; k < by.elsewhere.indices.size(); ++k)
      pull -= by.weight * by.elsewhere.coefficients[k] * response[by.elsewhere.indices[k]] * by.arm(pulled.center);
  for (const auto& [vertex, q] : pulled.vertices_outside) pull += response[vertex] * q;
  return pull;
}

void RigidRegions::share_rotations(const std::vector<Placement>& placements, Rotations& rotations) const {
  for (size_t r = 0; r < regions_.size(); ++r)
    for (const int c : regions_[r].cells) rotations[c] = Eigen::Quaterniond(placements[r].rotation);
}

void RigidRegions::share_rotations(const std::vector<Placement>& placements, CellPasses& passes) const {
  for (size_t r = 0; r < regions_.size(); ++r) {
    const Eigen::Quaterniond rotation(placements[r].rotation);
    for (const int c : regions_[r].cells) passes.set_rotation(c, rotation);
  }
}

// R makes H = S R^T symmetric, S = sum_j p'_j (p_j - c)^T. Vertices that move by d_j turn it by the w of
//     (tr(H) I - H) w = sum_j R (p_j - c) x d_j,
// and a turn by w changes the energy by -<[w]x R, Q> = <w, twist(Q R^T)>.
Positions RigidRegions::turn_cells(const Positions& positions, Rotations& rotations) const {
  Positions gradient = Positions::Zero(positions.rows(), 3);
  const RegionTargets places{positions, Positions(0, 3), Positions(0, 3)};
  for (const Region& region : regions_) {
    Matrix3 Q = Matrix3::Zero();
    for (const int c : region.cells) {
      const Eigen::RowVector3d home = positions.row(cells_->home(c));
      cells_->for_each_vertex(
          c, [&](int v, const Vector3& q) { Q += (positions.row(v) - home).transpose() * q.transpose(); });
    }
    // Held at all of its vertices.
    Region held;
    for (const int v : region.members) {
      held.anchors.push_back({rest(v), v, -1});
      held.center += rest(v) / static_cast<double>(region.members.size());
    }
    find_anchor_rank(held);
    Placement placement;
    place(held, -Q, places, placement);
    const Matrix3& R = placement.rotation;
    for (const int c : region.cells) rotations[c] = Eigen::Quaterniond(R);

    Matrix3 H = Matrix3::Zero();
    for (const int v : region.members) H += positions.row(v).transpose() * (R * (rest(v) - held.center)).transpose();
    const Matrix3 resistance = H.trace() * Matrix3::Identity() - H;
    const Vector3 torque = solve_symmetric(resistance, twist(Q * R.transpose()));
    for (const int v : region.members) gradient.row(v) = torque.cross(R * (rest(v) - held.center)).transpose();
  }
  return gradient;
}

}  // namespace arap
