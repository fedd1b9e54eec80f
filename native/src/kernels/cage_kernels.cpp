// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled once per instruction set, in the namespace ARAP_ISA_NAMESPACE.
#include "kernels/cage_kernels.h"

#include <numbers>

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

/// Of normal numbers > 0.
[[gnu::always_inline]] inline Numbers logarithm(const Numbers& x) {
  using Integers = Vector<std::int64_t, kCount>;
  constexpr std::int64_t kMantissa = (std::int64_t{1} << 52) - 1;
  constexpr std::int64_t kOne = std::int64_t{1023} << 52;
  constexpr std::int64_t kShift = std::int64_t{1075} << 52;  // 2^52: the lowest bits of such a number are an integer
  const auto x_bits = __builtin_bit_cast(Integers, x);
  const Numbers exponent = __builtin_bit_cast(Numbers, (x_bits >> 52) | kShift) - (0x1p52 + 1023);
  const Numbers mantissa = __builtin_bit_cast(Numbers, (x_bits & kMantissa) | kOne);
  const Mask<double> is_large = mantissa > std::numbers::sqrt2;
  const Numbers m = is_large ? 0.5 * mantissa : mantissa;
  const Numbers t = (m - 1) / (m + 1);
  const Numbers w = t * t;
  // 2 atanh(t) = 2 t (1 + w / 3 + w^2 / 5 + ...), |t| <= .172.
  Numbers series{};
  for (int k = 21; k > 1; k -= 2) series = (series + 1.0 / k) * w;
  return (is_large ? exponent + 1 : exponent) * std::numbers::ln2 + 2 * (t + t * series);
}

/// A linear function of the points.
[[gnu::always_inline]] inline Numbers at(const double* function, const Three<double>& points) {
  return points[0] * function[0] + (points[1] * function[1] + (points[2] * function[2] + function[3]));
}

/// An edge and its start from points.
struct SeenEdge {
  [[gnu::always_inline]] SeenEdge(const CageEdge& edge, const Three<double>& points) {
    const double* e = edge.along;
    const Numbers a[3] = {edge.start[0] - points[0], edge.start[1] - points[1], edge.start[2] - points[2]};  // NOLINT
    const Numbers x = a[1] * e[2] - a[2] * e[1];
    const Numbers y = a[2] * e[0] - a[0] * e[2];
    const Numbers z = a[0] * e[1] - a[1] * e[0];
    squared_area = x * x + y * y + z * z;
    cosine = a[0] * (a[0] + e[0]) + a[1] * (a[1] + e[1]) + a[2] * (a[2] + e[2]);
  }

  Numbers squared_area;  ///< of the parallelogram of the vectors to both ends
  Numbers cosine;        ///< their product
};

/// The angle that an edge is seen at, over the distance to its line.
[[gnu::always_inline]] inline Numbers angle_over_distance(const CageEdge& edge, const SeenEdge& seen) {
  constexpr double kTiny = 1e-200;  // on the line beyond the edge the limit is length / cosine
  const Numbers area = square_root<double>(seen.squared_area) + kTiny;
  return edge.length * angle(area, seen.cosine) / area;
}

/// ln((r_a + r_b + l) / (r_a + r_b - l)), r the distances of the ends.
[[gnu::always_inline]] inline Numbers logarithm_of_ends(const CageEdge& edge, const SeenEdge& seen,
                                                        const Numbers& to_start, const Numbers& to_end) {
  const Numbers product = to_start * to_end;
  // The same number; each way is without cancellation where the other one is not.
  const Numbers apart = seen.cosine > 0 ? product + seen.cosine : seen.squared_area / (product - seen.cosine);
  const Numbers sum = to_start + to_end + edge.length;
  return logarithm(sum * sum / (2 * apart));
}

[[gnu::always_inline]] inline void add(double* sum, const Numbers& value) {
  store<double, kCount>(sum, load<double, kCount>(sum) + value);
}

