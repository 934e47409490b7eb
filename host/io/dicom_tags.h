#pragma once

/// \file
/// Values of DICOM elements (PS3.5, 6.2), read without GDCM's assertions on what they hold.

#include <gdcmDataSet.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vasamesh {

/// The text up to the first zero, without the blanks round it, of one line; empty where the element
/// is absent or empty.
std::string dicom_text(const gdcm::DataSet& set, const gdcm::Tag& tag);

/// The decimal numbers, as many as there are; none where one of them is no finite number.
std::vector<double> dicom_numbers(const gdcm::DataSet& set, const gdcm::Tag& tag);

/// An unsigned integer of 16 or 32 bits.
std::optional<std::int64_t> dicom_unsigned(const gdcm::DataSet& set, const gdcm::Tag& tag);

/// The items of a sequence; none where it is absent.
std::vector<gdcm::DataSet> dicom_items(const gdcm::DataSet& set, const gdcm::Tag& tag);

}  // namespace vasamesh
