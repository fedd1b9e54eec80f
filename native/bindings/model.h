// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <memory>
#include <stdexcept>
#include <utility>

#include "arap/surface_arap.h"

namespace arap_native {

/// A SurfaceArap, and whether it is at work.
struct Model {
  explicit Model(arap::SurfaceArap bound) : solver(std::move(bound)) {}

  arap::SurfaceArap solver;
  std::atomic<int> n_targets = 0;
  std::atomic<bool> is_busy = false;
};

/// One call at a time on one object; a second one is refused, for waiting could take for ever (below a callback).
class Turn {
 public:
  explicit Turn(std::shared_ptr<Model> model) : model_(std::move(model)) {
    if (model_->is_busy.exchange(true)) {
      model_ = nullptr;
      throw std::runtime_error(
          "this SurfaceArap is at work in a job, in another thread or below its own progress callback: wait until that "
          "has ended, or use one SurfaceArap per thread");
    }
  }
  ~Turn() {
    if (model_ != nullptr) model_->is_busy = false;
  }
  Turn(Turn&&) noexcept = default;
  Turn& operator=(Turn&&) = delete;
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;

  Model& operator*() const { return *model_; }

 private:
  std::shared_ptr<Model> model_;
};

}  // namespace arap_native
