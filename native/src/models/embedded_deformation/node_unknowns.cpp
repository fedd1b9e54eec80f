// SPDX-License-Identifier: GPL-3.0-or-later
#include "models/embedded_deformation/node_unknowns.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <utility>

#include "dense/small_matrices.h"
#include "geometry/rotation_vectors.h"
#include "models/embedded_deformation/deformation_graph.h"

namespace arap {

namespace {

/// Of the largest entry of K's diagonal. A node whose vertices lie on a line may turn about it freely.
constexpr double kDamping = 1e-9;

double damping_of(const SparseMatrix& K) { return kDamping * K.diagonal().maxCoeff(); }

/// Rows of a node: the columns of A, and t.
using Linear = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

Linear linear_part(const Positions& state, int node) { return state.middleRows<3>(Eigen::Index{kNodeRows} * node); }

/// Where an entry of a compressed matrix is in its values.
int slot_of(const SparseMatrix& matrix, int row, int column) {
  const int* begin = matrix.innerIndexPtr() + matrix.outerIndexPtr()[column];
  const int* end = matrix.innerIndexPtr() + matrix.outerIndexPtr()[column + 1];
  return static_cast<int>(std::lower_bound(begin, end, row) - matrix.innerIndexPtr());
}

using Curvature = NodeUnknowns::Curvature;

/// What a matrix has of the second derivatives of a node.
Matrix3 taken(Curvature curvature, const Matrix3& symmetric) {
  return curvature == Curvature::kWhole ? symmetric : positive_part(symmetric);
}

/// Affine nodes: the unknowns are all numbers of the state, row by row.
class AffineNodes final : public NodeUnknowns {
 public:
  AffineNodes(double weight, const SparseMatrix& K)
      : weight_(weight), n_nodes_(static_cast<int>(K.cols()) / kNodeRows) {
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(3 * K.nonZeros() + Eigen::Index{kSquares} * n_nodes_);
    for (int column = 0; column < K.cols(); ++column)
      for (SparseMatrix::InnerIterator it(K, column); it; ++it)
        for (int c = 0; c < 3; ++c)
          entries.emplace_back(3 * static_cast<int>(it.row()) + c, 3 * column + c, it.value());
    const double damping = damping_of(K);
    for (int k = 0; k < 3 * K.cols(); ++k) entries.emplace_back(k, k, damping);
    for_own([&](int row, int column) { entries.emplace_back(row, column, 0.0); });
    matrix_.resize(3 * K.cols(), 3 * K.cols());
    matrix_.setFromTriplets(entries.begin(), entries.end());
    constant_.assign(matrix_.valuePtr(), matrix_.valuePtr() + matrix_.nonZeros());
    slots_.reserve(static_cast<size_t>(kSquares) * n_nodes_);
    for_own([&](int row, int column) { slots_.push_back(slot_of(matrix_, row, column)); });
  }

  [[nodiscard]] int per_node() const override { return 3 * kNodeRows; }

  [[nodiscard]] double energy(const Positions& state) const override {
    double sum = 0;
    for (int j = 0; j < n_nodes_; ++j) sum += errors(linear_part(state, j)).squaredNorm();
    return weight_ * sum;
  }

  const SparseMatrix& matrix(const Positions& state, const Positions& /*of_state*/, Curvature curvature) override {
    std::copy(constant_.begin(), constant_.end(), matrix_.valuePtr());
    for (int j = 0; j < n_nodes_; ++j) {
      const Linear columns = linear_part(state, j);
      const Jacobian J = jacobian(columns);
      const Matrix3 bent = taken(curvature, second_derivatives(errors(columns)));
      Eigen::Matrix<double, kOwn, kOwn> own = J.transpose() * J;
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b)
          own.block<3, 3>(Eigen::Index{3} * a, Eigen::Index{3} * b).diagonal().array() += bent(a, b);
      own *= weight_;
      for (int k = 0; k < kSquares; ++k)
        matrix_.valuePtr()[slots_[static_cast<size_t>(kSquares) * j + k]] += own(k % kOwn, k / kOwn);
    }
    return matrix_;
  }

  [[nodiscard]] Eigen::VectorXd gradient(const Positions& state, const Positions& of_state) const override {
    Eigen::VectorXd result = of_state.reshaped<Eigen::RowMajor>();
    for (int j = 0; j < n_nodes_; ++j) {
      const Linear columns = linear_part(state, j);
      result.segment<kOwn>(Eigen::Index{kPerNode} * j) += weight_ * jacobian(columns).transpose() * errors(columns);
    }
    return result;
  }

