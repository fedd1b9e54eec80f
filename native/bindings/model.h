// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <future>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "arap/cage_arap.h"
#include "arap/embedded_deformation.h"
#include "arap/lattice_arap.h"
#include "arap/poisson_editing.h"
#include "arap/surface_arap.h"
#include "arap/tet_arap.h"
#include "arap/vertex_properties.h"

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

/// Whether the vertices of its mesh may have properties.
template <typename Native>
constexpr bool kTakesProperties = std::is_constructible_v<Native, typename ClassOf<Native>::Mesh,
                                                          typename ClassOf<Native>::Options, arap::VertexProperties>;

/// What a model is bound to. The model keeps it, to be pickled.
template <typename Native>
struct Source {
  typename ClassOf<Native>::Mesh mesh;
  typename ClassOf<Native>::Options options;
  arap::VertexProperties properties;

  [[nodiscard]] Native bound(const arap::Progress& progress) const {
    if constexpr (kTakesProperties<Native>)
      return Native(mesh, options, properties, progress);
    else
      return Native(mesh, options, progress);
  }
};
template <>
struct Source<arap::CageArap> {
  arap::PolygonMesh mesh;
  arap::PolygonMesh cage;
  arap::CageArapOptions options;

  [[nodiscard]] arap::CageArap bound(const arap::Progress& progress) const { return {mesh, cage, options, progress}; }
};

/// How many parts a model would have with its seams joined, found when somebody asks: in a large mesh it takes a while.
template <typename Native>
std::shared_future<int> count_joined_parts(std::shared_ptr<const Source<Native>> source, const Native& model) {
  return std::async(std::launch::deferred,
                    [source = std::move(source), n_parts = model.n_parts(), threads = model.threads()] {
                      if constexpr (requires { source->options.join_seams; })
                        if (source->options.join_seams) return n_parts;
                      // A void counts with the shell around it.
                      if constexpr (requires { Native::n_parts_joined(source->mesh, threads); })
                        return Native::n_parts_joined(source->mesh, threads);
                      else
                        return source->mesh.n_parts_joined(threads);
                    })
      .share();
}

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

  arap::ConstraintSet constraints;  ///< the current ones; of no targets: there are none
  std::shared_future<int> n_parts_joined;
  std::atomic<int> n_targets = 0;
  std::atomic<int> n_parts_at_rest = 0;
  std::atomic<bool> is_busy = false;

 protected:
  explicit Model(std::shared_future<int> parts_joined) : n_parts_joined(std::move(parts_joined)) {}
};

template <typename Native>
class ModelOf final : public Model {
 public:
  ModelOf(const std::shared_ptr<const Source<Native>>& from, Native bound)
      : Model(count_joined_parts(from, bound)), source(from), native(std::move(bound)) {}

  void set_constraints(const arap::ConstraintSet& set, const arap::Progress& progress) override {
    arap::ConstraintSet copy = set;
    native.set_constraints(set, progress);
    constraints = std::move(copy);
    n_targets = set.n_targets();
    n_parts_at_rest = native.n_parts_at_rest();
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

  std::shared_ptr<const Source<Native>> source;
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
