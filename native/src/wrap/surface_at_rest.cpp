// SPDX-License-Identifier: GPL-3.0-or-later
#include "wrap/surface_at_rest.h"

#include "base/available_memory.h"
#include "mesh/surface_measures.h"
#include "parallel/parallel.h"

namespace arap {

namespace {

/// The box of a surface that there is memory for.
Eigen::AlignedBox3d checked_box(const PolygonMesh& surface) {
  constexpr double kBytesPerVertex = 1000;
  require_memory(kBytesPerVertex * surface.n_vertices(), "this surface");
  return surface_box(surface);
}

double size_of(const Eigen::AlignedBox3d& box) {
  const double diagonal = box.diagonal().norm();
  return diagonal > 0 ? diagonal : 1;
}

}  // namespace

SurfaceAtRest::SurfaceAtRest(const PolygonMesh& surface, int requested_threads, const MeterPart& meter)
    : SurfaceAtRest(surface, checked_box(surface), choose_threads(requested_threads, surface.n_vertices()), meter) {}

SurfaceAtRest::SurfaceAtRest(const PolygonMesh& surface, const Eigen::AlignedBox3d& box, int threads,
                             const MeterPart& meter)
    : center_(box.center().transpose()),
      size_(size_of(box)),
      places_(in_frame(surface.positions())),
      levels_(surface, places_, threads, meter.part(.75)),
      tree_(levels_.level(0).places),
      triangles_(surface, levels_, places_) {
  meter.add(.25);
}

}  // namespace arap
