// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <vector>

#include "energy/cell_energy.h"
#include "kernels/isa.h"
#include "parallel/workers.h"

namespace arap {

/// Rotation of each cell.
using Rotations = std::vector<Eigen::Quaterniond>;

/// How exact the passes of an iteration are.
enum class Precision {
  /// Positions are rounded to 1e-9 of the mesh, or of the largest coordinate where that is larger. Errors of about 1e-7
  /// of an edge in a residual, which move the minimizer by 1e-9 of the mesh, by up to 5e-6 where it is soft.
  kSingle,
  kDouble,  ///< twice the data and half the lanes; for what kSingle leaves
};

/// The two passes of an iteration over a cell energy, on the machine's fastest kernels. Holds a pose to work on: serves
/// one thread at a time.
class CellPasses {
 public:
  CellPasses() = default;
  CellPasses(const CellPasses&) = delete;
  CellPasses& operator=(const CellPasses&) = delete;
  virtual ~CellPasses() = default;

  /// Takes over positions, (n, 3).
  virtual void set_positions(const Positions& positions) = 0;
  /// Without the stresses of volumes, until fit_rotations() or alignment() find them.
  virtual void set_rotations(const Rotations& rotations) = 0;
  /// All of them to the identity.
  virtual void reset_rotations() = 0;
  virtual void read_rotations(Rotations& rotations) const = 0;

  /// Takes over the rows of some vertices, which are `positions` (n, 3) at these.
  virtual void move_vertices(const std::vector<int>& vertices, const Positions& positions) = 0;
  virtual void set_rotation(int cell, const Eigen::Quaterniond& rotation) = 0;
  [[nodiscard]] virtual Eigen::Quaterniond rotation(int cell) const = 0;

  /// Local step: each R_c becomes the rotation that maximizes <R_c, Q_c(p')>. Returns the sum of <R_c, Q_c>, less the
  /// term of volumes.
  virtual double fit_rotations() = 0;
  /// The same sum for the rotations as they are.
  [[nodiscard]] virtual double alignment() = 0;
  /// What fit_rotations() returned, brought up to date after changes of some rotations and vertices.
  /// @param cells  that have changed, or have vertices that have
  [[nodiscard]] virtual double alignment_after(const std::vector<int>& cells) = 0;

  /// residual = b - K p' with b_j = sum_c (R_c + P_c) q_cj, (n, 3), [SA07] Eq. (8), P_c = -k (J_c - 1) cof F_c the
  /// stress of a volume; returns 1/2 <p', K p'>.
  virtual double find_residual(Positions& residual) const = 0;

  /// Smallest change of `energy`, E_0 + 1/2 <p', K p'> - fit_rotations(), that is not rounding.
  [[nodiscard]] virtual double energy_rounding(double energy) const = 0;
  /// E_0, as these passes sum it: the energy at rest is 0.
  [[nodiscard]] virtual double rest_energy() const = 0;
};

/// @param energy   its K is read now
/// @param cells    its own or those that stand for them; must outlive the passes
/// @param rest     (n, 3)
/// @param workers  results do not depend on how many they are
[[nodiscard]] std::unique_ptr<CellPasses> make_cell_passes(const CellEnergy& energy, const Cells& cells,
                                                           const Positions& rest, Precision precision,
                                                           const Workers& workers, Isa isa = choose_isa());

/// Sizes of the mesh: what is nearer to its middle than this, fixed point knows beside it.
inline constexpr double kSinglePrecisionReach = 8;

/// Whether single precision serves an energy: its numbers are in the range of a float, its edges are no dust beside the
/// whole, and no part is so much stiffer than another that the rounded forces in the one would bend the other.
[[nodiscard]] bool fits_single_precision(const CellEnergy& energy, const Positions& rest);

}  // namespace arap
