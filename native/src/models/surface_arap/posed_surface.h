// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "arap/mesh.h"
#include "arap/options.h"
#include "arap/vertex_properties.h"
#include "models/model_space.h"
#include "models/surface_arap/surface_model.h"
#include "models/vertex_model.h"

namespace arap {

/// A surface, prepared to be posed.
struct PosedSurface {
  PosedSurface(const PolygonMesh& mesh, const Options& options, const VertexProperties& properties,
               const Progress& progress);

  ModelSpace space;
  SurfaceModel model;
  VertexModel posed;

 private:
  const PreparedModel& prepare(const PolygonMesh& mesh, const Options& options, const VertexProperties& properties,
                               const Progress& progress);
};

}  // namespace arap
