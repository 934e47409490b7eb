#include "phantom/tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "phantom/random.h"

namespace vasamesh::phantom {
namespace {

constexpr int kMostChildren = 2;
constexpr int kCandidates = 5;  ///< places tried for a target
constexpr int kSmoothingPasses = 14;
constexpr int kTaperNodes = 8;
constexpr int kSplinePieces = 3;

struct Node {
  Vec3 position;
  int parent;           ///< -1 for a root
  double least_radius;  ///< of a trunk; 0 for what grew
  double way = 0;       ///< from the trunk, mm
  int children = 0;
  int tips = 0;         ///< ends of the vessels beyond; 1 for a tip
  int main_child = -1;  ///< the thickest child
  double radius = 0;
  bool grown = false;
};

struct Target {
  Vec3 position;
  int node = -1;  ///< where to join it
  double cost = std::numeric_limits<double>::infinity();
};

/// Smooth random displacement: plane waves, each shorter and lower than the one before.
class Bending {
 public:
  Bending(const TreePlan& plan, Random& random) {
    double amplitude = plan.bending, length = plan.bending_length;
    for (Wave& wave : waves_) {
      const Vec3 way(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1));
      wave.number = 2 * std::numbers::pi / length * way.normalized();
      wave.amplitude = amplitude;
      for (int a = 0; a < 3; ++a) wave.phase[a] = random.between(0, 2 * std::numbers::pi);
      amplitude *= 0.6;
      length *= 0.7;
    }
  }
  Vec3 operator()(const Vec3& p) const {
    Vec3 bent = p;
    for (const Wave& wave : waves_)
      for (int a = 0; a < 3; ++a)
        bent[a] += wave.amplitude * std::sin(wave.number.dot(p) + wave.phase[a]);
    return bent;
  }

 private:
  struct Wave {
    Vec3 number, phase;
    double amplitude;
  };
  std::array<Wave, 4> waves_;
};

class Growth {
 public:
  explicit Growth(const TreePlan& plan) : plan_(plan), random_(plan.seed) {}

  std::vector<Vessel> run() {
    plant_trunks();
    scatter_targets();
    while (!targets_.empty()) join_cheapest();
    count_tips();
    set_radii();
    taper_tips();
    smooth();
    bend();
    return vessels();
  }

 private:
  void plant_trunks();
  void scatter_targets();
  void join_cheapest();
  void add_node(const Node& node);
  void offer(int node, Target& target) const;
  void offer_all(Target& target) const;
  void count_tips();
  void set_radii();
  void taper_tips();
  void smooth();
  void bend();
  std::vector<Vessel> vessels() const;
  Vessel vessel_from(int first) const;

  const TreePlan& plan_;
  Random random_;
  std::vector<Node> nodes_;  ///< parents before children
  std::vector<Target> targets_;
};

void Growth::plant_trunks() {
  for (const Vessel& trunk : plan_.trunks) {
    int parent = -1;
    for (std::size_t i = 0; i + 1 < trunk.points.size(); ++i) {
      const Vec3 way = trunk.points[i + 1] - trunk.points[i];
      const int count = std::max(1, static_cast<int>(way.norm() / plan_.step));
      for (int n = i == 0 ? 0 : 1; n <= count; ++n) {
        const double t = static_cast<double>(n) / count;
        const double radius = (1 - t) * trunk.radius[i] + t * trunk.radius[i + 1];
        add_node({trunk.points[i] + t * way, parent, radius});
        parent = static_cast<int>(nodes_.size()) - 1;
      }
    }
  }
}

/// A place in the region.
Vec3 scatter(const TargetRegion& region, Random& random) {
  for (;;) {
    const Vec3 p(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1));
    if (p.norm() <= 1 && p.norm() >= region.hollow)
      return region.centre + p.cwiseProduct(region.half_axes);
  }
}

double distance_to_targets(const Vec3& p, const std::vector<Target>& targets) {
  double least = std::numeric_limits<double>::infinity();
  for (const Target& target : targets) least = std::min(least, (target.position - p).norm());
  return least;
}

/// Each target is the loneliest of a few places: an even cover of the regions.
void Growth::scatter_targets() {
  for (const TargetRegion& region : plan_.regions)
    for (int n = 0; n < region.count; ++n) {
      Vec3 best = scatter(region, random_);
      for (int candidate = 1; candidate < kCandidates; ++candidate) {
        const Vec3 p = scatter(region, random_);
        if (distance_to_targets(p, targets_) > distance_to_targets(best, targets_)) best = p;
      }
      targets_.push_back({best});
    }
  for (Target& target : targets_) offer_all(target);
}

void Growth::add_node(const Node& node) {
  if (node.parent >= 0) ++nodes_[node.parent].children;
  nodes_.push_back(node);
}

/// Joins the target to the node if that is the cheapest so far.
void Growth::offer(int node, Target& target) const {
  const Node& from = nodes_[node];
  const Vec3 wire = target.position - from.position;
  const double length = wire.norm();
  const Vec3 before = from.parent < 0 ? wire : Vec3(from.position - nodes_[from.parent].position);
  const double cosine = wire.dot(before) / std::max(1e-9, length * before.norm());
  const double cost =
      length * (1 + plan_.turning * (1 - cosine)) + plan_.balance * (from.way + length);
  const bool is_bare = from.children > 0 && (from.least_radius > plan_.bare_radius ||
                                             !plan_.room.contains(from.position));
  if (is_bare || from.children >= kMostChildren || cost >= target.cost) return;
  target.cost = cost;
  target.node = node;
}

