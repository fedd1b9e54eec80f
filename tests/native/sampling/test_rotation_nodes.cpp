// SPDX-License-Identifier: GPL-3.0-or-later
#include "sampling/rotation_nodes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "mesh/mirror_symmetry.h"
#include "sampling/dijkstra.h"
#include "support/helpers.h"

namespace arap_test {
namespace {

using arap::CellEnergy;
using arap::Energy;
using arap::RotationNodes;
using arap::SurfaceArap;

TEST(RotationNodes, WithTheSupportBelowTheShortestEdgeTheyAreSpokesAndRims) {
  Random random(33);
  for (const MeshData& mesh : all_small_meshes()) {
    const arap::Options classic{.energy = Energy::kSpokesAndRims};
    const Positions p = mesh.positions() + random.noise(mesh.n_vertices(), .05 * mesh.diagonal());
    const double expected = SurfaceArap(mesh.mesh(), classic).energy(p);
    EXPECT_NEAR(SurfaceArap(mesh.mesh(), {.rigidity_radius = 1e-4}).energy(p), expected, 1e-12 * expected) << mesh.name;
  }
}

TEST(RotationNodes, WeightsOfEveryVertexSumToOne) {
  for (const MeshData& mesh : all_small_meshes()) {
    const RotationNodes nodes = choose_nodes(in_model_space(mesh), .1);
    const Eigen::VectorXd sums = dense_weights(nodes, mesh.n_vertices()).rowwise().sum();
    EXPECT_LT((sums.array() - 1).abs().maxCoeff(), 1e-14) << mesh.name;
  }
}

TEST(RotationNodes, EachCellIsAtHomeAtItsNode) {
  for (const MeshData& mesh : all_small_meshes()) {
    const MeshData model = in_model_space(mesh);
    const RotationNodes nodes = choose_nodes(model, .1);
    const CellEnergy energy = surface_energy(model.mesh(), {}, {}, 1, [&] { return nodes; });
    ASSERT_EQ(energy.n_cells(), nodes.size());
    for (int c = 0; c < energy.n_cells(); ++c) EXPECT_EQ(energy.cells.home(c), nodes.vertices[c]) << mesh.name;
  }
}

/// A random permutation.
std::vector<int> shuffled(int n, std::uint64_t seed) {
  Random random(seed);
  std::vector<int> order(static_cast<size_t>(n));
  std::iota(order.begin(), order.end(), 0);
  for (int k = n - 1; k > 0; --k) std::swap(order[k], order[static_cast<int>(random.uniform(0, k + 1))]);
  return order;
}

/// The mesh whose vertex order[v] is vertex v of `mesh`.
MeshData renumbered(const MeshData& mesh, const std::vector<int>& order) {
  MeshData result = mesh;
  for (int v = 0; v < mesh.n_vertices(); ++v) result.vertices[order[v]] = mesh.vertices[v];
  for (auto& face : result.faces)
    for (int& v : face) v = order[v];
  return result;
}

TEST(RotationNodes, AnotherChoiceOfNodesMovesNothingByMuch) {
  const MeshData mesh = triangulate(bar(12, Faces::kQuads));
  const Task task = bend_task(mesh, default_bend(mesh));
  const arap::Options options{.rigidity_radius = .06};
  const Positions expected = solve_once(mesh, task, to_accuracy(1e-7), options).positions;
  for (const std::uint64_t seed : {1, 2, 3}) {
    const std::vector<int> order = shuffled(mesh.n_vertices(), seed);
    Task other = task;
    for (int& v : other.constraints.vertices) v = order[v];
    const Positions p = solve_once(renumbered(mesh, order), other, to_accuracy(1e-7), options).positions;
    EXPECT_LT(max_distance(rows(p, order), expected), .002 * mesh.diagonal());
  }
}

TEST(RotationNodes, ConvergesUnderRefinementWhereSpokesAndRimsDoesNot) {
  // Two bars of the same shape, with the same handles.
  MeshData mesh = triangulate(bar(5, Faces::kQuads));
  const int n_common = mesh.n_vertices();
  const arap::Options classic{.energy = Energy::kSpokesAndRims};
  std::vector<Positions> with_nodes_at;
  std::vector<Positions> classic_at;
  for (int level = 0; level < 3; ++level) {
    if (level > 0) mesh = subdivide(mesh);
    const Positions p = mesh.positions();
    const double end = .6 * p.col(0).maxCoeff();
    const Matrix3 turn = rotation_about(Vector3::UnitZ(), 1.5);
    Task task;
    for (int v = 0; v < mesh.n_vertices(); ++v) {
      const Vector3& rest = mesh.vertices[v];
      if (rest[0] < -end) task.add(v, rest);
      if (rest[0] > end) task.add(v, turn * (rest - Vector3(end, 0, 0)) + Vector3(.5 * end, .9 * end, 0));
    }
    with_nodes_at.emplace_back(
        solve_once(mesh, task, to_accuracy(1e-7), {.rigidity_radius = .06}).positions.topRows(n_common));
    classic_at.emplace_back(solve_once(mesh, task, to_accuracy(1e-7), classic).positions.topRows(n_common));
  }
  const double change = max_distance(with_nodes_at[2], with_nodes_at[1]) / mesh.diagonal();
  const double classic_change = max_distance(classic_at[2], classic_at[1]) / mesh.diagonal();
  EXPECT_LT(change, .005);
  EXPECT_GT(classic_change, 2 * change);
  const double coarse_change = max_distance(with_nodes_at[1], with_nodes_at[0]) / mesh.diagonal();
  EXPECT_LT(coarse_change, .01) << "from a mesh whose edges are nearly as long as the radius";
}

TEST(RotationNodes, VarianceOfAVertexIsTheMeanOfItsFaces) {
  MeshData mesh;
  for (const Vector3& p : {Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(1, 1, 0), Vector3(0, 1, 0), Vector3(2, 0, 0)})
    mesh.add_vertex(p);
  mesh.add_vertex(Vector3(5, 5, 5));  // in no face
  mesh.faces = {{0, 1, 2, 3}, {1, 4, 2}};
  const std::vector<double> variances = arap::face_variances(mesh.mesh());
  const double of_quad = .5;          // its corners are sqrt(.5) from its centre
  const double of_triangle = 4. / 9;  // a ninth of the sum of its squared sides
  const std::vector<double> expected{
      of_quad, (of_quad + of_triangle) / 2, (of_quad + of_triangle) / 2, of_quad, of_triangle, 0};
  ASSERT_EQ(variances.size(), expected.size());
  for (size_t v = 0; v < expected.size(); ++v) EXPECT_NEAR(variances[v], expected[v], 1e-15) << "vertex " << v;
}

TEST(RotationNodes, SharesOfNodesAreTheirVoronoiAreasBalanced) {
  // A strip of faces of length 1 and width 1, of which each vertex is a node. Those at the ends have half the area.
  MeshData mesh;
  for (int k = 0; k < 4; ++k) {
    mesh.add_vertex(Vector3(k, 0, 0));
    mesh.add_vertex(Vector3(k, 1, 0));
    if (k > 0) mesh.faces.push_back({2 * k - 2, 2 * k, 2 * k + 1, 2 * k - 1});
  }
  const double radius = .9;
  const RotationNodes nodes = choose_nodes(mesh, radius);
  ASSERT_EQ(nodes.size(), mesh.n_vertices());
  const double support = 4 * radius * radius - 3 * .5;  // a face variances its corners by .5
  Eigen::MatrixXd kernel(8, 8);
  for (int v = 0; v < 8; ++v)
    for (int w = 0; w < 8; ++w)
      kernel(v, w) = std::max(0., 1 - (mesh.vertices[v] - mesh.vertices[w]).squaredNorm() / support);
  Eigen::VectorXd areas(8);
  areas << .25, .25, .5, .5, .5, .5, .25, .25;
  Eigen::VectorXd shares = areas;
  for (int k = 0; k < 4; ++k) {
    const Eigen::VectorXd sums = kernel * shares;
    const Eigen::VectorXd found = (kernel * areas.cwiseQuotient(sums)).cwiseQuotient(kernel * areas);
    shares.array() *= found.array().pow(1.5);
  }
  const Eigen::MatrixXd W = dense_weights(nodes, mesh.n_vertices());
  const Eigen::VectorXd sums = kernel * shares;
  for (int v = 0; v < 8; ++v)
    for (int c = 0; c < 8; ++c) {
      const int w = nodes.vertices[c];
      EXPECT_NEAR(W(v, c), kernel(v, w) * shares[w] / sums[v], 1e-6) << "vertex " << v << ", node at " << w;
    }
}

/// Distances along the surface from a vertex to all others.
std::vector<double> distances_from(const arap::EdgeGraph& graph, int vertex) {
  std::vector<double> distances(static_cast<size_t>(graph.n_vertices()), std::numeric_limits<double>::infinity());
  arap::TruncatedDijkstra sweep(graph);
  sweep.run(std::span(&vertex, 1), 1e9F, [&](int reached, float d) { distances[reached] = static_cast<double>(d); });
  return distances;
}

/// Greedy sampling: each vertex that is not nearer than r to a sample becomes one.
std::vector<int> greedy_choice(const arap::EdgeGraph& graph, double radius) {
  std::vector<int> chosen;
  std::vector<char> is_covered(static_cast<size_t>(graph.n_vertices()), 0);
  for (int v = 0; v < graph.n_vertices(); ++v) {
    if (is_covered[v] != 0) continue;
    chosen.push_back(v);
    const std::vector<double> distances = distances_from(graph, v);
    for (int w = 0; w < graph.n_vertices(); ++w)
      if (distances[w] < radius) is_covered[w] = 1;
  }
  return chosen;
}

TEST(RotationNodes, AreChosenInTheOrderOfTheVerticesAndMoveWithinTheirAreas) {
  const double radius = .1;
  for (const MeshData& data : {grid(60, Faces::kQuads), bumpy_sphere(4)}) {
    const MeshData mesh = in_model_space(renumbered(data, shuffled(data.n_vertices(), 5)));
    const arap::EdgeGraph graph = edge_graph(mesh);
    const std::vector<int> greedy = greedy_choice(graph, radius);
    const RotationNodes nodes = choose_nodes(mesh, radius);
    ASSERT_EQ(nodes.size(), static_cast<int>(greedy.size())) << mesh.name;
    int n_moved = 0;
    for (int c = 0; c < nodes.size(); ++c) {
      if (nodes.vertices[c] != greedy[c]) ++n_moved;
      const std::vector<double> distances = distances_from(graph, nodes.vertices[c]);
      EXPECT_LT(distances[greedy[c]], .4 * radius) << mesh.name << ", node " << c;
      for (const int other : greedy) EXPECT_GE(distances[other], distances[greedy[c]]) << mesh.name << ", node " << c;
    }
    EXPECT_GT(n_moved, nodes.size() / 5) << mesh.name;
  }
}

TEST(RotationNodes, EveryVertexIsNearerThan14RadiiToANode) {
  const double radius = .1;
  for (const MeshData& data : {grid(60, Faces::kQuads), bumpy_sphere(4)})
    for (const std::uint64_t seed : {1, 2}) {
      const MeshData mesh = in_model_space(renumbered(data, shuffled(data.n_vertices(), seed)));
      const RotationNodes nodes = choose_nodes(mesh, radius);
      std::vector<float> nearest(static_cast<size_t>(mesh.n_vertices()), 1e9F);
      const arap::EdgeGraph graph = edge_graph(mesh);
      arap::TruncatedDijkstra sweep(graph);
      sweep.run(nodes.vertices, 1e9F, [&](int v, float d) { nearest[v] = d; });
      EXPECT_LT(static_cast<double>(*std::max_element(nearest.begin(), nearest.end())), 1.4 * radius) << mesh.name;
    }
}

/// A box with open seams at |x| = .25 and shuffled vertices.
MeshData box_with_seams() {
  const MeshData whole = box({8, 10, 12}, Vector3(1, .8, 1.2), Faces::kQuads);
  std::vector<std::pair<int, bool>> places;
  MeshData mesh;
  for (const auto& face : whole.faces) {
    double middle = 0;
    for (const int v : face) middle += whole.vertices[v][0] / 4;
    std::vector<int> corners;
    for (const int v : face) {
      const std::pair<int, bool> place(v, std::abs(middle) > .25);
      auto found = std::find(places.begin(), places.end(), place);
      if (found == places.end()) {
        found = places.insert(found, place);
        mesh.add_vertex(whole.vertices[v]);
      }
      corners.push_back(static_cast<int>(found - places.begin()));
    }
    mesh.faces.push_back(corners);
  }
  return renumbered(mesh, shuffled(mesh.n_vertices(), 5));
}

TEST(MirrorSymmetry, MirroredTasksOfASymmetricMeshHaveMirroredPoses) {
  std::vector<MeshData> meshes = {quad_sphere(8), box({9, 8, 12}, Vector3(1, 1, 2), Faces::kQuads), box_with_seams()};
  // Concave caps. Of the second one, corners are on one line with others, so triangles of their fans are degenerate.
  for (const double y : {-.15, -.1})
    meshes.push_back(prism({{-.6, -.5}, {-.2, y}, {.2, y}, {.6, -.5}, {.6, .5}, {.1, .2}, {-.1, .2}, {-.6, .5}}, 2, 5));
  for (const MeshData& mesh : meshes) {
    const std::vector<int> mirror = arap::find_mirrors(in_model_space(mesh).mesh(), 1).at(0);
    const auto mirrored = [&](const Positions& p) {
      Positions result = rows(p, mirror);
      result.col(0) *= -1;
      return result;
    };
    const Task task = bend_task(mesh, default_bend(mesh));
    Task other = task;
    for (int& v : other.constraints.vertices) v = mirror[v];
    other.targets.col(0) *= -1;
    for (const Model& model : all_models())
      for (const arap::SolveOptions& solve_options : {to_accuracy(1e-9), arap::SolveOptions()}) {
        arap::Options options = model.options();
        options.rigidity_radius = .08;
        const Positions p = solve_once(mesh, task, solve_options, options).positions;
        const Positions q = solve_once(mesh, other, solve_options, options).positions;
        EXPECT_LT(max_distance(mirrored(p), q), 1e-6 * mesh.diagonal()) << mesh.name << ", " << model.name();
        EXPECT_GT(max_distance(p, mesh.positions()), .05 * mesh.diagonal()) << mesh.name;
      }
  }
}

TEST(RotationNodes, ImagesOfNodesAreNodes) {
  const MeshData mesh = in_model_space(box({29, 28, 42}, Vector3(1, 1, 2), Faces::kQuads));
  const auto mirrors = arap::find_mirrors(mesh.mesh(), 2);
  ASSERT_EQ(mirrors.size(), 3u);
  const RotationNodes nodes = choose_nodes(mesh, .1, mirrors);
  const std::set<int> chosen(nodes.vertices.begin(), nodes.vertices.end());
  EXPECT_EQ(static_cast<int>(chosen.size()), nodes.size());
  for (const std::vector<int>& mirror : mirrors)
    for (const int v : chosen) EXPECT_TRUE(chosen.contains(mirror[v]));
}

TEST(MirrorSymmetry, TellsTheSidesOfASeamApart) {
  const MeshData mesh = in_model_space(box_with_seams());
  std::set<std::pair<int, int>> edges;
  for (const auto& face : mesh.faces)
    for (size_t k = 0; k < face.size(); ++k) edges.insert(std::minmax(face[k], face[(k + 1) % face.size()]));
  const auto mirrors = arap::find_mirrors(mesh.mesh(), 1);
  ASSERT_EQ(mirrors.size(), 3u);
  EXPECT_EQ(mirrors, arap::find_mirrors(mesh.mesh(), 2));
  for (const std::vector<int>& mirror : mirrors) {
    for (int v = 0; v < mesh.n_vertices(); ++v) EXPECT_EQ(mirror[mirror[v]], v);
    for (const auto& [a, b] : edges) EXPECT_TRUE(edges.contains(std::minmax(mirror[a], mirror[b]))) << a << ", " << b;
  }
}

TEST(MirrorSymmetry, FacesOfABoxThatAreAllApartAreMirroredToFaces) {
  const MeshData box_of_six = in_model_space(box({1, 1, 1}, Vector3(1, .8, 1.2), Faces::kQuads));
  ASSERT_EQ(box_of_six.faces.size(), 6u);
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    MeshData mesh;
    for (const int f : shuffled(6, seed)) {
      const int first = mesh.n_vertices();
      for (const int v : box_of_six.faces[f]) mesh.add_vertex(box_of_six.vertices[v]);
      mesh.faces.push_back({first, first + 1, first + 2, first + 3});
    }
    const auto mirrors = arap::find_mirrors(mesh.mesh(), 1);
    ASSERT_EQ(mirrors.size(), 3u) << seed;
    for (const std::vector<int>& mirror : mirrors)
      for (int v = 0; v < mesh.n_vertices(); ++v) {
        EXPECT_EQ(mirror[mirror[v]], v);
        EXPECT_EQ(mirror[v] / 4, mirror[v / 4 * 4] / 4) << "a face is torn, seed " << seed;
      }
  }
}

/// Comparing all of them would take quadratic time. One stray vertex far away makes a whole mesh as small as this.
TEST(MirrorSymmetry, IsNotLookedForAmongThousandsOfVerticesWithinTheTolerance) {
  const MeshData large = in_model_space(grid(6, Faces::kQuads));
  const MeshData small = transformed(grid(60, Faces::kQuads), [](const Vector3& p) { return Vector3(5e-5 * p); });
  EXPECT_EQ(arap::find_mirrors(large.mesh(), 2).size(), 3u);
  EXPECT_TRUE(arap::find_mirrors(join(large, small).mesh(), 2).empty());
}

TEST(RotationNodes, EveryVertexHasANodeOfItsOwnGroupNearby) {
  const MeshData mesh = in_model_space(grid(20, Faces::kQuads));
  std::vector<int> group;
  for (const Vector3& p : mesh.vertices) group.push_back(std::abs(p[0]) < .05 ? -1 : (p[0] < 0 ? 0 : 1));
  const RotationNodes nodes = choose_nodes(mesh, .2, {}, group);
  for (int v = 0; v < mesh.n_vertices(); ++v) {
    bool has_own = false;
    for (int k = nodes.offsets[v]; k < nodes.offsets[v + 1]; ++k)
      has_own = has_own || group[nodes.vertices[nodes.nodes[k]]] == group[v];
    EXPECT_TRUE(has_own) << "vertex " << v;
  }
}

TEST(RotationNodes, ResultsDoNotDependOnTheNumberOfThreads) {
  const MeshData mesh = in_model_space(bumpy_sphere(4));
  const RotationNodes one = choose_nodes(mesh, .1);
  const RotationNodes two = choose_nodes(mesh, .1, {}, {}, 2);
  EXPECT_EQ(one.vertices, two.vertices);
  EXPECT_EQ(one.nodes, two.nodes);
  EXPECT_EQ(one.weights, two.weights);
}

TEST(RotationNodes, PartsDoNotSeeEachOthersNodesAndLooseVerticesHaveNone) {
  MeshData mesh = two_spheres(1);
  const int n_connected = mesh.n_vertices();
  mesh.add_vertex(Vector3(0, 0, 0));
  mesh = in_model_space(mesh);
  const RotationNodes nodes = choose_nodes(mesh, 1);
  ASSERT_EQ(nodes.size(), 2) << "smaller than the radius, each part has one";
  for (int v = 0; v < n_connected; ++v) EXPECT_EQ(nodes.offsets[v + 1] - nodes.offsets[v], 1);
  EXPECT_EQ(nodes.offsets[n_connected], nodes.offsets[n_connected + 1]);
}

}  // namespace
}  // namespace arap_test
