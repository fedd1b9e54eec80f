// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/mirror_symmetry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "base/eigen_compat.h"
#include "geometry/point_grid.h"
#include "parallel/parallel.h"

namespace arap {

namespace {

/// Of the grid: what is asked for is small beside it, so that it is nearly always in one cell.
constexpr double kCell = 8 * kMirrorTolerance;
/// Vertices nearer to each other are told apart by their neighbours.
constexpr double kSamePlace = 1e-6;
/// For an image: one of several vertices, which is not known yet.
constexpr int kUnknown = -2;
/// More vertices than this at one place are not told apart.
constexpr size_t kMostAtOnePlace = 256;

/// Sums that vanish for points mirrored along `axis`; cheap, and hardly any other mesh gets through.
bool may_be_mirrored(const Positions& rest, int axis) {
  const auto x = rest.col(axis).array();
  const auto y = rest.col((axis + 1) % 3).array();
  const auto z = rest.col((axis + 2) % 3).array();
  const std::array<double, 4> means{x.mean(), (x * y).mean(), (x * z).mean(), x.cube().mean()};
  for (const double mean : means)
    if (std::abs(mean) > kMirrorTolerance) return false;
  return true;
}

/// The vertices in faces, numbered anew.
struct Surface {
  explicit Surface(const PolygonMesh& polygons) : mesh(polygons) {
    for (int v = 0; v < mesh.n_vertices(); ++v)
      if (mesh.part_of_vertex()[v] >= 0) vertices.push_back(v);
    rest = Positions(mesh.positions()(vertices, all));
  }

  const PolygonMesh& mesh;
  std::vector<int> vertices;
  Positions rest;
};

/// The neighbours of each vertex of a surface along edges.
class Neighbors {
 public:
  explicit Neighbors(const Surface& surface) : offsets_(surface.vertices.size() + 1, 0) {
    std::vector<int> number(surface.mesh.n_vertices(), -1);
    for (size_t k = 0; k < surface.vertices.size(); ++k) number[surface.vertices[k]] = static_cast<int>(k);
    const auto for_each = [&](const auto& visit) {
      for (int f = 0; f < surface.mesh.n_faces(); ++f) {
        int from = number[surface.mesh.face(f).back()];
        for (const int vertex : surface.mesh.face(f)) {
          visit(from, number[vertex]);
          visit(number[vertex], from);
          from = number[vertex];
        }
      }
    };
    for_each([&](int v, int) { ++offsets_[v + 1]; });
    std::partial_sum(offsets_.begin(), offsets_.end(), offsets_.begin());
    neighbors_.resize(offsets_.back());
    std::vector<int> next(offsets_.begin(), offsets_.end() - 1);
    for_each([&](int v, int neighbor) { neighbors_[next[v]++] = neighbor; });
  }

  [[nodiscard]] std::span<const int> of(int v) const {
    return std::span<const int>(neighbors_).subspan(offsets_[v], offsets_[v + 1] - offsets_[v]);
  }

 private:
  std::vector<int> offsets_;
  std::vector<int> neighbors_;  ///< one for each face at an edge
};

/// Finds the vertices at the place of a vertex' image, as near as the nearest of them.
class CandidateSearch {
 public:
  CandidateSearch(const Positions& rest, const PointGrid& grid, int axis) : rest_(rest), grid_(grid), axis_(axis) {}

  /// In order; valid until the next call.
  const std::vector<int>& find(int vertex) {
    Eigen::RowVector3d place = rest_.row(vertex);
    place[axis_] = -place[axis_];
    near_.clear();
    double nearest = std::numeric_limits<double>::infinity();
    grid_.for_each_near(place, kMirrorTolerance, [&](int v, double squared) {
      near_.emplace_back(v, squared);
      nearest = std::min(nearest, squared);
    });
    const double reach = std::sqrt(nearest) + kSamePlace;
    found_.clear();
    for (const auto& [v, squared] : near_)
      if (squared <= reach * reach) found_.push_back(v);
    std::sort(found_.begin(), found_.end());
    return found_;
  }

 private:
  const Positions& rest_;
  const PointGrid& grid_;
  int axis_;
  std::vector<std::pair<int, double>> near_;
  std::vector<int> found_;
};

/// Pairs vertices whose images are not known with each other, so that neighbours' images are neighbours.
class Pairing {
 public:
  Pairing(const Surface& surface, const PointGrid& grid, int axis, std::vector<int>& images)
      : surface_(surface),
        neighbors_(surface),
        search_(surface.rest, grid, axis),
        images_(images),
        is_waiting_(images.size(), 0) {}

  /// Whether all have been paired.
  bool pair_all() {
    const auto n = static_cast<int>(images_.size());
    for (int v = 0; v < n; ++v) wait(v);
    spread();
    // Where all neighbours are in the same doubt, as on two sheets at one place, one choice settles it for them.
    for (int v = 0; v < n; ++v) {
      if (images_[v] != kUnknown) continue;
      const int best = most_likely(v);
      if (best < 0) return false;
      pair(v, best);
      spread();
    }
    return true;
  }

 private:
  [[nodiscard]] int part_of(int v) const { return surface_.mesh.part_of_vertex()[surface_.vertices[v]]; }

