// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled once per instruction set, in the namespace ARAP_ISA_NAMESPACE.
#include "kernels/cage_kernels.h"

#include "kernels/lanes.h"

namespace arap {
namespace {

/// A number of each of several points.
using Numbers = Lanes<double>;
constexpr int kCount = kLaneCount<double>;

constexpr double kHalfPi = 1.5707963267948966;

/// Below this distance from a plane the caller looks again: the error is about 1e-16 over it.
constexpr double kNearPlane = 3e-6;

[[gnu::always_inline]] inline Numbers all(double value) { return broadcast<double>(value); }
[[gnu::always_inline]] inline Numbers magnitude(const Numbers& x) { return x < 0 ? -x : x; }

/// The angle of the vector (x, y), y > 0, in (0, pi).
[[gnu::always_inline]] inline Numbers angle(const Numbers& y, const Numbers& x) {
  // tan(pi / 8) and tan(3 pi / 8): between them the angle is taken from pi / 4, above from pi / 2.
  constexpr double kLow = 0.41421356237309503;
  constexpr double kHigh = 2.414213562373095;
  const Numbers width = magnitude(x);
  const Mask<double> is_steep = y > kHigh * width;
  const Mask<double> is_flat = y < kLow * width;
  const Numbers over = is_flat ? y : is_steep ? -width : y - width;
  const Numbers under = is_flat ? width : is_steep ? y : y + width;
  const Numbers from = is_flat ? Numbers{} : is_steep ? all(kHalfPi) : all(kHalfPi / 2);
  const Numbers z = over / under;
  const Numbers w = z * z;
  // atan(z) / z = 1 + w P(w), to 7e-18 for |z| <= tan(pi / 8): interpolated at Chebyshev's points.
  constexpr double kCoefficients[] = {// NOLINT: no std::array here, see simd.h
                                      -0.019176885636589053, 0.039231657085083686, -0.050854496960392584,
                                      0.05858148904795124,   -0.0666451144646022,  0.07692183190760651,
                                      -0.09090904578121085,  0.11111111015256292,  -0.14285714284666542,
                                      0.1999999999999552,    -0.3333333333333333};
  Numbers series{};
  for (const double coefficient : kCoefficients) series = series * w + coefficient;
  const Numbers acute = from + (z + z * (w * series));
  return x < 0 ? 2 * kHalfPi - acute : acute;
}

/// A linear function of the points.
[[gnu::always_inline]] inline Numbers at(const double* function, const Three<double>& points) {
  return points[0] * function[0] + (points[1] * function[1] + (points[2] * function[2] + function[3]));
}

/// The angle that an edge is seen at, over the distance to its line.
[[gnu::always_inline]] inline Numbers angle_over_distance(const CageEdge& edge, const Three<double>& points) {
  constexpr double kTiny = 1e-200;  // on the line beyond the edge the limit is length / cosine
  const double* e = edge.along;
  const Numbers a[3] = {edge.start[0] - points[0], edge.start[1] - points[1], edge.start[2] - points[2]};  // NOLINT
  const Numbers x = a[1] * e[2] - a[2] * e[1];
  const Numbers y = a[2] * e[0] - a[0] * e[2];
  const Numbers z = a[0] * e[1] - a[1] * e[0];
  const Numbers area = square_root<double>(x * x + y * y + z * z) + kTiny;
  const Numbers cosine = a[0] * (a[0] + e[0]) + a[1] * (a[1] + e[1]) + a[2] * (a[2] + e[2]);
  return edge.length * angle(area, cosine) / area;
}

[[gnu::always_inline]] inline void add(double* sum, const Numbers& value) {
  store<double, kCount>(sum, load<double, kCount>(sum) + value);
}

/// The result is of kCount points, whose coordinates are kCageBlock apart, as are their weights.
unsigned mean_values_of_lanes(const CageView& cage, const double* coordinates, double* scratch, float* weights) {
  const Three<double> points{{load<double, kCount>(coordinates), load<double, kCount>(coordinates + kCageBlock),
                              load<double, kCount>(coordinates + std::ptrdiff_t{2} * kCageBlock)}};
  double* of_edges = scratch;
  double* of_vertices = scratch + std::ptrdiff_t{kCount} * cage.n_edges;
  for (std::ptrdiff_t e = 0; e < cage.n_edges; ++e)
    store<double, kCount>(of_edges + kCount * e, angle_over_distance(cage.edges[e], points));
  for (std::ptrdiff_t v = 0; v < cage.n_vertices; ++v) store<double, kCount>(of_vertices + kCount * v, Numbers{});

  Mask<double> is_unsure{};
  Numbers sum{};
  for (std::ptrdiff_t t = 0; t < cage.n_triangles; ++t) {
    const CageTriangle& triangle = cage.triangles[t];
    const Numbers depth = at(triangle.depth, points);
    Three<double> heights{};
    Three<double> angles{};
    for (int k = 0; k < 3; ++k) {
      heights[k] = at(triangle.heights[k], points);
      angles[k] = load<double, kCount>(of_edges + std::ptrdiff_t{kCount} * triangle.edges[k]);
    }
    is_unsure |= magnitude(depth) < kNearPlane;
    const Numbers over_depth = (heights[0] * angles[0] + heights[1] * angles[1] + heights[2] * angles[2]) / depth;
    for (int k = 0; k < 3; ++k) {
      const int next = (k + 1) % 3;
      const int last = (k + 2) % 3;
      const Numbers along = angles[k] + triangle.cosines[last] * angles[next] + triangle.cosines[next] * angles[last];
      const Numbers weight = (triangle.share * triangle.per_height[k]) * (heights[k] * over_depth + depth * along);
      sum += weight;
      add(of_vertices + std::ptrdiff_t{kCount} * triangle.vertices[k], weight);
    }
  }
  for (std::ptrdiff_t v = 0; v < cage.n_vertices; ++v)
    store<float, kCount>(
        weights + kCageBlock * v,
        __builtin_convertvector(load<double, kCount>(of_vertices + kCount * v) / sum, Vector<float, kCount>));
  return bits<double>(is_unsure);
}

unsigned mean_values(const CageView& cage, const double* points, double* scratch, float* weights) {
  unsigned unsure = 0;
  for (int k = 0; k < kCageBlock; k += kCount)
    unsure |= mean_values_of_lanes(cage, points + k, scratch, weights + k) << static_cast<unsigned>(k);
  return unsure;
}

void carry(const float* weights, const double* motions, int n_rows, double* sums) {
  constexpr int kWide = kLaneCount<float>;
  for (int k = 0; k < kCageBlock; k += kWide) {
    Three<double> low{};
    Three<double> high{};
    for (std::ptrdiff_t row = 0; row < n_rows; ++row) {
      const Vector<float, kWide> both = load<float, kWide>(weights + kCageBlock * row + k);
      const Numbers of_low = __builtin_convertvector(half<kWide, false>(both), Numbers);
      const Numbers of_high = __builtin_convertvector(half<kWide, true>(both), Numbers);
      for (int i = 0; i < 3; ++i) {
        low[i] += of_low * motions[3 * row + i];
        high[i] += of_high * motions[3 * row + i];
      }
    }
    double* to = sums + k;
    for (int i = 0; i < 3; ++i, to += kCageBlock) {
      store<double, kCount>(to, low[i]);
      store<double, kCount>(to + kCount, high[i]);
    }
  }
}

}  // namespace

namespace ARAP_ISA_NAMESPACE {

CageKernels cage_kernels();  // declared again in kernels.cpp
CageKernels cage_kernels() { return {mean_values, carry}; }

}  // namespace ARAP_ISA_NAMESPACE
}  // namespace arap
