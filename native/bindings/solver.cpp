// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver.h"

#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "arap/surface_arap.h"
#include "arrays.h"
#include "docstrings.h"
#include "gil.h"
#include "inputs.h"
#include "model.h"
#include "progress_call.h"
#include "result.h"

namespace arap_native {

namespace {

void set_constraints_of(Model& model, const arap::ConstraintSet& set, const arap::Progress& progress) {
  model.solver.set_constraints(set, progress);
  model.n_targets = set.size();
}

py::tuple patch_to_python(const arap::Patch& patch) {
  return py::make_tuple(to_array(patch.vertices), to_array(patch.weights),
                        to_array(std::vector<double>(patch.rest_position.begin(), patch.rest_position.end())));
}

/// arap::SurfaceArap for Python: checks arrays, then works without the GIL.
class Solver {
 public:
  static std::unique_ptr<Solver> of(std::shared_ptr<Model> model) {
    // Not make_unique: it would use the class's own new, which refuses.
    return std::unique_ptr<Solver>(::new Solver(std::move(model)));  // NOLINT(modernize-make-unique)
  }

  static std::unique_ptr<Solver> bind(BindInput input, py::object progress) {
    ProgressCall call(std::move(progress));
    const WithoutGil no_gil;
    return of(input.bind(call.function()));
  }

  static std::unique_ptr<JobHandle> begin_bind(Jobs& jobs, BindInput input) {
    return begin_job(
        jobs, [input = std::move(input)](const arap::Progress& progress) mutable { return input.bind(progress); },
        [](std::shared_ptr<Model> model) { return py::cast(of(std::move(model))); });
  }

  void set_constraints(const arap::ConstraintSet& set, py::object progress) {
    ProgressCall call(std::move(progress));
    exclusively([&](Model& model) { set_constraints_of(model, set, call.function()); });
  }

  std::unique_ptr<JobHandle> begin_set_constraints(Jobs& jobs, arap::ConstraintSet set) {
    return begin_job(
        jobs,
        [turn = Turn(model_), set = std::move(set)](const arap::Progress& progress) {
          set_constraints_of(*turn, set, progress);
          return true;
        },
        [](bool) { return py::none(); });
  }

  SolveResult solve(const py::object& targets, const arap::SolveOptions* options, const py::object& rotations,
                    py::object progress, const py::object& out) {
    const SolveInput input(*this, targets, options, rotations, out);
    ProgressCall call(std::move(progress));
    return {exclusively([&](Model& model) { return input.solve(model, call.function()); }), out};
  }

  std::unique_ptr<JobHandle> begin_solve(Jobs& jobs, const py::object& targets, const arap::SolveOptions* options,
                                         const py::object& rotations, const py::object& out) {
    return begin_job(
        jobs,
        [input = SolveInput(*this, targets, options, rotations, out),
         turn = Turn(model_)](const arap::Progress& progress) { return input.solve(*turn, progress); },
        [out](arap::SolveResult result) { return py::cast(SolveResult(std::move(result), out)); }, out);
  }

  void reset() {
    exclusively([&](Model& model) { model.solver.reset(); });
  }

  void set_positions(const py::object& positions) {
    const arap::Positions points = points_from(positions);
    exclusively([&](Model& model) { model.solver.set_positions(points); });
  }

  py::tuple patch_around(const py::object& vertices, double radius) {
    const auto indices = vector_from<int>(vertices, "vertices", "k", "one entry per vertex");
    return patch_to_python(exclusively([&](Model& model) { return model.solver.patch_around(indices, radius); }));
  }

  std::unique_ptr<JobHandle> begin_patches(Jobs& jobs, const py::object& around, const py::object& radii) {
    if (!py::isinstance<py::list>(around))
      throw py::type_error("around is of type " + type_name(around) + ", expected a list of numpy arrays of int32");
    std::vector<std::vector<int>> groups;
    for (const py::handle vertices : around)
      groups.push_back(vector_from<int>(py::reinterpret_borrow<py::object>(vertices), "an array of around", "k",
                                        "one entry per vertex"));
    auto reaches = vector_from<double>(radii, "radii", static_cast<py::ssize_t>(groups.size()), "one entry per patch");
    return begin_job(
        jobs,
        [turn = Turn(model_), groups = std::move(groups),
         reaches = std::move(reaches)](const arap::Progress& progress) {
          std::vector<arap::Patch> patches;
          for (size_t i = 0; i < groups.size(); ++i) {
            if (!progress(static_cast<double>(i) / static_cast<double>(groups.size())))
              throw arap::Cancelled("finding patches was cancelled");
            patches.push_back((*turn).solver.patch_around(groups[i], reaches[i]));
          }
          return patches;
        },
        [](const std::vector<arap::Patch>& patches) {
          py::list result;
          for (const arap::Patch& patch : patches) result.append(patch_to_python(patch));
          return result;
        });
  }

