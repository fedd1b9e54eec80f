// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/surface_arap/posed_surface.h"

#include "parallel/parallel.h"

namespace arap {

PosedSurface::PosedSurface(const PolygonMesh& mesh, const Options& options, const VertexProperties& properties,
                           const Progress& progress)
    : space(mesh), posed(space, prepare(mesh, options, properties, progress), 2) {}

const PreparedModel& PosedSurface::prepare(const PolygonMesh& mesh, const Options& options,
                                           const VertexProperties& properties, const Progress& progress) {
  if (options.join_seams) space.join(mesh.same_places(choose_threads(options.threads, mesh.n_vertices())));
  space.renumber(prepare_surface(model, space.make_model(mesh), options, space.to_model(properties.stiffness),
                                 space.regions_to_model(properties.rigid_regions), progress));
  return model.prepared;
}

}  // namespace arap
