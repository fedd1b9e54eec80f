// SPDX-License-Identifier: GPL-3.0-or-later
#include "options.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "arap/cage.h"
#include "arap/cage_arap.h"
#include "arap/embedded_deformation.h"
#include "arap/lattice_arap.h"
#include "arap/options.h"
#include "arap/poisson_editing.h"
#include "arap/tet_arap.h"
#include "arap/wrap_deformation.h"
#include "arrays.h"
#include "docstrings.h"
#include "enum_names.h"

namespace arap_native {

namespace {

/// Assigns one field; the options stay as they are where the new value is not allowed.
template <typename Options, typename T>
void assign(Options& options, T Options::*field, T value) {
  Options changed = options;
  changed.*field = value;
  changed.validate();
  options = changed;
}

/// Adds a field as an attribute that is validated when it is set.
template <typename Options, typename T>
void def_field(py::class_<Options>& type, const char* name, T Options::*field, const char* doc) {
  type.def_property(
      name, [field](const Options& options) { return options.*field; },
      [field](Options& options, T value) { assign(options, field, value); }, doc);
}

/// Adds an enum as an attribute that is a string.
template <typename Options, typename Enum>
void def_enum(py::class_<Options>& type, const char* name, Enum Options::*field, Names<Enum> names, const char* doc) {
  type.def_property(
      name, [field, names](const Options& options) { return name_of(options.*field, names); },
      [field, name, names](Options& options, const std::string& value) {
        assign(options, field, value_of(value, name, names));
      },
      doc);
}

/// Sets an option. Throws a TypeError that names it if the value is of another type than the default.
void set_option(const py::object& options, const std::string& name, const py::handle& value) {
  const std::string expected = type_name(options.attr(name.c_str()));
  try {
    py::setattr(options, name.c_str(), value);
  } catch (py::error_already_set& error) {
    if (!error.matches(PyExc_TypeError)) throw;
    throw py::type_error(
        py::str("{} = {!r} is of type {}, expected {}").format(name, value, type_name(value), expected));
  }
}

/// Adds the constructor, with every attribute as a keyword, and the repr, which is a call of it.
template <typename Options>
void def_construction(py::class_<Options>& type, const char* init_doc, std::vector<const char*> attributes) {
  const std::string name = py::str(type.attr("__name__"));
  type.def(py::init([name, attributes](const py::kwargs& values) {
             const py::object options = py::cast(Options{});
             for (const auto& [key, value] : values) {
               const std::string attribute = py::str(key);
               if (std::find(attributes.begin(), attributes.end(), attribute) == attributes.end())
                 throw py::type_error(py::str("{}() got an unexpected keyword argument {!r}").format(name, key));
               set_option(options, attribute, value);
             }
             return options.cast<Options>();
           }),
           init_doc);
  type.def("__repr__", [name, attributes = std::move(attributes)](py::handle self) {
    std::string text;
    for (const char* attribute : attributes)
      text += (text.empty() ? "" : ", ") + std::string(attribute) + "=" + std::string(py::repr(self.attr(attribute)));
    return name + "(" + text + ")";
  });
}

}  // namespace

void bind_options(py::module_& m) {
  using arap::Options;
  py::class_<Options> type(m, "Options", docstrings::Options);
  def_enum<Options, arap::Energy>(type, "energy", &Options::energy, kEnergies, docstrings::Options_energy);
  def_field(type, "rigidity_radius", &Options::rigidity_radius, docstrings::Options_rigidity_radius);
  def_enum<Options, arap::EdgeWeights>(type, "weights", &Options::weights, kWeights, docstrings::Options_weights);
  def_enum<Options, arap::LinearSolverKind>(type, "linear_solver", &Options::linear_solver, kLinearSolvers,
                                            docstrings::Options_linear_solver);
  def_field(type, "threads", &Options::threads, docstrings::Options_threads);
  def_field(type, "join_seams", &Options::join_seams, docstrings::Options_join_seams);
  def_construction(type, docstrings::Options_init,
                   {"energy", "rigidity_radius", "weights", "linear_solver", "threads", "join_seams"});
}

void bind_lattice_options(py::module_& m) {
  using arap::LatticeOptions;
  py::class_<LatticeOptions> type(m, "LatticeOptions", docstrings::LatticeOptions);
  def_field(type, "cube_size", &LatticeOptions::cube_size, docstrings::LatticeOptions_cube_size);
  def_field(type, "keep_volume", &LatticeOptions::keep_volume, docstrings::LatticeOptions_keep_volume);
  def_field(type, "threads", &LatticeOptions::threads, docstrings::LatticeOptions_threads);
  def_field(type, "join_seams", &LatticeOptions::join_seams, docstrings::LatticeOptions_join_seams);
  def_construction(type, docstrings::LatticeOptions_init, {"cube_size", "keep_volume", "threads", "join_seams"});
}

void bind_embedded_options(py::module_& m) {
  using arap::EmbeddedOptions;
  py::class_<EmbeddedOptions> type(m, "EmbeddedOptions", docstrings::EmbeddedOptions);
  def_field(type, "node_distance", &EmbeddedOptions::node_distance, docstrings::EmbeddedOptions_node_distance);
  def_enum<EmbeddedOptions, arap::GraphNodes>(type, "nodes", &EmbeddedOptions::nodes, kGraphNodes,
                                              docstrings::EmbeddedOptions_nodes);
  def_enum<EmbeddedOptions, arap::GraphWeights>(type, "weights", &EmbeddedOptions::weights, kGraphWeights,
                                                docstrings::EmbeddedOptions_weights);
  def_field(type, "rotation_weight", &EmbeddedOptions::rotation_weight, docstrings::EmbeddedOptions_rotation_weight);
  def_field(type, "regularization_weight", &EmbeddedOptions::regularization_weight,
            docstrings::EmbeddedOptions_regularization_weight);
  def_field(type, "constraint_weight", &EmbeddedOptions::constraint_weight,
            docstrings::EmbeddedOptions_constraint_weight);
  def_field(type, "threads", &EmbeddedOptions::threads, docstrings::EmbeddedOptions_threads);
  def_construction(type, docstrings::EmbeddedOptions_init,
                   {"node_distance", "nodes", "weights", "rotation_weight", "regularization_weight",
                    "constraint_weight", "threads"});
}

void bind_poisson_options(py::module_& m) {
  using arap::PoissonOptions;
  py::class_<PoissonOptions> type(m, "PoissonOptions", docstrings::PoissonOptions);
  def_enum<PoissonOptions, arap::Propagation>(type, "propagation", &PoissonOptions::propagation, kPropagations,
                                              docstrings::PoissonOptions_propagation);
  def_field(type, "threads", &PoissonOptions::threads, docstrings::PoissonOptions_threads);
  def_construction(type, docstrings::PoissonOptions_init, {"propagation", "threads"});
}

void bind_tet_options(py::module_& m) {
  using arap::TetOptions;
  py::class_<TetOptions> type(m, "TetOptions", docstrings::TetOptions);
  def_field(type, "threads", &TetOptions::threads, docstrings::TetOptions_threads);
  def_enum<TetOptions, arap::LinearSolverKind>(type, "linear_solver", &TetOptions::linear_solver, kLinearSolvers,
                                               docstrings::TetOptions_linear_solver);
  def_construction(type, docstrings::TetOptions_init, {"threads", "linear_solver"});
}

void bind_cage_options(py::module_& m) {
  using arap::CageOptions;
  py::class_<CageOptions> type(m, "CageOptions", docstrings::CageOptions);
  def_enum<CageOptions, arap::CageCoordinates>(type, "coordinates", &CageOptions::coordinates, kCageCoordinates,
                                               docstrings::CageOptions_coordinates);
  def_field(type, "grid_spacing", &CageOptions::grid_spacing, docstrings::CageOptions_grid_spacing);
  def_field(type, "threads", &CageOptions::threads, docstrings::CageOptions_threads);
  def_construction(type, docstrings::CageOptions_init, {"coordinates", "grid_spacing", "threads"});
}

void bind_cage_arap_options(py::module_& m) {
  using arap::CageArapOptions;
  py::class_<CageArapOptions> type(m, "CageArapOptions", docstrings::CageArapOptions);
  def_enum<CageArapOptions, arap::CageEnergy>(type, "energy", &CageArapOptions::energy, kCageEnergies,
                                              docstrings::CageArapOptions_energy);
  def_enum<CageArapOptions, arap::CageCoordinates>(type, "coordinates", &CageArapOptions::coordinates, kCageCoordinates,
                                                   docstrings::CageArapOptions_coordinates);
  def_field(type, "grid_spacing", &CageArapOptions::grid_spacing, docstrings::CageArapOptions_grid_spacing);
  def_field(type, "rigidity_radius", &CageArapOptions::rigidity_radius, docstrings::CageArapOptions_rigidity_radius);
  def_field(type, "threads", &CageArapOptions::threads, docstrings::CageArapOptions_threads);
  def_construction(type, docstrings::CageArapOptions_init,
                   {"energy", "coordinates", "grid_spacing", "rigidity_radius", "threads"});
}

void bind_wrap_options(py::module_& m) {
  using arap::WrapOptions;
  py::class_<WrapOptions> type(m, "WrapOptions", docstrings::WrapOptions);
  def_field(type, "anchors", &WrapOptions::anchors, docstrings::WrapOptions_anchors);
  def_field(type, "stay_outside", &WrapOptions::stay_outside, docstrings::WrapOptions_stay_outside);
  def_field(type, "threads", &WrapOptions::threads, docstrings::WrapOptions_threads);
  def_construction(type, docstrings::WrapOptions_init, {"anchors", "stay_outside", "threads"});
}

void bind_solve_options(py::module_& m) {
  using arap::SolveOptions;
  py::class_<SolveOptions> type(m, "SolveOptions", docstrings::SolveOptions);
  def_enum<SolveOptions, arap::InitialGuess>(type, "initial_guess", &SolveOptions::initial_guess, kInitialGuesses,
                                             docstrings::SolveOptions_initial_guess);
  def_enum<SolveOptions, arap::Acceleration>(type, "acceleration", &SolveOptions::acceleration, kAccelerations,
                                             docstrings::SolveOptions_acceleration);
  def_field(type, "max_iterations", &SolveOptions::max_iterations, docstrings::SolveOptions_max_iterations);
  def_field(type, "accuracy", &SolveOptions::accuracy, docstrings::SolveOptions_accuracy);
  def_field(type, "time_limit_s", &SolveOptions::time_limit_s, docstrings::SolveOptions_time_limit_s);
  def_construction(type, docstrings::SolveOptions_init,
                   {"initial_guess", "acceleration", "max_iterations", "accuracy", "time_limit_s"});
}

}  // namespace arap_native
