// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "arap/mesh.h"
#include "arap/types.h"

namespace arap::bench {

/// A mesh, its constrained vertices and their targets, in the format of measure/inputs/tasks.py.
struct TaskFile {
  /// Throws std::runtime_error, naming the file, if it cannot be read completely.
  explicit TaskFile(const std::string& path);

  [[nodiscard]] PolygonMesh mesh() const { return {positions, corner_vertices, face_sizes}; }

  Positions positions;  ///< (n, 3) at rest
  std::vector<int> corner_vertices;
  std::vector<int> face_sizes;
  std::vector<int> constrained;
  Positions targets;  ///< one row per constrained vertex
};

}  // namespace arap::bench
