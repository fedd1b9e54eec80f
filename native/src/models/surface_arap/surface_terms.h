// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <vector>

#include "arap/mesh.h"
#include "arap/options.h"
#include "energy/split_cells.h"
#include "sampling/rotation_nodes.h"

namespace arap {

/// The terms of a surface's cells of rotation nodes: triangles and ties. They are found again when they are needed.
class SurfaceTerms final : public CellTerms {
 public:
  /// @param mesh, options, stiffness, nodes  of which assemble_surface_energy() made the energy
  /// @param new_of_old                       the model's numbers of the mesh's vertices
  SurfaceTerms(PolygonMesh mesh, const Options& options, std::vector<double> stiffness, RotationNodes nodes,
               std::vector<int> new_of_old);

  [[nodiscard]] std::unique_ptr<const Reader> open() const override;

 private:
  PolygonMesh mesh_;
  Options options_;
  std::vector<double> stiffness_;
  RotationNodes nodes_;
  std::vector<int> new_of_old_;
};

}  // namespace arap
