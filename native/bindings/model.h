// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "arap/cage_arap.h"
#include "arap/embedded_deformation.h"
#include "arap/lattice_arap.h"
#include "arap/poisson_editing.h"
#include "arap/surface_arap.h"
#include "arap/tet_arap.h"

namespace arap_native {

/// What Python must know of a model's class.
template <typename Native>
struct ClassOf;
template <>
struct ClassOf<arap::SurfaceArap> {
  using Mesh = arap::PolygonMesh;
  using Options = arap::Options;
  static constexpr const char* kName = "SurfaceArap";
};
template <>
struct ClassOf<arap::LatticeArap> {
  using Mesh = arap::PolygonMesh;
  using Options = arap::LatticeOptions;
  static constexpr const char* kName = "LatticeArap";
};
template <>
struct ClassOf<arap::PoissonEditing> {
  using Mesh = arap::PolygonMesh;
  using Options = arap::PoissonOptions;
  static constexpr const char* kName = "PoissonEditing";
};
template <>
struct ClassOf<arap::EmbeddedDeformation> {
  using Mesh = arap::PolygonMesh;
  using Options = arap::EmbeddedOptions;
  static constexpr const char* kName = "EmbeddedDeformation";
};
template <>
struct ClassOf<arap::CageArap> {
  using Mesh = arap::PolygonMesh;
  using Options = arap::CageArapOptions;
  static constexpr const char* kName = "CageArap";
};
template <>
struct ClassOf<arap::TetArap> {
  using Mesh = arap::TetMesh;
  using Options = arap::TetOptions;
  static constexpr const char* kName = "TetArap";
};

/// A bound model of any class, and whether it is at work.
class Model {
 public:
  virtual ~Model() = default;
  Model(const Model&) = delete;
  Model& operator=(const Model&) = delete;

  virtual void set_constraints(const arap::ConstraintSet& set, const arap::Progress& progress) = 0;
  virtual arap::SolveResult solve(const arap::Positions& targets, const arap::SolveOptions& options,
                                  std::span<const arap::Matrix3> rotations, const arap::Progress& progress,
                                  std::span<float> out) = 0;
  virtual void reset() = 0;
  virtual void set_positions(const arap::Positions& positions) = 0;
  [[nodiscard]] virtual arap::Positions positions() const = 0;
  [[nodiscard]] virtual int n_factorizations() const = 0;

  // Fixed at bind: these may be read at any time.
  [[nodiscard]] virtual int n_vertices() const = 0;
  [[nodiscard]] virtual int n_parts() const = 0;
  [[nodiscard]] virtual int threads() const = 0;
  [[nodiscard]] virtual const std::vector<int>& part_of_vertex() const = 0;
  [[nodiscard]] virtual const std::vector<int>& loose_vertices() const = 0;
  [[nodiscard]] virtual const char* class_name() const = 0;

  std::atomic<int> n_targets = 0;
  std::atomic<bool> is_busy = false;

 protected:
  Model() = default;
};

template <typename Native>
class ModelOf final : public Model {
 public:
  explicit ModelOf(Native bound) : native(std::move(bound)) {}

  void set_constraints(const arap::ConstraintSet& set, const arap::Progress& progress) override {
    native.set_constraints(set, progress);
    n_targets = set.n_targets();
  }
  arap::SolveResult solve(const arap::Positions& targets, const arap::SolveOptions& options,
                          std::span<const arap::Matrix3> rotations, const arap::Progress& progress,
                          std::span<float> out) override {
    return native.solve(targets, options, rotations, progress, out);
  }
  void reset() override { native.reset(); }
  void set_positions(const arap::Positions& positions) override { native.set_positions(positions); }
  [[nodiscard]] arap::Positions positions() const override { return native.positions(); }
  [[nodiscard]] int n_factorizations() const override { return native.n_factorizations(); }
  [[nodiscard]] int n_vertices() const override { return native.n_vertices(); }
  [[nodiscard]] int n_parts() const override { return native.n_parts(); }
  [[nodiscard]] int threads() const override { return native.threads(); }
  [[nodiscard]] const std::vector<int>& part_of_vertex() const override { return native.part_of_vertex(); }
  [[nodiscard]] const std::vector<int>& loose_vertices() const override { return native.loose_vertices(); }
  [[nodiscard]] const char* class_name() const override { return ClassOf<Native>::kName; }

  Native native;
};

/// One call at a time on one object; a second one is refused, for waiting could take for ever (below a callback).
template <typename AnyModel>
class Turn {
 public:
  explicit Turn(std::shared_ptr<AnyModel> model) : model_(std::move(model)) {
    if (model_->is_busy.exchange(true)) {
      const std::string name = model_->class_name();
      model_ = nullptr;
      throw std::runtime_error(
          "this " + name +
          " is at work in a job, in another thread or below its own progress callback: wait until that has ended, or "
          "use one " +
          name + " per thread");
    }
  }
  ~Turn() {
    if (model_ != nullptr) model_->is_busy = false;
  }
  Turn(Turn&&) noexcept = default;
  Turn& operator=(Turn&&) = delete;
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;

  AnyModel& operator*() const { return *model_; }

 private:
  std::shared_ptr<AnyModel> model_;
};

}  // namespace arap_native
