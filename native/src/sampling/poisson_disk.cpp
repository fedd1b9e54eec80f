// SPDX-License-Identifier: GPL-3.0-or-later
#include "sampling/poisson_disk.h"

#include <algorithm>
#include <utility>

#include "sampling/dijkstra.h"

namespace arap {

namespace {

/// A sample moves by less than this part of r. A vertex stays nearer than 1.4 r to a sample: inside of its support in
/// rotation_nodes.cpp, at least sqrt(2) r.
constexpr double kFurthestMove = .4;

/// A vertex and its images under all combinations of mirrors, in the same order for each vertex.
std::vector<int> images_of(int vertex, const std::vector<std::vector<int>>& mirrors) {
  std::vector<int> images(1, vertex);
  for (const std::vector<int>& mirror : mirrors)
    for (size_t k = 0, n = images.size(); k < n; ++k) images.push_back(mirror[images[k]]);
  return images;
}

/// The samples so far, and the nearest sample to each vertex with its distance.
class Sampler {
 public:
  Sampler(const EdgeGraph& graph, double radius, const std::vector<int>& group)
      : graph_(graph),
        radius_(static_cast<float>(radius)),
        group_(group),
        distance_(graph.n_vertices(), static_cast<float>(radius)),
        nearest_(graph.n_vertices(), -1) {}

  [[nodiscard]] bool is_covered(int vertex) const { return distance_[vertex] < radius_; }
  [[nodiscard]] const std::vector<int>& samples() const { return samples_; }
  /// Index of the sample nearest to a vertex; -1 at an isolated vertex.
  [[nodiscard]] int nearest(int vertex) const { return nearest_[vertex]; }
  [[nodiscard]] double distance(int vertex) const { return static_cast<double>(distance_[vertex]); }

  void choose(int vertex) {
    if (is_sample(vertex)) return;
    const auto sample = static_cast<int>(samples_.size());
    samples_.push_back(vertex);
    distance_[vertex] = 0;
    nearest_[vertex] = sample;
    queue_.push({0, vertex});
    shorten_distances(graph_, queue_, distance_, [&](int /*from*/, int to) {
      if (!is_same_group(vertex, to)) return false;
      nearest_[to] = sample;
      return true;
    });
  }

 private:
  [[nodiscard]] bool is_sample(int vertex) const {
    return nearest_[vertex] >= 0 && samples_[nearest_[vertex]] == vertex;
  }
  [[nodiscard]] bool is_same_group(int a, int b) const { return group_.empty() || group_[a] == group_[b]; }

