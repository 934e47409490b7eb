#include "io/dicom_tags.h"

#include <gdcmByteValue.h>
#include <gdcmSequenceOfItems.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstring>
#include <string_view>

#include "io/text_words.h"

namespace vasamesh {
namespace {

const gdcm::ByteValue* bytes_of(const gdcm::DataSet& set, const gdcm::Tag& tag) {
  return set.FindDataElement(tag) ? set.GetDataElement(tag).GetByteValue() : nullptr;
}

std::optional<double> number_of(std::string_view text) {
  text = without_plus(trimmed(text));
  double number = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || stop != end || !std::isfinite(number)) return std::nullopt;
  return number;
}

}  // namespace

std::string dicom_text(const gdcm::DataSet& set, const gdcm::Tag& tag) {
  const gdcm::ByteValue* const bytes = bytes_of(set, tag);
  if (!bytes || !bytes->GetPointer()) return {};
  const std::string_view whole(bytes->GetPointer(), bytes->GetLength());
  std::string text(trimmed(whole.substr(0, whole.find('\0'))));
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return std::iscntrl(c) != 0; }, '?');
  return text;
}

std::vector<double> dicom_numbers(const gdcm::DataSet& set, const gdcm::Tag& tag) {
  const std::string text = dicom_text(set, tag);
  std::vector<double> numbers;
  for (std::size_t begin = 0, end = 0; end != std::string::npos && !text.empty(); begin = end + 1) {
    end = text.find('\\', begin);
    const auto number = number_of(std::string_view(text).substr(begin, end - begin));
    if (!number) return {};
    numbers.push_back(*number);
  }
  return numbers;
}

std::optional<std::int64_t> dicom_unsigned(const gdcm::DataSet& set, const gdcm::Tag& tag) {
  const gdcm::ByteValue* const bytes = bytes_of(set, tag);
  if (!bytes || !bytes->GetPointer()) return std::nullopt;
  std::uint16_t word = 0;
  std::uint32_t long_word = 0;
  if (bytes->GetLength() == sizeof(long_word)) {
    std::memcpy(&long_word, bytes->GetPointer(), sizeof(long_word));
    return long_word;
  }
  if (bytes->GetLength() != sizeof(word)) return std::nullopt;
  std::memcpy(&word, bytes->GetPointer(), sizeof(word));
  return word;
}

std::vector<gdcm::DataSet> dicom_items(const gdcm::DataSet& set, const gdcm::Tag& tag) {
  std::vector<gdcm::DataSet> items;
  if (!set.FindDataElement(tag)) return items;
  const gdcm::SmartPointer<gdcm::SequenceOfItems> sequence = set.GetDataElement(tag).GetValueAsSQ();
  if (!sequence) return items;
  for (std::size_t i = 1; i <= sequence->GetNumberOfItems(); ++i)
    items.push_back(sequence->GetItem(i).GetNestedDataSet());
  return items;
}

}  // namespace vasamesh
