#pragma once

/// \file
/// What the baseline programs have in common: PROGRAM VOLUME SURFACE.ply [options]. Every voxel but
/// 0 is object; the surface comes in mm, LPS. Exit codes are those of vasamesh.

#include <CLI/CLI.hpp>
#include <functional>

#include "io/volume_reader.h"
#include "vasamesh/types.h"

namespace vasamesh::baselines {

using Method = std::function<void(const Segmentation&, const std::string& output)>;

/// Parses the arguments, to which the caller may have added options, reads the volume and runs the
/// method. \returns the exit code.
int run_program(CLI::App& app, int argc, char** argv, const Method& method);

/// The part of the volume that holds the object, with `border` background voxels round it.
/// \throws Error bad_input when nothing is in the foreground.
Segmentation cropped(const Segmentation& segmentation, int border);

}  // namespace vasamesh::baselines
