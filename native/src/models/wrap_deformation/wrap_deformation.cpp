// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/wrap_deformation.h"

#include "arap/error.h"
#include "base/option_bounds.h"
#include "models/carried_points.h"
#include "models/input_checks.h"
#include "parallel/meter.h"
#include "parallel/parallel.h"
#include "wrap/surface_at_rest.h"
#include "wrap/wrap_points.h"

namespace arap {

namespace {

constexpr const char* kSurface = "surface_positions";

/// Of positions of the surface, row by row, those that the points hang on.
template <class Number>
Positions used_of(const WrapPoints& points, const Number* surface) {
  const std::vector<int>& used = points.used();
  Positions moved(used.size(), 3);
  parallel_for<4096>(points.workers(), static_cast<int>(used.size()), [&](int begin, int end) {
    for (int k = begin; k < end; ++k)
      moved.row(k) =
          Eigen::Matrix<Number, 1, 3>::Map(surface + 3 * static_cast<size_t>(used[k])).template cast<double>();
  });
  require_finite(kSurface, moved, [&](int k) { return text("vertex ", used[k]); });
  return moved;
}

void put_singles(const WrapPoints& points, const Positions& moved, std::span<float> out) {
  SinglePoints result(kSurface, out, points.size());
  points.deform(moved, [&](int p, const Vector3& place) { result.put(p, place); });
  result.require_finite();
}

void require_input(const Positions& points, const WrapOptions& options, const std::vector<int>& piece_of_point) {
  options.validate();
  require_points(points, "surface");
  if (!piece_of_point.empty())
    require_rows("piece_of_point", static_cast<Eigen::Index>(piece_of_point.size()), points.rows());
  for (size_t k = 0; k < piece_of_point.size(); ++k)
    if (piece_of_point[k] < -1)
      throw InvalidInput(text("piece_of_point[", k, "] = ", piece_of_point[k], ", must be >= -1"));
}

}  // namespace

void WrapOptions::validate() const {
  constexpr int kMostAnchors = 64;
  require_between("anchors", anchors, 1, kMostAnchors);
  require_threads(threads);
}

struct WrapSurface::Impl {
  Impl(const PolygonMesh& surface, int threads, const MeterPart& meter) : at_rest(surface, threads, meter) {}

  SurfaceAtRest at_rest;
};

WrapSurface::WrapSurface(const PolygonMesh& surface, int threads, const Progress& progress) {
  require_threads(threads);
  Meter meter(progress, "preparing the surface was cancelled");
  impl_ = std::make_unique<Impl>(surface, threads, MeterPart{&meter, 1});
  meter.reach(1);
}

WrapSurface::~WrapSurface() = default;
WrapSurface::WrapSurface(WrapSurface&&) noexcept = default;
WrapSurface& WrapSurface::operator=(WrapSurface&&) noexcept = default;

int WrapSurface::n_vertices() const { return impl_->at_rest.n_vertices(); }

struct WrapDeformation::Impl {
  WrapPoints points;
};

WrapDeformation::WrapDeformation(const WrapSurface& surface, const Positions& points, const WrapOptions& options,
                                 const std::vector<int>& piece_of_point, const Progress& progress) {
  require_input(points, options, piece_of_point);
  Meter meter(progress, "binding the points to the surface was cancelled");
  impl_ = std::make_unique<Impl>(Impl{WrapPoints(surface.impl_->at_rest, points, options.anchors, options.stay_outside,
                                                 piece_of_point, options.threads, {&meter, 1})});
  meter.reach(1);
}

WrapDeformation::WrapDeformation(const PolygonMesh& surface, const Positions& points, const WrapOptions& options,
                                 const std::vector<int>& piece_of_point, const Progress& progress) {
  require_input(points, options, piece_of_point);  // before the long work
  constexpr double kPreparing = .5;                // of the whole
  const WrapSurface prepared(surface, options.threads, part_of(progress, 0, kPreparing));
  *this = WrapDeformation(prepared, points, options, piece_of_point, part_of(progress, kPreparing, 1));
}

WrapDeformation::~WrapDeformation() = default;
WrapDeformation::WrapDeformation(WrapDeformation&&) noexcept = default;
WrapDeformation& WrapDeformation::operator=(WrapDeformation&&) noexcept = default;

Positions WrapDeformation::deform(const Positions& surface_positions) const {
  require_rows(kSurface, surface_positions.rows(), n_vertices());
  Positions result(n_points(), 3);
  impl_->points.deform(used_of(impl_->points, surface_positions.data()),
                       [&](int p, const Vector3& place) { result.row(p) = place.transpose(); });
  return result;
}

void WrapDeformation::deform(const Positions& surface_positions, std::span<float> out) const {
  require_rows(kSurface, surface_positions.rows(), n_vertices());
  put_singles(impl_->points, used_of(impl_->points, surface_positions.data()), out);
}

void WrapDeformation::deform(std::span<const float> surface_positions, std::span<float> out) const {
  require_three_numbers(kSurface, surface_positions.size(), "vertex", n_vertices());
  put_singles(impl_->points, used_of(impl_->points, surface_positions.data()), out);
}

int WrapDeformation::n_points() const { return impl_->points.size(); }
int WrapDeformation::n_vertices() const { return impl_->points.n_surface_vertices(); }
int WrapDeformation::n_pieces() const { return impl_->points.n_pieces(); }
int WrapDeformation::threads() const { return impl_->points.workers().threads(); }

}  // namespace arap
