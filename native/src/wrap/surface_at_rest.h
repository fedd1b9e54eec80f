// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>

#include "arap/mesh.h"
#include "arap/types.h"
#include "geometry/point_tree.h"
#include "parallel/meter.h"
#include "wrap/surface_levels.h"
#include "wrap/surface_triangles.h"

namespace arap {

/// What binds of points need of a surface, whatever the points are. Works in a space in which the surface is centred
/// and of diagonal 1. Never changes, so several threads may bind to it.
class SurfaceAtRest {
 public:
  SurfaceAtRest(const PolygonMesh& surface, int requested_threads, const MeterPart& meter);
  SurfaceAtRest(const SurfaceAtRest&) = delete;  // its parts refer to each other
  SurfaceAtRest& operator=(const SurfaceAtRest&) = delete;

  [[nodiscard]] int n_vertices() const { return static_cast<int>(places_.rows()); }
  /// The diagonal of the surface as given; > 0.
  [[nodiscard]] double size() const { return size_; }
  /// (n, 3) as given, in the space of the surface.
  [[nodiscard]] Positions in_frame(const Positions& positions) const { return (positions.rowwise() - center_) / size_; }

  /// (n_vertices, 3)
  [[nodiscard]] const Positions& places() const { return places_; }
  [[nodiscard]] const SurfaceLevels& levels() const { return levels_; }
  /// Of the nodes of the first level.
  [[nodiscard]] const PointTree& tree() const { return tree_; }
  [[nodiscard]] const SurfaceTriangles& triangles() const { return triangles_; }

 private:
  SurfaceAtRest(const PolygonMesh& surface, const Eigen::AlignedBox3d& box, int threads, const MeterPart& meter);

  Eigen::RowVector3d center_;
  double size_;
  Positions places_;
  SurfaceLevels levels_;
  PointTree tree_;
  SurfaceTriangles triangles_;
};

}  // namespace arap