void Growth::offer_all(Target& target) const {
  target.cost = std::numeric_limits<double>::infinity();
  for (int node = 0; node < static_cast<int>(nodes_.size()); ++node) offer(node, target);
}

/// Joins the target of least cost by a straight line of nodes, each a place to branch from.
void Growth::join_cheapest() {
  const auto best =
      std::min_element(targets_.begin(), targets_.end(),
                       [](const Target& a, const Target& b) { return a.cost < b.cost; });
  const Target target = *best;
  targets_.erase(best);
  const Vec3 start = nodes_[target.node].position, wire = target.position - start;
  const int count = std::max(1, static_cast<int>(wire.norm() / plan_.step));
  const int first = static_cast<int>(nodes_.size());
  for (int n = 1; n <= count; ++n) {
    const int parent = n == 1 ? target.node : static_cast<int>(nodes_.size()) - 1;
    const double way = nodes_[parent].way + wire.norm() / count;
    add_node({start + wire * (static_cast<double>(n) / count), parent, 0, way});
    nodes_.back().grown = true;
  }
  for (Target& other : targets_) {
    if (nodes_[other.node].children >= kMostChildren) offer_all(other);
    for (int node = first; node < static_cast<int>(nodes_.size()); ++node) offer(node, other);
  }
}

void Growth::count_tips() {
  for (int i = static_cast<int>(nodes_.size()) - 1; i >= 0; --i) {
    Node& node = nodes_[i];
    if (node.children == 0) node.tips = 1;
    if (node.parent >= 0) nodes_[node.parent].tips += node.tips;
  }
}

/// Murray's law from the tips on.
void Growth::set_radii() {
  for (Node& node : nodes_)
    node.radius = std::max(node.least_radius, plan_.tip_radius * std::cbrt(node.tips));
  for (int i = 0; i < static_cast<int>(nodes_.size()); ++i) {
    if (nodes_[i].parent < 0) continue;
    int& main_child = nodes_[nodes_[i].parent].main_child;
    if (main_child < 0 || nodes_[i].radius > nodes_[main_child].radius) main_child = i;
  }
}

void Growth::taper_tips() {
  for (std::size_t tip = 0; tip < nodes_.size(); ++tip) {
    if (nodes_[tip].children > 0 || !nodes_[tip].grown) continue;
    int node = static_cast<int>(tip);
    for (int n = 0; n < kTaperNodes && nodes_[node].tips == 1 && nodes_[node].grown; ++n) {
      const double t = static_cast<double>(n) / kTaperNodes;
      nodes_[node].radius = (1 - t) * plan_.end_radius + t * plan_.tip_radius;
      node = nodes_[node].parent;
    }
  }
}

void Growth::smooth() {
  for (int pass = 0; pass < kSmoothingPasses; ++pass) {
    std::vector<Vec3> moved(nodes_.size());
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const Node& node = nodes_[i];
      moved[i] = node.position;
      if (!node.grown || node.main_child < 0) continue;
      const Vec3 middle = 0.5 * (nodes_[node.parent].position + nodes_[node.main_child].position);
      moved[i] = 0.5 * (node.position + middle);
    }
    for (std::size_t i = 0; i < nodes_.size(); ++i) nodes_[i].position = moved[i];
  }
}

void Growth::bend() {
  const Bending bending(plan_, random_);
  for (Node& node : nodes_) node.position = bending(node.position);
}

/// Catmull and Rom's spline through four points, between the second and the third.
Vec3 spline(const std::array<Vec3, 4>& p, double t) {
  return 0.5 * (2 * p[1] + t * (p[2] - p[0]) + t * t * (2 * p[0] - 5 * p[1] + 4 * p[2] - p[3]) +
                t * t * t * (3 * p[1] - p[0] - 3 * p[2] + p[3]));
}

Vessel refine(const Vessel& knots) {
  const auto& p = knots.points;
  const std::size_t last = p.size() - 1;
  Vessel fine;
  for (std::size_t i = 0; i < last; ++i)
    for (int n = 0; n < kSplinePieces; ++n) {
      const double t = static_cast<double>(n) / kSplinePieces;
      fine.points.push_back(
          spline({p[i ? i - 1 : 0], p[i], p[i + 1], p[std::min(i + 2, last)]}, t));
      fine.radius.push_back((1 - t) * knots.radius[i] + t * knots.radius[i + 1]);
    }
  fine.points.push_back(p[last]);
  fine.radius.push_back(knots.radius[last]);
  return fine;
}

/// The vessel whose first node is `first`, from the point where it leaves its parent vessel.
Vessel Growth::vessel_from(int first) const {
  Vessel knots;
  if (nodes_[first].parent >= 0) {
    knots.points.push_back(nodes_[nodes_[first].parent].position);
    knots.radius.push_back(nodes_[first].radius);
  }
  for (int node = first; node >= 0; node = nodes_[node].main_child) {
    knots.points.push_back(nodes_[node].position);
    knots.radius.push_back(nodes_[node].radius);
  }
  return refine(knots);
}

std::vector<Vessel> Growth::vessels() const {
  std::vector<Vessel> found;
  for (int i = 0; i < static_cast<int>(nodes_.size()); ++i) {
    const int parent = nodes_[i].parent;
    if (parent < 0 || nodes_[parent].main_child != i) found.push_back(vessel_from(i));
  }
  return found;
}

}  // namespace

std::vector<Vessel> grow_tree(const TreePlan& plan) { return Growth(plan).run(); }

}  // namespace vasamesh::phantom