  [[nodiscard]] std::vector<int> free_candidates(int v) {
    std::vector<int> found = search_.find(v);
    std::erase_if(found, [&](int w) { return images_[w] != kUnknown; });
    return found;
  }

  /// Of a vertex' neighbours, how many have an image beside `image`.
  [[nodiscard]] int count_images_beside(int vertex, int image) const {
    const std::span<const int> beside = neighbors_.of(image);
    int count = 0;
    for (const int neighbor : neighbors_.of(vertex))
      if (images_[neighbor] >= 0 && std::find(beside.begin(), beside.end(), images_[neighbor]) != beside.end()) ++count;
    return count;
  }

  /// Of a vertex' neighbours, how many could have an image beside `image`.
  [[nodiscard]] int count_possible_beside(int vertex, int image) {
    const std::span<const int> beside = neighbors_.of(image);
    int count = 0;
    for (const int neighbor : neighbors_.of(vertex)) {
      const std::vector<int>& candidates = search_.find(neighbor);
      if (std::any_of(beside.begin(), beside.end(),
                      [&](int w) { return std::binary_search(candidates.begin(), candidates.end(), w); }))
        ++count;
    }
    return count;
  }

  /// The candidate that most neighbours can follow; of several, one of the same part. -1 where all are taken.
  [[nodiscard]] int most_likely(int v) {
    int best = -1;
    int most = -1;
    for (const int w : free_candidates(v)) {
      const int count = 2 * count_possible_beside(v, w) + (part_of(w) == part_of(v) ? 1 : 0);
      if (count > most) best = w;
      most = std::max(most, count);
    }
    return best;
  }

  void wait(int v) {
    if (images_[v] != kUnknown || is_waiting_[v] != 0) return;
    is_waiting_[v] = 1;
    waiting_.push_back(v);
  }

  void spread() {
    while (!waiting_.empty()) {
      const int v = waiting_.back();
      waiting_.pop_back();
      is_waiting_[v] = 0;
      if (images_[v] != kUnknown) continue;
      int best = -1;
      int most = 0;
      for (const int w : free_candidates(v)) {
        const int count = count_images_beside(v, w);
        if (count >= most) best = count == most ? -1 : w;
        most = std::max(most, count);
      }
      if (best >= 0) pair(v, best);
    }
  }

  void pair(int v, int w) {
    images_[v] = w;
    images_[w] = v;
    for (const int end : {v, w})
      for (const int neighbor : neighbors_.of(end)) wait(neighbor);
  }

  const Surface& surface_;
  Neighbors neighbors_;
  CandidateSearch search_;
  std::vector<int>& images_;
  std::vector<int> waiting_;
  std::vector<char> is_waiting_;
};

/// Empty where there is no map.
std::vector<int> find_images(const Surface& surface, const PointGrid& grid, int axis, int threads) {
  const auto n = static_cast<int>(surface.rest.rows());
  std::vector<int> images(n);
  const bool all_found = parallel_all(threads, n, [&](int begin, int end) {
    CandidateSearch search(surface.rest, grid, axis);
    for (int v = begin; v < end; ++v) {
      const std::vector<int>& candidates = search.find(v);
      if (candidates.empty() || candidates.size() > kMostAtOnePlace) return false;
      images[v] = candidates.size() == 1 ? candidates.front() : kUnknown;
    }
    return true;
  });
  if (!all_found) return {};
  // One that is the only candidate of another is that one's image, too.
  for (int v = 0; v < n; ++v)
    if (images[v] >= 0 && images[images[v]] == kUnknown) images[images[v]] = v;
  if (std::find(images.begin(), images.end(), kUnknown) != images.end() &&
      !Pairing(surface, grid, axis, images).pair_all())
    return {};
  for (int v = 0; v < n; ++v)
    if (images[images[v]] != v) return {};
  return images;
}

bool commute(const std::vector<int>& a, const std::vector<int>& b) {
  for (size_t v = 0; v < a.size(); ++v)
    if (a[b[v]] != b[a[v]]) return false;
  return true;
}

/// The map of all vertices from that of those in faces.
std::vector<int> with_loose(const Surface& surface, const std::vector<int>& images, int n_vertices) {
  std::vector<int> result(n_vertices);
  std::iota(result.begin(), result.end(), 0);
  for (size_t k = 0; k < images.size(); ++k) result[surface.vertices[k]] = surface.vertices[images[k]];
  return result;
}

}  // namespace

std::vector<std::vector<int>> find_mirrors(const PolygonMesh& mesh, int threads) {
  std::vector<std::vector<int>> mirrors;
  if (mesh.n_faces() == 0) return mirrors;
  const Surface surface(mesh);
  std::optional<PointGrid> grid;
  for (int axis = 0; axis < 3; ++axis) {
    if (!may_be_mirrored(surface.rest, axis)) continue;
    if (!grid) grid.emplace(surface.rest, kCell, threads);
    const std::vector<int> images = find_images(surface, *grid, axis, threads);
    if (images.empty()) continue;
    std::vector<int> mirror = with_loose(surface, images, mesh.n_vertices());
    if (std::all_of(mirrors.begin(), mirrors.end(), [&](const auto& other) { return commute(mirror, other); }))
      mirrors.push_back(std::move(mirror));
  }
  return mirrors;
}

}  // namespace arap
