// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "constraints/constrained_system.h"
#include "energy/cell_energy.h"
#include "energy/cell_passes.h"

namespace arap {

/// Where a rigid region is: p'_j = rotation (p_j - center) + translation.
struct Placement {
  Matrix3 rotation = Matrix3::Identity();
  Vector3 translation = Vector3::Zero();
};

/// Where constraints want the regions.
struct RegionTargets {
  Positions vertices;  ///< (n, 3), of soft and hard vertices
  Positions patches;   ///< of the points given to RigidRegions::set_constraints
  Positions rows;      ///< of the soft rows given there
};

/// A point that a region carries along.
struct RegionPoint {
  int region;
  Vector3 rest;
};

/// The regions but for those of one vertex: that is no more rigid than it is alone.
/// @param region_of_vertex  (n,) any label >= 0, < 0 = in no region; or empty
[[nodiscard]] std::vector<int> without_single_vertices(std::vector<int> region_of_vertex);

/// Vertices that move as one body each. Rotation and translation are eliminated from the system: the members of a
/// region share the unknown of their first vertex (the translation), and the cells at home in it share its rotation.
///
/// With the others fixed, the energy as a function of a region's motion is linear in R, since quadratic terms in R are
/// constant, and quadratic in t. The center is chosen so that the mixed term vanishes; then the best R does not
/// depend on t. Terms inside the region are constant and take no part: the region's own edges do not vote for its old
/// R.
class RigidRegions {
 public:
  /// K is all that reduce() needs; the rest needs read_cells() when the energy and the rest positions are whole.
  /// @param region_of_vertex  (n,) any label >= 0, < 0 = in no region; empty: no regions
  RigidRegions(const std::vector<int>& region_of_vertex, const CellEnergy& energy, const Positions& rest);

  /// @param cells  of the energy, or those that stand for them; must outlive this
  void read_cells(const Cells& cells);

  [[nodiscard]] bool empty() const { return regions_.empty(); }
  [[nodiscard]] int size() const { return static_cast<int>(regions_.size()); }

  /// The vertex whose unknown moves v.
  [[nodiscard]] int unknown_of(int v) const { return empty() ? v : unknown_of_vertex_[v]; }

  [[nodiscard]] bool has_member(int v) const { return !empty() && is_member_[v] != 0; }
  /// Whether the row names a vertex of a region.
  [[nodiscard]] bool has_member(const LinearRow& row) const;

  /// Follows the vertices of energy and rest, which have new numbers, before read_cells(); a region keeps its unknown.
  void renumber(const std::vector<int>& new_of_old);

  /// P^T K P for at least one region, where P maps unknowns to vertices; the rows of members that are not unknowns stay
  /// empty.
  [[nodiscard]] SparseMatrix reduce(const SparseMatrix& K) const;
  /// P^T x.
  void reduce(Positions& x) const;
  /// The rows of all members, region after region.
  [[nodiscard]] Positions member_rows(const Positions& x) const;
  void set_member_rows(const Positions& rows, Positions& x) const;
  /// P x.
  void expand(Positions& x) const;

  /// Takes the constraints into account: members that are hard, and points held by patches, anchor the region; soft
  /// members and soft rows pull at it.
  /// @param is_hard        (n,)
  /// @param soft_diagonal  (n,) 2 omega of each vertex, 0 where it is not soft
  void set_constraints(const std::vector<char>& is_hard, const Eigen::VectorXd& soft_diagonal,
                       const std::vector<RegionPoint>& patches, const LinearRows& rows);

  /// The region that has more than half of the patch's weight, -1 where there is none.
  [[nodiscard]] int region_of(const LinearRow& patch) const;
  /// Whether the targets of its anchors tell where all of it is.
  [[nodiscard]] bool is_held(int region) const { return regions_[region].anchor_rank == 2; }
  /// (n,) whether a vertex is one of any; empty without regions.
  [[nodiscard]] const std::vector<char>& members() const { return is_member_; }
  [[nodiscard]] bool is_anchored(int region) const { return !regions_[region].anchors.empty(); }
  [[nodiscard]] int unknown(int region) const { return regions_[region].members.front(); }

  [[nodiscard]] Placement rest_placement(int region) const { return {Matrix3::Identity(), regions_[region].center}; }

  /// Where placements carry a point.
  [[nodiscard]] Vector3 carried(const RegionPoint& point, const std::vector<Placement>& placements) const;

  /// Best placements for the members' present positions.
  [[nodiscard]] std::vector<Placement> fit_placements(const Positions& positions) const;

  /// Moves anchored regions where their anchors' targets are, as far as a rigid motion can.
  void place_anchored(const RegionTargets& targets, std::vector<Placement>& placements) const;

  /// Writes the members' positions.
  void write(const std::vector<Placement>& placements, Positions& positions) const;

  /// Reads the regions' translations from positions that moved by an expanded correction.
  void read_translations(std::vector<Placement>& placements, const Positions& positions) const;

