#include "stages/bridge.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "backend/ranges.h"
#include "types/angles.h"
#include "types/box.h"

namespace vasamesh {

namespace {

constexpr std::size_t kGrain = 256;          // loops a task takes
constexpr float kBridgeReach = 3;            // longest bridge, in longest edges of its loop
constexpr std::size_t kMostTrials = 2000;    // bridges or chords tried for a loop
constexpr std::uint32_t kMostStarts = 1024;  // corners of a long loop from which chords are tried,
constexpr std::uint32_t kMostEnds = 4096;    // and to which

using Loop = std::vector<std::uint32_t>;

/// From the edge at corner i of a loop to the edge at corner j of loop `other`.
struct BridgeTrial {
  float cost;  ///< the squared lengths of its two edges
  std::uint32_t other, i, j;
  bool operator<(const BridgeTrial& b) const {
    return std::tie(cost, other, i, j) < std::tie(b.cost, b.other, b.i, b.j);
  }
};

struct ChordTrial {
  float squared;
  std::uint32_t i, j;
  bool operator<(const ChordTrial& b) const {
    return std::tie(squared, i, j) < std::tie(b.squared, b.i, b.j);
  }
};

class Bridger {
 public:
  Bridger(const Backend& backend, const TriangleMesh& mesh, const GapRules& rules,
          const GapLoops& loops, std::vector<float> turnings, GapRim& rim)
      : backend_(backend),
        mesh_(mesh),
        rules_(rules),
        rim_(rim),
        loops_(loops.count()),
        boxes_(loops.count()),
        turnings_(std::move(turnings)) {
    for (std::size_t l = 0; l < loops.count(); ++l) {
      loops_[l].assign(loops[l].begin(), loops[l].end());
      measure(l);
    }
  }

  void join_annuli() {
    for (std::size_t l = 0; l < loops_.size();) {
      backend_.checkpoint();
      BridgeTrial bridge;
      if (turnings_[l] >= kLeastTurning || loops_[l].empty() || !find_bridge(l, bridge)) {
        ++l;
        continue;
      }
      join(l, bridge);
      turnings_[l] = turning_of(l);
    }
  }

  void split_long_loops() {
    for (std::size_t l = 0; l < loops_.size();) {
      backend_.checkpoint();
      if (loops_[l].size() <= kLongLoop || !split(l)) ++l;
    }
  }

  BridgedLoops take() {
    result_.loops.first.push_back(0);
    for (std::size_t l = 0; l < loops_.size(); ++l) {
      if (loops_[l].empty()) continue;
      result_.loops.add(loops_[l]);
      result_.turning.push_back(turnings_[l]);
    }
    return std::move(result_);
  }

 private:
  Vec3 at(std::uint32_t v) const { return vertex_at(mesh_, v); }
  static std::uint32_t next(const Loop& loop, std::size_t i) { return loop[(i + 1) % loop.size()]; }

  void measure(std::size_t l) {
    boxes_[l] = {};
    for (std::uint32_t v : loops_[l]) boxes_[l].take_in(at(v));
  }

  float turning_of(std::size_t l) const {
    std::vector<Vec3> points, normals;
    for (std::uint32_t v : loops_[l]) {
      points.push_back(at(v));
      normals.push_back(rim_.normal(v));
    }
    return turning(points, normals);
  }

  float longest_edge(const Loop& loop) const {
    float longest = 0;
    for (std::size_t i = 0; i < loop.size(); ++i)
      longest = std::max(longest, squared_norm(at(next(loop, i)) - at(loop[i])));
    return std::sqrt(longest);
  }

  bool find_bridge(std::size_t l, BridgeTrial& found) {
    const Loop& loop = loops_[l];
    const float reach = kBridgeReach * longest_edge(loop);
    std::vector<BridgeTrial> trials;
    for (std::uint32_t other = 0; other < loops_.size(); ++other) {
      if (other == l || loops_[other].empty() || !boxes_[l].meets(boxes_[other], reach)) continue;
      for (std::uint32_t i = 0; i < loop.size(); ++i)
        for (std::uint32_t j = 0; j < loops_[other].size(); ++j) {
          const float there = squared_norm(at(loops_[other][j]) - at(next(loop, i)));
          const float back = squared_norm(at(next(loops_[other], j)) - at(loop[i]));
          if (std::max(there, back) <= reach * reach) trials.push_back({there + back, other, i, j});
        }
    }
    const auto end = trials.begin() + std::min(trials.size(), kMostTrials);
    std::partial_sort(trials.begin(), end, trials.end());
    const auto valid = std::find_if(trials.begin(), end, [&](const BridgeTrial& trial) {
      std::uint32_t triangles[6];
      return triangulate_bridge(l, trial, triangles);
    });
    if (valid == end) return false;
    found = *valid;
    return true;
  }

