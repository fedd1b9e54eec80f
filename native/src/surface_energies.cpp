// SPDX-License-Identifier: GPL-3.0-or-later
#include "surface_energies.h"

#include <algorithm>

#include "arap/error.h"
#include "parallel.h"
#include "row_accumulator.h"

namespace arap {

namespace {

/// Which items (triangles or ties) name a vertex: the items of v are [offsets[v], offsets[v + 1]) of `items`.
struct Incidence {
  std::vector<int> offsets;
  std::vector<int> items;

  template <class Item>
  Incidence(int n_vertices, const std::vector<Item>& all) : offsets(n_vertices + 1, 0) {
    for (const Item& item : all)
      for (const int v : item.vertices) ++offsets[v + 1];
    for (size_t v = 1; v < offsets.size(); ++v) offsets[v] += offsets[v - 1];
    items.resize(offsets.back());
    std::vector<int> next(offsets.begin(), offsets.end() - 1);
    for (size_t i = 0; i < all.size(); ++i)
      for (const int v : all[i].vertices) items[next[v]++] = static_cast<int>(i);
  }

  /// f(item) for each item of v once; a tie that names v twice lists it twice in a row.
  template <class Function>
  void for_each(int v, const Function& f) const {
    int last = -1;
    for (int k = offsets[v]; k < offsets[v + 1]; ++k) {
      const int item = items[k];
      if (item != last) f(item);
      last = item;
    }
  }
};

class SurfaceAssembler {
 public:
  SurfaceAssembler(const PolygonMesh& mesh, const Options& options, const std::vector<double>& stiffness)
      : rest_(mesh.positions()),
        stiffness_(stiffness),
        is_spokes_(options.energy == Energy::kSpokes),
        triangulation_(triangulate(mesh, options.weights)),
        triangles_at_(mesh.n_vertices(), triangulation_.triangles),
        ties_at_(mesh.n_vertices(), triangulation_.ties) {
    if (!is_spokes_) return;
    for (Triangle& triangle : triangulation_.triangles)
      for (double& weight : triangle.half_cotangents) weight = std::max(0.0, weight);
  }

  [[nodiscard]] int n() const { return static_cast<int>(rest_.rows()); }

  /// Column i of K.
  void system_column(int i, RowAccumulator<double>& column) const {
    triangles_at_.for_each(i, [&](int t) {
      const Triangle& triangle = triangulation_.triangles[t];
      for_edges_at(triangle, i, [&](size_t edge, int j) {
        const double value = 2 * triangle.half_cotangents[edge] * cells_of_edge(triangle, edge);
        column[i] += value;
        column[j] -= value;
      });
    });
    ties_at_.for_each(i, [&](int t) {
      const Tie& tie = triangulation_.ties[t];
      double own = 0;
      for (size_t a = 0; a < 3; ++a)
        if (tie.vertices[a] == i) own += tie.coefficients[a];
      const double factor = 2 * tie.weight * stiffness(tie.vertices[0]) * own;
      for (size_t a = 0; a < 3; ++a) column[tie.vertices[a]] += factor * tie.coefficients[a];
    });
    column[i] += 0;  // the diagonal is always there, also of loose vertices
  }

  /// q of the cell of vertex i.
  void cell(int i, RowAccumulator<Vector3>& row) const {
    const double scale = 2 * stiffness(i);
    const auto add_edge = [&](int a, int b, double weight) {
      const Vector3 value = weight * (rest_.row(a) - rest_.row(b)).transpose();
      row[a] += value;
      row[b] -= value;
    };
    triangles_at_.for_each(i, [&](int t) {
      const Triangle& triangle = triangulation_.triangles[t];
      if (is_spokes_)
        for_edges_at(triangle, i, [&](size_t edge, int j) { add_edge(i, j, scale * triangle.half_cotangents[edge]); });
      else
        for (size_t edge = 0; edge < 3; ++edge)
          add_edge(triangle.vertices[(edge + 1) % 3], triangle.vertices[(edge + 2) % 3],
                   scale / 3 * triangle.half_cotangents[edge]);
    });
    ties_at_.for_each(i, [&](int t) {
      const Tie& tie = triangulation_.ties[t];
      if (tie.vertices[0] != i) return;
      Vector3 u = Vector3::Zero();
      for (size_t a = 0; a < 3; ++a) u += tie.coefficients[a] * rest_.row(tie.vertices[a]).transpose();
      for (size_t a = 0; a < 3; ++a) row[tie.vertices[a]] += scale * tie.weight * tie.coefficients[a] * u;
    });
  }

 private:
  [[nodiscard]] double stiffness(int vertex) const { return stiffness_.empty() ? 1.0 : stiffness_[vertex]; }

