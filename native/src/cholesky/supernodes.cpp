// SPDX-License-Identifier: GPL-3.0-or-later
#include "cholesky/supernodes.h"

#include <algorithm>
#include <iterator>
#include <queue>
#include <utility>

#include "base/permutation.h"
#include "cholesky/elimination_tree.h"

namespace arap {

namespace {

/// Supernodes without their rows: a tree of nodes with sizes.
struct Nodes {
  std::vector<int> first_column;  ///< (size + 1,), in the elimination tree's ordering
  std::vector<int> n_columns;
  std::vector<int> n_rows;
  std::vector<int> parent;

  [[nodiscard]] int size() const { return static_cast<int>(n_columns.size()); }
};

/// A column belongs to the supernode of the column before it if that is its only child and has the same rows plus its
/// own.
Nodes fundamental_supernodes(const EliminationTree& tree) {
  const auto n = static_cast<int>(tree.ordering.size());
  std::vector<int> n_children(n, 0);
  for (const int p : tree.parent)
    if (p >= 0) ++n_children[p];
  Nodes nodes;
  std::vector<int> node_of(n);
  for (int k = 0; k < n; ++k) {
    const bool continues =
        k > 0 && tree.parent[k - 1] == k && n_children[k] == 1 && tree.count[k - 1] == tree.count[k] + 1;
    if (!continues) nodes.first_column.push_back(k);
    node_of[k] = static_cast<int>(nodes.first_column.size()) - 1;
  }
  const auto n_nodes = static_cast<int>(nodes.first_column.size());
  nodes.first_column.push_back(n);
  for (int s = 0; s < n_nodes; ++s) {
    const int last = nodes.first_column[s + 1] - 1;
    nodes.n_columns.push_back(last + 1 - nodes.first_column[s]);
    nodes.n_rows.push_back(tree.count[last] - 1);
    nodes.parent.push_back(tree.parent[last] < 0 ? -1 : node_of[tree.parent[last]]);
  }
  return nodes;
}

/// Joins children with their parents while that saves time, bottom up. Afterwards `nodes` holds the sizes of joined
/// nodes at their topmost members. Returns for each node the topmost member of its joined node.
///
/// The gain of a child only shrinks while the parent grows, so only the top of the heap has to be updated.
std::vector<int> amalgamate(Nodes& nodes) {
  const int n = nodes.size();
  std::vector<int> joined(n);
  std::vector<int> first_child(n, -1);
  std::vector<int> next_sibling(n, -1);
  for (int s = n - 1; s >= 0; --s) {
    joined[s] = s;
    if (nodes.parent[s] < 0) continue;
    next_sibling[s] = first_child[nodes.parent[s]];
    first_child[nodes.parent[s]] = s;
  }
  for (int s = 0; s < n; ++s) {
    const auto gain = [&](int child) {
      return solve_cost(nodes.n_columns[child], nodes.n_rows[child]) + solve_cost(nodes.n_columns[s], nodes.n_rows[s]) -
             solve_cost(nodes.n_columns[child] + nodes.n_columns[s], nodes.n_rows[s]);
    };
    std::priority_queue<std::pair<double, int>> candidates;
    const auto add = [&](int child) {
      const double g = gain(child);
      if (g > 0) candidates.emplace(g, child);
    };
    std::vector<int> adopted;  // children of joined nodes that are not joined themselves
    for (int c = first_child[s]; c >= 0; c = next_sibling[c]) add(c);
    while (!candidates.empty()) {
      const int child = candidates.top().second;
      candidates.pop();
      const double g = gain(child);
      if (!(g > 0)) continue;
      if (!candidates.empty() && g < candidates.top().first) {
        candidates.emplace(g, child);
        continue;
      }
      joined[child] = s;
      nodes.n_columns[s] += nodes.n_columns[child];
      for (int c = first_child[child]; c >= 0;) {
        const int next = next_sibling[c];
        add(c);
        adopted.push_back(c);
        c = next;
      }
    }
    for (const int c : adopted) {
      nodes.parent[c] = s;
      if (joined[c] != c) continue;
      next_sibling[c] = first_child[s];
      first_child[s] = c;
    }
    // Remove joined nodes from the list of children.
    int* link = &first_child[s];
    while (*link >= 0) {
      if (joined[*link] == *link)
        link = &next_sibling[*link];
      else
        *link = next_sibling[*link];
    }
  }
  // Follow to the topmost member; parents come after children.
  for (int s = n - 1; s >= 0; --s) joined[s] = joined[joined[s]];
  return joined;
}

/// Columns and parents of the joined nodes, in postorder.
SupernodalStructure arrange(const EliminationTree& tree, const Nodes& nodes, const std::vector<int>& joined) {
  const int n = nodes.size();
  std::vector<int> tops;  // the topmost members, ascending
  std::vector<int> top_index(n, -1);
  for (int s = 0; s < n; ++s) {
    if (joined[s] != s) continue;
    top_index[s] = static_cast<int>(tops.size());
    tops.push_back(s);
  }
  std::vector<int> parent;
  parent.reserve(tops.size());
  for (const int s : tops) parent.push_back(nodes.parent[s] < 0 ? -1 : top_index[joined[nodes.parent[s]]]);
  std::vector<std::vector<int>> members(tops.size());
  for (int s = 0; s < n; ++s) members[top_index[joined[s]]].push_back(s);

  SupernodalStructure structure;
  structure.ordering.reserve(tree.ordering.size());
  const std::vector<int> post = postorder(parent);
  const std::vector<int> post_index = inverse_permutation(post);
  for (const int t : post) {
    Supernode supernode{};
    supernode.first_column = static_cast<int>(structure.ordering.size());
    supernode.n_columns = nodes.n_columns[tops[t]];
    supernode.parent = parent[t] < 0 ? -1 : post_index[parent[t]];
    for (const int s : members[t])
      structure.ordering.insert(structure.ordering.end(), tree.ordering.begin() + nodes.first_column[s],
                                tree.ordering.begin() + nodes.first_column[s + 1]);
    structure.supernodes.push_back(supernode);
  }
  return structure;
}

/// The rows of a supernode are those of its columns in A and those of its children, except its own columns.
void find_rows(const SparseMatrix& pattern, SupernodalStructure& structure) {
  const std::vector<int> new_index = inverse_permutation(structure.ordering);
  auto& supernodes = structure.supernodes;
  std::vector<int> next_sibling(supernodes.size(), -1);
  std::vector<int> first_child(supernodes.size(), -1);
  std::vector<int> seen_by(structure.ordering.size(), -1);
  for (int s = 0; s < std::ssize(supernodes); ++s) {
    Supernode& node = supernodes[s];
    node.rows_offset = structure.rows.size();
    const auto add = [&](int row) {
      if (row < node.end_column() || seen_by[row] == s) return;
      seen_by[row] = s;
      structure.rows.push_back(row);
    };
    for (int c = node.first_column; c < node.end_column(); ++c)
      for (SparseMatrix::InnerIterator it(pattern, structure.ordering[c]); it; ++it) add(new_index[it.row()]);
    for (int child = first_child[s]; child >= 0; child = next_sibling[child])
      for (int k = 0; k < supernodes[child].n_rows; ++k) add(structure.rows[supernodes[child].rows_offset + k]);
    node.n_rows = static_cast<int>(structure.rows.size() - node.rows_offset);
    std::sort(structure.rows.end() - node.n_rows, structure.rows.end());
    if (node.parent < 0) continue;
    next_sibling[s] = first_child[node.parent];
    first_child[node.parent] = s;
  }
}

}  // namespace

double solve_cost(int n_columns, int n_rows) {
  // Measured: the call, each stored number (read twice), each gathered and scattered row, each column.
  constexpr double kSupernode = 40;
  constexpr double kNumber = 0.2;
  constexpr double kRow = 2;
  constexpr double kColumn = 1;
  const auto padded = [](int n) { return static_cast<double>(n + (4 - n % 4) % 4); };  // stored are tiles of 4 x 4
  const double c = padded(n_columns);
  const double r = padded(n_rows);
  return kSupernode + kNumber * (c * (c + 4) + 2 * c * r) + kRow * r + kColumn * c;
}

SupernodalStructure make_supernodes(const SparseMatrix& pattern, std::vector<int> ordering) {
  const EliminationTree tree = make_elimination_tree(pattern, std::move(ordering));
  Nodes nodes = fundamental_supernodes(tree);
  const std::vector<int> joined = amalgamate(nodes);
  SupernodalStructure structure = arrange(tree, nodes, joined);
  find_rows(pattern, structure);
  return structure;
}

}  // namespace arap
