#pragma once

/// \file
/// Cell lattices of known functions, labelled by their sign: what the mesh stages start from.

#include <array>
#include <functional>
#include <vector>

#include "backend/backend.h"
#include "stages/field.h"
#include "types/lattice.h"
#include "types/vec3.h"
#include "vasamesh/types.h"

namespace vasamesh::test {

/// A function of a point in voxel lengths, positive inside.
using Solid3 = std::function<float(const Vec3&)>;

/// The lattice over a whole volume of `size` voxels (multiples of 4) in steps of scale / 2; bricks
/// for which `keep` is false are left out.
Lattice analytic_lattice(Backend& backend, const std::array<int, 3>& size, const Scale& scale,
                         const Solid3& solid,
                         const std::function<bool(const BrickCoord&)>& keep = nullptr);

/// The base surface and the indicator function of a solid, in voxel lengths.
struct AnalyticScene {
  AnalyticScene(Backend& backend, const std::array<int, 3>& size, const Solid3& solid,
                const Scale& scale = {1, 1, 1});

  IndicatorField field;
  TriangleMesh surface;
};

/// Distances, exact near the surface.
Solid3 ball(const Vec3& centre, float radius);
Solid3 ring(const Vec3& centre, float large, float small);
/// A tube of round ends from a to b.
Solid3 capsule(const Vec3& a, const Vec3& b, float radius);
/// What lies in any of them, blended over about `blend` lengths where they meet.
Solid3 joined(std::vector<Solid3> solids, float blend);

/// A tree of `branches` tubes in a cube of `side` voxels, radii 1.5 to 3, by a fixed seed.
Solid3 random_tree(unsigned seed, int branches, float side);

}  // namespace vasamesh::test
