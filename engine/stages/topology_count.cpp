#include "stages/topology_count.h"

#include <algorithm>
#include <bit>

#include "backend/ranges.h"
#include "stages/constant_blocks.h"
#include "stages/euler.h"

namespace vasamesh {

namespace {

constexpr int kSpeck = 8;  // voxels below which a piece is a speck
constexpr int kSlab = 16;  // layers of z a task takes

using Place = std::array<std::int64_t, 3>;

Place unpadded(std::int64_t x, std::int64_t y, std::int64_t z) {
  return {x - kPad, y - kPad, z - kPad};
}

void note(Finding& finding, std::int64_t count, const Place& place) {
  if (count == 0) return;
  if (finding.count == 0) finding.place = place;
  finding.count += count;
}

/// Calls visit(run, y, z) for every run, in raster order.
template <class Visit>
void for_each_run(const RunTable& table, const Visit& visit) {
  const int rows = table.size[1];
  std::uint32_t run = 0;
  for (int z = 0; z < table.size[2]; ++z)
    for (int y = 0; y < rows; ++y)
      for (; run < table.row_first[static_cast<std::size_t>(z) * rows + y + 1]; ++run)
        visit(run, y, z);
}

RowWindow whole(const BitView& bits) { return {{0, 0}, {bits.size[1], bits.size[2]}}; }

/// The rows that hold runs, and one more on each side.
RowWindow window_of(const RunTable& table) {
  RowWindow window{{table.size[1], table.size[2]}, {0, 0}};
  for_each_run(table, [&](std::uint32_t, int y, int z) {
    window.first = {std::min(window.first[0], y - 1), std::min(window.first[1], z - 1)};
    window.last = {std::max(window.last[0], y + 2), std::max(window.last[1], z + 2)};
  });
  return window;
}

/// Numbers the components in order of their first runs, and fills the pieces' sizes and places.
void number_pieces(const std::vector<std::uint32_t>& root, PieceLookup& lookup,
                   InputFindings& findings) {
  lookup.piece.resize(root.size());
  for_each_run(lookup.table, [&](std::uint32_t run, int y, int z) {
    const Run& r = lookup.table.runs[run];
    if (root[run] == run) {
      lookup.piece[run] = static_cast<std::int32_t>(findings.pieces.size());
      findings.pieces.push_back({0, unpadded(r.begin, y, z), 0, 0});
    }
    lookup.piece[run] = lookup.piece[root[run]];
    findings.pieces[lookup.piece[run]].voxels += r.end - r.begin;
  });
}

/// Gives each enclosed component of the background to the piece below its first voxel. That voxel
/// lies on the component's outer boundary, and so does the piece.
void count_cavities(Backend& backend, const BitView& object, int background_connectivity,
                    const PieceLookup& lookup, InputFindings& findings) {
  const RunTable background = collect_runs(backend, object, window_of(lookup.table), false);
  const auto root = connect_runs(backend, background, background_connectivity);
  for_each_run(background, [&](std::uint32_t run, int y, int z) {
    if (run == 0 || root[run] != run) return;
    const int x = background.runs[run].begin;
    ++findings.pieces[lookup.at(x, y, z - 1)].cavities;
    note(findings.cavities, 1, unpadded(x, y, z));
  });
}

void summarise_pieces(const std::vector<std::int64_t>& euler, Solid& solid) {
  InputFindings& findings = solid.findings;
  for (std::size_t p = 0; p < findings.pieces.size(); ++p) {
    Piece& piece = findings.pieces[p];
    piece.handles = 1 + piece.cavities - euler[p];
    findings.object_voxels += piece.voxels;
    note(findings.specks, piece.voxels < kSpeck, piece.first_voxel);
    note(findings.handles, piece.handles, piece.first_voxel);
    solid.topology.handles += piece.handles;
    solid.topology.cavities += piece.cavities;
  }
  solid.topology.pieces = static_cast<std::int64_t>(findings.pieces.size());
}

/// Object voxels in the first or last layer of the caller's volume along any axis.
Finding find_border_contacts(const RunTable& table, const std::array<std::int64_t, 3>& size) {
  Finding contacts;
  for_each_run(table, [&](std::uint32_t run, int y, int z) {
    const Run& r = table.runs[run];
    const std::int64_t first = kPad, last = kPad + size[0] - 1;
    if (y == kPad || y == kPad + size[1] - 1 || z == kPad || z == kPad + size[2] - 1) {
      note(contacts, r.end - r.begin, unpadded(r.begin, y, z));
      return;
    }
    if (r.begin == first) note(contacts, 1, unpadded(first, y, z));
    if (r.end - 1 == last && (last != first || r.begin != first))
      note(contacts, 1, unpadded(last, y, z));
  });
  return contacts;
}

/// One row of the object's opening by 2 x 2 x 2 voxels, taken from the object: what is left are
/// voxels without such a block round them.
class ThinRow {
 public:
  ThinRow(const BitView& object, int y, int z) : object_(object), y_(y), z_(z) {}