  const EdgeGraph& graph_;
  float radius_;
  const std::vector<int>& group_;
  std::vector<float> distance_;  ///< to the nearest sample, at most the radius
  std::vector<int> nearest_;     ///< index of that sample
  DistanceQueue queue_;
  std::vector<int> samples_;
};

Sampler choose_greedily(const EdgeGraph& graph, double radius, const std::vector<std::vector<int>>& mirrors,
                        const std::vector<int>& group, const MeterPart& meter) {
  Sampler sampler(graph, radius, group);
  constexpr double kOnPlanes = 0.1;  // of the time, if there are any
  const auto choose_where = [&](double part, const auto& is_wanted) {
    int last = 0;
    for (int v = 0; v < graph.n_vertices(); ++v)
      if (!graph.arcs(v).empty() && !sampler.is_covered(v) && is_wanted(v)) {
        for (const int image : images_of(v, mirrors))
          if (!graph.arcs(image).empty()) sampler.choose(image);
        meter.add(part * (v - std::exchange(last, v)) / graph.n_vertices());
      }
  };
  // Vertices on planes of symmetry come first: a sample beside a plane would be very close to its own image.
  for (const std::vector<int>& mirror : mirrors)
    choose_where(kOnPlanes / static_cast<double>(mirrors.size()), [&](int v) { return mirror[v] == v; });
  choose_where(mirrors.empty() ? 1 : 1 - kOnPlanes, [](int) { return true; });
  return sampler;
}

/// Area of the Voronoi cell of each sample.
std::vector<double> cell_areas(const Sampler& sampler, const std::vector<double>& areas,
                               const std::vector<std::vector<int>>& mirrors) {
  std::vector<double> sums(sampler.samples().size(), 0);
  for (int v = 0; v < static_cast<int>(areas.size()); ++v)
    if (sampler.nearest(v) >= 0) sums[sampler.nearest(v)] += areas[v];
  // Ties break the symmetry: a vertex equally near to two samples belongs to the first one. So average over images.
  for (const std::vector<int>& mirror : mirrors)
    for (int c = 0; c < static_cast<int>(sums.size()); ++c)
      if (const int image = sampler.nearest(mirror[sampler.samples()[c]]); image > c)
        sums[c] = sums[image] = (sums[c] + sums[image]) / 2;
  return sums;
}

/// Centre of the Voronoi cell of each sample.
std::vector<Vector3> cell_centres(const Sampler& sampler, const Positions& rest, const std::vector<double>& areas) {
  std::vector<Vector3> centres(sampler.samples().size(), Vector3::Zero());
  std::vector<double> sums(centres.size(), 0);
  for (int v = 0; v < static_cast<int>(areas.size()); ++v)
    if (const int c = sampler.nearest(v); c >= 0) {
      centres[c] += areas[v] * rest.row(v).transpose();
      sums[c] += areas[v];
    }
  for (size_t c = 0; c < centres.size(); ++c)
    centres[c] = sums[c] > 0 ? Vector3(centres[c] / sums[c]) : Vector3(rest.row(sampler.samples()[c]).transpose());
  return centres;
}

/// Whether a sample and its images may move to a vertex and its images: each stays in its cell and on its planes.
bool can_move(const Sampler& sampler, const std::vector<int>& images_of_sample, const std::vector<int>& images,
              double furthest) {
  for (size_t k = 0; k < images.size(); ++k) {
    const bool is_in_cell = sampler.nearest(images[k]) == sampler.nearest(images_of_sample[k]);
    if (!is_in_cell || sampler.distance(images[k]) >= furthest) return false;
    if (images_of_sample[k] == images_of_sample[0] && images[k] != images[0]) return false;
  }
  return true;
}

/// A Lloyd step: the vertex nearest to the centre of each sample's Voronoi cell.
std::vector<int> move_to_centres(const Sampler& sampler, const Positions& rest, const std::vector<double>& areas,
                                 double radius, const std::vector<std::vector<int>>& mirrors) {
  const std::vector<Vector3> centres = cell_centres(sampler, rest, areas);
  const auto off_centre = [&](int v) { return (rest.row(v).transpose() - centres[sampler.nearest(v)]).squaredNorm(); };
  std::vector<int> moved = sampler.samples();
  const double furthest = kFurthestMove * radius;
  for (int v = 0; v < static_cast<int>(areas.size()); ++v) {
    const int c = sampler.nearest(v);
    if (c < 0 || sampler.distance(v) >= furthest || off_centre(v) >= off_centre(moved[c])) continue;
    if (can_move(sampler, images_of(sampler.samples()[c], mirrors), images_of(v, mirrors), furthest)) moved[c] = v;
  }
  // Ties again: let the images follow the first sample.
  for (int c = 0; c < static_cast<int>(moved.size()); ++c) {
    const std::vector<int> samples = images_of(sampler.samples()[c], mirrors);
    const std::vector<int> images = images_of(moved[c], mirrors);
    for (size_t k = 1; k < samples.size(); ++k)
      if (const int image = sampler.nearest(samples[k]); image > c) moved[image] = images[k];
  }
  return moved;
}

}  // namespace

DiskSamples sample_poisson_disk(const EdgeGraph& graph, const Positions& rest, const std::vector<double>& areas,
                                double radius, const std::vector<std::vector<int>>& mirrors,
                                const std::vector<int>& group, const MeterPart& meter) {
  const Sampler sampler = choose_greedily(graph, radius, mirrors, group, meter);
  return {.vertices = move_to_centres(sampler, rest, areas, radius, mirrors),
          .areas = cell_areas(sampler, areas, mirrors)};
}

}  // namespace arap
