#include "reference/expand_reference.h"

#include <algorithm>
#include <array>
#include <tuple>

#include "stages/expand_front.h"
#include "stages/expand_grid.h"
#include "stages/expand_propose.h"
#include "support/backends.h"

namespace vasamesh::test {

namespace {

using Corner = std::uint32_t;
using Loop = std::vector<Corner>;

template <class T>
std::vector<T> copied(Backend& backend, View<T> view, std::size_t count) {
  return to_host(backend, view.subview(0, count));
}

template <class T>
View<T> view_of_all(std::vector<T>& values) {
  return {values.data(), 0, values.size()};
}

std::uint32_t mixed(std::uint32_t x) {
  x = (x ^ x >> 16) * 0x7feb352du;
  x = (x ^ x >> 15) * 0x846ca68bu;
  return (x ^ x >> 16) & 0xffffu;
}

/// Round, then the rank: a loop of three, or how many of the limits the angle is below; then
/// chance.
std::uint32_t key(const PlainFront& front, std::uint32_t round, Corner c) {
  const auto next = [&](Corner at) { return front.corners[at].next; };
  const std::array<float, 5> limits = {3.9f, 3.4f, 2.75f, 2.2f, 1.75f};
  const float angle = front.corners[c].angle;
  const auto below =
      std::count_if(limits.begin(), limits.end(), [&](float l) { return angle < l; });
  const auto rank = next(next(next(c))) == c ? 7u : 1u + static_cast<std::uint32_t>(below);
  return (round << 20) + (rank << 16) + mixed(c + 0x9e3779b9u * round);
}

bool overlap(const FieldView& field, const CellBox& a, const CellBox& b) {
  for (int z = std::max(a.low[2], b.low[2]); z <= std::min(a.high[2], b.high[2]); ++z)
    for (int y = std::max(a.low[1], b.low[1]); y <= std::min(a.high[1], b.high[1]); ++y)
      for (int x = std::max(a.low[0], b.low[0]); x <= std::min(a.high[0], b.high[0]); ++x)
        if (cell_index(field, {x, y, z}) < cell_count(field)) return true;
  return false;
}

CellBox claim(const FieldView& field, const PlainFront& front, Corner c) {
  const FrontVertex& v = front.vertices[front.corners[c].vertex];
  return cells_round(field, v.position, (front.corners[c].wide ? 2.9f : 1.25f) * v.size);
}

/// The plain arrays as a view, with lists of the cells in the order of the entries.
struct PlainView {
  PlainView(const FieldView& field, PlainFront& front)
      : edge_at(cell_count(field) + 1, kNoEntry), vertex_at(cell_count(field) + 1, kNoEntry) {
    const auto cell = [&](const Vec3& p) { return cell_index(field, cell_at(field, p)); };
    for (std::uint32_t v = 0; v < front.vertices.size(); ++v) {
      std::uint32_t& head = vertex_at[cell(front.vertices[v].position)];
      front.vertices[v].next_near = head;
      head = v;
    }
    for (Corner c : front.listed) {
      FrontCorner& corner = front.corners[c];
      const Vec3 start = front.vertices[corner.vertex].position,
                 end = front.vertices[front.corners[corner.next].vertex].position;
      std::uint32_t& head = edge_at[cell(0.5f * (start + end))];
      corner.next_near = head;
      head = c;
    }
    view.vertices = view_of_all(front.vertices);
    view.corners = view_of_all(front.corners);
    view.edge_at = view_of_all(edge_at);
    view.vertex_at = view_of_all(vertex_at);
  }
  std::vector<std::uint32_t> edge_at, vertex_at;
  FrontView view;
};

/// The boundary as loops of corners, each before its next.
class Loops {
 public:
  explicit Loops(PlainFront& front) : front_(front) {
    std::vector<bool> seen(front.corners.size());
    for (Corner first : front.listed) {
      Loop loop;
      for (Corner c = first; !seen[c]; c = front.corners[c].next) {
        seen[c] = true;
        loop.push_back(c);
      }
      if (!loop.empty()) loops_.push_back(loop);
    }
  }

