// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "arrays.h"
#include "data.h"
#include "gil.h"
#include "inputs.h"
#include "job_handle.h"
#include "model.h"
#include "progress_call.h"
#include "result.h"
#include "signature.h"

namespace arap_native {

namespace py = pybind11;

/// A model for Python: checks arrays, then works without the GIL.
class BoundModel {
 public:
  void set_constraints(const arap::ConstraintSet& set, py::object progress);
  std::unique_ptr<JobHandle> begin_set_constraints(Jobs& jobs, arap::ConstraintSet set);
  SolveResult solve(const py::object& targets, const arap::SolveOptions* options, const py::object& rotations,
                    py::object progress, const py::object& out);
  std::unique_ptr<JobHandle> begin_solve(Jobs& jobs, const py::object& targets, const arap::SolveOptions* options,
                                         const py::object& rotations, const py::object& out);
  void reset();
  void set_positions(const py::object& positions);
  [[nodiscard]] py::array positions() const;
  [[nodiscard]] int n_factorizations() const;

  // Fixed at bind: these may be read at any time.
  [[nodiscard]] py::ssize_t n_vertices() const { return model_->n_vertices(); }
  [[nodiscard]] int n_parts() const { return model_->n_parts(); }
  [[nodiscard]] int threads() const { return model_->threads(); }
  [[nodiscard]] py::array part_of_vertex() const { return to_array(model_->part_of_vertex()); }
  [[nodiscard]] py::array loose_vertices() const { return to_array(model_->loose_vertices()); }
  [[nodiscard]] int n_parts_joined() const;
  [[nodiscard]] std::string repr() const;

  /// What has happened since the bind, for pickles: constraints and positions.
  [[nodiscard]] py::tuple state() const;

  [[nodiscard]] arap::Positions points_from(const py::object& positions) const {
    return positions_from(positions, "positions", n_vertices(), "one row per vertex");
  }

 protected:
  explicit BoundModel(std::shared_ptr<Model> model) : model_(std::move(model)) {}

 private:
  class SolveInput;

  std::shared_ptr<Model> model_;
};

/// A model of one class.
template <typename Native>
class BoundAs : public BoundModel {
 public:
  explicit BoundAs(std::shared_ptr<ModelOf<Native>> model) : BoundModel(model), model_(std::move(model)) {}

  static std::unique_ptr<BoundAs> bind(BindInput<Native> input, py::object progress) {
    ProgressCall call(std::move(progress));
    const WithoutGil no_gil;
    return std::make_unique<BoundAs>(arap_native::bind(input, call.function()));
  }

  static std::unique_ptr<JobHandle> begin_bind(Jobs& jobs, BindInput<Native> input) {
    return begin_job(
        jobs,
        [input = std::move(input)](const arap::Progress& progress) mutable {
          return arap_native::bind(input, progress);
        },
        [](std::shared_ptr<ModelOf<Native>> model) { return py::cast(std::make_unique<BoundAs>(std::move(model))); });
  }

  /// Has the model for itself as long as this lives.
  [[nodiscard]] Turn<ModelOf<Native>> turn() const { return Turn<ModelOf<Native>>(model_); }

  template <typename Work>
  [[nodiscard]] std::invoke_result_t<Work, Native&> exclusively(const Work& work) const {
    const auto model = turn();
    const WithoutGil no_gil;
    return work((*model).native);
  }

  // What is fixed at bind.
  [[nodiscard]] const Native& native() const { return model_->native; }
  [[nodiscard]] const Source<Native>& source() const { return *model_->source; }

