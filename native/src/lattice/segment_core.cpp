// SPDX-License-Identifier: GPL-3.0-or-later
#include "lattice/segment_core.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace arap {

namespace {

using Row = Eigen::RowVector3d;

/// Places on a segment, half as far from each other as samples are.
class Places {
 public:
  Places(const Lattice& lattice, const Segment& segment)
      : head_(segment.head.transpose()),
        along_((segment.tail - segment.head).transpose()),
        // A segment far longer than the mesh has no more of it inside than one of its size.
        n_(static_cast<int>(std::min(1e6, std::ceil(2 * kSamplesAlong * along_.norm() / lattice.cube_size())))) {}

  [[nodiscard]] int size() const { return n_ + 1; }
  [[nodiscard]] double share(int k) const { return static_cast<double>(k) / n_; }
  [[nodiscard]] Row operator[](int k) const { return head_ + share(k) * along_; }
  [[nodiscard]] double length() const { return along_.norm(); }

 private:
  Row head_;
  Row along_;
  int n_;
};

/// The piece that has each place inside, of one part; -1: none has.
std::vector<int> pieces_along(const Lattice& lattice, const Places& places, int part) {
  const CubeGrid& grid = lattice.pieces().grid_of(part);
  const Row head = places[0];
  const Row tail = places[places.size() - 1];
  const Row far_corner = grid.corner(grid.counts);
  if ((head.cwiseMax(tail).array() < grid.origin.array()).any() ||
      (head.cwiseMin(tail).array() > far_corner.array()).any())
    return {};
  std::vector<int> pieces(places.size());
  for (int k = 0; k < places.size(); ++k) pieces[k] = lattice.pieces().around(places[k], part);
  return pieces;
}

/// How far a place is from the surface of a part, as seen along 26 directions; 0: it is outside.
double depth(const Lattice& lattice, const Row& place, int part) {
  const double step = lattice.cube_size() / kSamplesAlong;
  double least = std::numeric_limits<double>::infinity();
  for (int direction = 0; direction < 27; ++direction) {
    const Row along = Eigen::RowVector3i(direction / 9 - 1, direction / 3 % 3 - 1, direction % 3 - 1).cast<double>();
    if (direction == 13) continue;  // none
    double reached = 0;
    while (reached < least && lattice.pieces().around(place + reached * along.normalized(), part) >= 0) reached += step;
    least = std::min(least, reached);
  }
  return least;
}

/// Adds the core of one part.
void add_core(const Lattice& lattice, const Places& places, int part, std::vector<int>& core) {
  constexpr double kFree = 1.2;
  constexpr double kMostFree = 0.4;
  const std::vector<int> pieces = pieces_along(lattice, places, part);
  if (std::ranges::all_of(pieces, [](int piece) { return piece < 0; })) return;
  const auto free_share = [&](int k) {
    return std::min(kMostFree, kFree * depth(lattice, places[k], part) / places.length());
  };
  const double begin = free_share(0);
  const double end = 1 - free_share(places.size() - 1);
  const auto add = [&](double low, double high) {
    for (int k = 0; k < places.size(); ++k)
      if (pieces[k] >= 0 && places.share(k) >= low && places.share(k) <= high) core.push_back(pieces[k]);
  };
  const size_t n_before = core.size();
  add(begin, end);
  if (core.size() == n_before) add(0, 1);  // inside at its ends alone
}

}  // namespace

std::vector<int> segment_core(const Lattice& lattice, const Segment& segment) {
  const Places places(lattice, segment);
  std::vector<int> core;
  for (int part = 0; part < lattice.pieces().n_parts(); ++part) add_core(lattice, places, part, core);
  std::sort(core.begin(), core.end());
  core.erase(std::unique(core.begin(), core.end()), core.end());
  return core;
}

}  // namespace arap
