// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled once per instruction set, in the namespace ARAP_ISA_NAMESPACE.
#include "kernels/wrap_kernels.h"

#include "kernels/lanes.h"

namespace arap {
namespace {

using Numbers = Lanes<float>;
constexpr int kCount = kLaneCount<float>;
using Row = Vector<float, 4>;

/// Fourth powers of it are numbers.
constexpr float kLargest = 1e8F;

/// Of the squared growth of an area.
constexpr float kLeastGrowth = 1e-24F;

/// A triangle that is so many times as large as usual, or as small, in every direction may just be bent with the
/// surface; from kScaled on all of it is taken for scaled, and between them more and more.
constexpr float kBent = 4.F / 3;
constexpr float kScaled = 2;

/// Of the area: a triangle that has shrunk to less has no normal to speak of, and the less it has, the less it pushes.
constexpr float kCollapsed = 1e-4F;

[[gnu::always_inline]] inline Numbers limited(const Numbers& x) {
  const Numbers low = x < -kLargest ? broadcast<float>(-kLargest) : x;
  return low > kLargest ? broadcast<float>(kLargest) : low;
}

[[gnu::always_inline]] inline Numbers dot(const Three<float>& a, const Three<float>& b) {
  return a[0] * b[0] + (a[1] * b[1] + a[2] * b[2]);
}

[[gnu::always_inline]] inline Three<float> cross(const Three<float>& a, const Three<float>& b) {
  return {{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]}};
}

[[gnu::always_inline]] inline Three<float> operator+(const Three<float>& a, const Three<float>& b) {
  return {{a[0] + b[0], a[1] + b[1], a[2] + b[2]}};
}

/// (a + da) x (b + db) - a x b
[[gnu::always_inline]] inline Three<float> change_of_cross(const Three<float>& a, const Three<float>& b,
                                                           const Three<float>& da, const Three<float>& db) {
  return cross(a, db) + cross(da, b) + cross(da, db);
}

/// Rows of matrices, one in each lane.
struct Rows {
  Three<float> v[3];  // NOLINT
  [[nodiscard, gnu::always_inline]] Three<float> times(const Three<float>& x) const {
    return {{dot(v[0], x), dot(v[1], x), dot(v[2], x)}};
  }
};

/// The rows of D, seen from an anchor, and its displacement.
[[gnu::always_inline]] inline void measure(const AnchorsView& anchors, const double* displacements, int anchor,
                                           float* rows) {
  const Vector<double, 4> here = load<double, 4>(displacements + std::ptrdiff_t{4} * anchors.vertices[anchor]);
  Row x{};
  Row y{};
  Row z{};
  for (std::ptrdiff_t k = anchors.offsets[anchor]; k < anchors.offsets[anchor + 1]; ++k) {
    const Vector<double, 4> next = load<double, 4>(displacements + std::ptrdiff_t{4} * anchors.neighbours[k]);
    const Row change = __builtin_convertvector(next - here, Row);
    const Row gradient = load<float, 4>(anchors.gradients + 4 * k);
    x += spread<4, 0>(change) * gradient;
    y += spread<4, 1>(change) * gradient;
    z += spread<4, 2>(change) * gradient;
  }
  store<float, 4>(rows, x);
  store<float, 4>(rows + 4, y);
  store<float, 4>(rows + 8, z);
  store<float, 4>(rows + 12, __builtin_convertvector(here, Row));
}

/// Three of four components of row i of each anchor.
[[gnu::always_inline]] inline Three<float> three(const float* rows, int i) {
  const Four<float> all = components<float>([&](int k) __attribute__((always_inline)) {
    return load<float, 4>(rows + std::ptrdiff_t{kMapNumbers} * k + std::ptrdiff_t{4} * i);
  });
  return {{all[0], all[1], all[2]}};
}

/// Adds what brings the normal n = u x v to the new one, over the root of the area's growth g: (n + c) / sqrt(g) - n,
/// with n + c = (u + D u) x (v + D v). Of c alone, so where nothing changes it is 0 to the last digit.
[[gnu::always_inline]] inline void add_change_of_normal(const Three<float>& u, const Three<float>& v, Rows& D) {
  const Three<float> n = cross(u, v);
  const Three<float> c = change_of_cross(u, v, D.times(u), D.times(v));
  const Three<float> now = n + c;
  // Of an area that has shrunk, 1 + (2 n + c) c is rounding.
  const Numbers direct = dot(now, now);
  const Numbers squared = direct < .5F ? direct : 1 + dot(now + n, c);
  const Numbers growth = squared > kLeastGrowth ? squared : broadcast<float>(kLeastGrowth);
  const Numbers per_root = 1 / square_root<float>(square_root<float>(growth));
  for (int i = 0; i < 3; ++i) {
    const Numbers w = per_root * c[i] + (per_root - 1) * n[i];
    for (int k = 0; k < 3; ++k) D.v[i][k] += w * n[k];
  }
}

/// @param frames  of the anchors' block, at the first of them
/// @param maps    takes the maps in place of what measure() wrote
[[gnu::always_inline]] inline void complete(const float* frames, float* maps) {
  const auto vector = [&](int first) __attribute__((always_inline)) {
    return Three<float>{{load<float, kCount>(frames + std::ptrdiff_t{kWrapBlock} * first),
                         load<float, kCount>(frames + std::ptrdiff_t{kWrapBlock} * (first + 1)),
                         load<float, kCount>(frames + std::ptrdiff_t{kWrapBlock} * (first + 2))}};
  };
  Rows D{{three(maps, 0), three(maps, 1), three(maps, 2)}};
  const Three<float> here = three(maps, 3);
  for (Three<float>& row : D.v)
    for (Numbers& number : row.v) number = limited(number);
  add_change_of_normal(vector(0), vector(3), D);
  const Three<float> of_place = D.times(vector(6));
  for (int i = 0; i < 3; ++i) {
    const Four<float> row{{D.v[i][0], D.v[i][1], D.v[i][2], here[i] - of_place[i]}};
    for_each_row<float>(
        row, [&](int k, Row values) __attribute__((always_inline)) {
          store<float, 4>(maps + std::ptrdiff_t{kMapNumbers} * k + std::ptrdiff_t{4} * i, values);
        });
  }
}

void find_maps(const AnchorsView& anchors, const double* displacements, float* maps, int begin, int end) {
  for (std::ptrdiff_t block = begin; block < end; ++block) {
    const std::ptrdiff_t first = block * kWrapBlock;
    for (int k = 0; k < kWrapBlock; ++k)
      measure(anchors, displacements, static_cast<int>(first) + k, maps + (first + k) * kMapNumbers);
    for (int k = 0; k < kWrapBlock; k += kCount)
      complete(anchors.frames + block * 9 * kWrapBlock + k, maps + (first + k) * kMapNumbers);
  }
}

void move_points(const int* offsets, const AnchorWeight* weights, const float* maps, const float* points, float* moves,
                 int begin, int end) {
  constexpr int kVectors = (12 + kCount - 1) / kCount;  // that hold the rows
  for (std::ptrdiff_t p = begin; p < end; ++p) {
    Numbers sums[kVectors]{};  // NOLINT: no std::array here, see simd.h
    for (std::ptrdiff_t k = offsets[p]; k < offsets[p + 1]; ++k) {
      const float* map = maps + std::ptrdiff_t{kMapNumbers} * weights[k].anchor;
      for (int i = 0; i < kVectors; ++i)
        sums[i] += weights[k].weight * load<float, kCount>(map + std::ptrdiff_t{kCount} * i);
    }
    const Numbers point = repeat_four<kCount>(points + 4 * p);
    float products[kVectors * kCount];  // NOLINT
    for (int i = 0; i < kVectors; ++i) store<float, kCount>(products + std::ptrdiff_t{kCount} * i, sums[i] * point);
    float* move = moves + 4 * (p - begin);
    for (int i = 0; i < 3; ++i) {
      const float* row = products + std::ptrdiff_t{4} * i;
      move[i] = (row[0] + row[1]) + (row[2] + row[3]);
    }
    move[3] = 0;
  }
  // push_points() reads whole blocks.
  for (std::ptrdiff_t p = end; p % kWrapBlock != 0; ++p) store<float, 4>(moves + 4 * (p - begin), Row{});
}

/// Numbers of a side in each lane.
struct Sides {
  const float* numbers;
  [[nodiscard, gnu::always_inline]] Numbers at(int i) const {
    return load<float, kCount>(numbers + std::ptrdiff_t{kWrapBlock} * i);
  }
  [[nodiscard, gnu::always_inline]] Three<float> three_at(int i) const { return {{at(i), at(i + 1), at(i + 2)}}; }
};

/// What to - from is for each lane, in lengths of its edge.
/// @param from, to  from(k), to(k): Vector<double, 4>
template <class From, class To>
[[gnu::always_inline]] inline Three<float> change(const From& from, const To& to, const Numbers& per_edge) {
  const Four<float> all = components<float>([&](int k) __attribute__((always_inline)) {
    return __builtin_convertvector(to(k) - from(k), Row);
  });
  return {{limited(all[0] * per_edge), limited(all[1] * per_edge), limited(all[2] * per_edge)}};
}

/// What is beyond bending of a stretch >= 1.
[[gnu::always_inline]] inline Numbers beyond_bending(const Numbers& stretch) {
  const Numbers grown = 1 + (stretch - kBent) * ((kScaled - 1) / (kScaled - kBent));
  const Numbers least = grown < 1 ? broadcast<float>(1) : grown;
  return least < stretch ? least : stretch;
}

/// How many times as large as usual lengths across triangles are.
/// @param mean, determinant  the half trace, and the determinant, of the matrices whose eigenvalues are the squares of
///                           the triangles' stretches
[[gnu::always_inline]] inline Numbers scale_of(const Numbers& mean, const Numbers& determinant) {
  constexpr float kSquare = kBent * kBent;
  const Numbers one = broadcast<float>(1);
  const Numbers squared = mean * mean - determinant;
  const Numbers half = square_root<float>(squared > 0 ? squared : Numbers{});
  const Numbers low = mean - half;
  const Numbers high = mean + half;
  const Numbers larger = beyond_bending(square_root<float>(low > 1 ? low : one));
  constexpr float kLeast = 1e-16F;
  const Numbers smaller = 1 / beyond_bending(1 / square_root<float>(high > kLeast ? high : broadcast<float>(kLeast)));
  return low > kSquare ? larger : high * kSquare < 1 ? smaller : one;
}

/// Of changes alone, so where nothing changes it is 0 to the last digit.
[[gnu::always_inline]] inline Three<float> push(const Sides& its, const Three<float>& u, const Three<float>& v,
                                                const Three<float>& x, float growth) {
  const Three<float> ab = its.three_at(side::kAB);
  const Three<float> ac = its.three_at(side::kAC);
  const Three<float> area_at_rest = cross(ab, ac);
  const Three<float> c = change_of_cross(ab, ac, u, v);
  const Three<float> area = area_at_rest + c;
  const Numbers squared_at_rest = dot(area_at_rest, area_at_rest);
  const Numbers squared = dot(area, area);
  constexpr float kLeastSize = 1e-15F;
  const Numbers root = square_root<float>(squared);
  const Numbers size = root > kLeastSize ? root : broadcast<float>(kLeastSize);

  const Numbers change_of_trace = its.at(side::kInverse) * dot(ab + ab + u, u) +
                                  its.at(side::kInverse + 1) * (2 * (dot(ab, v) + dot(u, ac) + dot(u, v))) +
                                  its.at(side::kInverse + 2) * dot(ac + ac + v, v);
  const float per_square = 1 / (growth * growth);
  const Numbers mean = limited((1 + change_of_trace / 2) * per_square);
  const Numbers determinant = squared / squared_at_rest * per_square * per_square;
  const Numbers looks = its.at(side::kInverse);
  const Numbers scale = growth * (looks > 0 ? scale_of(mean, determinant) : broadcast<float>(1));

  // Lengths of the plane's normal times the size of the area.
  const Numbers change_of_size = dot(area_at_rest + area, c) / (size + square_root<float>(squared_at_rest));
  const Numbers wanted = its.at(side::kDistance) * ((scale - 1) * size + change_of_size);
  const Three<float> now = its.three_at(side::kPlace) + x;
  const Numbers missing = wanted - (dot(c, now) + dot(area_at_rest, x));
  // No farther than from where it is to the plane, and on: of a small area, rounding would bring it anywhere.
  const Numbers above = its.at(side::kDistance);
  const Numbers most = scale * (above < 0 ? -above : above) + square_root<float>(dot(now, now));
  const Numbers way = missing / size;
  const Numbers down = way < -most ? -most : way;
  const Numbers least = kCollapsed * growth * growth * square_root<float>(squared_at_rest);
  const Numbers share = its.at(side::kStrength) * (size / (size + least * (least / size)));
  const Numbers along = share * (down > most ? most : down) / (size * its.at(side::kPerEdge));
  return {{along * area[0], along * area[1], along * area[2]}};
}

void push_points(const SidesView& sides, const double* displacements, float growth, float* moves, int begin, int end) {
  for (std::ptrdiff_t p = begin; p < end; p += kCount) {
    const std::ptrdiff_t block = p / kWrapBlock;
    const std::ptrdiff_t lane = p % kWrapBlock;
    const Sides its{sides.numbers + block * kSideNumbers * kWrapBlock + lane};
    if (all<float>(its.at(side::kStrength) <= 0)) continue;
    const int* corners = sides.corners + block * 3 * kWrapBlock + lane;
    const auto corner = [&](int i) {
      return [=](int k) __attribute__((always_inline)) {
        return load<double, 4>(displacements + std::ptrdiff_t{4} * corners[kWrapBlock * i + k]);
      };
    };
    float* its_moves = moves + 4 * (p - begin);
    const auto moved = [=](int k) __attribute__((always_inline)) {
      return __builtin_convertvector(load<float, 4>(its_moves + std::ptrdiff_t{4} * k), Vector<double, 4>);
    };
    const Numbers per_edge = its.at(side::kPerEdge);
    const Three<float> pushed =
        push(its, change(corner(0), corner(1), per_edge), change(corner(0), corner(2), per_edge),
             change(corner(0), moved, per_edge), growth);
    for_each_row<float>(
        {{pushed[0], pushed[1], pushed[2], Numbers{}}}, [&](int k, Row row) __attribute__((always_inline)) {
          float* move = its_moves + std::ptrdiff_t{4} * k;
          store<float, 4>(move, load<float, 4>(move) + row);
        });
  }
}

}  // namespace

namespace ARAP_ISA_NAMESPACE {

WrapKernels wrap_kernels();  // declared again in kernels.cpp
WrapKernels wrap_kernels() { return {find_maps, move_points, push_points}; }

}  // namespace ARAP_ISA_NAMESPACE
}  // namespace arap