/// A triangle as points see it, and the terms of its edges.
struct SeenTriangle {
  [[gnu::always_inline]] SeenTriangle(const CageTriangle& triangle, const Three<double>& points, const double* terms)
      : depth(at(triangle.depth, points)) {
    for (int k = 0; k < 3; ++k) {
      heights[k] = at(triangle.heights[k], points);
      of_edges[k] = load<double, kCount>(terms + std::ptrdiff_t{kCount} * triangle.edges[k]);
    }
    over_edges = heights[0] * of_edges[0] + heights[1] * of_edges[1] + heights[2] * of_edges[2];
  }

  /// As of_corner() of cages/cage.h, times the share.
  [[nodiscard, gnu::always_inline]] Numbers of_corner(const CageTriangle& triangle, int k,
                                                      const Numbers& of_area) const {
    const int next = (k + 1) % 3;
    const int last = (k + 2) % 3;
    const Numbers along =
        of_edges[k] + triangle.cosines[last] * of_edges[next] + triangle.cosines[next] * of_edges[last];
    return (triangle.share * triangle.per_height[k]) * (heights[k] * of_area + depth * along);
  }

  Numbers depth;
  Three<double> heights{};
  Three<double> of_edges{};
  Numbers over_edges{};  ///< sum of heights times terms
};

[[gnu::always_inline]] inline Three<double> load_points(const double* coordinates) {
  return {{load<double, kCount>(coordinates), load<double, kCount>(coordinates + kCageBlock),
           load<double, kCount>(coordinates + std::ptrdiff_t{2} * kCageBlock)}};
}

[[gnu::always_inline]] inline void put(float* weights, const Numbers& values) {
  store<float, kCount>(weights, __builtin_convertvector(values, Vector<float, kCount>));
}

/// Of kCount points, whose coordinates are kCageBlock apart, as are their weights.
unsigned mean_values_of_lanes(const CageView& cage, const double* coordinates, double* scratch, float* weights) {
  const Three<double> points = load_points(coordinates);
  double* of_edges = scratch;
  double* of_vertices = scratch + std::ptrdiff_t{kCount} * cage.n_edges;
  for (std::ptrdiff_t e = 0; e < cage.n_edges; ++e)
    store<double, kCount>(of_edges + kCount * e, angle_over_distance(cage.edges[e], {cage.edges[e], points}));
  for (std::ptrdiff_t v = 0; v < cage.n_vertices; ++v) store<double, kCount>(of_vertices + kCount * v, Numbers{});

  const Numbers squared = points[0] * points[0] + points[1] * points[1] + points[2] * points[2];
  Mask<double> is_unsure = squared > kFarFromCage * kFarFromCage;
  Numbers sum{};
  for (std::ptrdiff_t t = 0; t < cage.n_triangles; ++t) {
    const CageTriangle& triangle = cage.triangles[t];
    const SeenTriangle seen(triangle, points, of_edges);
    is_unsure |= magnitude(seen.depth) < kNearPlane;
    const Numbers over_depth = seen.over_edges / seen.depth;
    for (int k = 0; k < 3; ++k) {
      const Numbers weight = seen.of_corner(triangle, k, over_depth);
      sum += weight;
      add(of_vertices + std::ptrdiff_t{kCount} * triangle.vertices[k], weight);
    }
  }
  for (std::ptrdiff_t v = 0; v < cage.n_vertices; ++v)
    put(weights + kCageBlock * v, load<double, kCount>(of_vertices + kCount * v) / sum);
  return bits<double>(is_unsure);
}

/// Lanes beside a triangle's vertices.
struct Corners {
  [[gnu::always_inline]] Corners(const CageTriangle& triangle, const double* distances, const double* cosines) {
    for (int k = 0; k < 3; ++k) {
      to_corner[k] = load<double, kCount>(distances + std::ptrdiff_t{kCount} * triangle.vertices[k]);
      of_edge[k] = load<double, kCount>(cosines + std::ptrdiff_t{kCount} * triangle.edges[k]);
    }
  }

  /// > 0 from behind. As a tangent of its half.
  [[nodiscard, gnu::always_inline]] Numbers solid_angle(const CageTriangle& triangle, const Numbers& depth) const {
    constexpr double kTiny = 1e-200;
    const Numbers under = to_corner[0] * to_corner[1] * to_corner[2] + of_edge[0] * to_corner[0] +
                          of_edge[1] * to_corner[1] + of_edge[2] * to_corner[2];
    const Numbers half = angle(magnitude(depth) * triangle.twice_area + kTiny, under);
    return 2 * (depth < 0 ? -half : half);
  }

