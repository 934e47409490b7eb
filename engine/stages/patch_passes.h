#pragma once

/// \file
/// The passes of remeshing over one part of a surface, but those of relax.h. Each goes through the
/// part in a fixed order and keeps the rules of patch_rules.h; vertices that are not whole stay
/// where they are.
///
/// Botsch, Kobbelt 2004; Dunyach, Vanderhaeghe, Barthe, Botsch: Adaptive remeshing for real-time
/// mesh deformation, 2013.

#include <cstdint>

#include "stages/patch_mesh.h"
#include "stages/places.h"
#include "types/indicator_field.h"
#include "types/sizes.h"

namespace vasamesh {

/// What the vertices are projected onto and how long edges shall be.
struct RemeshGoal {
  FieldView field;
  SizeView sizes;
  const Places* places = nullptr;  ///< the least factor counts
  bool local = false;              ///< work near such places alone

  /// The mean edge comes out shorter than the length that splits and collapses aim at.
  static constexpr float kLengthFactor = 1.08f;

  float size_at(const Vec3& p) const {
    const float factor = places ? places->factor_at(p) : 1;
    return kLengthFactor * factor * vasamesh::size_at(sizes, p);
  }
};

/// Edges shorter than this times their size are collapsed, those longer than kLongest split.
inline constexpr float kShortest = 4.0f / 5.0f;

/// Merges vertices into their neighbours along edges shorter than `shortest` times their size,
/// unless that makes an edge longer than `longest` times its size or breaks a rule.
void collapse_short_edges(PatchMesh& mesh, float shortest, float longest);

/// Splits edges longer than `longest` times their size; new vertices come onto the surface.
void split_long_edges(PatchMesh& mesh, const RemeshGoal& goal, float longest);

/// Flips edges where that brings the numbers of edges at the four corners nearer to six (four on
/// borders), until none is left or `passes` are over.
void flip_to_valence(PatchMesh& mesh, int passes);

/// Flips edges where that makes the least angle of their two triangles larger.
void flip_to_angle(PatchMesh& mesh, int passes);

/// Collapses, flips and moves round the triangles whose least angle has a squared sine below
/// `wanted`, each only if the least angle there grows and no triangle comes to meet another. Where
/// angles below 20 degrees stay, the place is relaxed off the field, by 0.4 voxel lengths at most a
/// time, and tried again. \return triangles that stay below.
std::uint32_t repair(PatchMesh& mesh, const RemeshGoal& goal, float wanted, int passes);

/// Flips and moves round the triangles with an angle below 20 degrees, whatever they face: for what
/// is crumpled at the scale of its edges, where the function's normals are of no use. No triangle
/// turns by 90 degrees or more at a time, or comes to meet another.
void widen_angles(PatchMesh& mesh, int passes);

/// Flips and moves round the triangles with an edge more than 1.5 times as long as another, towards
/// equal edges. Vertices move in the mesh's own tangent planes, by a quarter of their size at most
/// a time; edges that the mesh is bent along by more than 41 degrees stay; no triangle turns by
/// more than 26 degrees a time, gets an angle below 25 degrees that it did not have, or comes to
/// meet another.
void even_edges(PatchMesh& mesh, int passes);

/// The cosine between the normals of two triangles with a dihedral angle of 60 degrees.
inline constexpr float kSharpBend = -0.5f;

/// Flips and moves round the edges with dihedral angles below 60 degrees, so that the
/// least one there grows: of what is thin and has been flattened, or of vertices that stand out. No
/// triangle gets an angle below 25 degrees where there was none, or comes to meet another.
void open_dihedrals(PatchMesh& mesh, int passes);

/// Gives a point the field's normal and on_field, or on_field = false and the normal that it has:
/// where the zero set is too far, its gradient too small, or its normal too far from the point's.
void take_normal(const FieldView& field, SurfacePoint& point);

// When the field's normal is of use to a point: its slope a voxel length at least, and the cosine
// between the normals.
inline constexpr float kLeastSlope = 0.15f, kLeastAgreement = 0.5f;
inline constexpr int kProjectionSteps = 3;

/// Puts a point near the surface onto it, with the normal and the size there. False where the field
/// gives no place of use within `reach` that faces as the point does; the point then stays.
bool put_onto_surface(const RemeshGoal& goal, float reach, SurfacePoint& point);

}  // namespace vasamesh
