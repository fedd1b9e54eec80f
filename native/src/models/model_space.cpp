// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/model_space.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <utility>

#include "base/processor.h"
#include "mesh/surface_measures.h"
#include "parallel/parallel.h"

namespace arap {

namespace {

/// Rows that a thread takes at once.
constexpr int kRows = 4096;

/// Rows ahead that are fetched: the model's order is another one, so the processor cannot know what is read next.
constexpr int kRowsAhead = 24;

/// The mesh elsewhere, number(v) for each of its vertices.
template <class Number>
PolygonMesh with_vertices(const PolygonMesh& mesh, Positions positions, const Number& number) {
  std::vector<int> corners;
  std::vector<int> sizes;
  corners.reserve(mesh.n_corners());
  sizes.reserve(mesh.n_faces());
  for (int f = 0; f < mesh.n_faces(); ++f) {
    for (const int v : mesh.face(f)) corners.push_back(number(v));
    sizes.push_back(static_cast<int>(mesh.face(f).size()));
  }
  return {std::move(positions), std::move(corners), std::move(sizes)};
}

}  // namespace

ModelSpace::ModelSpace(const Positions& rest, const std::vector<int>& part_of_vertex)
    : model_vertex_(part_of_vertex.size()), input_vertex_(part_of_vertex.size()) {
  const Eigen::AlignedBox3d box = box_of_parts(rest, part_of_vertex);
  center_ = box.center().transpose();
  const double diagonal = box.diagonal().norm();
  if (diagonal > 0) size_ = diagonal;
  std::iota(model_vertex_.begin(), model_vertex_.end(), 0);
  std::iota(input_vertex_.begin(), input_vertex_.end(), 0);
  for (int v = 0; v < n_input_vertices(); ++v)
    if (part_of_vertex[v] < 0) loose_.push_back({v, rest.row(v) - center_});
}

void ModelSpace::join(const std::vector<int>& same_as) {
  input_vertex_.clear();
  for (int v = 0; v < n_input_vertices(); ++v) {
    const int first = same_as[v];
    if (first == v) {
      model_vertex_[v] = static_cast<int>(input_vertex_.size());
      input_vertex_.push_back(v);
    } else {
      model_vertex_[v] = model_vertex_[first];
    }
  }
  // What is joined to a vertex of a part is not loose.
  std::vector<int> n_others(input_vertex_.size(), 0);
  for (const int m : model_vertex_) ++n_others[m];
  for (const Loose& loose : loose_) --n_others[model_vertex_[loose.vertex]];
  std::erase_if(loose_, [&](const Loose& loose) { return n_others[model_vertex_[loose.vertex]] > 0; });
}

void ModelSpace::renumber(const std::vector<int>& new_of_old) {
  std::vector<int> renumbered(input_vertex_.size());
  for (size_t m = 0; m < input_vertex_.size(); ++m) renumbered[new_of_old[m]] = input_vertex_[m];
  input_vertex_ = std::move(renumbered);
  for (int& m : model_vertex_) m = new_of_old[m];
}

Positions ModelSpace::to_model(const Positions& of_input, const Workers& workers) const {
  Positions result(n_model_vertices(), 3);
  parallel_for<kRows>(workers, n_model_vertices(), [&](int begin, int end) {
    for (int m = begin; m < end; ++m) result.row(m) = (of_input.row(input_vertex_[m]) - center_) / size_;
  });
  for (const Loose& loose : loose_)
    result.row(model_vertex_[loose.vertex]) = (of_input.row(loose.vertex) - center_ - loose.shift) / size_;
  return result;
}

Positions ModelSpace::targets_to_model(const Positions& targets, const ConstraintSet& of_input) const {
  Positions result = points_to_model(targets);
  if (loose_.empty()) return result;
  for (size_t k = 0; k < of_input.vertices.size(); ++k) {
    const auto found = std::lower_bound(loose_.begin(), loose_.end(), of_input.vertices[k],
                                        [](const Loose& loose, int v) { return loose.vertex < v; });
    if (found != loose_.end() && found->vertex == of_input.vertices[k])
      result.row(static_cast<Eigen::Index>(k)) -= found->shift / size_;
  }
  return result;
}

Positions ModelSpace::to_input(const Positions& of_model, const Workers& workers) const {
  Positions result;
  to_input(of_model, workers, result);
  return result;
}

void ModelSpace::to_input(const Positions& of_model, const Workers& workers, Positions& result) const {
  result.resize(n_input_vertices(), 3);
  parallel_for<kRows>(workers, n_input_vertices(), [&](int begin, int end) {
    for (int v = begin; v < end; ++v) result.row(v) = of_model.row(model_vertex_[v]) * size_ + center_;
  });
  for (const Loose& loose : loose_) result.row(loose.vertex) += loose.shift;
}

bool ModelSpace::write_to_input(const Positions& of_model, const Workers& workers, std::span<float> of_input) const {
  const bool is_finite = parallel_all<kRows>(workers, n_input_vertices(), [&](int begin, int end) {
    double zero = 0;  // not a number as soon as one of the numbers is not finite
    for (int v = begin; v < end; ++v) {
      prefetch(of_model.data() + std::ptrdiff_t{3} * model_vertex_[std::min(v + kRowsAhead, end - 1)]);
      const Eigen::RowVector3f x = (of_model.row(model_vertex_[v]) * size_ + center_).cast<float>();
      Eigen::RowVector3f::Map(of_input.data() + std::ptrdiff_t{3} * v) = x;
      // Not in single precision, whose range the sum of three finite numbers may leave.
      zero += 0 * x.cast<double>().sum();
    }
    return zero == 0;
  });
  return is_finite && parallel_all<kRows>(workers, static_cast<int>(loose_.size()), [&](int begin, int end) {
           bool are_finite = true;
           for (int l = begin; l < end; ++l) {
             const auto& [v, shift] = loose_[l];
             auto x = Eigen::RowVector3f::Map(of_input.data() + std::ptrdiff_t{3} * v);
             x = (of_model.row(model_vertex_[v]) * size_ + center_ + shift).cast<float>();
             are_finite = are_finite && x.allFinite();
           }
           return are_finite;
         });
}

double ModelSpace::energy_to_input(double energy, int dimension) const {
  for (int k = 0; k < dimension; ++k) energy *= size_;
  return energy;
}

Positions ModelSpace::gradient_to_input(const Positions& of_model, int dimension) const {
  const double scale = energy_to_input(1, dimension - 1);
  Positions result = Positions::Zero(n_input_vertices(), 3);
  for (int m = 0; m < n_model_vertices(); ++m) result.row(input_vertex_[m]) = of_model.row(m) * scale;
  return result;
}

std::vector<double> ModelSpace::to_model(const std::vector<double>& of_input) const {
  std::vector<double> result;
  if (of_input.empty()) return result;
  result.reserve(input_vertex_.size());
  for (const int v : input_vertex_) result.push_back(of_input[v]);
  return result;
}

std::vector<int> ModelSpace::regions_to_model(const std::vector<int>& of_input) const {
  std::vector<int> result(of_input.empty() ? 0 : input_vertex_.size(), -1);
  for (size_t v = 0; v < of_input.size(); ++v) {
    int& region = result[model_vertex_[v]];
    if (of_input[v] >= 0 && (region < 0 || of_input[v] < region)) region = of_input[v];
  }
  return result;
}

PolygonMesh ModelSpace::make_model(const PolygonMesh& mesh) const {
  return with_vertices(mesh, to_model(mesh.positions(), Workers(1)), [&](int v) { return model_vertex_[v]; });
}

PolygonMesh ModelSpace::beside_model(const PolygonMesh& mesh) const {
  return with_vertices(mesh, points_to_model(mesh.positions()), [](int v) { return v; });
}

Segment ModelSpace::to_model(const Segment& of_input) const {
  return {(of_input.head - center_.transpose()) / size_, (of_input.tail - center_.transpose()) / size_};
}

ConstraintSet ModelSpace::to_model(ConstraintSet of_input) const {
  for (std::vector<int>* vertices : {&of_input.vertices, &of_input.patches.vertices})
    for (int& v : *vertices) v = model_vertex_[v];
  for (Segment& segment : of_input.segments) segment = to_model(segment);
  return of_input;
}

}  // namespace arap
