// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <functional>

#include "optimize/local_global.h"

namespace arap {

/// The softest directions of the energy, beside the factorized matrix A: those that global steps leave nearly whole.
/// All other cells turn along where a cell turns, so they are looked for among what global steps make of turns that
/// are constant or linear in the rest positions. With orthonormal directions u_k of the stiffnesses t_k = <u_k, H u_k>
/// (Rayleigh-Ritz; H the Hessian, t of all directions in [0, 1]) the pose is about sum_k u_k <u_k, r> / t_k from the
/// minimum along them, r = -grad E: forces that are too small to be seen in a step, divided by what they work against.
class SoftDirections {
 public:
  using MayGoOn = std::function<bool()>;

  explicit SoftDirections(LocalGlobal& steps) : steps_(steps) {}

  void forget() {
    is_whole_ = false;
    n_tried_ = 0;
  }

  /// Finds them at a pose that is fitted, and stays so. Does one turn at least; false if may_go_on() then said no, and
  /// another call goes on.
  [[nodiscard]] bool find(const Pose& pose, const MayGoOn& may_go_on);

  /// By which angle cells have turned since they were found, root mean square; infinity before.
  [[nodiscard]] double turned() const;

  /// Along them, by the residual at hand: the largest movement of a vertex to the minimum.
  [[nodiscard]] double distance() const;

 private:
  /// Of a turn: the axis, and the rest coordinate it grows with.
  static constexpr int kTurns = 12;

  void begin(Rotations rotations);
  /// What a global step makes of a turn is one of the columns; the moved pose is any afterwards.
  void try_turn(int turn, const Pose& pose, const Positions& force, const Positions& free_force);
  void choose();
  /// The products of the first columns with a residual.
  [[nodiscard]] Eigen::VectorXd products(int n_columns, const Positions& residual) const;
  [[nodiscard]] double turned_from(const Rotations& rotations) const;

  LocalGlobal& steps_;
  bool is_whole_ = false;
  int n_tried_ = 0;             ///< turns
  int n_ = 0;                   ///< columns that count
  Eigen::MatrixXf columns_;     ///< (3 n, kTurns), each a direction
  Eigen::MatrixXd stiffness_;   ///< of H between columns, before they are chosen
  Eigen::MatrixXd norm_;        ///< of A
  Eigen::VectorXd compliance_;  ///< 1 / t
  Rotations rotations_;         ///< of the cells, where they were found
};

}  // namespace arap
