// SPDX-License-Identifier: GPL-3.0-or-later
#include "lattice_tets.h"

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "arap/lattice_tets.h"
#include "arrays.h"
#include "data.h"
#include "docstrings.h"
#include "gil.h"
#include "inputs.h"
#include "progress_call.h"
#include "signature.h"

namespace arap_native {

namespace {

using Object = const py::object&;

/// For Python: tetrahedra, and the surface, for where its loose vertices are. Nothing changes once it is made.
class BoundTets {
 public:
  BoundTets(arap::LatticeTets native, arap::PolygonMesh surface, double cube_size)
      : native_(std::move(native)), surface_(std::move(surface)), cube_size_(cube_size) {}

  static std::unique_ptr<BoundTets> around(MeshArrays arrays, double cube_size, const py::object& progress) {
    ProgressCall call(progress);
    const WithoutGil no_gil;
    arap::PolygonMesh surface = mesh_of(std::move(arrays));
    arap::LatticeTets native = arap::LatticeTets::around(surface, cube_size, call.function());
    return std::make_unique<BoundTets>(std::move(native), std::move(surface), cube_size);
  }

  [[nodiscard]] const arap::LatticeTets& native() const { return native_; }

  [[nodiscard]] py::array embed(Object of_tets) const {
    return to_array(embedded(
        positions_from(of_tets, "of_tets", native_.mesh.n_vertices(), "one row per vertex of the tetrahedra")));
  }

  [[nodiscard]] py::tuple patches(Object vertices) const {
    arap::Patches patches =
        patches_of(vector_from<int>(vertices, "vertices", "k", "one entry per vertex of the surface"));
    return py::make_tuple(to_array(std::move(patches.offsets)), to_array(std::move(patches.vertices)),
                          to_array(std::move(patches.weights)));
  }

  /// What it was made of.
  [[nodiscard]] py::dict arguments() const {
    py::dict arguments = arguments_of(surface_);
    arguments["cube_size"] = cube_size_;
    return arguments;
  }

  [[nodiscard]] std::string repr() const {
    return py::str("<LatticeTets: {} tetrahedra, {} vertices of the surface>")
        .format(native_.mesh.n_tets(), native_.tet_of_vertex.size());
  }

 private:
  [[nodiscard]] arap::Positions embedded(const arap::Positions& of_tets) const {
    const WithoutGil no_gil;
    arap::Positions of_surface = surface_.positions();
    native_.embed(of_tets, of_surface);
    return of_surface;
  }

  [[nodiscard]] arap::Patches patches_of(const std::vector<int>& vertices) const {
    const WithoutGil no_gil;
    arap::Patches patches{{0}, {}, {}};
    for (const int v : vertices) patches.add(native_.patch(v));
    return patches;
  }

  arap::LatticeTets native_;
  arap::PolygonMesh surface_;
  double cube_size_;
};

}  // namespace

void bind_lattice_tets(py::module_& m) {
  py::class_<BoundTets> type(m, "LatticeTets", docstrings::LatticeTets);
  def_init(type, docstrings::LatticeTets_init,
           [](Object rest_positions, Object faces, Object face_sizes, double cube_size, Object progress) {
             return BoundTets::around(mesh_from(rest_positions, faces, face_sizes), cube_size, progress);
           });
  def(type, docstrings::LatticeTets_patches,
      [](const BoundTets& tets, Object vertices) { return tets.patches(vertices); });
  def(type, docstrings::LatticeTets_embed, [](const BoundTets& tets, Object of_tets) { return tets.embed(of_tets); });
  def(type, "__repr__(self)", [](const BoundTets& tets) { return tets.repr(); });
  def(type, "__reduce__(self)",
      [](Object self) { return rebuilt_by(self, converted<const BoundTets&>(self, "self").arguments()); });
  def_property(
      type, "rest_positions", [](const BoundTets& tets) { return to_array(tets.native().mesh.positions()); },
      docstrings::LatticeTets_rest_positions);
  def_property(
      type, "tets", [](const BoundTets& tets) { return to_array(tets.native().mesh.tets()); },
      docstrings::LatticeTets_tets);
  def_property(
      type, "tet_of_vertex", [](const BoundTets& tets) { return to_array(tets.native().tet_of_vertex); },
      docstrings::LatticeTets_tet_of_vertex);
  def_property(
      type, "coordinates", [](const BoundTets& tets) { return to_array(tets.native().coordinates); },
      docstrings::LatticeTets_coordinates);
}

}  // namespace arap_native
