// SPDX-License-Identifier: GPL-3.0-or-later
// What calls are given, copied from arrays: a mesh, constraints, rotations.
#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "arap/constraints.h"
#include "arap/mesh.h"
#include "arap/tet_mesh.h"
#include "arap/types.h"
#include "arap/vertex_properties.h"
#include "arrays.h"
#include "model.h"

namespace arap_native {

namespace py = pybind11;

/// What a PolygonMesh is made of; made into one without the GIL.
struct MeshArrays {
  std::string prefix;  ///< of messages: which mesh it is, if there are several
  arap::Positions positions;
  std::vector<int> corner_vertices;
  std::vector<int> face_sizes;
};

/// @param faces  a row or a list per face, or with `face_sizes` one face after the other
MeshArrays mesh_from(const py::object& rest_positions, const py::object& faces, const py::object& face_sizes);
/// The same of one among several meshes.
/// @param prefix  of messages
MeshArrays prefixed_mesh_from(const std::string& prefix, const py::object& rest_positions, const py::object& faces,
                              const py::object& face_sizes);
/// Of a tuple or list as make_cage() returns it, with or without face_sizes. Messages begin with the name.
MeshArrays mesh_from_tuple(const py::object& object, const std::string& name);
arap::PolygonMesh mesh_of(MeshArrays arrays);

/// What a TetMesh is made of.
struct TetArrays {
  arap::Positions positions;
  std::vector<arap::TetMesh::Tet> tets;
};

TetArrays tets_from(const py::object& rest_positions, const py::object& tets);
arap::TetMesh mesh_of(TetArrays arrays);

/// The arrays of a kind of mesh.
template <typename Mesh>
using ArraysOf = std::conditional_t<std::is_same_v<Mesh, arap::TetMesh>, TetArrays, MeshArrays>;

arap::VertexProperties properties_from(const py::object& stiffness, const py::object& rigid_regions, const Extent& n);

/// What a model is bound to, copied from arrays.
template <typename Native>
struct BindInput {
  using Options = typename ClassOf<Native>::Options;
  using Arrays = ArraysOf<typename ClassOf<Native>::Mesh>;
  Arrays mesh;
  Options options;
  arap::VertexProperties properties;

  BindInput(Arrays arrays, const Options* given, const py::object& stiffness = py::none(),
            const py::object& rigid_regions = py::none())
      : mesh(std::move(arrays)),
        options(given != nullptr ? *given : Options{}),
        properties(properties_from(stiffness, rigid_regions, mesh.positions.rows())) {}

  /// Once: takes the arrays. Needs no GIL.
  Source<Native> source() { return {mesh_of(std::move(mesh)), options, std::move(properties)}; }
};

/// A mesh and its cage.
struct CagedArrays {
  MeshArrays mesh;
  MeshArrays cage;
};

CagedArrays caged_from(const py::object& rest_positions, const py::object& faces, const py::object& face_sizes,
                       const py::object& cage);

template <>
struct BindInput<arap::CageArap> {
  using Options = arap::CageArapOptions;
  using Arrays = CagedArrays;
  Arrays arrays;
  Options options;

  BindInput(Arrays given_arrays, const Options* given)
      : arrays(std::move(given_arrays)), options(given != nullptr ? *given : Options{}) {}

  /// As that of the others.
  Source<arap::CageArap> source() {
    return {mesh_of(std::move(arrays.mesh)), mesh_of(std::move(arrays.cage)), options};
  }
};

/// Binds, once: takes the arrays. Needs no GIL.
template <typename Native>
std::shared_ptr<ModelOf<Native>> bind(BindInput<Native>& input, const arap::Progress& progress) {
  const auto source = std::make_shared<const Source<Native>>(input.source());
  return std::make_shared<ModelOf<Native>>(source, source->bound(progress));
}

std::vector<arap::Segment> segments_from(const py::object& object);

arap::ConstraintSet constraints_from(const py::object& vertices, const py::object& strengths, const py::object& patches,
                                     const py::object& segments);

std::vector<arap::Matrix3> rotations_from(const py::object& object, const Extent& rows);

}  // namespace arap_native
