// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled once per instruction set, in the namespace ARAP_ISA_NAMESPACE.
#include "kernels/lattice_kernels.h"

#include "kernels/simd.h"

namespace arap {
namespace {

using Point = Vector<double, 4>;

/// As spline_weights().
void weights_at(double t, double* weights) {
  weights[0] = 0.5 * (1 - t) * (1 - t);
  weights[1] = 0.5 + t - t * t;
  weights[2] = 0.5 * t * t;
}

void embed(const EmbeddingView& vertices, const double* control_points, double* points, int begin, int end) {
  for (std::ptrdiff_t v = begin; v < end; ++v) {
    if (vertices.pieces[v] < 0) continue;
    const int* c = vertices.control_points + std::ptrdiff_t{27} * vertices.pieces[v];
    double x[3];  // NOLINT: no std::array here, see simd.h
    double y[3];  // NOLINT
    double z[3];  // NOLINT
    weights_at(static_cast<double>(vertices.places[3 * v]), x);
    weights_at(static_cast<double>(vertices.places[3 * v + 1]), y);
    weights_at(static_cast<double>(vertices.places[3 * v + 2]), z);
    Point sum{};
    for (const double of_x : x) {
      Point along_y{};
      for (const double of_y : y) {
        Point along_z{};
        for (const double of_z : z) along_z += of_z * load<double, 4>(control_points + std::ptrdiff_t{4} * *c++);
        along_y += of_y * along_z;
      }
      sum += of_x * along_y;
    }
    for (int k = 0; k < 3; ++k) points[3 * v + k] = sum[k];
  }
}

}  // namespace

namespace ARAP_ISA_NAMESPACE {

LatticeKernels lattice_kernels();  // declared again in kernels.cpp
LatticeKernels lattice_kernels() { return {embed}; }

}  // namespace ARAP_ISA_NAMESPACE
}  // namespace arap