  [[nodiscard]] Positions stepped(const Positions& state, const Eigen::VectorXd& step) const override {
    return state + step.reshaped<Eigen::RowMajor>(state.rows(), 3);
  }

 private:
  static constexpr int kPerNode = 3 * kNodeRows;
  static constexpr int kOwn = 9;  ///< unknowns of A
  static constexpr int kSquares = kOwn * kOwn;
  static constexpr int kErrors = 6;
  using Errors = Eigen::Matrix<double, kErrors, 1>;
  using Jacobian = Eigen::Matrix<double, kErrors, kOwn>;
  /// Pairs of columns whose products an error compares with those of a rotation [SSP07] Eq. (5).
  static constexpr std::array<std::pair<int, int>, kErrors> kPairs = {{{0, 1}, {0, 2}, {1, 2}, {0, 0}, {1, 1}, {2, 2}}};

  static Errors errors(const Linear& columns) {
    Errors result;
    for (int k = 0; k < kErrors; ++k) {
      const auto [a, b] = kPairs[k];
      result[k] = columns.row(a).dot(columns.row(b)) - (a == b ? 1 : 0);
    }
    return result;
  }

  static Jacobian jacobian(const Linear& columns) {
    Jacobian J = Jacobian::Zero();
    for (int k = 0; k < kErrors; ++k) {
      const auto [a, b] = kPairs[k];
      J.block<1, 3>(k, Eigen::Index{3} * a) += columns.row(b);
      J.block<1, 3>(k, Eigen::Index{3} * b) += columns.row(a);
    }
    return J;
  }

  /// Of the columns, sum_k errors_k times the second derivative of error k: the same for x, y and z.
  static Matrix3 second_derivatives(const Errors& errors) {
    Matrix3 result = Matrix3::Zero();
    for (int k = 0; k < kErrors; ++k) {
      const auto [a, b] = kPairs[k];
      result(a, b) += errors[k];
      result(b, a) += errors[k];
    }
    return result;
  }

  /// use(row, column) for the entries of each node's own term, column by column.
  template <class Use>
  void for_own(const Use& use) const {
    for (int j = 0; j < n_nodes_; ++j)
      for (int k = 0; k < kSquares; ++k) use(kPerNode * j + k % kOwn, kPerNode * j + k / kOwn);
  }

  double weight_;
  int n_nodes_;
  SparseMatrix matrix_;
  std::vector<double> constant_;  ///< values of the matrix without the nodes' own term
  std::vector<int> slots_;        ///< of the entries of the nodes' own term
};

/// Rigid nodes: three unknowns turn a node, A <- exp([w]) A, and three move it.
class RigidNodes final : public NodeUnknowns {
 public:
  explicit RigidNodes(const SparseMatrix& K)
      : damping_(damping_of(K)), n_nodes_(static_cast<int>(K.cols()) / kNodeRows) {
    std::vector<Eigen::Triplet<double>> entries;
    for_blocks(K, [&](int row_node, int column_node, const Eigen::Matrix4d& block) {
      for (int column = 0; column < kUnknowns; ++column)
        for (int row = 0; row < kUnknowns; ++row)
          entries.emplace_back(kUnknowns * row_node + row, kUnknowns * column_node + column, 0.0);
      blocks_.push_back({row_node, column_node, 0, block});
    });
    matrix_.resize(Eigen::Index{kUnknowns} * n_nodes_, Eigen::Index{kUnknowns} * n_nodes_);
    matrix_.setFromTriplets(entries.begin(), entries.end());
    for (Block& block : blocks_) block.slot = slot_of(matrix_, kUnknowns * block.row, kUnknowns * block.column);
  }

  [[nodiscard]] int per_node() const override { return kUnknowns; }
  [[nodiscard]] double energy(const Positions& /*state*/) const override { return 0; }

  const SparseMatrix& matrix(const Positions& state, const Positions& of_state, Curvature curvature) override {
    for (const Block& block : blocks_) {
      Eigen::Matrix<double, kUnknowns, kUnknowns> own = turned(block, state);
      if (block.row == block.column) {
        own.diagonal().array() += damping_;
        own.topLeftCorner<3, 3>() += taken(curvature, second_derivatives(state, of_state, block.row));
      }
      const int* starts = matrix_.outerIndexPtr() + std::ptrdiff_t{kUnknowns} * block.column;
      for (int column = 0; column < kUnknowns; ++column) {
        // All columns of a node have the same rows.
        double* values = matrix_.valuePtr() + block.slot + (starts[column] - starts[0]);
        for (int row = 0; row < kUnknowns; ++row) values[row] = own(row, column);
      }
    }
    return matrix_;
  }

