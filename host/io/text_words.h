#pragma once

/// \file
/// Words and numbers of files that are text.

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

namespace vasamesh {

/// What `text` holds after the mark that some editors put before UTF-8.
inline std::string_view without_mark(std::string_view text) {
  constexpr std::string_view kMark = "\xef\xbb\xbf";
  return text.starts_with(kMark) ? text.substr(kMark.size()) : text;
}

/// Without the blanks and line ends round it.
inline std::string_view trimmed(std::string_view text) {
  constexpr const char* kBlanks = " \t\r\n";
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

/// Takes the next word off the front of `text`; empty at the end.
inline std::string_view next_word(std::string_view& text) {
  constexpr const char* kBlanks = " \t\r\n\v\f";
  text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
  const std::string_view word = text.substr(0, text.find_first_of(kBlanks));
  text.remove_prefix(word.size());
  return word;
}

/// What std::from_chars does not take: a plus sign.
inline std::string_view without_plus(std::string_view word) {
  return word.starts_with('+') && !word.starts_with("+-") ? word.substr(1) : word;
}

/// The number that `word` is; none where it is something else. What is too small for a double is 0,
/// or nearly so, and too large, infinite.
inline std::optional<double> number_in(std::string_view word) {
  word = without_plus(word);
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (end != word.data() + word.size()) return std::nullopt;
  if (error == std::errc::result_out_of_range)
    return std::strtod(std::string(word).c_str(), nullptr);
  return error == std::errc() ? std::optional(value) : std::nullopt;
}

}  // namespace vasamesh
