// SPDX-License-Identifier: GPL-3.0-or-later
// What calls are given, copied from arrays: a mesh, constraints, rotations.
#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <vector>

#include "arap/surface_arap.h"
#include "arrays.h"
#include "model.h"

namespace arap_native {

namespace py = pybind11;

/// What a PolygonMesh is made of; made into one without the GIL.
struct MeshArrays {
  arap::Positions positions;
  std::vector<int> corner_vertices;
  std::vector<int> face_sizes;
};

MeshArrays mesh_from(const py::object& rest_positions, const py::object& corner_vertices, const py::object& face_sizes);
arap::PolygonMesh mesh_of(MeshArrays arrays);

/// What a SurfaceArap is bound to.
struct BindInput {
  MeshArrays mesh;
  arap::Options options;
  arap::VertexProperties properties;

  BindInput(const py::object& rest_positions, const py::object& corner_vertices, const py::object& face_sizes,
            const arap::Options* given, const py::object& stiffness, const py::object& rigid_regions);

  /// Binds, once: takes the arrays. Needs no GIL.
  std::shared_ptr<Model> bind(const arap::Progress& progress);
};

arap::ConstraintSet constraints_from(const py::object& vertices, const py::object& strengths,
                                     const py::object& patches);

std::vector<arap::Matrix3> rotations_from(const py::object& object, const Extent& rows);

}  // namespace arap_native
