// SPDX-License-Identifier: GPL-3.0-or-later
#include "sampling/rotation_nodes.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>

#include "base/offsets.h"
#include "parallel/parallel.h"
#include "sampling/node_supports.h"
#include "sampling/poisson_disk.h"

namespace arap {

namespace {

/// Support of the weights, in radii.
constexpr double kSupport = 2;
/// Least share of a node in the surface, as a part of r^2: faces without area need rotations too.
constexpr double kLeastShare = .01;
/// Steps of balance(): further ones change little.
constexpr int kBalancings = 4;
/// In (1, 2): four steps then do as much as six.
constexpr double kOverRelaxation = 1.5;
/// Parts of the time that the samples and the supports take.
constexpr double kSampling = 0.5;
constexpr double kSupports = 0.3;
/// Least squared support of a vertex, as a part of the squared support: the nodes that cover a vertex stay inside.
constexpr double kLeastSupport = .5;

/// s_j^2. The corners of a triangle share their weights, which widens them by the triangle's variance. The mean squared
/// distance of a weight from its node, s_j^2 / 3 on a small triangle, should be the same on a large one.
double squared_support(double support, double variance) {
  const double whole = support * support;
  return std::max(whole - 3 * variance, kLeastSupport * whole);
}

/// A vertex in the support of a node, and its weight before normalization.
struct Weighted {
  int vertex;
  float weight;
};
using WeightedSupports = std::vector<std::vector<Weighted>>;

WeightedSupports find_weights(const EdgeGraph& graph, const std::vector<double>& variances,
                              const std::vector<int>& nodes, double radius, int threads, const MeterPart& meter) {
  const double support = kSupport * radius;
  std::vector<std::vector<Reached>> supports = find_supports(graph, nodes, static_cast<float>(support), threads, meter);
  WeightedSupports result(nodes.size());
  parallel_for(threads, static_cast<int>(nodes.size()), [&](int begin, int end) {
    for (int c = begin; c < end; ++c) {
      for (const auto& [vertex, distance] : supports[c]) {
        const auto d = static_cast<double>(distance);
        const double weight = 1 - d * d / squared_support(support, variances[vertex]);
        if (weight > 0) result[c].push_back({vertex, static_cast<float>(weight)});
      }
      supports[c] = {};
    }
  });
  return result;
}

/// At each vertex 1 / (sum over its entries of share times weight).
std::vector<double> reciprocal_sums(const RotationNodes& entries, const std::vector<double>& shares, int threads) {
  std::vector<double> reciprocals(entries.offsets.size() - 1);
  parallel_for(threads, static_cast<int>(reciprocals.size()), [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      double sum = 0;
      for (int k = entries.offsets[v]; k < entries.offsets[v + 1]; ++k)
        sum += shares[entries.nodes[k]] * entries.weights[k];
      reciprocals[v] = 1 / sum;
    }
  });
  return reciprocals;
}

/// Makes the sums at the vertices more even: divides each share by the harmonic mean of the sums in its node's support
/// [Richardson 1972, Lucy 1974; as Sinkhorn's scaling]. Shares stay positive.
void balance(std::vector<double>& shares, const RotationNodes& entries, const WeightedSupports& supports,
             const std::vector<double>& areas, int threads) {
  const std::vector<double> reciprocals = reciprocal_sums(entries, shares, threads);
  parallel_for(threads, entries.size(), [&](int begin, int end) {
    for (int c = begin; c < end; ++c) {
      double sum = 0;
      double whole = 0;
      for (const Weighted& reached : supports[c]) {
        const double part = areas[reached.vertex] * static_cast<double>(reached.weight);
        sum += part * reciprocals[reached.vertex];
        whole += part;
      }
      if (whole > 0) shares[c] *= std::pow(sum / whole, kOverRelaxation);
    }
  });
}

}  // namespace

std::vector<double> face_variances(const PolygonMesh& mesh) {
  std::vector<double> variances(mesh.n_vertices(), 0);
  std::vector<int> n_faces(mesh.n_vertices(), 0);
  const Positions& p = mesh.positions();
  for (int f = 0; f < mesh.n_faces(); ++f) {
    const std::span<const int> face = mesh.face(f);
    const double share = 1 / static_cast<double>(face.size());
    Eigen::RowVector3d centre = Eigen::RowVector3d::Zero();
    for (const int v : face) centre += share * p.row(v);
    double variance = 0;
    for (const int v : face) variance += share * (p.row(v) - centre).squaredNorm();
    for (const int v : face) {
      variances[v] += variance;
      ++n_faces[v];
    }
  }
  for (size_t v = 0; v < variances.size(); ++v) variances[v] /= std::max(1, n_faces[v]);
  return variances;
}

RotationNodes choose_rotation_nodes(const EdgeGraph& graph, const PolygonMesh& mesh, const std::vector<double>& areas,
                                    double radius, const std::vector<std::vector<int>>& mirrors,
                                    const std::vector<int>& group, int threads, const MeterPart& meter) {
  RotationNodes result;
  DiskSamples samples =
      sample_poisson_disk(graph, mesh.positions(), areas, radius, mirrors, group, meter.part(kSampling));
  std::vector<double> shares = std::move(samples.areas);
  for (double& share : shares) share = std::max(share, kLeastShare * radius * radius);
  result.vertices = std::move(samples.vertices);
  const std::vector<double> variances = face_variances(mesh);
  meter.tell();
  const WeightedSupports supports =
      find_weights(graph, variances, result.vertices, radius, threads, meter.part(kSupports));
  meter.tell();
  result.offsets.assign(graph.n_vertices() + 1, 0);
  for (const std::vector<Weighted>& support : supports)
    for (const Weighted& reached : support) ++result.offsets[reached.vertex + 1];
  make_offsets(result.offsets);
  result.nodes.resize(result.offsets.back());
  result.weights.resize(result.offsets.back());
  std::vector<int> next(result.offsets.begin(), result.offsets.end() - 1);
  for (size_t c = 0; c < supports.size(); ++c)
    for (const Weighted& reached : supports[c]) {
      const int slot = next[reached.vertex]++;
      result.nodes[slot] = static_cast<int>(c);
      result.weights[slot] = static_cast<double>(reached.weight);
    }
  meter.tell();
  for (int k = 0; k < kBalancings; ++k) {
    balance(shares, result, supports, areas, threads);
    meter.add((1 - kSampling - kSupports) / kBalancings);
  }
  const std::vector<double> reciprocals = reciprocal_sums(result, shares, threads);
  parallel_for(threads, graph.n_vertices(), [&](int begin, int end) {
    for (int v = begin; v < end; ++v)
      for (int k = result.offsets[v]; k < result.offsets[v + 1]; ++k)
        result.weights[k] *= shares[result.nodes[k]] * reciprocals[v];
  });
  return result;
}

RotationNodes node_at_each_vertex(int n_vertices) {
  RotationNodes result;
  result.vertices.resize(n_vertices);
  std::iota(result.vertices.begin(), result.vertices.end(), 0);
  result.nodes = result.vertices;
  result.offsets = result.vertices;
  result.offsets.push_back(n_vertices);
  result.weights.assign(n_vertices, 1.0);
  return result;
}

}  // namespace arap
