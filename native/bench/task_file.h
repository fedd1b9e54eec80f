// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "arap/mesh.h"
#include "arap/types.h"

namespace arap::bench {

/// A mesh, which of its vertices are constrained and where they go; as measure/task_file.py writes it.
struct TaskFile {
  /// Throws std::runtime_error naming the file where it cannot be read whole.
  explicit TaskFile(const std::string& path);

  [[nodiscard]] PolygonMesh mesh() const { return {positions, corner_vertices, face_sizes}; }

  Positions positions;  ///< (n, 3) at rest
  std::vector<int> corner_vertices;
  std::vector<int> face_sizes;
  std::vector<int> constrained;
  Positions targets;  ///< one row per constrained vertex
};

}  // namespace arap::bench
