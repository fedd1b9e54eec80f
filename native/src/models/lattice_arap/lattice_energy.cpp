// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/lattice_arap/lattice_energy.h"

#include <algorithm>
#include <array>
#include <utility>

#include "base/grouped.h"
#include "sparse/matrix_assembly.h"

namespace arap {

namespace {

using Matrix27 = Eigen::Matrix<double, kControlPoints, kControlPoints>;

/// A piece with hardly anything inside, as of a sheet, is as stiff as this share of a cube.
constexpr double kLeastInside = 0.02;

/// At the middles of octants alone, some modes of a cube that has few neighbours cost nothing. So much of the energy is
/// that of the whole octants instead; all of it would be stiffer than need be.
constexpr double kWhole = 0.1;

/// Along one axis, at the middles of both halves of a cube: linear weights of the three control points, and derivatives
/// by the cube's size.
constexpr double kWeights[2][3] = {{0.25, 0.75, 0}, {0, 0.75, 0.25}};
constexpr double kSlopes[2][3] = {{-1, 1, 0}, {0, -1, 1}};
/// Variance of the weights of two neighbours within a half: they grow and fall by the place.
constexpr double kVariance = 1.0 / 48;

std::array<int, 3> along(int k) { return {k / 9, k / 3 % 3, k % 3}; }

/// Mean of <grad M_j, grad M_k> over a cube of size 1. Octants are all pairs of halves, so the mean of a product over
/// axes is the product of the means.
/// @param variance  of the weights within a half: 0 at the middles of octants
Matrix27 mean_stiffness(double variance) {
  Eigen::Matrix3d of_weights = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d of_slopes = Eigen::Matrix3d::Zero();
  for (int half = 0; half < 2; ++half)
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) {
        of_weights(a, b) +=
            (kWeights[half][a] * kWeights[half][b] + variance * kSlopes[half][a] * kSlopes[half][b]) / 2;
        of_slopes(a, b) += kSlopes[half][a] * kSlopes[half][b] / 2;
      }
  Matrix27 result = Matrix27::Zero();
  for (int j = 0; j < kControlPoints; ++j)
    for (int k = 0; k < kControlPoints; ++k)
      for (int sloped = 0; sloped < 3; ++sloped) {
        double product = 1;
        for (int axis = 0; axis < 3; ++axis)
          product *= (axis == sloped ? of_slopes : of_weights)(along(j)[axis], along(k)[axis]);
        result(j, k) += product;
      }
  return result;
}

Matrix27 unit_stiffness() { return (1 - kWhole) * mean_stiffness(0) + kWhole * mean_stiffness(kVariance); }

/// Which pieces have a control point, and as which of their own.
class Incidence {
 public:
  explicit Incidence(const Lattice& lattice)
      : slots_(lattice.n_control_points(), [&](const auto& add) {
          for (int piece = 0; piece < lattice.n_pieces(); ++piece)
            for (int k = 0; k < kControlPoints; ++k) add(lattice.control_points(piece)[k], kControlPoints * piece + k);
        }) {}

  /// f(piece, k) for each piece that has control point c, as its k-th.
  template <class Function>
  void for_each(int c, const Function& f) const {
    for (const int slot : slots_.of(c)) f(slot / kControlPoints, slot % kControlPoints);
  }

 private:
  Grouped slots_;  ///< kControlPoints * piece + k
};

class LatticeAssembler {
 public:
  LatticeAssembler(const Lattice& lattice, const std::vector<double>& stiffness)
      : lattice_(lattice), piece_stiffness_(stiffness), incidence_(lattice), stiffness_(unit_stiffness()) {}

  /// Its volume times its stiffness.
  [[nodiscard]] double weight(int piece) const {
    const double h = lattice_.cube_size();
    const double volume = h * h * h * std::max(kLeastInside, lattice_.pieces().inside(piece));
    return piece_stiffness_.empty() ? volume : volume * piece_stiffness_[piece];
  }

  [[nodiscard]] SparseMatrix system(int threads, const MeterPart& meter) const {
    const double per_area = 1 / (lattice_.cube_size() * lattice_.cube_size());
    const auto fill = [&](int i, RowAccumulator<double>& column) {
      incidence_.for_each(i, [&](int piece, int k) {
        for (int j = 0; j < kControlPoints; ++j)
          if (stiffness_(j, k) != 0)
            column[lattice_.control_points(piece)[j]] += 2 * weight(piece) * per_area * stiffness_(j, k);
      });
    };
    return assemble_matrix(lattice_.n_control_points(), threads, fill, meter);
  }

  [[nodiscard]] CubeCells cells() const {
    std::vector<double> weights;
    weights.reserve(lattice_.n_pieces());
    for (int piece = 0; piece < lattice_.n_pieces(); ++piece)
      weights.push_back(2 * weight(piece) / lattice_.cube_size());
    return {lattice_.n_control_points(), lattice_.control_points(), std::move(weights)};
  }

 private:
  const Lattice& lattice_;
  const std::vector<double>& piece_stiffness_;
  Incidence incidence_;
  Matrix27 stiffness_;
};

}  // namespace

void assemble_lattice_energy(CellEnergy& energy, const Lattice& lattice, const std::vector<double>& stiffness,
                             int threads, const MeterPart& meter,
                             const std::function<const std::vector<int>*()>& find_order) {
  const LatticeAssembler assembler(lattice, stiffness);
  energy.rest_energy = 0;
  for (int piece = 0; piece < lattice.n_pieces(); ++piece) energy.rest_energy += 3 * assembler.weight(piece);
  energy.K = assembler.system(threads, meter);
  take_cubes(energy, assembler.cells(), find_order(), threads);
}

}  // namespace arap
