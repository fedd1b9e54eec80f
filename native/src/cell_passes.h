// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "aligned_buffer.h"
#include "cell_energy.h"
#include "cell_stream.h"
#include "kernels.h"

namespace arap {

/// Rotation of each cell, filled up to whole slices.
using Rotations = std::vector<Eigen::Quaterniond>;

[[nodiscard]] Rotations identity_rotations(int n_cells);

/// The two passes of an iteration over a cell energy, on the machine's fastest kernels. Holds room for one set of
/// positions: serves one thread at a time.
class CellPasses {
 public:
  CellPasses(const CellEnergy& energy, int threads);

  /// Takes over the positions, (n, 3), for the passes.
  void set_positions(const Positions& positions);

  /// Local step: each R_c becomes the rotation that maximizes <R_c, Q_c(p')>.
  void fit_rotations(Rotations& rotations) const;

  /// residual = b - K p' with b_j = sum_c R_c q_cj, (n, 3), [SA07] Eq. (8); returns 1/2 <p', K p'> - <p', b>, which is
  /// the energy without E_0.
  double find_residual(const Rotations& rotations, Positions& residual) const;

 private:
  int n_vertices_;
  int threads_;
  const CellKernels* kernels_;
  CellStream stream_;
  AlignedBuffer<double> positions_;  ///< (n, 4)
};

}  // namespace arap
