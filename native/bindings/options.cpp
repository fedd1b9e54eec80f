// SPDX-License-Identifier: GPL-3.0-or-later
#include "options.h"

#include "arap/cage.h"
#include "arap/lattice_arap.h"
#include "arap/options.h"
#include "arap/wrap_deformation.h"
#include "docstrings.h"
#include "option_fields.h"

namespace arap_native {

void bind_options(py::module_& m) {
  using arap::Options;
  py::class_<Options> type(m, "Options", docstrings::Options);
  def_enum<Options, arap::Energy>(type, "energy", &Options::energy, kEnergies, docstrings::Options_energy);
  def_field(type, "rigidity_radius", &Options::rigidity_radius, docstrings::Options_rigidity_radius);
  def_enum<Options, arap::EdgeWeights>(type, "weights", &Options::weights, kWeights, docstrings::Options_weights);
  def_field(type, "threads", &Options::threads, docstrings::Options_threads);
  def_field(type, "join_seams", &Options::join_seams, docstrings::Options_join_seams);
  def_construction(type, docstrings::Options_init);
}

void bind_lattice_options(py::module_& m) {
  using arap::LatticeOptions;
  py::class_<LatticeOptions> type(m, "LatticeOptions", docstrings::LatticeOptions);
  def_field(type, "cube_size", &LatticeOptions::cube_size, docstrings::LatticeOptions_cube_size);
  def_field(type, "keep_volume", &LatticeOptions::keep_volume, docstrings::LatticeOptions_keep_volume);
  def_field(type, "threads", &LatticeOptions::threads, docstrings::LatticeOptions_threads);
  def_field(type, "join_seams", &LatticeOptions::join_seams, docstrings::LatticeOptions_join_seams);
  def_construction(type, docstrings::LatticeOptions_init);
}

void bind_cage_options(py::module_& m) {
  using arap::CageOptions;
  py::class_<CageOptions> type(m, "CageOptions", docstrings::CageOptions);
  def_enum<CageOptions, arap::CageCoordinates>(type, "coordinates", &CageOptions::coordinates, kCageCoordinates,
                                               docstrings::CageOptions_coordinates);
  def_field(type, "grid_spacing", &CageOptions::grid_spacing, docstrings::CageOptions_grid_spacing);
  def_field(type, "threads", &CageOptions::threads, docstrings::CageOptions_threads);
  def_construction(type, docstrings::CageOptions_init);
}

void bind_wrap_options(py::module_& m) {
  using arap::WrapOptions;
  py::class_<WrapOptions> type(m, "WrapOptions", docstrings::WrapOptions);
  def_field(type, "anchors", &WrapOptions::anchors, docstrings::WrapOptions_anchors);
  def_field(type, "stay_outside", &WrapOptions::stay_outside, docstrings::WrapOptions_stay_outside);
  def_field(type, "threads", &WrapOptions::threads, docstrings::WrapOptions_threads);
  def_construction(type, docstrings::WrapOptions_init);
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
  def_construction(type, docstrings::SolveOptions_init);
}

}  // namespace arap_native