  /// Local step of one region: fits its rotation, and moves its members, in the passes too; so are its cells turned.
  /// @param soft_diagonal  as in set_constraints
  /// @param pull           what else is linear in the rotation
  void fit_rotation(int region, const RegionTargets& targets, const Eigen::VectorXd& soft_diagonal, const Matrix3& pull,
                    Placement& placement, CellPasses& passes, Positions& positions) const;

  /// An average of vertices moves by R arm.
  [[nodiscard]] Vector3 arm_of(int region, const LinearRow& average) const;
  /// Where vertices outside move by step * response, the region's linear term falls by <R, step pull^T>.
  /// @param response  (n,)
  [[nodiscard]] Vector3 pull_along(int region, const Eigen::Ref<const Eigen::VectorXd>& response) const;

  /// Gives the cells of each region its rotation.
  void share_rotations(const std::vector<Placement>& placements, Rotations& rotations) const;
  void share_rotations(const std::vector<Placement>& placements, CellPasses& passes) const;
  /// All that have a member.
  [[nodiscard]] const std::vector<int>& cells_with_members() const { return cells_with_members_; }

  /// f(member, its place) for the members of all regions.
  template <class Function>
  void for_each_place(const std::vector<Placement>& placements, const Function& f) const {
    for (size_t r = 0; r < regions_.size(); ++r)
      for (const int v : regions_[r].members) f(v, place_of(v, regions_[r], placements[r]));
  }

  /// At positions of any shape: gives the cells of each region the rotation that its vertices have made, as well as
  /// they agree; what a line or a point of vertices leaves open is chosen best. Returns what these rotations add to the
  /// gradient of the energy, since they turn where vertices move, (n, 3).
  [[nodiscard]] Positions turn_cells(const Positions& positions, Rotations& rotations) const;

 private:
  /// A point of the region that a constraint fixes: a hard member, or the average of a patch.
  struct Anchor {
    Vector3 rest;
    int vertex;  ///< < 0 for a patch
    int patch;

    [[nodiscard]] Vector3 target(const RegionTargets& targets) const {
      return vertex >= 0 ? targets.vertices.row(vertex).transpose() : targets.patches.row(patch).transpose();
    }
  };

  /// A soft row with members of the region: with them it is share translation + R arm + a constant.
  struct Pull {
    int row;  ///< in the targets
    double weight;
    double share;         ///< sum of the members' coefficients
    Vector3 moment;       ///< sum of their coefficients times rest positions
    LinearRow elsewhere;  ///< the row without the members

    [[nodiscard]] Vector3 arm(const Vector3& center) const { return moment - share * center; }
  };

  /// A vertex outside that cells of the region have.
  struct VertexOutside {
    int vertex;
    Vector3 q;  ///< sum of its rest vectors in these
  };

  /// A cell outside that has members of the region.
  struct CellOutside {
    int cell;
    Vector3 q = Vector3::Zero();       ///< sum of the members' rest vectors
    Matrix3 moment = Matrix3::Zero();  ///< sum of q_cj p_j^T over the members j
  };

  struct Region {
    std::vector<int> members;  ///< vertices, the first is the unknown
    std::vector<int> border;   ///< members with neighbours outside
    std::vector<int> cells;    ///< whose home is a member
    std::vector<VertexOutside> vertices_outside;
    std::vector<CellOutside> cells_outside;
    std::vector<Anchor> anchors;  ///< hard members
    std::vector<Pull> pulls;
    int anchor_rank = 0;  ///< 0 a point, 1 a line, 2 at least a plane
    Vector3 anchor_axis = Vector3::Zero();
    Vector3 center = Vector3::Zero();
    Vector3 mixed = Vector3::Zero();  ///< the mixed term is <t, R mixed>; 0 for free regions
  };

  [[nodiscard]] bool is_member(int v, const Region& region) const {
    return unknown_of_vertex_[v] == region.members.front();
  }
  [[nodiscard]] bool has_cell(int c, const Region& region) const {
    const int home = cells_->home(c);
    return home >= 0 && is_member(home, region);
  }
  void find_cells();
  void find_border(Region& region) const;
  void find_outside(Region& region) const;
  void choose_center(Region& region, const Eigen::VectorXd& soft_diagonal) const;
  void find_pulls(Region& region, const LinearRows& rows) const;
  static void find_anchor_rank(Region& region);
  static void place(const Region& region, const Matrix3& linear, const RegionTargets& targets, Placement& placement);
  void write(const Region& region, const Placement& placement, Positions& positions) const;
  [[nodiscard]] Matrix3 linear_term(const Region& region, const Placement& placement, const Positions& positions,
                                    const CellPasses& passes) const;
  [[nodiscard]] Eigen::RowVector3d place_of(int v, const Region& region, const Placement& placement) const {
    return (placement.rotation * (rest(v) - region.center) + placement.translation).transpose();
  }
  [[nodiscard]] Vector3 rest(int v) const { return rest_->row(v).transpose(); }

  const CellEnergy* energy_;
  const Cells* cells_ = nullptr;
  const Positions* rest_;
  std::vector<int> unknown_of_vertex_;
  std::vector<char> is_member_;  ///< (n,) of any region
  std::vector<Region> regions_;
  std::vector<int> cells_with_members_;
};

}  // namespace arap