  double energy(const py::object& positions) {
    const arap::Positions points = points_from(positions);
    return exclusively([&](Model& model) { return model.solver.energy(points); });
  }

  py::array energy_gradient(const py::object& positions) {
    const arap::Positions points = points_from(positions);
    return to_array(exclusively([&](Model& model) { return model.solver.energy_gradient(points); }));
  }

  py::array positions() {
    return to_array(exclusively([](Model& model) { return model.solver.positions(); }));
  }

  int n_factorizations() {
    return exclusively([](Model& model) { return model.solver.n_factorizations(); });
  }

  // Fixed at bind: these may be read at any time.
  [[nodiscard]] py::ssize_t n_vertices() const { return model_->solver.n_vertices(); }
  [[nodiscard]] int n_parts() const { return model_->solver.n_parts(); }
  [[nodiscard]] int threads() const { return model_->solver.threads(); }
  [[nodiscard]] py::array part_of_vertex() const { return to_array(model_->solver.part_of_vertex()); }
  [[nodiscard]] py::array loose_vertices() const { return to_array(model_->solver.loose_vertices()); }

  [[nodiscard]] std::string repr() const {
    return py::str("<SurfaceArap: {} vertices, {} {}, {} {}>")
        .format(n_vertices(), n_parts(), n_parts() == 1 ? "part" : "parts", threads(),
                threads() == 1 ? "thread" : "threads");
  }

 private:
  explicit Solver(std::shared_ptr<Model> model) : model_(std::move(model)) {}

  /// What a solve is called with. Holds no Python object: whoever solves keeps `out` alive.
  class SolveInput {
   public:
    SolveInput(const Solver& solver, const py::object& targets, const arap::SolveOptions* options,
               const py::object& rotations, const py::object& out) {
      // Without constraints the library says so; any number of rows is as good then.
      const int n_targets = solver.model_->n_targets;
      const Extent rows = n_targets > 0 ? Extent(n_targets) : Extent("k + n_patches");
      targets_ = positions_from(targets, "targets", rows, "one row per constrained vertex, then one per patch");
      if (options != nullptr) options_ = *options;
      rotations_ = rotations_from(rotations, rows);
      out_ = out_from(out, solver.n_vertices());
    }

    [[nodiscard]] arap::SolveResult solve(Model& model, const arap::Progress& progress) const {
      return model.solver.solve(targets_, options_, rotations_, progress, out_);
    }

   private:
    arap::Positions targets_;
    arap::SolveOptions options_;
    std::vector<arap::Matrix3> rotations_;
    std::span<float> out_;
  };

  [[nodiscard]] arap::Positions points_from(const py::object& positions) const {
    return positions_from(positions, "positions", n_vertices(), "one row per vertex");
  }

  template <typename Work>
  std::invoke_result_t<Work, Model&> exclusively(const Work& work) {
    const Turn turn(model_);
    const WithoutGil no_gil;
    return work(*turn);
  }

  /// pybind11 asks for memory without an object in it if a script has called __new__ alone.
 public:
  static void* operator new(size_t) {
    throw py::type_error("this SurfaceArap has no mesh, because only __new__ was called: call SurfaceArap(...)");
  }
  static void operator delete(void* solver) { ::operator delete(solver); }

