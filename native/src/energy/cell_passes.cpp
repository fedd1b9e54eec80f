// SPDX-License-Identifier: GPL-3.0-or-later
#include "energy/cell_passes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>

#include "base/aligned_buffer.h"
#include "energy/cell_terms.h"
#include "energy/sliced_rows.h"
#include "kernels/kernels.h"
#include "parallel/parallel.h"

namespace arap {

namespace {

/// -K_jk of each vertex j, k other than j.
template <class Real>
SlicedNumbers<Real> sliced_off_diagonals(const SparseMatrix& K, const Workers& workers) {
  // Whole slices: no two threads write to one.
  constexpr int kRowRange = 64 * kSliceWidth;
  const auto n = static_cast<int>(K.cols());
  const auto for_each_other = [&](int v, const auto& f) {
    for (SparseMatrix::InnerIterator it(K, v); it; ++it)
      if (it.row() != v) f(static_cast<int>(it.row()), it.value());
  };
  std::vector<int> sizes(n);
  parallel_for<kRowRange>(workers, n, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) for_each_other(v, [&](int, double) { ++sizes[v]; });
  });
  SlicedNumbers<Real> rows(sizes, workers.threads());
  parallel_for<kRowRange>(workers, n, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      int e = 0;
      for_each_other(v, [&](int k, double value) { rows.set(v, e++, k, static_cast<Real>(-value)); });
    }
  });
  return rows;
}

/// @tparam Terms  of listed cells or of cubes
template <class Real, template <class> class Terms>
class CellPassesOf final : public CellPasses {
 public:
  CellPassesOf(const CellEnergy& energy, const Cells& cells, const Positions& rest, const Workers& workers, Isa isa)
      : n_vertices_(energy.n_vertices()),
        n_cells_(energy.n_cells(cells)),
        workers_(workers),
        kernels_(cell_kernels<Real>(isa)),
        terms_(energy, cells, workers, isa),
        off_diagonals_(sliced_off_diagonals<Real>(energy.K, workers)),
        coordinates_(4 * whole_slices(n_vertices_)),
        rotations_(4 * whole_slices(n_cells_)),
        volume_stiffness_(static_cast<Real>(energy.volume_stiffness)) {
    std::fill_n(coordinates_.data(), coordinates_.size(), Coordinate<Real>{0});
    if (energy.volume_stiffness > 0) measure_volumes(rest);
    reset_rotations();
    set_positions(rest);
    Positions residual;
    rest_energy_ = alignment() - find_residual(residual);
  }

  void set_positions(const Positions& positions) override {
    const double largest = store_positions(positions);
    if constexpr (std::is_same_v<Real, float>) {
      const double range = range_for(largest);
      if (range == range_) return;
      range_ = range;
      store_positions(positions);
    }
  }

  void set_rotations(const Rotations& rotations) override {
    parallel_for<kSliceRange * kSliceWidth>(workers_, n_cells_, [&](int begin, int end) {
      for (int c = begin; c < end; ++c) store_rotation(c, rotations[c]);
    });
    drop_stresses();
  }

  void reset_rotations() override {
    // Those that fill up the last slice too: they are fitted with the others.
    for (size_t c = 0; c < whole_slices(n_cells_); ++c) store_rotation(c, Eigen::Quaterniond::Identity());
    drop_stresses();
  }

  void read_rotations(Rotations& rotations) const override {
    rotations.resize(n_cells_);
    parallel_for<kSliceRange * kSliceWidth>(workers_, n_cells_, [&](int begin, int end) {
      for (int c = begin; c < end; ++c)
        rotations[c].coeffs() =
            Eigen::Vector4<Real>::Map(rotations_.data() + std::ptrdiff_t{4} * c).template cast<double>();
    });
  }

  void move_vertices(const std::vector<int>& vertices, const Positions& positions) override {
    double largest = 0;
    for (const int v : vertices) {
      const Eigen::RowVector3d place = positions.row(v);
      const double size =
          kernels_.store_positions(place.data(), 1, range_, coordinates_.data() + std::ptrdiff_t{4} * v);
      largest = largest > size ? largest : size + 0 * largest;  // not a number as soon as one is not
    }
    if (std::is_same_v<Real, float> && !(largest <= 0.99 * range_)) set_positions(positions);
  }

  void set_rotation(int cell, const Eigen::Quaterniond& rotation) override { store_rotation(cell, rotation); }

  [[nodiscard]] Eigen::Quaterniond rotation(int cell) const override {
    return Eigen::Quaterniond(
        Eigen::Vector4<Real>::Map(rotations_.data() + std::ptrdiff_t{4} * cell).template cast<double>());
  }

