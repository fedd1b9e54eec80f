// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/cage.h"
#include "base/option_bounds.h"
#include "cages/cage_points.h"
#include "cages/cage_weights.h"
#include "cages/harmonic.h"
#include "models/cage_deformation/cage_fit.h"
#include "models/carried_points.h"
#include "models/input_checks.h"
#include "parallel/meter.h"

namespace arap {

void CageOptions::validate() const {
  constexpr double kFinest = .005;
  constexpr double kCoarsest = .1;
  require_between("grid_spacing", grid_spacing, kFinest, kCoarsest);
  require_threads(threads);
}

struct CageDeformation::Impl {
  Impl(const PolygonMesh& mesh, const Positions& given, const CageOptions& options, Meter& meter)
      : points(mesh, given, options, {&meter, 1}), fit(points) {}

  CagePoints points;
  CageFit fit;
};

CageDeformation::CageDeformation(const PolygonMesh& cage, const Positions& points, const CageOptions& options,
                                 const Progress& progress) {
  options.validate();
  require_points(points, "cage");
  Meter meter(progress, "computing the weights of the cage was cancelled");
  impl_ = std::make_unique<Impl>(cage, points, options, meter);
  meter.reach(1);
}

CageDeformation::~CageDeformation() = default;
CageDeformation::CageDeformation(CageDeformation&&) noexcept = default;
CageDeformation& CageDeformation::operator=(CageDeformation&&) noexcept = default;

Positions CageDeformation::deform(const Positions& cage_positions) const {
  require_moved("cage_positions", cage_positions, n_vertices());
  Positions result(n_points(), 3);
  impl_->points.deform(cage_positions, [&](int p, const Vector3& place) { result.row(p) = place.transpose(); });
  return result;
}

void CageDeformation::deform(const Positions& cage_positions, std::span<float> out) const {
  require_moved("cage_positions", cage_positions, n_vertices());
  SinglePoints result("cage_positions", out, n_points());
  impl_->points.deform(cage_positions, [&](int p, const Vector3& place) { result.put(p, place); });
  result.require_finite();
}

Positions CageDeformation::fit(const Positions& positions, double smoothness, const Progress& progress) const {
  require_rows("positions", positions.rows(), n_points());
  require_finite("positions", positions, [](int k) { return text("row ", k); });
  constexpr double kLeast = 1e-12;
  require_between("smoothness", smoothness, kLeast, 1);
  if (impl_->points.coordinates() == CageCoordinates::kGreen)
    throw InvalidInput(
        "Green coordinates are not linear in the cage, so no cage can be fitted by them; take mean value or harmonic "
        "coordinates");
  Meter meter(progress, "fitting the cage was cancelled");
  Positions result = impl_->fit.fit(positions, smoothness, {&meter, 1});
  meter.reach(1);
  return result;
}

CageWeights CageDeformation::weights(int point) const {
  if (point < 0 || point >= n_points())
    throw InvalidInput(text("point ", point, " is not there, there are points 0 to ", n_points() - 1));
  const CagePoints& points = impl_->points;
  if (points.coordinates() != CageCoordinates::kHarmonic)
    return weights_of(points.cage(), points.coordinates(), points.rest().row(point));
  CageWeights stored{points.weights().of_point(point), {}};
  repair_weights(points.cage(), points.rest().row(point), stored.vertices);
  return stored;
}

int CageDeformation::n_points() const { return impl_->points.size(); }
int CageDeformation::n_vertices() const { return impl_->points.cage().n_vertices(); }
int CageDeformation::n_triangles() const { return impl_->points.cage().n_triangles(); }
int CageDeformation::threads() const { return impl_->points.workers().threads(); }

}  // namespace arap
