// SPDX-License-Identifier: GPL-3.0-or-later
#include "energy/split_cells.h"

#include <algorithm>
#include <numeric>

#include "base/offsets.h"

namespace arap {

namespace {

/// Where a cell has more pieces than this, the largest one gets all that has held vertices only: shares of specks would
/// be many times the memory of the rest.
constexpr size_t kMostShares = 4;

class Splitter {
 public:
  Splitter(const Cells& cells, const Positions& rest, const std::vector<int>& parts, const std::vector<char>& is_member)
      : cells_(cells), rest_(rest), parts_(parts), is_member_(is_member) {}

  /// False if no cell has vertices of two parts.
  bool find_pieces();
  /// Shares what has held vertices only.
  void find_shares(const CellTerms::Reader& terms, const MeterPart& meter);
  [[nodiscard]] CellChanges changes(const CellTerms::Reader& terms, const MeterPart& meter) const;
  [[nodiscard]] const std::vector<int>& origins() const { return origins_; }

 private:
  /// What a split cell has of a part.
  struct Piece {
    int cell;
    int part;
    int number = -1;  ///< of the new cell
    int home = -1;
    double size = 0;   ///< energy of its terms if nothing turned, as a measure of the surface
    double share = 0;  ///< of what has held vertices only

    [[nodiscard]] bool operator<(const Piece& other) const {
      return cell < other.cell || (cell == other.cell && part < other.part);
    }
    [[nodiscard]] bool operator==(const Piece& other) const { return cell == other.cell && part == other.part; }
  };

  [[nodiscard]] bool is_member(int v) const { return !is_member_.empty() && is_member_[v] != 0; }
  [[nodiscard]] bool stays_whole(int cell) const {
    const int home = cells_.home(cell);
    return parts_[home] < 0 && is_member(home);
  }
  [[nodiscard]] bool is_split(int cell) const { return slot_of_cell_[cell] >= 0; }
  [[nodiscard]] std::span<const Piece> pieces_of(int cell) const {
    const int slot = slot_of_cell_[cell];
    return std::span(pieces_).subspan(offsets_[slot], offsets_[slot + 1] - offsets_[slot]);
  }
  [[nodiscard]] std::span<Piece> pieces_of(int cell) {
    const int slot = slot_of_cell_[cell];
    return std::span(pieces_).subspan(offsets_[slot], offsets_[slot + 1] - offsets_[slot]);
  }
  /// Which of pieces_of() a part has.
  [[nodiscard]] size_t place_of(int cell, int part) const {
    const std::span<const Piece> pieces = pieces_of(cell);
    return static_cast<size_t>(std::lower_bound(pieces.begin(), pieces.end(), Piece{.cell = cell, .part = part}) -
                               pieces.begin());
  }
  /// -1 if all are held.
  [[nodiscard]] int part_of(std::span<const int> vertices) const {
    for (const int v : vertices)
      if (parts_[v] >= 0) return parts_[v];
    return -1;
  }
  void number_pieces();
  void find_homes();
  /// use(cell, part, q) for what a vertex has of split cells; part -1: held vertices only.
  template <class Use>
  void for_each_split(int v, const CellTerms::Reader& terms, const Use& use) const;