  void add(Corner corner, const Proposal& p) {
    const Loop loop = from(corner);
    const Corner next = loop[1 % loop.size()], previous = loop.back();
    if (p.kind == Proposal::ear) fill(previous, next);
    if (p.kind == Proposal::join_next || p.kind == Proposal::join_both) fill(corner, p.target);
    if (p.kind == Proposal::join_previous || p.kind == Proposal::join_both)
      fill(previous, p.target);
    if (p.kind == Proposal::fan) fan(corner, next, previous, p);
  }

  void write_back() {
    for (const Loop& loop : loops_)
      for (std::size_t i = 0; i < loop.size(); ++i) {
        front_.corners[loop[i]].next = loop[(i + 1) % loop.size()];
        front_.corners[loop[(i + 1) % loop.size()]].previous = loop[i];
      }
  }

 private:
  /// Takes out the loop of a corner, turned so that it begins there.
  Loop take(Corner corner) {
    const auto holds = [&](const Loop& loop) {
      return std::find(loop.begin(), loop.end(), corner) != loop.end();
    };
    const auto found = std::find_if(loops_.begin(), loops_.end(), holds);
    Loop loop = *found;
    loops_.erase(found);
    std::rotate(loop.begin(), std::find(loop.begin(), loop.end(), corner), loop.end());
    return loop;
  }
  Loop from(Corner corner) {
    Loop loop = take(corner);
    loops_.push_back(loop);
    return loop;
  }

  void triangle(Corner a, Corner b, Corner c) {
    for (const Corner corner : {a, b, c}) front_.triangles.push_back(front_.corners[corner].vertex);
  }
  void kill(Corner c) {
    front_.corners[c].state = CornerState::dead;
    --front_.vertices[front_.corners[c].vertex].corners;
  }
  void change(Corner c) { front_.corners[c].state = CornerState::changed; }
  Corner add_corner(std::uint32_t vertex) {
    front_.corners.push_back({.vertex = vertex});
    ++front_.vertices[vertex].corners;
    front_.listed.push_back(static_cast<Corner>(front_.corners.size() - 1));
    return front_.listed.back();
  }

  /// The triangle of the edge after `corner` with its tip at `tip`.
  void fill(Corner corner, Corner tip) {
    Loop loop = take(corner);
    triangle(corner, tip, loop[1]);
    if (loop.size() == 3 && (tip == loop[2])) {
      for (const Corner c : loop) kill(c);
      return;
    }
    for (const Corner c : {corner, tip, loop[1]}) change(c);
    if (tip == loop[2] || tip == loop.back()) {
      const auto gone = tip == loop[2] ? loop.begin() + 1 : loop.begin();
      kill(*gone);
      loop.erase(gone);
      loops_.push_back(loop);
      return;
    }
    const Corner spare = add_corner(front_.corners[tip].vertex);
    std::rotate(loop.begin(), loop.begin() + 1, loop.end());  // from the next to the corner
    const auto at = std::find(loop.begin(), loop.end(), tip);
    Loop other(at, loop.end());  // from the tip to the corner
    loop.erase(at, loop.end());
    if (other.empty()) {
      other = take(tip);  // another loop: it comes between the corner and its next
      loop.insert(loop.end(), other.begin(), other.end());
      change(other.back());
    } else {
      loops_.push_back(other);
      change(loop.back());
    }
    loop.push_back(spare);
    loops_.push_back(loop);
  }

  void fan(Corner corner, Corner next, Corner previous, const Proposal& p) {
    Loop loop = take(corner);
    std::vector<Corner> rim = {next};
    for (int i = 0; i < p.vertices; ++i) {
      front_.vertices.push_back({p.position[i], p.normal[i], p.size[i]});
      rim.push_back(add_corner(static_cast<std::uint32_t>(front_.vertices.size() - 1)));
    }
    rim.push_back(previous);
    for (std::size_t i = 1; i < rim.size(); ++i) triangle(corner, rim[i], rim[i - 1]);
    change(next);
    change(previous);
    kill(corner);
    loop.erase(loop.begin());
    loop.insert(loop.end(), rim.rbegin() + 1, rim.rend() - 1);
    loops_.push_back(loop);
  }

