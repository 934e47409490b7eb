#pragma once

/// \file
/// Surfaces in and out of files: VTK XML (.vtp), STL (.stl), PLY (.ply), Wavefront (.obj); legacy
/// VTK (.vtk) in only.

#include <atomic>
#include <optional>
#include <string>
#include <vector>

#include "vasamesh/parameters.h"
#include "vasamesh/types.h"

namespace vasamesh {

/// Reads a triangle surface; polygons are cut into triangles, lines and points ignored. Vertices
/// come in the file's order and space, rounded to float32; those of an STL file are merged where
/// equal, in order of first appearance.
///
/// \throws Error bad_input, naming the file: no such file, unknown ending, unreadable, no
///         triangles, an index out of range, a coordinate that is not finite, more than 2^32 - 1
///         vertices.
TriangleMesh read_surface(const std::string& path);

/// A surface, and the space that its file says it is in, as write_surface or 3D Slicer writes it.
struct PlacedSurface {
  TriangleMesh mesh;
  std::optional<Space> space;  ///< none where the file says nothing
};

/// The same. \throws Error as read_surface.
PlacedSurface read_placed_surface(const std::string& path);

/// Writes a surface; the ending chooses the format (.vtp, .stl and .ply binary, .obj). float32
/// coordinates survive bit by bit in each of them. The space is written into the file: SPACE=LPS
/// (RAS, VOXEL) in the header of an STL, in a comment of a PLY or OBJ, in a field-data string
/// "SPACE" of a VTP. The file appears under its name only when it is complete.
///
/// \throws Error usage (unknown ending), refused (folder missing or not writable, disk full),
///         cancelled (`cancel` was set before it was complete).
void write_surface(const std::string& path, const TriangleMesh& mesh, Space space,
                   const std::atomic<bool>* cancel = nullptr);

/// A number at each vertex or triangle, under a name.
struct SurfaceArray {
  std::string name;
  std::vector<float> values;
};

/// Writes a .vtp with numbers at its vertices and triangles, for viewers to colour it by.
/// \pre each array has an entry for every vertex, or triangle.
/// \throws Error usage (another ending), refused, cancelled (as write_surface).
void write_surface_map(const std::string& path, const TriangleMesh& mesh, Space space,
                       const std::vector<SurfaceArray>& of_vertices,
                       const std::vector<SurfaceArray>& of_triangles,
                       const std::atomic<bool>* cancel = nullptr);

/// What write_surface would refuse, found before any work is done.
/// \throws Error usage (unknown ending), refused (folder missing or not writable; a folder, device
///         or pipe of that name).
void check_output_path(const std::string& path);

/// "lps", "ras" or "voxel"; and as files name it: "LPS", "RAS" or "VOXEL".
const char* space_name(Space space);
std::string upper_space_name(Space space);

}  // namespace vasamesh
