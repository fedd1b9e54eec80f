// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "arap/types.h"
#include "base/aligned_buffer.h"
#include "kernels/kernels.h"
#include "parallel/meter.h"
#include "parallel/parallel.h"
#include "parallel/workers.h"
#include "wrap/anchor_maps.h"
#include "wrap/anchor_search.h"
#include "wrap/surface_at_rest.h"
#include "wrap/surface_levels.h"
#include "wrap/surface_sides.h"

namespace arap {

/// Points that a surface carries: their anchors, weights and rigid pieces. The similarity that fits the surface's
/// motion best moves them in double; single precision carries what it leaves.
class WrapPoints {
 public:
  /// As WrapDeformation's.
  WrapPoints(const SurfaceAtRest& surface, const Positions& points, int n_anchors, bool stay_outside,
             const std::vector<int>& piece_of_point, int requested_threads, const MeterPart& meter);

  [[nodiscard]] int size() const { return static_cast<int>(rest_.rows()); }
  [[nodiscard]] int n_surface_vertices() const { return n_surface_vertices_; }
  [[nodiscard]] int n_pieces() const { return n_pieces_; }
  [[nodiscard]] const Workers& workers() const { return workers_; }

  /// The vertices of the surface that the points hang on.
  [[nodiscard]] const std::vector<int>& used() const { return used_; }

  /// Calls put(point, place) for all points.
  /// @param moved  (n, 3) of used()
  template <class Put>
  void deform(const Positions& moved, const Put& put) const {
    const Frame frame = frame_of(moved);
    const WrapKernels& own = kernels(isa_).wrap;
    AlignedBuffer<float> maps(maps_.n_numbers());
    maps_.find(own, frame.displacements, workers_, maps);
    const double growth = sides_.growth(frame.displacements);
    Positions bent(in_pieces_.size(), 3);
    parallel_for<kRange>(workers_, size(), [&](int begin, int end) {
      Moves moves;
      own.move_points(offsets_.data(), weights_.data(), maps.data(), single_rest_.data(), moves.data(), begin, end);
      if (frame.unit == 1) sides_.push(own, frame.displacements, growth, moves.data(), begin, end);
      for (int p = begin; p < end; ++p) {
        const Vector3 move = Eigen::Vector3f::Map(&moves[4 * static_cast<size_t>(p - begin)]).template cast<double>();
        const Vector3 place = frame.linear * (rest_.row(p).transpose() + frame.unit * move) + frame.shift;
        if (place_in_pieces_.empty() || place_in_pieces_[p] < 0)
          put(p, place);
        else
          bent.row(place_in_pieces_[p]) = place.transpose();
      }
    });
    put_pieces(bent, frame.rotation, put);
  }

 private:
  static constexpr int kRange = 512;  ///< of points
  using Moves = std::array<float, size_t{4} * kRange>;

  /// A pose of the surface, seen from where its best fitting similarity leaves everything at rest.
  struct Frame {
    Matrix3 rotation;
    Matrix3 linear;  ///< with shift it leaves there
    Vector3 shift;
    double unit = 1;                      ///< of the displacements: what single precision can hold
    AlignedBuffer<double> displacements;  ///< (n, 4) of used_, the last number 0
  };

  /// @return  the anchors that the weights name
  std::vector<AnchorMaps::Node> set_weights(const SurfaceLevels& levels, const std::vector<AnchorLists>& lists);
  [[nodiscard]] Frame frame_of(const Positions& moved) const;
  void set_pieces(const Positions& points, const std::vector<int>& piece_of_point);
  struct Rigid {
    Matrix3 rotation;
    Vector3 from;
    Vector3 to;
  };
  /// The best one of a piece.
  /// @param turn  of the surface as a whole: where the piece does not tell
  [[nodiscard]] Rigid rigid_motion(int piece, const Positions& bent, const Matrix3& turn) const;

  template <class Put>
  void put_pieces(const Positions& bent, const Matrix3& turn, const Put& put) const {
    for (int piece = 0; piece < n_pieces_; ++piece) {
      const Rigid motion = rigid_motion(piece, bent, turn);
      parallel_for(workers_, piece_offsets_[piece + 1] - piece_offsets_[piece], [&](int begin, int end) {
        for (int k = piece_offsets_[piece] + begin; k < piece_offsets_[piece] + end; ++k) {
          const int p = in_pieces_[k];
          put(p, Vector3(motion.rotation * (input_rest_.row(k).transpose() - motion.from) + motion.to));
        }
      });
    }
  }

  int n_surface_vertices_;
  int n_pieces_ = 0;
  Workers workers_;
  double size_;  ///< of the surface
  Isa isa_ = choose_isa();
  Positions rest_;                  ///< (n, 3) of the points: centred, the surface of diagonal 1
  std::vector<float> single_rest_;  ///< (n, 4) the same, and 1
  std::vector<int> used_;           ///< vertices of the surface
  AnchorMaps maps_;
  SurfaceSides sides_;
  Positions used_rest_;      ///< (n, 3) of used_
  std::vector<int> fitted_;  ///< some of used_, which tell the similarity
  Vector3 fitted_mean_;
  double fitted_square_ = 0;  ///< sum of the squared distances from there
  std::vector<int> offsets_;  ///< of each point, in weights_
  std::vector<AnchorWeight> weights_;
  std::vector<int> in_pieces_;         ///< points of pieces, those of a piece one after the other
  std::vector<int> piece_offsets_{0};  ///< of each piece, in in_pieces_
  std::vector<int> place_in_pieces_;   ///< of each point, in in_pieces_, or -1; empty without pieces
  Positions input_rest_;               ///< of in_pieces_, as given
};

}  // namespace arap