  PlainFront& front_;
  std::vector<Loop> loops_;
};

}  // namespace

PlainFront plain_front(Backend& backend, const FrontView& front) {
  const FrontCounts counts = to_host(backend, front.counts)[0];
  return {copied(backend, front.vertices, counts.vertices),
          copied(backend, front.corners, counts.corners),
          copied(backend, front.triangles, 3 * std::size_t{counts.triangles}),
          copied(backend, front.listed, counts.listed)};
}

std::vector<Corner> choose_one_by_one(const FieldView& field, std::uint32_t round, bool wake,
                                      PlainFront& front) {
  std::erase_if(front.listed,
                [&](Corner c) { return front.corners[c].state == CornerState::dead; });
  const auto vertex = [&](Corner c) { return front.vertices[front.corners[c].vertex]; };
  for (Corner c : front.listed) {
    FrontCorner& corner = front.corners[c];
    if (!wake && corner.state != CornerState::changed) continue;
    corner.angle = angle_between(vertex(c).position, vertex(c).normal,
                                 vertex(corner.previous).position, vertex(corner.next).position);
    corner.state = CornerState::active;
    corner.wide = 0;
    const Vec3 middle = 0.5f * (vertex(c).position + vertex(corner.next).position);
    corner.cell = static_cast<std::uint32_t>(cell_index(field, cell_at(field, middle)));
  }
  for (Corner c : front.listed)
    front.corners[c].key = front.corners[c].state == CornerState::active ? key(front, round, c) : 0;
  std::vector<Corner> chosen;
  for (Corner c : front.listed) {
    const auto order = [&](Corner at) { return std::tuple(front.corners[at].key, at); };
    const FrontCorner& corner = front.corners[c];
    const std::array<Corner, 5> round_it = {front.corners[corner.previous].previous,
                                            corner.previous, c, corner.next,
                                            front.corners[corner.next].next};
    const bool first = std::all_of(round_it.begin(), round_it.end(),
                                   [&](Corner at) { return order(at) <= order(c); });
    if (corner.key > 0 && first) chosen.push_back(c);
  }
  return chosen;
}

std::vector<bool> holders_one_by_one(const FieldView& field, const PlainFront& front,
                                     const std::vector<Corner>& chosen) {
  std::vector<bool> holders;
  for (Corner c : chosen) {
    const auto is_stronger = [&](Corner other) {
      return std::tuple(front.corners[other].key, other) > std::tuple(front.corners[c].key, c);
    };
    holders.push_back(std::none_of(chosen.begin(), chosen.end(), [&](Corner other) {
      return is_stronger(other) &&
             overlap(field, claim(field, front, c), claim(field, front, other));
    }));
  }
  return holders;
}

std::vector<Proposal> propose_one_by_one(const FieldView& field, const SizeView& sizes,
                                         const FrontLimits& limits,
                                         const std::vector<Corner>& chosen,
                                         const std::vector<bool>& holders, PlainFront& front) {
  const PlainView plain(field, front);
  std::vector<Proposal> proposals(chosen.size());
  std::vector<BoundaryEdge> near;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    if (!holders[i]) continue;
    FrontCorner& corner = front.corners[chosen[i]];
    const Proposal p =
        propose(field, sizes, plain.view, limits, claim(field, front, chosen[i]), chosen[i], near);
    proposals[i] = p;
    if (p.kind != Proposal::nothing && p.kind != Proposal::more_room) continue;
    if (p.kind == Proposal::nothing || corner.wide) corner.state = CornerState::frozen;
    if (p.kind == Proposal::more_room) corner.wide = 1;
  }
  return proposals;
}

void add_one_by_one(const std::vector<Corner>& chosen, const std::vector<Proposal>& proposals,
                    PlainFront& front) {
  Loops loops(front);
  for (std::size_t i = 0; i < chosen.size(); ++i) loops.add(chosen[i], proposals[i]);
  loops.write_back();
}

}  // namespace vasamesh::test
