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

/// Calls use(part, k, piece) for each place inside of a part, until it returns false.
template <class Use>
void for_inside(const Lattice& lattice, const Places& places, const Use& use) {
  const Row head = places[0];
  const Row tail = places[places.size() - 1];
  for (int part = 0; part < lattice.pieces().n_parts(); ++part) {
    const CubeGrid& grid = lattice.pieces().grid_of(part);
    const Row far_corner = grid.corner(grid.counts);
    if ((head.cwiseMax(tail).array() < grid.origin.array()).any() ||
        (head.cwiseMin(tail).array() > far_corner.array()).any())
      continue;
    for (int k = 0; k < places.size(); ++k)
      if (const int piece = lattice.pieces().around(places[k], part); piece >= 0 && !use(part, k, piece)) return;
  }
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

}  // namespace

bool is_inside_anywhere(const Lattice& lattice, const Segment& segment) {
  bool result = false;
  for_inside(lattice, Places(lattice, segment), [&](int, int, int) {
    result = true;
    return false;
  });
  return result;
}

std::vector<int> segment_core(const Lattice& lattice, const Segment& segment) {
  constexpr double kFree = 1.2;
  constexpr double kMostFree = 0.4;
  const Places places(lattice, segment);
  std::vector<int> core;
  std::vector<int> of_ends;  // of the part at hand
  int part_at_hand = -1;
  size_t n_before = 0;
  double begin = 0;
  double end = 1;
  const auto finish_part = [&] {
    if (core.size() == n_before) core.insert(core.end(), of_ends.begin(), of_ends.end());
    of_ends.clear();
    n_before = core.size();
  };
  const auto free_share = [&](int k, int part) {
    return std::min(kMostFree, kFree * depth(lattice, places[k], part) / places.length());
  };
  for_inside(lattice, places, [&](int part, int k, int piece) {
    if (part != part_at_hand) {
      finish_part();
      part_at_hand = part;
      begin = free_share(0, part);
      end = 1 - free_share(places.size() - 1, part);
    }
    std::vector<int>& pieces = places.share(k) >= begin && places.share(k) <= end ? core : of_ends;
    pieces.push_back(piece);
    return true;
  });
  finish_part();
  std::sort(core.begin(), core.end());
  core.erase(std::unique(core.begin(), core.end()), core.end());
  return core;
}

}  // namespace arap
