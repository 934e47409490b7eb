#include "io/dicom_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <system_error>
#include <utility>

#include "io/file_ending.h"
#include "io/io_error.h"
#include "lower_case.h"

namespace vasamesh {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kPreamble = 128;  // "DICM" follows it (PS3.10, 7.1)

/// In the order of their names.
std::vector<fs::directory_entry> entries_of(const std::string& folder) {
  std::vector<fs::directory_entry> entries;
  std::error_code error;
  fs::directory_iterator entry(folder, error);
  for (; !error && entry != fs::directory_iterator(); entry.increment(error))
    entries.push_back(*entry);
  if (error)
    throw_bad_input(folder, "the folder cannot be read: " + error.message(),
                    "make it readable or copy it");
  std::sort(entries.begin(), entries.end());
  return entries;
}

/// Hidden files are other programs' notes, DICOMDIR is a table of contents.
bool is_left_aside(const std::string& name) {
  return name.starts_with('.') || lower_case(name) == "dicomdir";
}

/// Whether links lead to a file. \throws Error bad_input where they lead nowhere.
bool is_file(const fs::directory_entry& entry) {
  std::error_code error;
  const fs::file_type type = entry.status(error).type();
  if (type == fs::file_type::none || type == fs::file_type::not_found)
    throw_bad_input(entry.path().string(),
                    entry.is_symlink(error) ? "this link leads to no file that can be reached"
                                            : "the file cannot be reached",
                    "get a whole copy of the series, or remove it if it is no slice");
  return type == fs::file_type::regular;
}

/// The first bytes, up to and with those that say "DICM".
std::string head_of(const std::string& file) {
  std::string head(kPreamble + 4, '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.read(head.data(), static_cast<std::streamsize>(head.size()));
  if (!stream.is_open() || stream.bad())
    throw_bad_input(file, "the file cannot be read",
                    "make it readable, or remove it if it is no slice");
  head.resize(static_cast<std::size_t>(stream.gcount()));
  return head;
}

/// What the name ends in; empty for numbers, as those that end a UID.
std::string ending_of(const std::string& file) {
  const std::string ending = lower_case(fs::path(file).extension().string());
  const auto is_letter = [](unsigned char c) { return std::isalpha(c) != 0; };
  return std::any_of(ending.begin(), ending.end(), is_letter) ? ending : "";
}

/// Without a preamble, files begin with one of the first elements of the group 0002 or 0008.
bool begins_as_dicom(const std::string& head) {
  if (head.size() == kPreamble + 4 && head.ends_with("DICM")) return true;
  if (head.size() < 8) return false;
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(head[i]); };
  const auto begins = [&](unsigned group, unsigned element, unsigned zero) {
    return zero == 0 && (group == 2 || group == 8) && element <= 0x18;
  };
  return begins(byte(0), byte(2), byte(1) | byte(3)) || begins(byte(1), byte(3), byte(0) | byte(2));
}

/// Whether a file that is no DICOM may have been a slice, by a name like the slices' own.
bool may_be_slice(const std::string& file, const std::string& head,
                  const std::set<std::string>& endings) {
  const bool is_text = !head.empty() && head.find('\0') == std::string::npos;
  return !is_text && endings.contains(ending_of(file));
}

[[noreturn]] void throw_no_slice(const std::string& file, bool empty) {
  throw_bad_input(
      file, empty ? "an empty file among the slices" : "a file among the slices that is not DICOM",
      "get a whole copy of the series, or remove the file if it is no slice");
}

/// Several series in one folder.
[[noreturn]] void throw_several(const std::string& folder,
                                const std::map<std::string, std::vector<DicomFile>>& series) {
  std::string list;
  int named = 0;
  for (const auto& [uid, files] : series)
    if (named++ < 10) list += (list.empty() ? "" : ", ") + (uid.empty() ? "one without UID" : uid);
  throw_bad_input(folder,
                  fmt::format("it holds {} DICOM series ({}{})", series.size(), list,
                              series.size() > 10 ? ", ..." : ""),
                  "put the one to convert into a folder of its own");
}

/// Scout images lie beside the slices that they were made for.
void leave_localizers(std::map<std::string, std::vector<DicomFile>>& series) {
  const auto is_scout = [](const auto& one) {
    return std::all_of(one.second.begin(), one.second.end(),
                       [](const DicomFile& file) { return file.is_localizer; });
  };
  if (!std::all_of(series.begin(), series.end(), is_scout)) std::erase_if(series, is_scout);
}

}  // namespace

std::vector<std::string> list_dicom_folder(const std::string& folder) {
  std::vector<std::pair<std::string, std::string>> others;  // with their heads
  std::vector<std::string> files;
  std::set<std::string> endings{".dcm"};
  for (const fs::directory_entry& entry : entries_of(folder)) {
    if (is_left_aside(entry.path().filename().string()) || !is_file(entry)) continue;
    const std::string file = entry.path().string(), head = head_of(file);
    if (begins_as_dicom(head)) {
      files.push_back(file);
      endings.insert(ending_of(file));
    } else {
      others.emplace_back(file, head);
    }
  }
  for (const auto& [file, head] : others)
    if (may_be_slice(file, head, endings) || !file_ending(file, {".dcm"}).empty())
      throw_no_slice(file, head.empty());
  return files;
}

std::vector<DicomFile> dicom_series(const std::string& folder,
                                    const std::vector<std::string>& files) {
  std::map<std::string, std::vector<DicomFile>> series;
  std::vector<DicomFile> others;  // without pixels
  for (const std::string& path : files) {
    DicomFile file = read_dicom_file(path);
    if (file.is_directory) continue;
    if (!file.has_pixels && file.series.empty()) throw_damaged_header(path);
    (file.has_pixels ? series[file.series] : others).push_back(std::move(file));
  }
  leave_localizers(series);
  if (series.empty() && !others.empty())
    throw_bad_input(others.front().path,
                    others.size() == 1
                        ? "it holds no pixels"
                        : "neither it nor the folder's other DICOM files hold pixels",
                    "give a folder with a DICOM series of images");
  if (series.empty())
    throw_bad_input(folder, "a folder without a DICOM series", "give a file, or such a folder");
  if (series.size() > 1) throw_several(folder, series);
  for (const DicomFile& file : others)
    if (file.series == series.begin()->first)
      throw_bad_input(file.path, "it belongs to the series but holds no pixels",
                      "get a whole copy of the series, or remove the file if it is no slice");
  return std::move(series.begin()->second);
}

}  // namespace vasamesh
