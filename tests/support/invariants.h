#pragma once

/// \file
/// What every mesh test ends in: the surface is closed, manifold, outward, free of
/// self-intersection, and, where a segmentation is given, of its topology. The check itself has its
/// negative controls in verify_test.cpp.

#include "stages/verify.h"
#include "vasamesh/report.h"
#include "vasamesh/types.h"

namespace vasamesh::test {

/// check_surface on a oneTBB backend.
CheckReport check(const TriangleMesh& mesh, const SolidMatch* wanted = nullptr);

/// Adds a failure that names what is wrong with the surface.
void expect_good_surface(const TriangleMesh& mesh);
void expect_good_surface(const TriangleMesh& mesh, const SolidMatch& wanted);

/// Also that the whole surface has these numbers.
void expect_good_surface(const TriangleMesh& mesh, const Topology& wanted);

/// Also that it is the surface of a segmentation, piece by piece, in the given space.
void expect_good_surface(const TriangleMesh& mesh, const VolumeView& volume,
                         Connectivity connectivity = Connectivity::vertex,
                         Space space = Space::lps);

}  // namespace vasamesh::test
