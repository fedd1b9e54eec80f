// SPDX-License-Identifier: GPL-3.0-or-later
#include "options.h"

#include "arap/cage_arap.h"
#include "arap/embedded_deformation.h"
#include "arap/poisson_editing.h"
#include "arap/tet_arap.h"
#include "docstrings.h"
#include "option_fields.h"

namespace arap_native {

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
  def_construction(type, docstrings::EmbeddedOptions_init);
}

void bind_poisson_options(py::module_& m) {
  using arap::PoissonOptions;
  py::class_<PoissonOptions> type(m, "PoissonOptions", docstrings::PoissonOptions);
  def_enum<PoissonOptions, arap::Propagation>(type, "propagation", &PoissonOptions::propagation, kPropagations,
                                              docstrings::PoissonOptions_propagation);
  def_field(type, "threads", &PoissonOptions::threads, docstrings::PoissonOptions_threads);
  def_construction(type, docstrings::PoissonOptions_init);
}

void bind_tet_options(py::module_& m) {
  using arap::TetOptions;
  py::class_<TetOptions> type(m, "TetOptions", docstrings::TetOptions);
  def_field(type, "threads", &TetOptions::threads, docstrings::TetOptions_threads);
  def_construction(type, docstrings::TetOptions_init);
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
  def_construction(type, docstrings::CageArapOptions_init);
}

}  // namespace arap_native
