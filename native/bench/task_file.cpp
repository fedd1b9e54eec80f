// SPDX-License-Identifier: GPL-3.0-or-later
#include "task_file.h"

#include <array>
#include <cstdint>
#include <fstream>
#include <stdexcept>

namespace arap::bench {

namespace {

template <class Value>
void read(std::ifstream& file, Value* values, std::int64_t count) {
  file.read(reinterpret_cast<char*>(values), static_cast<std::streamsize>(count * sizeof(Value)));
}

}  // namespace

TaskFile::TaskFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::array<std::int64_t, 4> counts = {};  // vertices, corners, faces, constrained vertices
  read(file, counts.data(), 4);
  if (!file) throw std::runtime_error(path + ": no task file");
  positions.resize(counts[0], 3);
  corner_vertices.resize(counts[1]);
  face_sizes.resize(counts[2]);
  constrained.resize(counts[3]);
  targets.resize(counts[3], 3);
  read(file, positions.data(), positions.size());
  read(file, corner_vertices.data(), counts[1]);
  read(file, face_sizes.data(), counts[2]);
  read(file, constrained.data(), counts[3]);
  read(file, targets.data(), targets.size());
  if (!file) throw std::runtime_error(path + ": the file ends before its arrays do; write it again");
}

}  // namespace arap::bench