 private:
  std::shared_ptr<Model> model_;
};

}  // namespace

void bind_solver(py::module_& m, const std::shared_ptr<Jobs>& jobs) {
  const py::object none = py::none();
  using Object = const py::object&;
  py::class_<Solver>(m, "SurfaceArap", docstrings::SurfaceArap)
      .def(py::init([](Object rest_positions, Object corner_vertices, Object face_sizes, const arap::Options* options,
                       Object stiffness, Object rigid_regions, py::object progress) {
             return Solver::bind({rest_positions, corner_vertices, face_sizes, options, stiffness, rigid_regions},
                                 std::move(progress));
           }),
           docstrings::SurfaceArap_init, py::arg("rest_positions"), py::arg("corner_vertices"),
           py::arg("face_sizes") = none, py::arg("options") = none, py::kw_only(), py::arg("stiffness") = none,
           py::arg("rigid_regions") = none, py::arg("progress") = none)
      .def_static(
          "begin_bind",
          [jobs](Object rest_positions, Object corner_vertices, Object face_sizes, const arap::Options* options,
                 Object stiffness, Object rigid_regions) {
            return Solver::begin_bind(*jobs,
                                      {rest_positions, corner_vertices, face_sizes, options, stiffness, rigid_regions});
          },
          docstrings::SurfaceArap_begin_bind, py::arg("rest_positions"), py::arg("corner_vertices"),
          py::arg("face_sizes") = none, py::arg("options") = none, py::kw_only(), py::arg("stiffness") = none,
          py::arg("rigid_regions") = none)
      .def(
          "set_constraints",
          [](Solver& solver, Object vertices, Object strengths, Object patches, py::object progress) {
            solver.set_constraints(constraints_from(vertices, strengths, patches), std::move(progress));
          },
          docstrings::SurfaceArap_set_constraints, py::arg("vertices"), py::arg("strengths") = none,
          py::arg("patches") = none, py::kw_only(), py::arg("progress") = none)
      .def(
          "begin_set_constraints",
          [jobs](Solver& solver, Object vertices, Object strengths, Object patches) {
            return solver.begin_set_constraints(*jobs, constraints_from(vertices, strengths, patches));
          },
          docstrings::SurfaceArap_begin_set_constraints, py::arg("vertices"), py::arg("strengths") = none,
          py::arg("patches") = none)
      .def("solve", &Solver::solve, docstrings::SurfaceArap_solve, py::arg("targets"), py::arg("options") = none,
           py::kw_only(), py::arg("rotations") = none, py::arg("progress") = none, py::arg("out") = none)
      .def(
          "begin_solve",
          [jobs](Solver& solver, Object targets, const arap::SolveOptions* options, Object rotations, Object out) {
            return solver.begin_solve(*jobs, targets, options, rotations, out);
          },
          docstrings::SurfaceArap_begin_solve, py::arg("targets"), py::arg("options") = none, py::kw_only(),
          py::arg("rotations") = none, py::arg("out") = none)
      .def("reset", &Solver::reset, docstrings::SurfaceArap_reset)
      .def("set_positions", &Solver::set_positions, docstrings::SurfaceArap_set_positions, py::arg("positions"))
      .def("patch_around", &Solver::patch_around, docstrings::SurfaceArap_patch_around, py::arg("vertices"),
           py::arg("radius") = 0.0)
      .def(
          "begin_patches",
          [jobs](Solver& solver, Object around, Object radii) { return solver.begin_patches(*jobs, around, radii); },
          docstrings::SurfaceArap_begin_patches, py::arg("around"), py::arg("radii"))
      .def("energy", &Solver::energy, docstrings::SurfaceArap_energy, py::arg("positions"))
      .def("energy_gradient", &Solver::energy_gradient, docstrings::SurfaceArap_energy_gradient, py::arg("positions"))
      .def_property_readonly("positions", &Solver::positions, docstrings::SurfaceArap_positions)
      .def_property_readonly("n_vertices", &Solver::n_vertices, docstrings::SurfaceArap_n_vertices)
      .def_property_readonly("n_parts", &Solver::n_parts, docstrings::SurfaceArap_n_parts)
      .def_property_readonly("part_of_vertex", &Solver::part_of_vertex, docstrings::SurfaceArap_part_of_vertex)
      .def_property_readonly("loose_vertices", &Solver::loose_vertices, docstrings::SurfaceArap_loose_vertices)
      .def_property_readonly("n_factorizations", &Solver::n_factorizations, docstrings::SurfaceArap_n_factorizations)
      .def_property_readonly("threads", &Solver::threads, docstrings::SurfaceArap_threads)
      .def("__repr__", &Solver::repr);
}

}  // namespace arap_native
