// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "support/helpers.h"
#include "support/meshes.h"

namespace arap_test {

/// A model of any kind, for what all of them promise.
class AnyModel {
 public:
  AnyModel() = default;
  AnyModel(const AnyModel&) = delete;
  AnyModel& operator=(const AnyModel&) = delete;
  virtual ~AnyModel() = default;

  virtual void set_constraints(const arap::ConstraintSet& constraints) = 0;
  virtual arap::SolveResult solve(const Positions& targets, const arap::SolveOptions& options) = 0;
  virtual void set_positions(const Positions& positions) = 0;
  [[nodiscard]] virtual Positions positions() const = 0;
};

/// A kind of models, and a small mesh for it.
struct KindOfModel {
  std::string name;
  Positions rest;
  bool has_inside = false;  ///< so it takes segments
  std::function<std::unique_ptr<AnyModel>(int threads)> bind;
};

/// All that pose a mesh by its vertices.
std::vector<KindOfModel> kinds_of_models();

/// The low end along x stays, the far end moves, and so does a patch in the middle; with an inside a bone, too.
Task pull_on(const KindOfModel& kind, const RigidMotion& motion, double strength = 1);

}  // namespace arap_test