  double fit_rotations() override {
    alignments_.resize(n_ranges());
    terms_.find_covariances(view());
    workers_.run(n_ranges(), [&](int range) {
      alignments_[range] =
          terms_.fit_rotations(view(), volumes(), rotations_.data(), range_begin(range), range_begin(range + 1));
    });
    return std::accumulate(alignments_.begin(), alignments_.end(), 0.0);
  }

  [[nodiscard]] double alignment() override {
    terms_.find_covariances(view());
    return parallel_sum(
        workers_, terms_.n_cell_slices(), [&](int begin, int end) { return find_alignment(begin, end); },
        terms_.cell_range());
  }

  [[nodiscard]] double alignment_after(const std::vector<int>& cells) override {
    std::vector<int> ranges;
    ranges.reserve(cells.size());
    for (const int cell : cells) ranges.push_back(cell / kSliceWidth / terms_.cell_range());
    std::sort(ranges.begin(), ranges.end());
    ranges.erase(std::unique(ranges.begin(), ranges.end()), ranges.end());
    terms_.find_covariances(view());
    workers_.run(static_cast<int>(ranges.size()), [&](int k) {
      alignments_[ranges[k]] = find_alignment(range_begin(ranges[k]), range_begin(ranges[k] + 1));
    });
    return std::accumulate(alignments_.begin(), alignments_.end(), 0.0);
  }

  double find_residual(Positions& residual) const override {
    residual.resize(n_vertices_, 3);
    terms_.find_turns(rotations_.data(), stresses_.data());
    return parallel_sum<kSliceRange>(workers_, terms_.n_vertex_slices(), [&](int begin, int end) {
      return terms_.residual(off_diagonals_.view(), view(), rotations_.data(), stresses_.data(), residual.data(),
                             n_vertices_, begin, end);
    });
  }

  [[nodiscard]] double energy_rounding(double energy) const override {
    const double largest = std::max(rest_energy_, energy);
    // Single errors of cells have any sign, so those of a sum grow with the root of their number.
    constexpr auto kEpsilon = static_cast<double>(std::numeric_limits<Real>::epsilon());
    return std::is_same_v<Real, float> ? 4 * kEpsilon / std::sqrt(1.0 + n_cells_) * largest : 50 * kEpsilon * largest;
  }

  [[nodiscard]] double rest_energy() const override { return rest_energy_; }

 private:
  /// A power of two above it, and not by rounding only: `range` itself would be one unit too many. What is not finite
  /// has no range: then all differences are not a number either.
  static double range_for(double largest) {
    if (!std::isfinite(largest)) return std::numeric_limits<double>::quiet_NaN();
    int exponent = 0;
    std::frexp(largest / 0.99, &exponent);
    return std::ldexp(1.0, std::max(exponent, 0));
  }

  /// Returns the largest |coordinate|.
  double store_positions(const Positions& positions) {
    return parallel_reduce<kSliceRange * kSliceWidth>(
        workers_, n_vertices_, 0.0,
        [&](int begin, int end) {
          return kernels_.store_positions(positions.data() + std::ptrdiff_t{3} * begin, end - begin, range_,
                                          coordinates_.data() + std::ptrdiff_t{4} * begin);
        },
        [](double a, double b) { return a > b ? a : b + 0 * a; });
  }

  [[nodiscard]] PositionsView<Real> view() const {
    if constexpr (std::is_same_v<Real, float>)
      return {coordinates_.data(), static_cast<float>(range_ / kFixedPointUnits)};
    else
      return {coordinates_.data(), 1};
  }

  [[nodiscard]] VolumeView<Real> volumes() { return {double_volumes_.data(), volume_stiffness_, stresses_.data()}; }

  /// 2 V_c = tr(Q_c) / 3 at rest.
  void measure_volumes(const Positions& rest) {
    double_volumes_ = AlignedBuffer<Real>(whole_slices(n_cells_));
    stresses_ = AlignedBuffer<Real>(12 * whole_slices(n_cells_));
    std::fill_n(double_volumes_.data(), double_volumes_.size(), Real{0});
    const std::vector<double> traces = terms_.traces(rest, workers_);
    std::transform(traces.begin(), traces.end(), double_volumes_.data(),
                   [](double trace) { return static_cast<Real>(trace); });
  }

  void drop_stresses() { std::fill_n(stresses_.data(), stresses_.size(), Real{0}); }

  [[nodiscard]] int n_ranges() const {
    return (terms_.n_cell_slices() + terms_.cell_range() - 1) / terms_.cell_range();
  }
  /// The first slice of a range of cells.
  [[nodiscard]] int range_begin(int range) const {
    return std::min(range * terms_.cell_range(), terms_.n_cell_slices());
  }