  /// The two triangles of a bridge by its better diagonal: the first at the loop's edge, the
  /// second at the other's. \return false where neither diagonal obeys the rules.
  bool triangulate_bridge(std::size_t l, const BridgeTrial& bridge,
                          std::uint32_t (&triangles)[6]) const {
    const std::uint32_t a = loops_[l][bridge.i], b = next(loops_[l], bridge.i),
                        c = loops_[bridge.other][bridge.j],
                        d = next(loops_[bridge.other], bridge.j);
    if (a == c || a == d || b == c || b == d || !is_free(b, c) || !is_free(d, a)) return false;
    const std::uint32_t splits[2][6] = {{a, b, c, c, d, a}, {d, a, b, b, c, d}};
    const bool diagonal[2] = {!rim_.has_edge(a, c), !rim_.has_edge(b, d)};
    float best = 1;
    bool found = false;
    for (int s = 0; s < 2; ++s) {
      const std::uint32_t* t = splits[s];
      if (!diagonal[s] || !obeys(t) || !obeys(t + 3)) continue;
      const float worst = std::max(least_angle_measure(at(t[0]), at(t[1]), at(t[2])),
                                   least_angle_measure(at(t[3]), at(t[4]), at(t[5])));
      if (!(worst < best)) continue;
      best = worst;
      found = true;
      std::copy(t, t + 6, triangles);
    }
    return found;
  }

  bool obeys(const std::uint32_t* t) const {
    const Vec3 points[3] = {at(t[0]), at(t[1]), at(t[2])};
    const Vec3 normals[3] = {rim_.normal(t[0]), rim_.normal(t[1]), rim_.normal(t[2])};
    return triangle_follows_surface(rules_, points, normals);
  }

  /// Whether the surface may get an edge between the two.
  bool is_free(std::uint32_t a, std::uint32_t b) const {
    return a != b && !rim_.has_edge(a, b) && chord_follows_surface(rules_, at(a), at(b)) &&
           !crosses_a_loop(a, b);
  }

  bool crosses_a_loop(std::uint32_t a, std::uint32_t b) const {
    Box box;
    box.take_in(at(a));
    box.take_in(at(b));
    const float reach = 0.5f * norm(at(b) - at(a));
    for (std::size_t l = 0; l < loops_.size(); ++l) {
      if (loops_[l].empty() || !box.meets(boxes_[l], reach)) continue;
      for (std::size_t i = 0; i < loops_[l].size(); ++i)
        if (crosses(a, b, loops_[l][i], next(loops_[l], i))) return true;
    }
    return false;
  }

  /// Whether two edges of one sheet cross, seen along the surface's normal.
  bool crosses(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) const {
    if (a == c || a == d || b == c || b == d) return false;
    const Vec3 p = at(a), q = at(b), u = at(c), v = at(d);
    const Vec3 normal = normalised(rim_.normal(a) + rim_.normal(b));
    const float length = std::max(squared_norm(q - p), squared_norm(v - u));
    const Vec3 apart = 0.5f * ((u + v) - (p + q));
    const float height = dot(apart, normal);
    if (squared_norm(apart) > length || height * height > 0.25f * length) return false;
    const auto side = [&](const Vec3& from, const Vec3& to, const Vec3& of) {
      return dot(normal, cross(to - from, of - from));
    };
    return side(p, q, u) * side(p, q, v) < 0 && side(u, v, p) * side(u, v, q) < 0;
  }

  void join(std::size_t l, const BridgeTrial& bridge) {
    std::uint32_t t[6];
    triangulate_bridge(l, bridge, t);
    result_.triangles.insert(result_.triangles.end(), t, t + 6);
    ++result_.bridges;
    Loop loop = std::move(loops_[l]), other = std::move(loops_[bridge.other]);
    loops_[bridge.other].clear();
    const std::uint32_t a = loop[bridge.i], b = next(loop, bridge.i), c = other[bridge.j],
                        d = next(other, bridge.j);
    const bool joins_ac = t[0] == a;
    rim_.add_edge(c, b, joins_ac ? a : d);
    rim_.add_edge(a, d, joins_ac ? c : b);
    rim_.add_edge(t[0], t[2], GapRim::kNoVertex);
    // b ... a, then d ... c
    std::rotate(loop.begin(), loop.begin() + (bridge.i + 1) % loop.size(), loop.end());
    std::rotate(other.begin(), other.begin() + (bridge.j + 1) % other.size(), other.end());
    loop.insert(loop.end(), other.begin(), other.end());
    loops_[l] = std::move(loop);
    measure(l);
    measure(bridge.other);
  }

