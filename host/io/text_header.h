#pragma once

/// \file
/// The text at the head of a MetaImage or NRRD file: lines of a key and a value.

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace vasamesh {

struct TextHeader {
  std::map<std::string, std::string> fields;  ///< keys and values without surrounding blanks
  std::int64_t end = 0;                       ///< bytes up to and with the header's last line

  /// The value of `key`; `otherwise` when there is none.
  std::string get(const std::string& key, const std::string& otherwise = "") const;
  /// The value in lower case.
  std::string get_lower(const std::string& key, const std::string& otherwise = "") const;
  /// The value's numbers, up to the first thing that is none.
  std::vector<double> numbers(const std::string& key) const;
};

struct TextHeaderFormat {
  std::string separators;  ///< characters, each of which ends a key
  std::string metadata;    ///< what stands for the separator in lines that are no fields; or empty
  bool (*last)(const std::string& key, const std::string& line);  ///< whether the header ends
};

/// Reads lines of a key, a separator and a value, to the last: "" is the key of one without
/// separator, or of metadata. \throws Error bad_input: no such line in the first MiB.
TextHeader read_text_header(const std::string& path, const TextHeaderFormat& format);

/// The file that `header_path` names `name`, beside it unless the name is absolute.
std::string beside(const std::string& header_path, const std::string& name);

}  // namespace vasamesh
