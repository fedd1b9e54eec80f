// SPDX-License-Identifier: GPL-3.0-or-later
#include "cholesky/elimination_tree.h"

#include <iterator>
#include <utility>

#include "base/permutation.h"

namespace arap {

namespace {

/// An entry (k, i) of A with i < k makes k an ancestor of i: climb from i, and make the root that is found a child of
/// k. `ancestor` holds shortcuts over paths that were climbed before.
std::vector<int> find_parents(const SparseMatrix& pattern, const std::vector<int>& ordering,
                              const std::vector<int>& new_index) {
  std::vector<int> parent(ordering.size(), -1);
  std::vector<int> ancestor(ordering.size(), -1);
  for (int k = 0; k < std::ssize(ordering); ++k) {
    for (SparseMatrix::InnerIterator it(pattern, ordering[k]); it; ++it) {
      int i = new_index[it.row()];
      while (i != -1 && i < k) {
        const int next = ancestor[i];
        ancestor[i] = k;
        if (next == -1) parent[i] = k;
        i = next;
      }
    }
  }
  return parent;
}

/// Row k of L has an entry in each column on the paths from the entries (k, i) of A up to k.
std::vector<int> count_entries(const SparseMatrix& pattern, const std::vector<int>& ordering,
                               const std::vector<int>& new_index, const std::vector<int>& parent) {
  std::vector<int> count(ordering.size(), 1);
  std::vector<int> last_row(ordering.size(), -1);
  for (int k = 0; k < std::ssize(ordering); ++k) {
    last_row[k] = k;
    for (SparseMatrix::InnerIterator it(pattern, ordering[k]); it; ++it) {
      for (int i = new_index[it.row()]; i < k && last_row[i] != k; i = parent[i]) {
        ++count[i];
        last_row[i] = k;
      }
    }
  }
  return count;
}

}  // namespace

std::vector<int> postorder(const std::vector<int>& parent) {
  const auto n = static_cast<int>(parent.size());
  std::vector<int> first_child(n, -1);
  std::vector<int> next_sibling(n, -1);
  for (int j = n - 1; j >= 0; --j) {
    if (parent[j] < 0) continue;
    next_sibling[j] = first_child[parent[j]];
    first_child[parent[j]] = j;
  }
  std::vector<int> result;
  result.reserve(n);
  std::vector<int> path;
  for (int root = 0; root < n; ++root) {
    if (parent[root] >= 0) continue;
    path.push_back(root);
    while (!path.empty()) {
      const int node = path.back();
      const int child = first_child[node];
      if (child >= 0) {
        first_child[node] = next_sibling[child];
        path.push_back(child);
      } else {
        result.push_back(node);
        path.pop_back();
      }
    }
  }
  return result;
}

EliminationTree make_elimination_tree(const SparseMatrix& pattern, std::vector<int> ordering) {
  const std::vector<int> parent = find_parents(pattern, ordering, inverse_permutation(ordering));
  const std::vector<int> post = postorder(parent);
  const std::vector<int> post_index = inverse_permutation(post);
  EliminationTree tree;
  tree.ordering.reserve(ordering.size());
  tree.parent.reserve(ordering.size());
  for (const int k : post) {
    tree.ordering.push_back(ordering[k]);
    tree.parent.push_back(parent[k] < 0 ? -1 : post_index[parent[k]]);
  }
  tree.count = count_entries(pattern, tree.ordering, inverse_permutation(tree.ordering), tree.parent);
  return tree;
}

}  // namespace arap
