// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <functional>
#include <utility>
#include <vector>

#include "arap/types.h"
#include "cages/cage.h"
#include "lattice/line_crossings.h"
#include "parallel/meter.h"
#include "parallel/workers.h"

namespace arap {

/// Values of hats at a place of the cage: vertices and weights of sum 1.
using HatValues = std::vector<std::pair<int, double>>;

/// Laplace's equation inside of a cage, on the nodes of a regular grid: the sum of (u_j - u_i) / distance over the six
/// neighbours j of a node. Where the cage is nearer than the next node it takes the place of that, with the hats there
/// for values [Gibou, Fedkiw, Cheng, Kang 2002, "A second-order-accurate symmetric discretization of the Poisson
/// equation on irregular domains"]. The matrix is symmetric, without positive entries beside the diagonal, and linear
/// functions solve the equations exactly.
class HarmonicGrid {
 public:
  HarmonicGrid(const Cage& cage, double spacing);

  [[nodiscard]] int n_nodes() const { return static_cast<int>(places_.size()); }

  /// Solves for all vertices, three at a time, and calls take(first vertex, values), values of (n_nodes, 3).
  template <class Take>
  void solve(const Workers& workers, const MeterPart& meter, const Take& take) const {
    const int n_vertices = static_cast<int>(sources_.size());
    solve_columns(workers, meter, n_vertices, [&](int first, const Positions& values) { take(first, values); });
  }

  /// Where the cage is met, and its hats there.
  struct OnCage {
    Eigen::RowVector3d place;
    HatValues hats;
  };

  /// The cell that a point is in.
  struct Cell {
    std::array<int, 8> nodes{};                   ///< of the corners, along z first; -1: outside
    std::array<Eigen::RowVector3d, 8> corners{};  ///< their places
    std::array<double, 3> place{};                ///< of the point in the cell, 0 to 1
    std::vector<OnCage> cage;                     ///< on its edges
    [[nodiscard]] bool is_whole() const;          ///< all nodes are inside and the cage meets no edge
  };
  [[nodiscard]] Cell cell_at(const Eigen::RowVector3d& point) const;

 private:
  struct Link {
    double conductance = 0;  ///< one over the distance, in spacings; 0: no neighbour
    int node = -1;
    const Crossing* crossing = nullptr;
  };
  struct Source {
    int node;
    double value;
  };
  using Sample = std::array<int, 3>;
  using TakeColumns = std::function<void(int first, const Positions& values)>;

  void find_nodes();
  void find_sources();
  void solve_columns(const Workers& workers, const MeterPart& meter, int n_vertices, const TakeColumns& take) const;
  [[nodiscard]] int index(const Sample& sample) const {
    return (sample[0] * box_.counts[1] + sample[1]) * box_.counts[2] + sample[2];
  }
  [[nodiscard]] Link link(int node, int axis, bool is_up) const;
  /// The first or the last crossing between a sample and the next one along an axis; null: none.
  [[nodiscard]] const Crossing* crossing_after(const Sample& sample, int axis, bool is_last) const;
  [[nodiscard]] HatValues hats(const Crossing& crossing, int axis) const;
  [[nodiscard]] Eigen::RowVector3d place(const Crossing& crossing, int axis) const;

  const Cage& cage_;
  SampleBox box_;
  std::vector<int> triangles_;  ///< of one cut of each face
  std::array<std::vector<Crossing>, 3> crossings_;
  std::array<std::vector<std::array<int, 2>>, 3> crossing_after_;  ///< of each sample: the first and the last, or -1
  std::vector<int> node_of_sample_;                                ///< -1: outside
  std::vector<Sample> places_;                                     ///< of the nodes
  std::vector<std::vector<Source>> sources_;                       ///< of each vertex
};

}  // namespace arap
