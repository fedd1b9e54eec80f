// SPDX-License-Identifier: GPL-3.0-or-later
#include "lattice_tets.h"

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "arap/lattice_tets.h"
#include "arrays.h"
#include "docstrings.h"
#include "gil.h"
#include "inputs.h"

namespace arap_native {

namespace {

using Object = const py::object&;

/// For Python: tetrahedra, and where the surface is at rest, for its loose vertices. Nothing changes once it is made.
class BoundTets {
 public:
  static std::unique_ptr<BoundTets> around(MeshArrays arrays, double cube_size) {
    const WithoutGil no_gil;
    const arap::PolygonMesh surface = mesh_of(std::move(arrays));
    // Not make_unique: it would use the class's own new, which refuses.
    return std::unique_ptr<BoundTets>(  // NOLINT(modernize-make-unique)
        ::new BoundTets(arap::LatticeTets::around(surface, cube_size), surface.positions()));
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

  [[nodiscard]] std::string repr() const {
    return py::str("<LatticeTets: {} tetrahedra, {} vertices of the surface>")
        .format(native_.mesh.n_tets(), native_.tet_of_vertex.size());
  }

  /// As that of BoundModel.
  static void* operator new(size_t) {
    throw py::type_error("this LatticeTets has no mesh, because only __new__ was called: call its class");
  }
  static void operator delete(void* bound) { ::operator delete(bound); }

 private:
  BoundTets(arap::LatticeTets native, arap::Positions rest) : native_(std::move(native)), rest_(std::move(rest)) {}

  [[nodiscard]] arap::Positions embedded(const arap::Positions& of_tets) const {
    const WithoutGil no_gil;
    arap::Positions of_surface = rest_;
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
  arap::Positions rest_;
};

}  // namespace

void bind_lattice_tets(py::module_& m) {
  py::class_<BoundTets>(m, "LatticeTets", docstrings::LatticeTets)
      .def(py::init([](Object rest_positions, Object faces, Object face_sizes, double cube_size) {
             return BoundTets::around(mesh_from(rest_positions, faces, face_sizes), cube_size);
           }),
           docstrings::LatticeTets_init, py::arg("rest_positions"), py::arg("faces"),
           py::arg("face_sizes") = py::none(), py::arg("cube_size") = 0.0)
      .def("patches", &BoundTets::patches, docstrings::LatticeTets_patches, py::arg("vertices"))
      .def("embed", &BoundTets::embed, docstrings::LatticeTets_embed, py::arg("of_tets"))
      .def_property_readonly(
          "rest_positions", [](const BoundTets& tets) { return to_array(tets.native().mesh.positions()); },
          docstrings::LatticeTets_rest_positions)
      .def_property_readonly(
          "tets", [](const BoundTets& tets) { return to_array(tets.native().mesh.tets()); },
          docstrings::LatticeTets_tets)
      .def_property_readonly(
          "tet_of_vertex", [](const BoundTets& tets) { return to_array(tets.native().tet_of_vertex); },
          docstrings::LatticeTets_tet_of_vertex)
      .def_property_readonly(
          "coordinates", [](const BoundTets& tets) { return to_array(tets.native().coordinates); },
          docstrings::LatticeTets_coordinates)
      .def("__repr__", &BoundTets::repr);
}

}  // namespace arap_native