 private:
  std::shared_ptr<ModelOf<Native>> model_;
};

/// What a model is bound by, by the names of its constructor.
template <typename Native>
py::dict arguments_of(const Source<Native>& source) {
  py::dict arguments = arguments_of(source.mesh);
  arguments["options"] = source.options;
  add_arguments(source.properties, arguments);
  return arguments;
}
inline py::dict arguments_of(const Source<arap::CageArap>& source) {
  py::dict arguments = arguments_of(source.mesh);
  arguments["options"] = source.options;
  arguments["cage"] = tuple_of(source.cage);
  return arguments;
}

/// Adds what a model is pickled by, a call of its class and its state.
template <typename Native>
void def_pickle(py::class_<BoundAs<Native>, BoundModel>& type) {
  def(type, "__reduce__(self)", [](const py::object& self) {
    const auto& model = converted<const BoundAs<Native>&>(self, "self");
    return rebuilt_by(self, arguments_of(model.source()), model.state());
  });
}

/// Adds a model's class to the module, with the two ways to bind one.
/// @param arrays_from  makes its mesh's arrays of the first arguments
template <typename Native, typename... Given>
py::class_<BoundAs<Native>, BoundModel> bind_class(py::module_& m, const std::shared_ptr<Jobs>& jobs, const char* doc,
                                                   const char* init_doc, const char* begin_bind_doc,
                                                   typename BindInput<Native>::Arrays (*arrays_from)(Given...)) {
  using Object = const py::object&;
  using Options = typename ClassOf<Native>::Options;
  py::class_<BoundAs<Native>, BoundModel> type(m, ClassOf<Native>::kName, doc);
  if constexpr (!kTakesProperties<Native>) {
    def_init(type, init_doc, [arrays_from](Given... mesh, const Options* options, Object progress) {
      return BoundAs<Native>::bind({arrays_from(mesh...), options}, progress);
    });
    def_static(type, begin_bind_doc, [jobs, arrays_from](Given... mesh, const Options* options) {
      return BoundAs<Native>::begin_bind(*jobs, {arrays_from(mesh...), options});
    });
  } else {
    def_init(
        type, init_doc,
        [arrays_from](Given... mesh, const Options* options, Object stiffness, Object rigid_regions, Object progress) {
          return BoundAs<Native>::bind({arrays_from(mesh...), options, stiffness, rigid_regions}, progress);
        });
    def_static(type, begin_bind_doc,
               [jobs, arrays_from](Given... mesh, const Options* options, Object stiffness, Object rigid_regions) {
                 return BoundAs<Native>::begin_bind(*jobs, {arrays_from(mesh...), options, stiffness, rigid_regions});
               });
  }
  def_pickle(type);
  return type;
}

/// The same for a model of polygons.
template <typename Native>
py::class_<BoundAs<Native>, BoundModel> bind_polygon_class(py::module_& m, const std::shared_ptr<Jobs>& jobs,
                                                           const char* doc, const char* init_doc,
                                                           const char* begin_bind_doc) {
  return bind_class<Native>(m, jobs, doc, init_doc, begin_bind_doc, &mesh_from);
}

/// Adds the energy of a model that tells it.
template <typename Native>
void def_energy(py::class_<BoundAs<Native>, BoundModel>& type, const char* energy_doc, const char* gradient_doc) {
  using Bound = BoundAs<Native>;
  def(type, energy_doc, [](const Bound& model, const py::object& positions) {
    const arap::Positions points = model.points_from(positions);
    return model.exclusively([&](Native& native) { return native.energy(points); });
  });
  def(type, gradient_doc, [](const Bound& model, const py::object& positions) {
    const arap::Positions points = model.points_from(positions);
    return to_array(model.exclusively([&](Native& native) { return native.energy_gradient(points); }));
  });
}

/// Adds Model, what all classes of models have in common.
void bind_model(py::module_& m, const std::shared_ptr<Jobs>& jobs);

/// Each adds its class.
void bind_surface_arap(py::module_& m, const std::shared_ptr<Jobs>& jobs);
void bind_lattice_arap(py::module_& m, const std::shared_ptr<Jobs>& jobs);
void bind_poisson_editing(py::module_& m, const std::shared_ptr<Jobs>& jobs);
void bind_embedded_deformation(py::module_& m, const std::shared_ptr<Jobs>& jobs);
void bind_cage_arap(py::module_& m, const std::shared_ptr<Jobs>& jobs);
void bind_tet_arap(py::module_& m, const std::shared_ptr<Jobs>& jobs);

}  // namespace arap_native