  bool split(std::size_t l) {
    const Loop& loop = loops_[l];
    const auto n = static_cast<std::uint32_t>(loop.size());
    const std::uint32_t least = n / 4, from_step = (n + kMostStarts - 1) / kMostStarts,
                        to_step = (n + kMostEnds - 1) / kMostEnds;
    std::vector<ChordTrial> trials;
    for (std::uint32_t i = 0; i < n; i += from_step)
      for (std::uint32_t j = i + least; j < n && j - i + least <= n; j += to_step)
        trials.push_back({squared_norm(at(loop[j]) - at(loop[i])), i, j});
    const auto end = trials.begin() + std::min(trials.size(), kMostTrials);
    std::partial_sort(trials.begin(), end, trials.end());
    const auto valid = std::find_if(trials.begin(), end, [&](const ChordTrial& trial) {
      return lies_in_corner(loop, trial.i, loop[trial.j]) &&
             lies_in_corner(loop, trial.j, loop[trial.i]) && is_free(loop[trial.i], loop[trial.j]);
    });
    if (valid == end) return false;
    split_at(l, valid->i, valid->j);
    return true;
  }

  /// Whether the vertex lies between a corner's edges, on the gap's side.
  bool lies_in_corner(const Loop& loop, std::size_t i, std::uint32_t vertex) const {
    const Vec3 here = at(loop[i]), x = at(next(loop, i)) - here, y = cross(rim_.normal(loop[i]), x);
    const auto angle = [&](std::uint32_t v) {
      const Vec3 to = at(v) - here;
      return positive_angle(dot(x, to), dot(y, to));
    };
    const float of_vertex = angle(vertex);
    return of_vertex > 0 && of_vertex < angle(loop[(i + loop.size() - 1) % loop.size()]);
  }

  void split_at(std::size_t l, std::size_t i, std::size_t j) {
    const Loop whole = std::move(loops_[l]);
    rim_.add_edge(whole[i], whole[j], GapRim::kNoVertex);
    ++result_.splits;
    Loop rest(whole.begin() + j, whole.end());
    rest.insert(rest.end(), whole.begin(), whole.begin() + i + 1);
    loops_[l].assign(whole.begin() + i, whole.begin() + j + 1);
    measure(l);
    loops_.insert(loops_.begin() + l + 1, std::move(rest));
    boxes_.insert(boxes_.begin() + l + 1, Box{});
    measure(l + 1);
    turnings_[l] = turning_of(l);
    turnings_.insert(turnings_.begin() + l + 1, turning_of(l + 1));
  }

  const Backend& backend_;
  const TriangleMesh& mesh_;
  const GapRules rules_;
  GapRim& rim_;
  std::vector<Loop> loops_;  ///< empty once joined to another
  std::vector<Box> boxes_;
  std::vector<float> turnings_;
  BridgedLoops result_;
};

std::vector<float> find_turnings(Backend& backend, const TriangleMesh& mesh, const GapLoops& loops,
                                 const GapRim& rim) {
  std::vector<float> result(loops.count());
  for_each_range(backend, loops.count(), kGrain, [&](std::size_t begin, std::size_t end) {
    std::vector<Vec3> points, normals;
    for (std::size_t l = begin; l < end; ++l) {
      points.clear();
      normals.clear();
      for (std::uint32_t v : loops[l]) {
        points.push_back(vertex_at(mesh, v));
        normals.push_back(rim.normal(v));
      }
      result[l] = turning(points, normals);
    }
  });
  return result;
}

}  // namespace

BridgedLoops bridge_loops(Backend& backend, const TriangleMesh& mesh, const GapRules& rules,
                          const GapLoops& loops, GapRim& rim) {
  std::vector<float> turnings = find_turnings(backend, mesh, loops, rim);
  bool any = false;
  for (std::size_t l = 0; l < loops.count(); ++l)
    any |= turnings[l] < kLeastTurning || loops.size(l) > kLongLoop;
  if (!any) return {loops, std::move(turnings), {}, 0, 0};
  Bridger bridger(backend, mesh, rules, loops, std::move(turnings), rim);
  bridger.join_annuli();
  bridger.split_long_loops();
  return bridger.take();
}

}  // namespace vasamesh
