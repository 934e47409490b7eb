#include "phantom/tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "phantom/random.h"

namespace vasamesh {
namespace {

constexpr int kMostRounds = 2000;
constexpr int kMostChildren = 3;
constexpr double kCrowded = 0.5;  ///< steps between a new node and the nearest other
constexpr int kSmoothingPasses = 6;
constexpr int kTaperNodes = 8;
constexpr int kSplinePieces = 3;

struct Node {
  Vec3 position;
  int parent;           ///< -1 for a root
  double least_radius;  ///< of a trunk; 0 for what grew
  int children = 0;
  int tips = 0;         ///< ends of the vessels beyond; 1 for a tip
  int main_child = -1;  ///< the thickest child
  double radius = 0;
  bool grown = false;
};

struct Target {
  Vec3 position;
  int nearest = -1;
  double square = std::numeric_limits<double>::infinity();
  bool done = false;
};

/// Smooth random displacement: a sum of plane waves.
class Bending {
 public:
  Bending(const TreePlan& plan, Random& random) : amplitude_(plan.bending / kWaves) {
    for (Wave& wave : waves_) {
      const Vec3 way(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1));
      wave.number = 2 * std::numbers::pi / plan.bending_length * way.normalized();
      for (int a = 0; a < 3; ++a) wave.phase[a] = random.between(0, 2 * std::numbers::pi);
    }
  }
  Vec3 operator()(const Vec3& p) const {
    Vec3 bent = p;
    for (const Wave& wave : waves_)
      for (int a = 0; a < 3; ++a)
        bent[a] += amplitude_ * std::sin(wave.number.dot(p) + wave.phase[a]);
    return bent;
  }

 private:
  static constexpr int kWaves = 3;
  struct Wave {
    Vec3 number, phase;
  };
  std::array<Wave, kWaves> waves_;
  double amplitude_;
};

class Growth {
 public:
  explicit Growth(const TreePlan& plan) : plan_(plan), random_(plan.seed) {}

  std::vector<Vessel> run() {
    plant_trunks();
    scatter_targets();
    for (int round = 0; round < kMostRounds && grow_round(); ++round) {
    }
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
  bool grow_round();
  Vec3 next_position(int node, const Vec3& pull) const;
  bool is_crowded(const Vec3& place) const;
  void give_up_targets(int node);
  void add_node(const Node& node);
  void meet_targets(int node);
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

void Growth::scatter_targets() {
  for (const TargetRegion& region : plan_.regions)
    for (int n = 0; n < region.count;) {
      const Vec3 p(random_.between(-1, 1), random_.between(-1, 1), random_.between(-1, 1));
      if (p.norm() > 1 || p.norm() < region.hollow) continue;
      targets_.push_back({region.centre + p.cwiseProduct(region.half_axes)});
      ++n;
    }
  for (int node = 0; node < static_cast<int>(nodes_.size()); ++node) meet_targets(node);
}

void Growth::add_node(const Node& node) {
  if (node.parent >= 0) ++nodes_[node.parent].children;
  nodes_.push_back(node);
}

void Growth::meet_targets(int node) {
  for (Target& target : targets_) {
    const double square = (target.position - nodes_[node].position).squaredNorm();
    if (target.done || square >= target.square) continue;
    target.square = square;
    target.nearest = node;
    target.done = square < plan_.reached * plan_.reached;
  }
}

/// Where a node that is drawn along `pull` puts its child.
Vec3 Growth::next_position(int node, const Vec3& pull) const {
  Vec3 way = pull.normalized();
  const int parent = nodes_[node].parent;
  if (parent >= 0 && nodes_[node].children == 0)
    way += plan_.persistence * (nodes_[node].position - nodes_[parent].position).normalized();
  return nodes_[node].position + plan_.step * way.normalized();
}

bool Growth::is_crowded(const Vec3& place) const {
  const double least = kCrowded * plan_.step;
  return std::any_of(nodes_.begin(), nodes_.end(), [&](const Node& node) {
    return (node.position - place).squaredNorm() < least * least;
  });
}

/// One new node for each node that draws targets. \return whether anything changed.
bool Growth::grow_round() {
  std::vector<Vec3> pull(nodes_.size(), Vec3::Zero());
  std::vector<char> drawn(nodes_.size(), 0);
  for (const Target& target : targets_) {
    if (target.done) continue;
    pull[target.nearest] += (target.position - nodes_[target.nearest].position).normalized();
    drawn[target.nearest] = 1;
  }
  bool changed = false;
  for (int i = 0; i < static_cast<int>(drawn.size()); ++i) {
    if (!drawn[i]) continue;
    changed = true;
    const Vec3 place = next_position(i, pull[i]);
    if (nodes_[i].children >= kMostChildren || is_crowded(place)) {
      give_up_targets(i);
    } else {
      add_node({place, i, 0});
      nodes_.back().grown = true;
      meet_targets(static_cast<int>(nodes_.size()) - 1);
    }
  }
  return changed;
}

void Growth::give_up_targets(int node) {
  for (Target& target : targets_)
    if (target.nearest == node) target.done = true;
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

}  // namespace vasamesh
