#include "io/text_header.h"

#include <cstdlib>
#include <filesystem>
#include <string_view>

#include "io/byte_stream.h"
#include "io/io_error.h"
#include "io/text_words.h"
#include "lower_case.h"

namespace vasamesh {
namespace {

constexpr std::size_t kMostHeaderBytes = std::size_t{1} << 20;

bool is_metadata(std::string_view line, std::size_t split, const TextHeaderFormat& format) {
  return !format.metadata.empty() && line.substr(split).starts_with(format.metadata);
}

}  // namespace

std::string TextHeader::get(const std::string& key, const std::string& otherwise) const {
  const auto field = fields.find(key);
  return field == fields.end() ? otherwise : field->second;
}

std::string TextHeader::get_lower(const std::string& key, const std::string& otherwise) const {
  return lower_case(get(key, otherwise));
}

std::vector<double> TextHeader::numbers(const std::string& key) const {
  const std::string value = get(key);
  std::vector<double> numbers;
  const char* at = value.c_str();
  for (char* next = nullptr;; at = next) {
    const double number = std::strtod(at, &next);
    if (next == at) return numbers;
    numbers.push_back(number);
  }
}

TextHeader read_text_header(const std::string& path, const TextHeaderFormat& format) {
  std::string text(kMostHeaderBytes, '\0');
  text.resize(ByteStream(path, 0, Encoding::raw).read(text.data(), text.size()));
  TextHeader header;
  std::size_t begin = 0;
  for (std::size_t end; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1) {
    const std::string_view line = trimmed(std::string_view(text).substr(begin, end - begin));
    const std::size_t split = line.find_first_of(format.separators);
    const bool has_key = split != std::string::npos && !is_metadata(line, split, format);
    const std::string key = has_key ? std::string(trimmed(line.substr(0, split))) : "";
    if (has_key) header.fields[key] = std::string(trimmed(line.substr(split + 1)));
    header.end = static_cast<std::int64_t>(end) + 1;
    if (format.last(key, std::string(line))) return header;
  }
  throw_bad_input(path, "its header does not end", "get a whole copy of the file");
}

std::string beside(const std::string& header_path, const std::string& name) {
  return (std::filesystem::path(header_path).parent_path() / name).string();
}

}  // namespace vasamesh
