// SPDX-License-Identifier: GPL-3.0-or-later
#include "bound_model.h"

#include <span>
#include <vector>

#include "docstrings.h"

namespace arap_native {

namespace {

template <typename Work>
std::invoke_result_t<Work, Model&> exclusively(const std::shared_ptr<Model>& model, const Work& work) {
  const Turn turn(model);
  const WithoutGil no_gil;
  return work(*turn);
}

}  // namespace

/// What a solve is called with. Holds no Python object: whoever solves keeps `out` alive.
class BoundModel::SolveInput {
 public:
  SolveInput(const Model& model, const py::object& targets, const arap::SolveOptions* options,
             const py::object& rotations, const py::object& out) {
    // Without constraints the library says so; any number of rows is as good then.
    const int n_targets = model.n_targets;
    const Extent rows = n_targets > 0 ? Extent(n_targets) : Extent("k + n_patches + 4 n_segments");
    targets_ = positions_from(targets, "targets", rows,
                              "one row per constrained vertex, then one per patch, then four per segment");
    if (options != nullptr) options_ = *options;
    rotations_ = rotations_from(rotations, rows);
    out_ = out_from(out, model.n_vertices());
  }

  [[nodiscard]] arap::SolveResult solve(Model& model, const arap::Progress& progress) const {
    return model.solve(targets_, options_, rotations_, progress, out_);
  }

 private:
  arap::Positions targets_;
  arap::SolveOptions options_;
  std::vector<arap::Matrix3> rotations_;
  std::span<float> out_;
};

void BoundModel::set_constraints(const arap::ConstraintSet& set, py::object progress) {
  ProgressCall call(std::move(progress));
  exclusively(model_, [&](Model& model) { model.set_constraints(set, call.function()); });
}

std::unique_ptr<JobHandle> BoundModel::begin_set_constraints(Jobs& jobs, arap::ConstraintSet set) {
  return begin_job(
      jobs,
      [turn = Turn(model_), set = std::move(set)](const arap::Progress& progress) {
        (*turn).set_constraints(set, progress);
        return true;
      },
      [](bool) { return py::none(); });
}

SolveResult BoundModel::solve(const py::object& targets, const arap::SolveOptions* options, const py::object& rotations,
                              py::object progress, const py::object& out) {
  const SolveInput input(*model_, targets, options, rotations, out);
  ProgressCall call(std::move(progress));
  return {exclusively(model_, [&](Model& model) { return input.solve(model, call.function()); }), out};
}

std::unique_ptr<JobHandle> BoundModel::begin_solve(Jobs& jobs, const py::object& targets,
                                                   const arap::SolveOptions* options, const py::object& rotations,
                                                   const py::object& out) {
  return begin_job(
      jobs,
      [input = SolveInput(*model_, targets, options, rotations, out),
       turn = Turn(model_)](const arap::Progress& progress) { return input.solve(*turn, progress); },
      [out](arap::SolveResult result) { return py::cast(SolveResult(std::move(result), out)); }, out);
}

void BoundModel::reset() {
  exclusively(model_, [](Model& model) { model.reset(); });
}

void BoundModel::set_positions(const py::object& positions) {
  const arap::Positions points = points_from(positions);
  exclusively(model_, [&](Model& model) { model.set_positions(points); });
}

py::array BoundModel::positions() const {
  return to_array(exclusively(model_, [](Model& model) { return model.positions(); }));
}

int BoundModel::n_factorizations() const {
  return exclusively(model_, [](Model& model) { return model.n_factorizations(); });
}

std::string BoundModel::repr() const {
  return py::str("<{}: {} vertices, {} {}, {} {}>")
      .format(model_->class_name(), n_vertices(), n_parts(), n_parts() == 1 ? "part" : "parts", threads(),
              threads() == 1 ? "thread" : "threads");
}

void bind_model(py::module_& m, const std::shared_ptr<Jobs>& jobs) {
  const py::object none = py::none();
  using Object = const py::object&;
  py::class_<BoundModel>(m, "Model", docstrings::Model)
      .def(
          "set_constraints",
          [](BoundModel& model, Object vertices, Object strengths, Object patches, Object segments,
             py::object progress) {
            model.set_constraints(constraints_from(vertices, strengths, patches, segments), std::move(progress));
          },
          docstrings::Model_set_constraints, py::arg("vertices"), py::arg("strengths") = none,
          py::arg("patches") = none, py::arg("segments") = none, py::kw_only(), py::arg("progress") = none)
      .def(
          "begin_set_constraints",
          [jobs](BoundModel& model, Object vertices, Object strengths, Object patches, Object segments) {
            return model.begin_set_constraints(*jobs, constraints_from(vertices, strengths, patches, segments));
          },
          docstrings::Model_begin_set_constraints, py::arg("vertices"), py::arg("strengths") = none,
          py::arg("patches") = none, py::arg("segments") = none)
      .def("solve", &BoundModel::solve, docstrings::Model_solve, py::arg("targets"), py::arg("options") = none,
           py::kw_only(), py::arg("rotations") = none, py::arg("progress") = none, py::arg("out") = none)
      .def(
          "begin_solve",
          [jobs](BoundModel& model, Object targets, const arap::SolveOptions* options, Object rotations, Object out) {
            return model.begin_solve(*jobs, targets, options, rotations, out);
          },
          docstrings::Model_begin_solve, py::arg("targets"), py::arg("options") = none, py::kw_only(),
          py::arg("rotations") = none, py::arg("out") = none)
      .def("reset", &BoundModel::reset, docstrings::Model_reset)
      .def("set_positions", &BoundModel::set_positions, docstrings::Model_set_positions, py::arg("positions"))
      .def_property_readonly("positions", &BoundModel::positions, docstrings::Model_positions)
      .def_property_readonly("n_vertices", &BoundModel::n_vertices, docstrings::Model_n_vertices)
      .def_property_readonly("n_parts", &BoundModel::n_parts, docstrings::Model_n_parts)
      .def_property_readonly("part_of_vertex", &BoundModel::part_of_vertex, docstrings::Model_part_of_vertex)
      .def_property_readonly("loose_vertices", &BoundModel::loose_vertices, docstrings::Model_loose_vertices)
      .def_property_readonly("n_factorizations", &BoundModel::n_factorizations, docstrings::Model_n_factorizations)
      .def_property_readonly("threads", &BoundModel::threads, docstrings::Model_threads)
      .def("__repr__", &BoundModel::repr);
}

}  // namespace arap_native
