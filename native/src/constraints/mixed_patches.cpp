// SPDX-License-Identifier: GPL-3.0-or-later
#include "constraints/mixed_patches.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <utility>

namespace arap {

MixedPatches::MixedPatches(const RigidRegions& regions, const std::vector<LinearRow>& patches,
                           const ConstrainedSystem& system) {
  for (int p = 0; p < std::ssize(patches); ++p)
    if (regions.has_member(patches[p])) patches_.push_back(p);
  if (patches_.empty()) return;
  Responses of_unknowns = system.responses(patches_);
  responses_ = std::move(of_unknowns.steps);
  stiffness_ = std::move(of_unknowns.stiffness);
  for (int v = 0; v < static_cast<int>(responses_.rows()); ++v)
    if (const int unknown = regions.unknown_of(v); unknown != v) responses_.row(v) = responses_.row(unknown);
  for (int r = 0; r < regions.size(); ++r) {
    std::vector<Lever>& levers = levers_.emplace_back();
    for (size_t k = 0; k < patches_.size(); ++k)
      levers.push_back(
          {regions.arm_of(r, patches[patches_[k]]), regions.pull_along(r, responses_.col(static_cast<int>(k)))});
  }
}

Positions MixedPatches::pulls(const Positions& residual) const { return responses_.transpose() * residual; }

Matrix3 MixedPatches::linear_term(int region, const Matrix3& rotation, const Positions& gaps,
                                  const Positions& pulls) const {
  const std::vector<Lever>& levers = levers_[region];
  Positions unturned = gaps;  // h
  for (std::ptrdiff_t p = 0; p < std::ssize(levers); ++p) unturned.row(p) += (rotation * levers[p].arm).transpose();
  const Positions held = stiffness_ * unturned;
  Matrix3 L = Matrix3::Zero();
  for (std::ptrdiff_t p = 0; p < std::ssize(levers); ++p) {
    const Vector3 pull = pulls.row(p).transpose() - rotation * levers[p].pull - held.row(p).transpose();
    L += pull * levers[p].arm.transpose() - unturned.row(p).transpose() * levers[p].pull.transpose();
  }
  return L;
}

bool MixedPatches::feels(int region) const {
  return std::any_of(levers_[region].begin(), levers_[region].end(),
                     [](const Lever& lever) { return !lever.arm.isZero(0); });
}

void MixedPatches::follow_turn(int region, const Matrix3& change, Positions& pulls) const {
  const std::vector<Lever>& levers = levers_[region];
  for (std::ptrdiff_t p = 0; p < std::ssize(levers); ++p) pulls.row(p) += (change * levers[p].pull).transpose();
}

void MixedPatches::close(const Positions& gaps, Positions& pulls, Positions& positions) const {
  positions.noalias() += responses_ * gaps;
  pulls -= stiffness_ * gaps;
}

}  // namespace arap
