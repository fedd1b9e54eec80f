// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <utility>
#include <vector>

#include "arap/constraints.h"
#include "arap/mesh.h"
#include "constraints/smallest_change.h"

namespace arap {

/// Hard vertices are exactly at their targets, and rigid regions exactly rigid: what the lattice leaves is spread
/// around them, along edges. What it leaves of patches their vertices take. A part that nothing constrains goes with
/// its region, if that is of other parts, too.
class ExactVertices {
 public:
  ExactVertices() = default;
  /// @param pieces         (n,) of each vertex, < 0 = none: a patch is what it has of pieces
  /// @param rigid_regions  (n,) of each vertex, < 0 = none; or empty
  /// @param at_rest        (n_parts,) whether nothing constrains a part
  /// @param reach          along edges; from there on nothing moves
  ExactVertices(const PolygonMesh& mesh, const ConstraintSet& set, const std::vector<int>& pieces,
                const std::vector<int>& rigid_regions, const std::vector<char>& at_rest, double reach);

  /// @param targets  of the set
  /// @param points   (n, 3) where the lattice brings the vertices
  void apply(const Positions& targets, const Workers& workers, Positions& points) const;

  /// Parts that nothing constrains and that go with no region, ascending.
  [[nodiscard]] const std::vector<int>& parts_at_rest() const { return parts_at_rest_; }

 private:
  struct Hard {
    int vertex;
    std::vector<int> targets;  ///< rows; it takes their mean
  };
  /// Moves as its hard members say. What they leave open, as one or two do, is as the lattice turns all of them.
  struct Region {
    Positions rest;
    std::vector<int> members;
    std::vector<std::pair<int, int>> hard;  ///< member, and index of its place
    std::vector<int> moved;                 ///< members of parts that something constrains; all, if there are none
    // Vertices of the parts that go with it, and where they rest.
    std::vector<int> carried;
    Positions rest_of_carried;
  };
  struct Follower {
    int vertex;
    int place;  ///< of the nearest one
    double share;
  };

  void find_places(const PolygonMesh& mesh, const ConstraintSet& set, const std::vector<int>& rigid_regions,
                   const std::vector<char>& at_rest);
  /// What moves the region, and what goes with it.
  static void find_parts(const PolygonMesh& mesh, const std::vector<char>& at_rest, Region& region);
  void find_followers(const PolygonMesh& mesh, double reach);
  void find_patches(const ConstraintSet& set, const std::vector<int>& pieces);

  std::vector<Hard> hard_;
  std::vector<Region> regions_;
  std::vector<int> vertices_;  ///< that are brought to a place: first the hard ones, then the members of regions
  std::vector<Follower> followers_;
  LinearRows patches_;
  std::vector<int> patch_targets_;
  SmallestChange of_patches_;
  std::vector<int> parts_at_rest_;
};

}  // namespace arap
