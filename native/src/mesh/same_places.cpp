// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "arap/mesh.h"

#include "geometry/duplicate_points.h"
#include "mesh/surface_measures.h"

namespace arap {

namespace {

/// As part of the diagonal: below all that is modelled, above what a change of units and axes rounds.
constexpr double kOfDiagonal = 1e-6;

/// As part of the largest coordinate: two steps of single precision each way. Nothing finer was ever there.
constexpr double kOfCoordinates = 4.8e-7;

}  // namespace

std::vector<int> PolygonMesh::same_places(int threads) const {
  const Eigen::AlignedBox3d box = surface_box(*this);
  const double largest = std::max(box.min().cwiseAbs().maxCoeff(), box.max().cwiseAbs().maxCoeff());
  const double distance = std::max(kOfDiagonal * box.diagonal().norm(), kOfCoordinates * largest);
  return coincident_with(positions_, distance, threads);
}

}  // namespace arap
