// SPDX-License-Identifier: GPL-3.0-or-later
#include "cages/cage_checks.h"

#include <algorithm>
#include <map>
#include <utility>

#include "arap/error.h"
#include "base/format_message.h"

namespace arap {

namespace {

/// How often faces run along an edge, from its lower vertex to the higher one and back.
struct Uses {
  int up = 0;
  int down = 0;
};

}  // namespace

void require_closed_cage(const PolygonMesh& mesh) {
  if (mesh.n_faces() == 0) throw InvalidInput("the cage has no faces; give it faces that close it");
  if (!(mesh.diagonal() > 0)) throw InvalidInput("the cage has no size, all its vertices are at one place; enlarge it");
  std::map<std::pair<int, int>, Uses> edges;
  for (int f = 0; f < mesh.n_faces(); ++f) {
    constexpr size_t kMostCorners = 4;
    if (mesh.face(f).size() > kMostCorners)
      throw InvalidInput(text("face ", f, " of the cage has ", mesh.face(f).size(),
                              " corners, must have 3 or 4; cut it into triangles or quads"));
    int from = mesh.face(f).back();
    for (const int to : mesh.face(f)) {
      Uses& uses = edges[std::minmax(from, to)];
      ++(from < to ? uses.up : uses.down);
      from = to;
    }
  }
  for (const auto& [edge, uses] : edges) {
    if (uses.up == uses.down) continue;
    const int n = uses.up + uses.down;
    if (n % 2 != 0)
      throw InvalidInput(text("the cage is not closed: its edge from vertex ", edge.first, " to ", edge.second, " has ",
                              n, n == 1 ? " face" : " faces", "; fill its holes and remove what is inside"));
    throw InvalidInput(text("the faces of the cage are not oriented alike: those at the edge from vertex ", edge.first,
                            " to ", edge.second, " have their fronts on different sides; recalculate its normals"));
  }
}

}  // namespace arap
