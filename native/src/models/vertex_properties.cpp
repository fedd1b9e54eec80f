// SPDX-License-Identifier: GPL-3.0-or-later
#include "arap/vertex_properties.h"

#include "arap/error.h"
#include "base/format_message.h"

namespace arap {

namespace {

/// Rest vectors are stored as floats and what these leave.
constexpr double kLargestStiffness = 1e12;

}  // namespace

void VertexProperties::validate(int n_vertices) const {
  const auto n = static_cast<size_t>(n_vertices);
  if (!stiffness.empty() && stiffness.size() != n)
    throw InvalidInput(text("stiffness has ", stiffness.size(), " entries, must have one per vertex, ", n));
  if (!rigid_regions.empty() && rigid_regions.size() != n)
    throw InvalidInput(text("rigid_regions has ", rigid_regions.size(), " entries, must have one per vertex, ", n));
  for (size_t v = 0; v < stiffness.size(); ++v)
    if (!(stiffness[v] >= 1 / kLargestStiffness && stiffness[v] <= kLargestStiffness))
      throw InvalidInput(text("stiffness of vertex ", v, " is ", stiffness[v], ", must be between ",
                              1 / kLargestStiffness, " and ", kLargestStiffness));
}

}  // namespace arap