  /// Sum of the stiffnesses of the cells that contain an edge of a triangle, with the energy's factor.
  [[nodiscard]] double cells_of_edge(const Triangle& triangle, size_t edge) const {
    const double ends = stiffness(triangle.vertices[(edge + 1) % 3]) + stiffness(triangle.vertices[(edge + 2) % 3]);
    return is_spokes_ ? ends : (ends + stiffness(triangle.vertices[edge])) / 3;
  }

  /// f(edge, other end) for the two edges of the triangle at vertex i.
  template <class Function>
  static void for_edges_at(const Triangle& triangle, int i, const Function& f) {
    for (size_t edge = 0; edge < 3; ++edge) {
      const int a = triangle.vertices[(edge + 1) % 3];
      const int b = triangle.vertices[(edge + 2) % 3];
      if (a == i) f(edge, b);
      if (b == i) f(edge, a);
    }
  }

  const Positions& rest_;
  const std::vector<double>& stiffness_;
  bool is_spokes_;
  Triangulation triangulation_;
  Incidence triangles_at_;
  Incidence ties_at_;
};

/// Sparse rows built in parallel: each thread takes consecutive vertices, the pieces are then joined in order.
template <class Value>
struct Rows {
  std::vector<int> offsets;
  std::vector<int> vertices;
  std::vector<Value> values;

  /// @param is_own_first  whether row v begins with vertex v, where it has that; sorted by vertex otherwise
  template <class Fill>
  Rows(int n, int threads, bool is_own_first, const Fill& fill) : offsets(n + 1, 0), is_own_first_(is_own_first) {
    const Shares shares(threads, n);
    std::vector<Piece> pieces(shares.count());
    shares.for_each([&](int share, int begin, int end) { fill_piece(n, begin, end, pieces[share], fill); });
    for (size_t v = 1; v < offsets.size(); ++v) offsets[v] += offsets[v - 1];
    vertices.reserve(offsets.back());
    values.reserve(offsets.back());
    for (Piece& piece : pieces) {
      for (const auto& [vertex, value] : piece) {
        vertices.push_back(vertex);
        values.push_back(value);
      }
      Piece().swap(piece);
    }
  }

 private:
  using Piece = std::vector<typename RowAccumulator<Value>::Entry>;

  template <class Fill>
  void fill_piece(int n, int begin, int end, Piece& piece, const Fill& fill) {
    RowAccumulator<Value> row(n);
    for (int v = begin; v < end; ++v) {
      fill(v, row);
      const auto old_size = static_cast<std::ptrdiff_t>(piece.size());
      piece.insert(piece.end(), row.entries().begin(), row.entries().end());
      row.clear();
      offsets[v + 1] = static_cast<int>(std::ssize(piece) - old_size);
      const int first = is_own_first_ ? v : -1;
      std::sort(piece.begin() + old_size, piece.end(), [first](const auto& a, const auto& b) {
        return std::pair(a.first != first, a.first) < std::pair(b.first != first, b.first);
      });
    }
  }

  bool is_own_first_;
};

void report(const Progress& progress, double fraction) {
  if (progress && !progress(fraction)) throw Cancelled("binding was cancelled");
}

}  // namespace

CellEnergy assemble_surface_energy(const PolygonMesh& mesh, const Options& options,
                                   const std::vector<double>& stiffness, int threads, const Progress& progress,
                                   const std::function<void(const SparseMatrix& K)>& on_matrix) {
  report(progress, 0.1);
  const SurfaceAssembler assembler(mesh, options, stiffness);
  const int n = mesh.n_vertices();
  CellEnergy energy;
  report(progress, 0.3);
  {
    Rows<double> system(n, threads, false, [&](int i, auto& column) { assembler.system_column(i, column); });
    energy.K = Eigen::Map<const SparseMatrix>(n, n, system.values.size(), system.offsets.data(), system.vertices.data(),
                                              system.values.data());
  }
  if (on_matrix) on_matrix(energy.K);
  report(progress, 0.6);
  Rows<Vector3> cells(n, threads, true, [&](int i, auto& row) { assembler.cell(i, row); });
  energy.cell_offsets = std::move(cells.offsets);
  energy.cell_vertices = std::move(cells.vertices);
  energy.q.resize(cells.values.size(), 3);
  for (size_t k = 0; k < cells.values.size(); ++k) energy.q.row(k) = cells.values[k].transpose();
  report(progress, 0.9);
  energy.index_by_vertex();
  Positions K_rest;
  multiply(energy.K, mesh.positions(), K_rest, Workers(threads));
  energy.rest_energy = 0.5 * mesh.positions().cwiseProduct(K_rest).sum();
  return energy;
}

}  // namespace arap
