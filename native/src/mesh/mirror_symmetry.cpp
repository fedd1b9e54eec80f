// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/mirror_symmetry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include "base/eigen_compat.h"
#include "geometry/point_grid.h"
#include "mesh/surface_measures.h"
#include "parallel/parallel.h"

namespace arap {

namespace {

/// Cell size of the grid: a search looks at two or three cells, and cells are not much larger than what it looks for.
constexpr double kGridCell = 4 * kMirrorTolerance;
/// If more vertices than this are near one image, the mesh counts as not symmetric: comparing all would take quadratic
/// time, for example if one stray vertex far away makes the rest of the mesh tiny.
constexpr int kMostCandidates = 256;

/// Sums that vanish for points mirrored along `axis`. They are cheap, and few other meshes pass.
bool may_be_mirrored(const Positions& rest, int axis) {
  const auto x = rest.col(axis).array();
  const auto y = rest.col((axis + 1) % 3).array();
  const auto z = rest.col((axis + 2) % 3).array();
  const std::array<double, 4> means{x.mean(), (x * y).mean(), (x * z).mean(), x.cube().mean()};
  return std::all_of(means.begin(), means.end(), [](double mean) { return std::abs(mean) <= kMirrorTolerance; });
}

/// Vertices in faces, with their own numbering.
struct Surface {
  Positions rest;
  Positions centres;  ///< mean centre of the faces at each vertex: differs between the two sides of an open seam
};

Positions face_centres(const PolygonMesh& mesh) {
  Positions sums = Positions::Zero(mesh.n_vertices(), 3);
  Eigen::VectorXd n_faces = Eigen::VectorXd::Zero(mesh.n_vertices());
  for (int f = 0; f < mesh.n_faces(); ++f) {
    const std::span<const int> face = mesh.face(f);
    Eigen::RowVector3d centre = Eigen::RowVector3d::Zero();
    for (const int v : face) centre += mesh.positions().row(v) / static_cast<double>(face.size());
    for (const int v : face) {
      sums.row(v) += centre;
      ++n_faces[v];
    }
  }
  return sums.array().colwise() / n_faces.array().max(1);
}

/// The vertex at the mirror image of vertex v, -1 for none.
int find_image(const Surface& surface, const PointGrid& grid, int axis, int v) {
  Eigen::RowVector3d place = surface.rest.row(v);
  Eigen::RowVector3d centre = surface.centres.row(v);
  place[axis] = -place[axis];
  centre[axis] = -centre[axis];
  int nearest = -1;
  int n_candidates = 0;
  double least = std::numeric_limits<double>::infinity();
  static_cast<void>(grid.find_near(place, kMirrorTolerance, [&](int w, double squared) {
    const double distance = squared + (surface.centres.row(w) - centre).squaredNorm();
    if (distance < least) nearest = w;
    least = std::min(least, distance);
    return ++n_candidates > kMostCandidates;
  }));
  return n_candidates > kMostCandidates ? -1 : nearest;
}

/// The image of each vertex; empty if some vertex has none or two have the same.
std::vector<int> find_images(const Surface& surface, const PointGrid& grid, int axis, int threads,
                             const MeterPart& meter) {
  const auto n = static_cast<int>(surface.rest.rows());
  std::vector<int> images(n);
  const bool all_found = parallel_all(threads, n, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      images[v] = find_image(surface, grid, axis, v);
      if (images[v] < 0) return false;
    }
    meter.add(static_cast<double>(end - begin) / n);
    return true;
  });
  if (!all_found) return {};
  for (int v = 0; v < n; ++v)
    if (images[images[v]] != v) return {};
  return images;
}

bool commute(const std::vector<int>& a, const std::vector<int>& b) {
  for (size_t v = 0; v < a.size(); ++v)
    if (a[b[v]] != b[a[v]]) return false;
  return true;
}

}  // namespace

std::vector<std::vector<int>> find_mirrors(const PolygonMesh& mesh, int threads, const MeterPart& meter) {
  const std::vector<int> vertices = vertices_in_faces(mesh);
  Surface surface{.rest = mesh.positions()(vertices, all), .centres = {}};
  std::vector<int> axes{0, 1, 2};
  std::erase_if(axes, [&](int axis) { return vertices.empty() || !may_be_mirrored(surface.rest, axis); });
  meter.add(0.2);
  if (axes.empty()) return {};
  surface.centres = face_centres(mesh)(vertices, all);
  meter.add(0.2);
  const PointGrid grid(surface.rest, kGridCell, threads);
  meter.add(0.2);
  std::vector<std::vector<int>> mirrors;
  for (const int axis : axes) {
    const std::vector<int> images =
        find_images(surface, grid, axis, threads, meter.part(0.4 / static_cast<double>(axes.size())));
    if (images.empty()) continue;
    std::vector<int> mirror(mesh.n_vertices());
    std::iota(mirror.begin(), mirror.end(), 0);
    for (size_t k = 0; k < images.size(); ++k) mirror[vertices[k]] = vertices[images[k]];
    if (std::all_of(mirrors.begin(), mirrors.end(), [&](const auto& other) { return commute(mirror, other); }))
      mirrors.push_back(std::move(mirror));
  }
  return mirrors;
}

}  // namespace arap
