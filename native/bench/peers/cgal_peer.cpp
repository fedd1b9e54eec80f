// SPDX-License-Identifier: GPL-3.0-or-later
// CGAL's Surface_mesh_deformation on a task file of triangles, with the commands of peers/worker.py.
//
//   cgal_peer TASK ENERGY POSITIONS
#include <CGAL/Surface_mesh_deformation.h>
#include <CGAL/version.h>

#include <exception>
#include <fstream>
#include <iostream>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>

#include "cgal_mesh.h"
#include "process.h"
#include "task_file.h"

namespace {

using Mesh = arap::bench::CgalMesh;
using arap::bench::cgal_vertex;
using arap::bench::Stopwatch;

template <CGAL::Deformation_algorithm_tag kEnergy>
class Peer {
 public:
  Peer(const std::string& task_path, std::string positions_path)
      : task_(task_path),
        positions_path_(std::move(positions_path)),
        mesh_(arap::bench::cgal_mesh(task_.positions.data(), static_cast<int>(task_.positions.rows()),
                                     task_.corner_vertices.data(), static_cast<int>(task_.face_sizes.size()))) {}

  std::string answer(const std::string& command) {
    std::istringstream words(command);
    std::string name;
    unsigned number = 0;
    words >> name >> number;
    if (name == "version") return R"({"version": ")" CGAL_VERSION_STR R"("})";
    if (name == "bind") return bind();
    if (name == "solve") return solve(number);
    if (name == "memory") return R"({"peak_mb": )" + std::to_string(arap::bench::peak_memory_mb()) + '}';
    throw std::runtime_error("no command " + name);
  }

 private:
  using Deformation = CGAL::Surface_mesh_deformation<Mesh, CGAL::Default, CGAL::Default, kEnergy>;

  std::string bind() {
    deformation_.reset();
    const Stopwatch watch;
    deformation_ = std::make_unique<Deformation>(mesh_);
    deformation_->insert_roi_vertices(vertices(mesh_).begin(), vertices(mesh_).end());
    for (const int v : task_.constrained) deformation_->insert_control_vertex(cgal_vertex(v));
    if (!deformation_->preprocess()) throw std::runtime_error("CGAL could not factorize the system");
    std::ostringstream out;
    out << R"({"ms": )" << watch.ms() << '}';
    return out.str();
  }

  std::string solve(unsigned n_iterations) {
    if (!deformation_) throw std::runtime_error("bind first");
    deformation_->reset();
    for (size_t k = 0; k < task_.constrained.size(); ++k)
      deformation_->set_target_position(cgal_vertex(task_.constrained[k]),
                                        {task_.targets(k, 0), task_.targets(k, 1), task_.targets(k, 2)});
    const Stopwatch watch;
    deformation_->deform(n_iterations, 0.0);
    std::ostringstream out;
    out << R"({"ms": )" << watch.ms() << '}';
    write_positions();
    // The rest shape again: a later bind takes it from the mesh.
    deformation_->reset();
    return out.str();
  }

  void write_positions() const {
    arap::Positions positions(task_.positions.rows(), 3);
    arap::bench::copy_positions(mesh_, positions.data());
    std::ofstream file(positions_path_, std::ios::binary);
    file.write(reinterpret_cast<const char*>(positions.data()),
               static_cast<std::streamsize>(positions.size() * sizeof(double)));
  }

  arap::bench::TaskFile task_;
  std::string positions_path_;
  Mesh mesh_;
  std::unique_ptr<Deformation> deformation_;
};

template <class SomePeer>
void serve(SomePeer peer) {
  for (std::string command; std::getline(std::cin, command);) std::cout << peer.answer(command) << std::endl;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc != 4) throw std::runtime_error("usage: cgal_peer TASK ENERGY POSITIONS");
    const std::string energy = argv[2];
    if (energy == "spokes")
      serve(Peer<CGAL::ORIGINAL_ARAP>(argv[1], argv[3]));
    else if (energy == "spokes_and_rims")
      serve(Peer<CGAL::SPOKES_AND_RIMS>(argv[1], argv[3]));
    else
      throw std::runtime_error("no energy " + energy);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
