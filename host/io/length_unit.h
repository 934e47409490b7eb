#pragma once

/// \file
/// Units of length in the headers of volumes, which ITK leaves out.

#include <string>

#include "vasamesh/types.h"

namespace vasamesh {

/// The length of a unit: nm, um, mm, cm, m, or the same in full and any case. No name is mm.
/// \param field  of the header, for the message. \throws Error bad_input: another name.
double unit_in_mm(const std::string& path, const std::string& name, const char* field);

/// Spacing and origin, so far in a unit of that many mm, become mm.
void take_lengths_in(double unit, Geometry& geometry);

}  // namespace vasamesh
