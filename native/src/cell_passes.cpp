// SPDX-License-Identifier: GPL-3.0-or-later
#include "cell_passes.h"

#include <algorithm>

#include "parallel.h"

namespace arap {

namespace {

/// Slices that a thread takes at once.
constexpr int kSliceRange = 32;

int whole_slices(int n) { return (n + kSliceWidth - 1) / kSliceWidth * kSliceWidth; }

}  // namespace

Rotations identity_rotations(int n_cells) {
  return Rotations(static_cast<size_t>(whole_slices(n_cells)), Eigen::Quaterniond::Identity());
}

CellPasses::CellPasses(const CellEnergy& energy, int threads)
    : n_vertices_(energy.n_vertices()),
      threads_(threads),
      kernels_(&kernels(choose_isa()).cell),
      stream_(energy),
      positions_(4 * static_cast<size_t>(whole_slices(energy.n_vertices()))) {
  std::fill_n(positions_.data(), positions_.size(), 0.0);
}

void CellPasses::set_positions(const Positions& positions) {
  parallel_for<kSliceRange * kSliceWidth>(threads_, n_vertices_, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) std::copy_n(positions.data() + 3L * v, 3, positions_.data() + 4L * v);
  });
}

void CellPasses::fit_rotations(Rotations& rotations) const {
  double* quaternions = rotations.front().coeffs().data();
  parallel_for<kSliceRange>(threads_, stream_.cells.n_slices(), [&](int begin, int end) {
    kernels_->fit_rotations(stream_.cells.view(), positions_.data(), quaternions, begin, end);
  });
}

double CellPasses::find_residual(const Rotations& rotations, Positions& residual) const {
  residual.resize(n_vertices_, 3);
  const double* quaternions = rotations.front().coeffs().data();
  return parallel_sum<kSliceRange>(threads_, stream_.incidences.n_slices(), [&](int begin, int end) {
    return kernels_->residual(stream_.incidences.view(), stream_.system.view(), positions_.data(), quaternions,
                              residual.data(), n_vertices_, begin, end);
  });
}

}  // namespace arap
