// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/lattice_arap/sheets.h"

#include <algorithm>
#include <set>
#include <utility>

#include "base/eigen_compat.h"

namespace arap {

Sheets::Sheets(const PolygonMesh& mesh, const Lattice& lattice, const VertexProperties& properties, int threads,
               const Progress& progress)
    : number_(mesh.n_vertices(), -1) {
  for (int v = 0; v < mesh.n_vertices(); ++v)
    if (mesh.part_of_vertex()[v] >= 0 && lattice.piece_of_vertex()[v] < 0) {
      number_[v] = static_cast<int>(vertices_.size());
      vertices_.push_back(v);
    }
  if (vertices_.empty()) return;
  const PolygonMesh surface = cut_out(mesh);
  size_ = std::max(surface.diagonal(), 1e-6);
  Options options;
  options.rigidity_radius = std::min(1.0, options.rigidity_radius / size_);
  options.threads = threads;
  VertexProperties of_surface;
  for (const int v : vertices_) {
    if (!properties.stiffness.empty()) of_surface.stiffness.push_back(properties.stiffness[v]);
    if (!properties.rigid_regions.empty()) of_surface.rigid_regions.push_back(properties.rigid_regions[v]);
  }
  surface_ = std::make_unique<PosedSurface>(surface, options, of_surface, progress);
}

PolygonMesh Sheets::cut_out(const PolygonMesh& mesh) {
  std::vector<int> corners;
  std::vector<int> sizes;
  for (int f = 0; f < mesh.n_faces(); ++f) {
    const std::span<const int> face = mesh.face(f);
    if (number_[face[0]] < 0) continue;
    for (const int v : face) corners.push_back(number_[v]);
    sizes.push_back(static_cast<int>(face.size()));
  }
  PolygonMesh surface(mesh.positions()(vertices_, all), std::move(corners), std::move(sizes));
  parts_.assign(surface.n_parts(), -1);
  for (size_t k = 0; k < vertices_.size(); ++k)
    parts_[surface.part_of_vertex()[k]] = mesh.part_of_vertex()[vertices_[k]];
  return surface;
}

Sheets::Change Sheets::prepare(const ConstraintSet& of_mesh, const Progress& progress) {
  Change change;
  if (empty()) return change;
  ConstraintSet set;
  std::vector<char> is_held(vertices_.size(), 0);
  for (size_t k = 0; k < of_mesh.vertices.size(); ++k) {
    const int number = number_[of_mesh.vertices[k]];
    // Vertices at one place are one, and the first one is what it does.
    if (number < 0 || is_held[number] != 0) continue;
    is_held[number] = 1;
    set.vertices.push_back(number);
    if (!of_mesh.strengths.empty()) set.strengths.push_back(of_mesh.strengths[k]);
    change.targets.push_back(static_cast<int>(k));
  }
  for (int p = 0; p < of_mesh.patches.size(); ++p) {
    Patch patch;
    bool is_whole = true;
    for (int k = of_mesh.patches.offsets[p]; k < of_mesh.patches.offsets[p + 1]; ++k) {
      if (!(of_mesh.patches.weights[k] > 0)) continue;
      patch.vertices.push_back(number_[of_mesh.patches.vertices[k]]);
      patch.weights.push_back(of_mesh.patches.weights[k]);
      is_whole = is_whole && patch.vertices.back() >= 0;
    }
    // One that is partly on what has cubes is held there.
    if (!is_whole) continue;
    set.patches.add(patch);
    change.targets.push_back(static_cast<int>(of_mesh.vertices.size()) + p);
  }
  if (!change.targets.empty()) change.of_surface = surface_->posed.prepare(set, progress);
  std::set<int> constrained;
  for (const std::vector<int>* held : {&set.vertices, &set.patches.vertices})
    for (const int number : *held) constrained.insert(parts_[surface_->posed.part_of_vertex()[number]]);
  change.constrained_parts.assign(constrained.begin(), constrained.end());
  return change;
}

void Sheets::take(Change change) noexcept {
  if (empty()) return;
  surface_->posed.take(std::move(change.of_surface));
  targets_ = std::move(change.targets);
}

SolveResult Sheets::solve(const Positions& targets, SolveOptions options, std::span<const Matrix3> rotations,
                          const Progress& progress) {
  SolveResult result;
  result.stop_reason = StopReason::kConverged;
  if (targets_.empty()) {
    take(at_rest());
    return result;
  }
  options.accuracy /= size_;
  std::vector<Matrix3> of_targets;
  if (!rotations.empty())
    for (const int t : targets_) of_targets.push_back(rotations[t]);
  result = surface_->posed.solve(targets(targets_, all), options, of_targets, progress, {});
  result.step *= size_;
  return result;
}

void Sheets::write(Positions& points) const {
  if (empty()) return;
  const Positions of_surface = surface_->posed.positions();
  for (size_t k = 0; k < vertices_.size(); ++k) points.row(vertices_[k]) = of_surface.row(static_cast<Eigen::Index>(k));
}

void Sheets::take(Pose pose) noexcept {
  if (!empty()) surface_->posed.take(std::move(pose));
}

void Sheets::undo() noexcept {
  if (!empty()) surface_->posed.undo();
}

}  // namespace arap
