// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/embedded_deformation/deformation_graph.h"

#include <algorithm>
#include <utility>

#include "base/grouped.h"
#include "base/offsets.h"
#include "mesh/mirror_symmetry.h"
#include "mesh/thickness_links.h"
#include "mesh/triangulation.h"
#include "parallel/parallel.h"
#include "sampling/node_supports.h"
#include "sampling/poisson_disk.h"
#include "sampling/rotation_nodes.h"
#include "sampling/surface_patch.h"

namespace arap {

namespace {

/// A matrix that couples the vertices of each triangle.
SparseMatrix neighbours(const PolygonMesh& mesh) {
  const Triangulation triangulation = triangulate(mesh, EdgeWeights::kUniform);
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(6 * triangulation.triangles.size());
  for (const Triangle& triangle : triangulation.triangles)
    for (size_t k = 0; k < 3; ++k) {
      const int a = triangle.vertices[k];
      const int b = triangle.vertices[(k + 1) % 3];
      if (a == b) continue;
      entries.emplace_back(a, b, 1);
      entries.emplace_back(b, a, 1);
    }
  SparseMatrix matrix(mesh.n_vertices(), mesh.n_vertices());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

/// The squares of weights that end at their support in a kink do so smoothly.
void take_smooth(DeformationGraph& graph, RotationNodes nodes) {
  graph.vertices = std::move(nodes.vertices);
  graph.offsets = std::move(nodes.offsets);
  graph.nodes = std::move(nodes.nodes);
  graph.weights = std::move(nodes.weights);
  for (double& weight : graph.weights) weight *= weight;
}

/// The nearest nodes of each vertex. A vertex with no more about it has all, and their weights end at the support.
void take_nearest(DeformationGraph& graph, const std::vector<std::vector<Reached>>& supports, float support) {
  constexpr int kTaken = 4;
  const auto n = static_cast<int>(graph.rest.rows());
  struct Near {
    float distance;
    int node;
    bool operator<(const Near& other) const {
      return distance != other.distance ? distance < other.distance : node < other.node;
    }
  };
  std::vector<std::vector<Near>> near(n);
  for (size_t j = 0; j < supports.size(); ++j)
    for (const Reached& reached : supports[j]) near[reached.vertex].push_back({reached.distance, static_cast<int>(j)});
  graph.offsets.assign(1, 0);
  for (std::vector<Near>& of_vertex : near) {
    std::sort(of_vertex.begin(), of_vertex.end());
    const size_t taken = std::min<size_t>(kTaken, of_vertex.size());
    const auto farthest = static_cast<double>(of_vertex.size() > taken ? of_vertex[taken].distance : support);
    for (size_t k = 0; k < taken; ++k) {
      const double rest = 1 - static_cast<double>(of_vertex[k].distance) / farthest;
      graph.nodes.push_back(of_vertex[k].node);
      // Five nodes at one distance, as on a grid, would leave none.
      graph.weights.push_back(std::max(rest * rest, 1e-6));
    }
    graph.offsets.push_back(static_cast<int>(graph.nodes.size()));
  }
}

void normalize(DeformationGraph& graph) {
  for (size_t v = 0; v + 1 < graph.offsets.size(); ++v) {
    double sum = 0;
    for (int k = graph.offsets[v]; k < graph.offsets[v + 1]; ++k) sum += graph.weights[k];
    for (int k = graph.offsets[v]; k < graph.offsets[v + 1]; ++k) graph.weights[k] /= sum;
  }
}

/// The node that moves each vertex most; -1: none.
std::vector<int> heaviest_nodes(const DeformationGraph& graph) {
  std::vector<int> heaviest(graph.rest.rows(), -1);
  for (size_t v = 0; v < heaviest.size(); ++v) {
    double most = 0;
    for (int k = graph.offsets[v]; k < graph.offsets[v + 1]; ++k)
      if (graph.weights[k] > most) {
        most = graph.weights[k];
        heaviest[v] = graph.nodes[k];
      }
  }
  return heaviest;
}

/// Pairs of nodes that a vertex has in common. Where triangles are larger than supports, vertices have none in common;
/// so the heaviest nodes of neighbours are pairs, too, and what is connected stays so.
std::vector<std::pair<int, int>> find_edges(const DeformationGraph& graph, const EdgeGraph& surface) {
  const auto n = static_cast<int>(graph.rest.rows());
  const Grouped vertices_of(graph.size(), [&](const auto& add) {
    for (int v = 0; v < n; ++v)
      for (int k = graph.offsets[v]; k < graph.offsets[v + 1]; ++k) add(graph.nodes[k], v);
  });
  const std::vector<int> heaviest = heaviest_nodes(graph);
  std::vector<std::pair<int, int>> edges;
  std::vector<int> last_seen(graph.size(), -1);
  for (int j = 0; j < graph.size(); ++j) {
    const size_t first = edges.size();
    const auto join = [&](int other) {
      if (other <= j || last_seen[other] == j) return;
      last_seen[other] = j;
      edges.emplace_back(j, other);
    };
    for (const int v : vertices_of.of(j)) {
      for (int k = graph.offsets[v]; k < graph.offsets[v + 1]; ++k) join(graph.nodes[k]);
      // Arcs have both directions, so the lower node of a pair finds the other one.
      if (heaviest[v] == j)
        for (const EdgeGraph::Arc& arc : surface.arcs(v)) join(heaviest[arc.vertex]);
    }
    std::sort(edges.begin() + static_cast<std::ptrdiff_t>(first), edges.end());
  }
  return edges;
}

}  // namespace

Positions DeformationGraph::rest_state() const {
  Positions state = Positions::Zero(Eigen::Index{kNodeRows} * size(), 3);
  for (int j = 0; j < size(); ++j) rows_of(state, j).topRows<3>().setIdentity();
  return state;
}

void DeformationGraph::move(const Positions& state, const Workers& workers, Positions& result) const {
  using State = Eigen::Matrix<double, kNodeRows, 3, Eigen::RowMajor>;
  // Only what differs from rest, so that nothing moves there by rounding.
  const Positions change = state - rest_state();
  result.resize(rest.rows(), 3);
  parallel_for<2048>(workers, static_cast<int>(rest.rows()), [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      Eigen::RowVector3d shift = Eigen::RowVector3d::Zero();
      for (int k = offsets[v]; k < offsets[v + 1]; ++k) {
        const Eigen::Map<const State> of_node(change.row(Eigen::Index{kNodeRows} * nodes[k]).data());
        const Eigen::RowVector3d arm = rest.row(v) - node(nodes[k]);
        shift += weights[k] * (arm * of_node.topRows<3>() + of_node.row(3));
      }
      result.row(v) = rest.row(v) + shift;
    }
  });
}

DeformationGraph::Combination DeformationGraph::of_state(const std::vector<int>& of_vertices,
                                                         const std::vector<double>& factors) const {
  Combination result;
  for (size_t i = 0; i < of_vertices.size(); ++i) {
    const int v = of_vertices[i];
    for (int k = offsets[v]; k < offsets[v + 1]; ++k) {
      const double factor = factors[i] * weights[k];
      const Eigen::RowVector3d arm = rest.row(v) - node(nodes[k]);
      for (int a = 0; a < kNodeRows; ++a) {
        result.row.indices.push_back(kNodeRows * nodes[k] + a);
        result.row.coefficients.push_back(factor * (a < 3 ? arm[a] : 1));
      }
      result.constant += factor * node(nodes[k]);
    }
  }
  return result;
}

DeformationGraph make_graph(const PolygonMesh& mesh, const EmbeddedOptions& options, int threads,
                            const MeterPart& meter) {
  const double distance = options.node_distance;
  DeformationGraph graph;
  graph.rest = mesh.positions();
  const std::vector<std::vector<int>> mirrors = find_mirrors(mesh, threads, meter.part(0.1));
  const auto links = find_thickness_links(mesh, distance, mirrors, threads, meter.part(0.2));
  const EdgeGraph surface(neighbours(mesh), graph.rest, threads, links);
  meter.tell();
  const std::vector<double> areas = vertex_areas(mesh);
  if (options.weights == GraphWeights::kSmooth) {
    take_smooth(graph, choose_rotation_nodes(surface, mesh, areas, distance, mirrors, {}, threads, meter.part(0.6)));
  } else {
    // Within it there are a dozen nodes on a surface.
    const auto support = static_cast<float>(4 * distance);
    graph.vertices = sample_poisson_disk(surface, graph.rest, areas, distance, mirrors, {}, meter.part(0.3)).vertices;
    take_nearest(graph, find_supports(surface, graph.vertices, support, threads, meter.part(0.3)), support);
  }
  normalize(graph);
  graph.edges = find_edges(graph, surface);
  meter.tell();
  return graph;
}

}  // namespace arap