  Three<double> to_corner{};
  Three<double> of_edge{};  ///< products of the vectors to its ends
};

unsigned green_of_lanes(const CageView& cage, const double* coordinates, double* scratch, float* weights) {
  constexpr double kPerSphere = 0.07957747154594767;  // 1 / 4 pi
  constexpr double kNearCage = 1e-11;
  constexpr double kRounding = 1e-9;
  const Three<double> points = load_points(coordinates);
  double* of_edges = scratch;
  double* cosines = of_edges + std::ptrdiff_t{kCount} * cage.n_edges;
  double* of_vertices = cosines + std::ptrdiff_t{kCount} * cage.n_edges;
  double* distances = of_vertices + std::ptrdiff_t{kCount} * cage.n_vertices;
  for (std::ptrdiff_t v = 0; v < cage.n_vertices; ++v) {
    Numbers squared{};
    for (int i = 0; i < 3; ++i)
      squared += (cage.vertices[3 * v + i] - points[i]) * (cage.vertices[3 * v + i] - points[i]);
    store<double, kCount>(distances + kCount * v, square_root<double>(squared));
    store<double, kCount>(of_vertices + kCount * v, Numbers{});
  }
  for (std::ptrdiff_t e = 0; e < cage.n_edges; ++e) {
    const CageEdge& edge = cage.edges[e];
    const auto to_end = [&](int end) __attribute__((always_inline)) {
      return load<double, kCount>(distances + std::ptrdiff_t{kCount} * edge.ends[end]);
    };
    const SeenEdge seen(edge, points);
    store<double, kCount>(of_edges + kCount * e, logarithm_of_ends(edge, seen, to_end(0), to_end(1)));
    store<double, kCount>(cosines + kCount * e, seen.cosine);
  }

  Mask<double> is_unsure{};
  Numbers sum{};
  for (std::ptrdiff_t t = 0; t < cage.n_triangles; ++t) {
    const CageTriangle& triangle = cage.triangles[t];
    const SeenTriangle seen(triangle, points, of_edges);
    is_unsure |= magnitude(seen.depth) < kNearCage;
    const Numbers angle = Corners(triangle, distances, cosines).solid_angle(triangle, seen.depth);
    for (int k = 0; k < 3; ++k) {
      const Numbers weight = kPerSphere * seen.of_corner(triangle, k, angle);
      sum += weight;
      add(of_vertices + std::ptrdiff_t{kCount} * triangle.vertices[k], weight);
    }
    put(weights + kCageBlock * (cage.n_vertices + t),
        (kPerSphere * triangle.share) * (seen.over_edges - seen.depth * angle));
  }
  for (std::ptrdiff_t v = 0; v < cage.n_vertices; ++v)
    put(weights + kCageBlock * v, load<double, kCount>(of_vertices + kCount * v));
  // Negated, so that what is not a number is told, too.
  is_unsure |= ~(magnitude(sum - 1) < kRounding);
  return bits<double>(is_unsure);
}

/// Calls of_lanes(first) for the points from `first` on, and joins what it says of them.
template <class OfLanes>
[[gnu::always_inline]] inline unsigned for_each_lanes(const OfLanes& of_lanes) {
  unsigned unsure = 0;
  for (int k = 0; k < kCageBlock; k += kCount) unsure |= of_lanes(k) << static_cast<unsigned>(k);
  return unsure;
}

unsigned mean_values(const CageView& cage, const double* points, double* scratch, float* weights) {
  return for_each_lanes([&](int k) { return mean_values_of_lanes(cage, points + k, scratch, weights + k); });
}

unsigned green(const CageView& cage, const double* points, double* scratch, float* weights) {
  return for_each_lanes([&](int k) { return green_of_lanes(cage, points + k, scratch, weights + k); });
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
CageKernels cage_kernels() { return {mean_values, green, carry}; }

}  // namespace ARAP_ISA_NAMESPACE
}  // namespace arap
