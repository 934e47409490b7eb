#pragma once

/// \file
/// Results for people, on stdout.

#include <string>

#include "stages/distance.h"
#include "vasamesh/report.h"

namespace vasamesh::cli {

/// A few lines about a conversion that succeeded.
void print_conversion(const std::string& input, const std::string& output, const Report& report);

/// A table of everything that was checked.
void print_check(const std::string& surface, const CheckReport& check,
                 const QualityReport& quality);

/// The distribution of the RMS curvature.
void print_curvature(const Distribution& rms);

/// \param voxel_known  false: distances in mm alone.
void print_distance(const DistanceReport& distance, bool voxel_known);

}  // namespace vasamesh::cli
