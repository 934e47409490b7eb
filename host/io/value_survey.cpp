#include "io/value_survey.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <optional>

namespace vasamesh {
namespace {

void add_value(double value, ValueSurvey& survey) {
  if (std::isnan(value)) {
    survey.nan = true;
  } else if (std::isinf(value)) {
    survey.infinite = true;
  } else {
    const bool first = survey.values.empty();
    survey.minimum = first ? value : std::min(survey.minimum, value);
    survey.maximum = first ? value : std::max(survey.maximum, value);
    survey.integral = survey.integral && std::trunc(value) == value;
    if (survey.values.size() <= ValueSurvey::kMostLabels) survey.values.insert(value);
  }
}

template <class T>
void add_values(const T* pixels, std::size_t count, ValueSurvey& survey) {
  std::optional<T> last;
  for (std::size_t i = 0; i < count; ++i) {
    if (last && pixels[i] == *last) continue;
    last = pixels[i];
    add_value(static_cast<double>(pixels[i]), survey);
  }
}

}  // namespace

std::string ValueSurvey::labels_text() const {
  constexpr int kMostNamed = 10;
  std::string names;
  int count = 0;
  for (const double value : values) {
    if (value == 0) continue;
    if (count < kMostNamed) names += (count ? ", " : "") + fmt::format("{}", value);
    if (count == kMostNamed) names += ", ...";
    ++count;
  }
  return fmt::format("{} label{} ({})", count, count == 1 ? "" : "s", names);
}

std::string ValueSurvey::range_text() const {
  return fmt::format("values from {} to {}", minimum, maximum);
}

ValueSurvey survey_values(const PixelSource& pixels) {
  ValueSurvey survey;
  std::mutex mutex;
  pixels.visit([&](const PixelChunk& chunk) {
    const std::lock_guard lock(mutex);
    visit_pixel_type(chunk.type, [&]<class T>(T) {
      add_values(static_cast<const T*>(chunk.pixels), chunk.count, survey);
    });
  });
  return survey;
}

}  // namespace vasamesh
