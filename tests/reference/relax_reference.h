#pragma once

/// \file
/// Smoothing and moves towards equal edges of one part, one vertex after the other in the order of
/// their numbers, over its half-edges.

#include <vector>

#include "stages/patch_mesh.h"
#include "stages/patch_passes.h"

namespace vasamesh::test {

/// Whole vertices that lie on the field. \return how often one has moved.
int smooth_one_by_one(PatchMesh& mesh, const RemeshGoal& goal, int passes);

/// Inner vertices that lie on the field, onto the surface or across their normals alone. \return
/// how often one has moved.
int equalise_one_by_one(PatchMesh& mesh, const RemeshGoal& goal, int passes, bool onto = true);

/// A vertex: how far the surface lies outside of the triangles round it; 0 where it is not inner or
/// off the field.
std::vector<float> gaps_one_by_one(const PatchMesh& mesh, const FieldView& field);

}  // namespace vasamesh::test