  [[nodiscard]] Eigen::VectorXd gradient(const Positions& state, const Positions& of_state) const override {
    Eigen::VectorXd result(Eigen::Index{kUnknowns} * n_nodes_);
    for (int j = 0; j < n_nodes_; ++j) {
      const Linear columns = linear_part(state, j);
      const Linear of_columns = linear_part(of_state, j);
      Eigen::RowVector3d turn = Eigen::RowVector3d::Zero();
      for (int a = 0; a < 3; ++a)
        turn += Eigen::RowVector3d(columns.row(a)).cross(Eigen::RowVector3d(of_columns.row(a)));
      result.segment<3>(Eigen::Index{kUnknowns} * j) = turn.transpose();
      result.segment<3>(Eigen::Index{kUnknowns} * j + 3) = of_state.row(Eigen::Index{kNodeRows} * j + 3).transpose();
    }
    return result;
  }

  [[nodiscard]] Positions stepped(const Positions& state, const Eigen::VectorXd& step) const override {
    Positions result = state;
    for (int j = 0; j < n_nodes_; ++j) {
      const Matrix3 R = rotation_by(step.segment<3>(Eigen::Index{kUnknowns} * j)).toRotationMatrix();
      result.middleRows<3>(Eigen::Index{kNodeRows} * j) = linear_part(state, j) * R.transpose();
      result.row(Eigen::Index{kNodeRows} * j + 3) += step.segment<3>(Eigen::Index{kUnknowns} * j + 3).transpose();
    }
    return result;
  }

 private:
  static constexpr int kUnknowns = 6;

  struct Block {
    int row;
    int column;
    int slot;  ///< of its first entry
    Eigen::Matrix4d K;
  };

  /// use(row node, column node, block of K) for all blocks with an entry, also those below the diagonal.
  template <class Use>
  void for_blocks(const SparseMatrix& K, const Use& use) const {
    std::vector<int> place(n_nodes_, -1);
    std::vector<std::pair<int, Eigen::Matrix4d>> of_node;
    for (int j = 0; j < n_nodes_; ++j) {
      of_node.clear();
      for (int b = 0; b < kNodeRows; ++b)
        for (SparseMatrix::InnerIterator it(K, kNodeRows * j + b); it; ++it) {
          const int other = static_cast<int>(it.row()) / kNodeRows;
          if (place[other] < 0) {
            place[other] = static_cast<int>(of_node.size());
            of_node.emplace_back(other, Eigen::Matrix4d::Zero());
          }
          of_node[place[other]].second(it.row() % kNodeRows, b) = it.value();
        }
      for (const auto& [other, block] : of_node) {
        place[other] = -1;
        use(other, j, block);
      }
    }
  }

  /// B_row^T (K x I) B_column, B the change of a state by the unknowns: row a of a node changes by w x row a.
  static Eigen::Matrix<double, kUnknowns, kUnknowns> turned(const Block& block, const Positions& state) {
    const Linear of_row = linear_part(state, block.row);
    const Linear of_column = linear_part(state, block.column);
    const Matrix3 products = of_column.transpose() * block.K.topLeftCorner<3, 3>().transpose() * of_row;
    Eigen::Matrix<double, kUnknowns, kUnknowns> result;
    result.topLeftCorner<3, 3>() = products.trace() * Matrix3::Identity() - products;
    result.topRightCorner<3, 3>() = cross_with(of_row.transpose() * block.K.topRightCorner<3, 1>());
    result.bottomLeftCorner<3, 3>() = -cross_with(of_column.transpose() * block.K.bottomLeftCorner<1, 3>().transpose());
    result.bottomRightCorner<3, 3>() = block.K(3, 3) * Matrix3::Identity();
    return result;
  }

  /// By the turn w of a node, the second derivative of <of_state, exp([w]) A>.
  static Matrix3 second_derivatives(const Positions& state, const Positions& of_state, int node) {
    const Matrix3 products = linear_part(of_state, node).transpose() * linear_part(state, node);
    return (products + products.transpose()) / 2 - products.trace() * Matrix3::Identity();
  }

  /// The matrix of x -> v x x.
  static Matrix3 cross_with(const Vector3& v) {
    Matrix3 result;
    result << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
    return result;
  }

  double damping_;
  int n_nodes_;
  std::vector<Block> blocks_;
  SparseMatrix matrix_;
};

}  // namespace

std::unique_ptr<NodeUnknowns> NodeUnknowns::make(GraphNodes kind, double rotation_weight, const SparseMatrix& K) {
  if (kind == GraphNodes::kRigid) return std::make_unique<RigidNodes>(K);
  return std::make_unique<AffineNodes>(rotation_weight, K);
}

}  // namespace arap