  const Cells& cells_;
  const Positions& rest_;
  const std::vector<int>& parts_;
  const std::vector<char>& is_member_;
  std::vector<Piece> pieces_;  ///< by cell and part
  std::vector<int> slot_of_cell_;
  std::vector<int> offsets_{0};                     ///< of each slot, in the pieces
  std::vector<std::vector<const Piece*>> sharers_;  ///< of each slot: what gets of held vertices
  std::vector<int> cell_of_home_;                   ///< of split cells, -1 elsewhere
  std::vector<char> has_split_;                     ///< (n,) vertices with split cells
  std::vector<int> origins_;
};

bool Splitter::find_pieces() {
  const auto n = static_cast<int>(parts_.size());
  const auto is_free = [](int part) { return part >= 0; };
  const auto any = std::find_if(parts_.begin(), parts_.end(), is_free);
  if (std::all_of(any, parts_.end(), [&](int part) { return !is_free(part) || part == *any; })) return false;
  std::vector<int> first(cells_.size(), -1);
  slot_of_cell_.assign(cells_.size(), -1);
  int n_split = 0;
  for (int v = 0; v < n; ++v) {
    if (parts_[v] < 0) continue;
    cells_.for_each_cell(v, [&](int c, const Vector3& /*q*/) {
      if (first[c] < 0)
        first[c] = parts_[v];
      else if (first[c] != parts_[v] && !is_split(c) && !stays_whole(c))
        slot_of_cell_[c] = n_split++;
    });
  }
  if (n_split == 0) return false;
  for (int v = 0; v < n; ++v)
    if (parts_[v] >= 0)
      cells_.for_each_cell(v, [&](int c, const Vector3& /*q*/) {
        if (is_split(c)) pieces_.push_back({.cell = c, .part = parts_[v]});
      });
  std::sort(pieces_.begin(), pieces_.end());
  pieces_.erase(std::unique(pieces_.begin(), pieces_.end()), pieces_.end());
  number_pieces();
  find_homes();
  return true;
}

void Splitter::number_pieces() {
  int slot = 0;
  for (auto piece = pieces_.begin(); piece != pieces_.end(); ++slot) {
    const int cell = piece->cell;
    slot_of_cell_[cell] = slot;
    const auto end =
        std::find_if(piece, pieces_.end(), [&](const Piece& of_another) { return of_another.cell != cell; });
    offsets_.push_back(static_cast<int>(end - pieces_.begin()));
    // The piece of its home stays the cell. A held home has any.
    const int part = parts_[cells_.home(cell)];
    const auto kept = std::find_if(piece, end, [&](const Piece& p) { return p.part == part; });
    Piece& same = kept == end ? *piece : *kept;
    same.number = cell;
    same.home = cells_.home(cell);
    for (; piece != end; ++piece) {
      if (piece->number >= 0) continue;
      piece->number = cells_.size() + static_cast<int>(origins_.size());
      origins_.push_back(cell);
    }
  }
}

void Splitter::find_homes() {
  const auto n = static_cast<int>(parts_.size());
  cell_of_home_.assign(n, -1);
  for (const Piece& piece : pieces_) cell_of_home_[cells_.home(piece.cell)] = piece.cell;
  has_split_.assign(n, 0);
  for (int v = 0; v < n; ++v)
    cells_.for_each_cell(v, [&](int c, const Vector3& /*q*/) {
      if (!is_split(c)) return;
      has_split_[v] = 1;
      if (parts_[v] < 0) return;
      Piece& piece = pieces_of(c)[place_of(c, parts_[v])];
      if (piece.home < 0 || (piece.number != c && is_member(piece.home) && !is_member(v))) piece.home = v;
    });
}

template <class Use>
void Splitter::for_each_split(int v, const CellTerms::Reader& terms, const Use& use) const {
  if (parts_[v] >= 0) {
    cells_.for_each_cell(v, [&](int c, const Vector3& q) {
      if (is_split(c)) use(c, parts_[v], q);
    });
  } else if (has_split_[v] != 0) {
    terms.read(v, [&](std::span<const int> vertices, int home, const Vector3& q) {
      if (const int c = cell_of_home_[home]; c >= 0) use(c, part_of(vertices), q);
    });
  }
}

void Splitter::find_shares(const CellTerms::Reader& terms, const MeterPart& meter) {
  const auto n = static_cast<int>(parts_.size());
  for (int v = 0; v < n; ++v) {
    meter.add_nth(v, n);
    for_each_split(v, terms, [&](int c, int part, const Vector3& q) {
      if (part >= 0) pieces_of(c)[place_of(c, part)].size += (rest_.row(v) - rest_.row(cells_.home(c))).dot(q);
    });
  }
  sharers_.resize(offsets_.size() - 1);
  for (size_t slot = 0; slot < sharers_.size(); ++slot) {
    std::vector<Piece*> largest;
    for (int k = offsets_[slot]; k < offsets_[slot + 1]; ++k) largest.push_back(&pieces_[k]);
    std::stable_sort(largest.begin(), largest.end(), [](const Piece* a, const Piece* b) { return a->size > b->size; });
    if (largest.size() > kMostShares) largest.erase(largest.begin() + 1, largest.end());
    double sum = 0;
    for (const Piece* piece : largest) sum += std::max(0.0, piece->size);
    for (Piece* piece : largest)
      piece->share = sum > 0 ? std::max(0.0, piece->size) / sum : 1 / static_cast<double>(largest.size());
    sharers_[slot].assign(largest.begin(), largest.end());
  }
}

CellChanges Splitter::changes(const CellTerms::Reader& terms, const MeterPart& meter) const {
  CellChanges result;
  for (const Piece& piece : pieces_) result.cells.push_back({piece.number, piece.home});
  std::sort(result.cells.begin(), result.cells.end(), [](const auto& a, const auto& b) { return a.number < b.number; });
  RowAccumulator<Vector3> row(cells_.size() + static_cast<int>(origins_.size()));
  for (int v = 0; v < static_cast<int>(parts_.size()); ++v) {
    meter.add_nth(v, static_cast<int>(parts_.size()));
    if (has_split_[v] == 0) continue;
    cells_.for_each_cell(v, [&](int c, const Vector3& q) {
      if (!is_split(c)) row[c] += q;
    });
    for_each_split(v, terms, [&](int c, int part, const Vector3& q) {
      if (part >= 0)
        row[pieces_of(c)[place_of(c, part)].number] += q;
      else
        for (const Piece* piece : sharers_[slot_of_cell_[c]]) row[piece->number] += piece->share * q;
    });
    result.vertices.push_back({v, row.entries()});
    row.clear();
  }
  return result;
}

}  // namespace

std::unique_ptr<SplitCells> split_cells(const Cells& cells, const CellTerms& terms, const Positions& rest,
                                        const std::vector<int>& parts, const std::vector<char>& is_member, int threads,
                                        const MeterPart& meter) {
  Splitter splitter(cells, rest, parts, is_member);
  if (!splitter.find_pieces()) return nullptr;
  const std::unique_ptr<const CellTerms::Reader> reader = terms.open();
  splitter.find_shares(*reader, meter.part(0.3));
  return std::make_unique<SplitCells>(SplitCells{
      Cells(cells, splitter.changes(*reader, meter.part(0.3)), threads, meter.part(0.4)), splitter.origins()});
}

}  // namespace arap
