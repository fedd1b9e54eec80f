// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/surface_arap/surface_terms.h"

#include <array>
#include <utility>

#include "base/permutation.h"
#include "models/surface_arap/surface_assembler.h"

namespace arap {

namespace {

class SurfaceReader final : public CellTerms::Reader {
 public:
  SurfaceReader(const PolygonMesh& mesh, const Options& options, const std::vector<double>& stiffness,
                const RotationNodes& nodes, const std::vector<int>& new_of_old)
      : assembler_(mesh, options, stiffness),
        nodes_(nodes),
        new_of_old_(new_of_old),
        old_of_new_(inverse_permutation(new_of_old)) {}

  void read(int vertex, const Use& use) const override {
    assembler_.for_each_term(old_of_new_[vertex], [&](std::array<int, 3> vertices, int i, const Vector3& q) {
      for (int& v : vertices) v = new_of_old_[v];
      for (int e = nodes_.offsets[i]; e < nodes_.offsets[i + 1]; ++e)
        use(vertices, new_of_old_[nodes_.vertices[nodes_.nodes[e]]], nodes_.weights[e] * q);
    });
  }

 private:
  SurfaceAssembler assembler_;
  const RotationNodes& nodes_;
  const std::vector<int>& new_of_old_;
  std::vector<int> old_of_new_;
};

}  // namespace

SurfaceTerms::SurfaceTerms(PolygonMesh mesh, const Options& options, std::vector<double> stiffness, RotationNodes nodes,
                           std::vector<int> new_of_old)
    : mesh_(std::move(mesh)),
      options_(options),
      stiffness_(std::move(stiffness)),
      nodes_(std::move(nodes)),
      new_of_old_(std::move(new_of_old)) {}

std::unique_ptr<const CellTerms::Reader> SurfaceTerms::open() const {
  return std::make_unique<SurfaceReader>(mesh_, options_, stiffness_, nodes_, new_of_old_);
}

}  // namespace arap