  /// Word i of the row; i ascending from 0.
  std::uint64_t word(int i) const {
    std::uint64_t opened = 0;
    for (int dz = 0; dz < 2; ++dz)
      for (int dy = 0; dy < 2; ++dy) {
        const std::uint64_t blocks = full_blocks(y_ + dy, z_ + dz, i);
        const std::uint64_t next =
            i + 1 < object_.words_per_row ? full_blocks(y_ + dy, z_ + dz, i + 1) : 0;
        opened |= blocks | (blocks >> 1) | (next << 63);
      }
    return at(y_, z_, i) & ~opened;
  }

 private:
  std::uint64_t at(int y, int z, int i) const { return object_.words[object_.row(y, z) + i]; }

  std::uint64_t column(int y, int z, int i) const {
    return at(y - 1, z - 1, i) & at(y, z - 1, i) & at(y - 1, z, i) & at(y, z, i);
  }

  /// Bit x is set when the eight voxels round corner (x, y, z) are object.
  std::uint64_t full_blocks(int y, int z, int i) const {
    const std::uint64_t here = column(y, z, i);
    const std::uint64_t before = i > 0 ? column(y, z, i - 1) : 0;
    return here & ((here << 1) | (before >> 63));
  }

  const BitView& object_;
  int y_, z_;
};

Finding find_one_voxel_parts(Backend& backend, const BitView& object, const RunTable& table) {
  const auto find = [&](std::size_t begin, std::size_t end) {
    Finding found;
    for (int z = static_cast<int>(begin); z < static_cast<int>(end); ++z)
      for (int y = 0; y < object.size[1]; ++y) {
        if (table.row_empty(y, z)) continue;
        const ThinRow row(object, y, z);
        for (int i = 0; i < object.words_per_row; ++i) {
          if (object.words[object.row(y, z) + i] == 0) continue;
          const std::uint64_t thin = row.word(i);
          note(found, std::popcount(thin), unpadded(64 * i + std::countr_zero(thin), y, z));
        }
      }
    return found;
  };
  Finding total;
  for (const Finding& part : map_ranges(backend, object.size[2], kSlab, find))
    note(total, part.count, part.place);
  return total;
}

Finding unpadded(const Finding& finding) {
  if (finding.count == 0) return finding;
  return {finding.count, unpadded(finding.place[0], finding.place[1], finding.place[2])};
}

}  // namespace

std::int32_t PieceLookup::at(int x, int y, int z) const {
  if (y < 0 || z < 0 || y >= table.size[1] || z >= table.size[2]) return kNone;
  const std::span<const Run> row = table.row(y, z);
  const auto run =
      std::partition_point(row.begin(), row.end(), [x](const Run& r) { return r.end <= x; });
  if (run == row.end() || run->begin > x) return kNone;
  return piece[static_cast<std::size_t>(&*run - table.runs.data())];
}

Solid examine_solid(Backend& backend, const BitView& object,
                    const std::array<std::int64_t, 3>& size, Connectivity connectivity) {
  const int contacts = static_cast<int>(connectivity);
  Solid solid;
  PieceLookup& lookup = solid.lookup;
  lookup.table = collect_runs(backend, object, whole(object), true);
  if (lookup.table.runs.empty()) return solid;
  InputFindings& findings = solid.findings;
  number_pieces(connect_runs(backend, lookup.table, contacts), lookup, findings);
  count_cavities(backend, object, contacts == 6 ? 26 : 6, lookup, findings);
  const CornerCounts corners =
      count_corners(backend, object, lookup.table, lookup.piece, findings.pieces.size(), contacts);
  summarise_pieces(corners.euler, solid);
  findings.edge_contacts = unpadded(corners.edge_contacts);
  findings.corner_contacts = unpadded(corners.corner_contacts);
  findings.border_contacts = find_border_contacts(lookup.table, size);
  findings.one_voxel_parts = find_one_voxel_parts(backend, object, lookup.table);
  findings.blocks = constant_blocks(lookup.table);
  return solid;
}

Finding drop_small_components(Backend& backend, BitVolume& object,
                              const std::array<std::int64_t, 3>& size, Connectivity connectivity,
                              std::int64_t min_component, Solid& solid) {
  Finding dropped;
  for (const Piece& piece : solid.findings.pieces)
    note(dropped, piece.voxels < min_component, piece.first_voxel);
  if (dropped.count == 0) return dropped;
  const View<std::uint64_t> words = object.words.view();
  for_each_run(solid.lookup.table, [&](std::uint32_t run, int y, int z) {
    if (solid.findings.pieces[solid.lookup.piece[run]].voxels >= min_component) return;
    const Run& r = solid.lookup.table.runs[run];
    const std::size_t row = object.view().row(y, z);
    for (int x = r.begin; x < r.end; ++x) words[row + (x >> 6)] &= ~(std::uint64_t{1} << (x & 63));
  });
  const double anisotropy = solid.findings.anisotropy;
  solid = examine_solid(backend, object.view(), size, connectivity);
  solid.findings.anisotropy = anisotropy;
  solid.findings.dropped = dropped;
  return dropped;
}

}  // namespace vasamesh
