#pragma once

/// \file
/// What values a volume holds, for the errors that name them.

#include <cstddef>
#include <set>
#include <string>

#include "io/pixel_source.h"

namespace vasamesh {

struct ValueSurvey {
  static constexpr std::size_t kMostLabels = 256;

  std::set<double> values;  ///< distinct and finite, up to kMostLabels + 1 of them
  double minimum = 0, maximum = 0;
  bool nan = false, infinite = false, integral = true;

  /// A few whole numbers: a label map rather than grey levels.
  bool is_label_map() const { return integral && values.size() <= kMostLabels; }

  /// How many labels there are beside 0, and the first ten: "3 labels (1, 2, 5)".
  std::string labels_text() const;
  /// "values from -1024 to 3071".
  std::string range_text() const;
};

ValueSurvey survey_values(const PixelSource& pixels);

}  // namespace vasamesh