  [[nodiscard]] double find_alignment(int begin, int end) {
    return terms_.alignment(view(), volumes(), rotations_.data(), begin, end);
  }

  void store_rotation(size_t c, const Eigen::Quaterniond& rotation) {
    Eigen::Vector4<Real>::Map(rotations_.data() + 4 * c) = rotation.coeffs().template cast<Real>();
  }

  int n_vertices_;
  int n_cells_;
  Workers workers_;
  const CellKernels<Real>& kernels_;
  mutable Terms<Real> terms_;                    ///< with what an iteration has found
  SlicedNumbers<Real> off_diagonals_;            ///< row: vertex j, index: vertex k other than j, value: -K_jk
  AlignedBuffer<Coordinate<Real>> coordinates_;  ///< (n, 4)
  double range_ = 1;                             ///< of fixed point
  AlignedBuffer<Real> rotations_;                ///< (n_cells, 4)
  Real volume_stiffness_;
  AlignedBuffer<Real> double_volumes_;  ///< (n_cells,) empty if volumes are free, as stresses are
  AlignedBuffer<Real> stresses_;        ///< (n_cells, 3, 4)
  std::vector<double> alignments_;      ///< of each range of cells, since fit_rotations()
  double rest_energy_ = 0;
};

template <class Real>
std::unique_ptr<CellPasses> make_passes(const CellEnergy& energy, const Cells& cells, const Positions& rest,
                                        const Workers& workers, Isa isa) {
  if (energy.cubes.empty()) return std::make_unique<CellPassesOf<Real, ListedTerms>>(energy, cells, rest, workers, isa);
  return std::make_unique<CellPassesOf<Real, CubeTerms>>(energy, cells, rest, workers, isa);
}

}  // namespace

std::unique_ptr<CellPasses> make_cell_passes(const CellEnergy& energy, const Cells& cells, const Positions& rest,
                                             Precision precision, const Workers& workers, Isa isa) {
  if (precision == Precision::kSingle) return make_passes<float>(energy, cells, rest, workers, isa);
  return make_passes<double>(energy, cells, rest, workers, isa);
}

namespace {

struct VertexHold {
  double stiffness;
  double longest_edge;
};

/// How stiffly its neighbours hold a vertex: the forces at it for a strain of 1, by the length of its longest
/// edge. Slivers have large weights on short edges and so change it little. 0 for loose vertices, NaN where weights are
/// not finite.
VertexHold vertex_hold(const CellEnergy& energy, const Positions& rest, int v) {
  double force = 0;
  double longest = 0;
  for (SparseMatrix::InnerIterator entry(energy.K, v); entry; ++entry) {
    if (entry.row() == v || entry.value() == 0) continue;
    const double length = (rest.row(entry.row()) - rest.row(v)).norm();
    force += std::abs(entry.value()) * length;
    longest = std::max(longest, length);
  }
  return {longest > 0 ? force / longest : force, longest};
}

}  // namespace

bool fits_single_precision(const CellEnergy& energy, const Positions& rest) {
  constexpr double kLargest = 1e12;
  constexpr double kSmallest = 1e-12;
  constexpr double kMostContrast = 100;
  constexpr double kShortest = 2e-5;  // of edges, which fixed point knows to a part in 20,000 then
  // Loose vertices may be anywhere. NaN is not near.
  if (rest.size() > 0 && !(rest.cwiseAbs().maxCoeff() <= kSinglePrecisionReach)) return false;
  std::vector<double> stiffnesses;
  std::vector<double> edges;
  for (int v = 0; v < energy.n_vertices(); ++v) {
    const VertexHold hold = vertex_hold(energy, rest, v);
    if (hold.stiffness == 0) continue;
    if (!(hold.stiffness > kSmallest && hold.stiffness < kLargest)) return false;
    stiffnesses.push_back(hold.stiffness);
    edges.push_back(hold.longest_edge);
  }
  if (stiffnesses.empty()) return true;
  // The softest one in a hundred stands for what has to bear the rounded forces in the stiffest part.
  const auto in_a_hundred = static_cast<std::ptrdiff_t>(stiffnesses.size() / 100);
  std::nth_element(stiffnesses.begin(), stiffnesses.begin() + in_a_hundred, stiffnesses.end());
  std::nth_element(edges.begin(), edges.begin() + in_a_hundred, edges.end());
  return edges[in_a_hundred] >= kShortest &&
         *std::max_element(stiffnesses.begin(), stiffnesses.end()) <= kMostContrast * stiffnesses[in_a_hundred];
}

}  // namespace arap
