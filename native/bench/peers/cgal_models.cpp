// SPDX-License-Identifier: GPL-3.0-or-later
// CGAL's Surface_mesh_deformation as a library that contenders/cgal.py loads.
//
// A call that fails returns null or false; cgal_error() then says why, until the next call.
#include <CGAL/Surface_mesh_deformation.h>
#include <CGAL/version.h>

#include <exception>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "cgal_mesh.h"

namespace {

using Mesh = arap::bench::CgalMesh;
using arap::bench::cgal_vertex;

std::string& last_error() {
  thread_local std::string text;
  return text;
}

class Model {
 public:
  virtual ~Model() = default;
  virtual void iterate(const double* targets, unsigned n_iterations, double* positions) = 0;
};

template <CGAL::Deformation_algorithm_tag kEnergy>
class Deformed final : public Model {
 public:
  Deformed(Mesh mesh, std::vector<int> constrained)
      : mesh_(std::move(mesh)), constrained_(std::move(constrained)), deformation_(mesh_) {
    deformation_.insert_roi_vertices(vertices(mesh_).begin(), vertices(mesh_).end());
    for (const int v : constrained_) deformation_.insert_control_vertex(cgal_vertex(v));
    if (!deformation_.preprocess()) throw std::runtime_error("CGAL could not factorize the system");
  }

  void iterate(const double* targets, unsigned n_iterations, double* positions) override {
    for (const int v : constrained_) {
      deformation_.set_target_position(cgal_vertex(v), {targets[0], targets[1], targets[2]});
      targets += 3;
    }
    deformation_.deform(n_iterations, 0.0);
    arap::bench::copy_positions(mesh_, positions);
  }

 private:
  Mesh mesh_;
  std::vector<int> constrained_;
  CGAL::Surface_mesh_deformation<Mesh, CGAL::Default, CGAL::Default, kEnergy> deformation_;
};

std::unique_ptr<Model> bound(const std::string& energy, Mesh mesh, std::vector<int> constrained) {
  if (energy == "spokes")
    return std::make_unique<Deformed<CGAL::ORIGINAL_ARAP>>(std::move(mesh), std::move(constrained));
  if (energy == "spokes_and_rims")
    return std::make_unique<Deformed<CGAL::SPOKES_AND_RIMS>>(std::move(mesh), std::move(constrained));
  if (energy == "smooth_rotations")
    return std::make_unique<Deformed<CGAL::SRE_ARAP>>(std::move(mesh), std::move(constrained));
  throw std::runtime_error("no energy " + energy);
}

}  // namespace

extern "C" {

const char* cgal_version() { return CGAL_VERSION_STR; }
const char* cgal_error() { return last_error().c_str(); }

/// Binds (n, 3) positions and (m, 3) triangles, with constrained vertices; cgal_free() ends it.
void* cgal_bind(const char* energy, const double* positions, int n_vertices, const int* triangles, int n_triangles,
                const int* constrained, int n_constrained) try {
  return bound(energy, arap::bench::cgal_mesh(positions, n_vertices, triangles, n_triangles),
               {constrained, constrained + n_constrained})
      .release();
} catch (const std::exception& error) {
  last_error() = error.what();
  return nullptr;
}

/// Iterations from where it is to targets, (k, 3) in the order of the constrained vertices; into positions, (n, 3).
bool cgal_iterate(void* model, const double* targets, unsigned n_iterations, double* positions) try {
  static_cast<Model*>(model)->iterate(targets, n_iterations, positions);
  return true;
} catch (const std::exception& error) {
  last_error() = error.what();
  return false;
}

void cgal_free(void* model) { delete static_cast<Model*>(model); }
}
