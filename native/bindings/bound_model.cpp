// SPDX-License-Identifier: GPL-3.0-or-later
#include "bound_model.h"

#include <span>
#include <utility>
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
  return {exclusively(model_, [&](Model& model) { return input.solve(model, call.function()); }), out, n_parts(),
          model_->n_parts_joined};
}

std::unique_ptr<JobHandle> BoundModel::begin_solve(Jobs& jobs, const py::object& targets,
                                                   const arap::SolveOptions* options, const py::object& rotations,
                                                   const py::object& out) {
  return begin_job(
      jobs,
      [input = SolveInput(*model_, targets, options, rotations, out),
       turn = Turn(model_)](const arap::Progress& progress) { return input.solve(*turn, progress); },
      [out, n_parts = n_parts(), joined = model_->n_parts_joined](arap::SolveResult result) {
        return py::cast(SolveResult(std::move(result), out, n_parts, joined));
      },
      out);
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
  const int n_at_rest = model_->n_parts_at_rest;
  return py::str("<{}: {} vertices, {}, {}, {} {}>")
      .format(model_->class_name(), n_vertices(), parts_text(n_parts(), model_->n_parts_joined),
              model_->n_targets == 0 ? "no constraints" : std::to_string(n_at_rest) + " at rest", threads(),
              threads() == 1 ? "thread" : "threads");
}

int BoundModel::n_parts_joined() const {
  const WithoutGil no_gil;
  return model_->n_parts_joined.get();
}

py::tuple BoundModel::state() const {
  auto [set, positions] =
      exclusively(model_, [](Model& model) { return std::pair(model.constraints, model.positions()); });
  py::object constraints = py::none();
  if (set.n_targets() > 0) constraints = tuple_of(set);
  return py::make_tuple(constraints, to_array(std::move(positions)));
}

void bind_model(py::module_& m, const std::shared_ptr<Jobs>& jobs) {
  using Object = const py::object&;
  using Options = const arap::SolveOptions*;
  py::class_<BoundModel> type(m, "Model", docstrings::Model);
  def(type, docstrings::Model_set_constraints,
      [](BoundModel& model, Object vertices, Object strengths, Object patches, Object segments, Object progress) {
        model.set_constraints(constraints_from(vertices, strengths, patches, segments), progress);
      });
  def(type, docstrings::Model_begin_set_constraints,
      [jobs](BoundModel& model, Object vertices, Object strengths, Object patches, Object segments) {
        return model.begin_set_constraints(*jobs, constraints_from(vertices, strengths, patches, segments));
      });
  def(type, docstrings::Model_solve,
      [](BoundModel& model, Object targets, Options options, Object rotations, Object progress, Object out) {
        return model.solve(targets, options, rotations, progress, out);
      });
  def(type, docstrings::Model_begin_solve,
      [jobs](BoundModel& model, Object targets, Options options, Object rotations, Object out) {
        return model.begin_solve(*jobs, targets, options, rotations, out);
      });
  def(type, docstrings::Model_reset, [](BoundModel& model) { model.reset(); });
  def(type, docstrings::Model_set_positions,
      [](BoundModel& model, Object positions) { model.set_positions(positions); });
  def(type, "__repr__(self)", [](const BoundModel& model) { return model.repr(); });
  const auto def_value = [&](const char* name, auto value, const char* doc) {
    def_property(
        type, name, [value](const BoundModel& model) { return (model.*value)(); }, doc);
  };
  def_value("positions", &BoundModel::positions, docstrings::Model_positions);
  def_value("n_vertices", &BoundModel::n_vertices, docstrings::Model_n_vertices);
  def_value("n_parts", &BoundModel::n_parts, docstrings::Model_n_parts);
  def_value("n_parts_joined", &BoundModel::n_parts_joined, docstrings::Model_n_parts_joined);
  def_value("part_of_vertex", &BoundModel::part_of_vertex, docstrings::Model_part_of_vertex);
  def_value("loose_vertices", &BoundModel::loose_vertices, docstrings::Model_loose_vertices);
  def_value("n_factorizations", &BoundModel::n_factorizations, docstrings::Model_n_factorizations);
  def_value("threads", &BoundModel::threads, docstrings::Model_threads);
}

}  // namespace arap_native
