#include "io/dicom_file.h"

#include <gdcmReader.h>

#include "io/dicom_tags.h"
#include "io/io_error.h"

namespace vasamesh {
namespace {

using gdcm::Tag;

const Tag kPixels(0x7fe0, 0x0010), kFloatPixels(0x7fe0, 0x0008), kDoublePixels(0x7fe0, 0x0009);
constexpr char kDicomdir[] = "1.2.840.10008.1.3.10";  // the SOP class of media directories

bool stands_at_pixels(const gdcm::Reader& reader) {
  // The stream stands at the pixels; past the end of a file without, or after what follows them.
  const auto position = static_cast<std::int64_t>(reader.GetStreamCurrentPosition());
  const gdcm::DataSet& set = reader.GetFile().GetDataSet();
  return position > 0 && (set.IsEmpty() || set.GetDES().rbegin()->GetTag() < kPixels);
}

void read_size(const gdcm::DataSet& set, DicomFile& file) {
  file.columns = dicom_unsigned(set, Tag(0x0028, 0x0011)).value_or(0);
  file.rows = dicom_unsigned(set, Tag(0x0028, 0x0010)).value_or(0);
  file.samples = dicom_unsigned(set, Tag(0x0028, 0x0002)).value_or(1);
  file.bits_allocated = dicom_unsigned(set, Tag(0x0028, 0x0100)).value_or(0);
  const auto frames = dicom_numbers(set, Tag(0x0028, 0x0008));
  if (frames.size() == 1 && frames.front() > 1 && frames.front() < 1e9)
    file.frame_count = static_cast<std::int64_t>(frames.front());
}

DicomFile parsed(const std::string& path, const gdcm::Reader& reader) {
  const gdcm::FileMetaInformation& meta = reader.GetFile().GetHeader();
  const gdcm::DataSet& set = reader.GetFile().GetDataSet();
  DicomFile file;
  file.path = path;
  file.series = dicom_text(set, Tag(0x0020, 0x000e));
  file.is_directory = dicom_text(meta, Tag(0x0002, 0x0002)) == kDicomdir;
  const std::string image_type = dicom_text(set, Tag(0x0008, 0x0008));
  file.is_localizer = image_type.find("LOCALIZER") != std::string::npos;
  file.has_float_pixels = set.FindDataElement(kFloatPixels) || set.FindDataElement(kDoublePixels);
  file.has_pixels = file.has_float_pixels || stands_at_pixels(reader);
  file.has_imager_spacing = set.FindDataElement(Tag(0x0018, 0x1164));
  read_size(set, file);
  file.frames = dicom_frames(set, file.frame_count);
  const gdcm::TransferSyntax syntax = meta.GetDataSetTransferSyntax();
  file.is_raw =
      !syntax.IsEncapsulated() && syntax != gdcm::TransferSyntax::DeflatedExplicitVRLittleEndian;
  file.is_big_endian = syntax.GetSwapCode() == gdcm::SwapCode::BigEndian;
  file.pixels_begin = static_cast<std::int64_t>(reader.GetStreamCurrentPosition());
  return file;
}

}  // namespace

DicomFile read_dicom_file(const std::string& path) {
  try {
    gdcm::Reader reader;
    reader.SetFileName(path.c_str());
    if (reader.ReadUpToTag(kPixels, {kPixels})) return parsed(path, reader);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception&) {
    throw_damaged_header(path);
  }
  throw_damaged_header(path);
}

void throw_damaged_header(const std::string& path) {
  throw_bad_input(path, "its DICOM header is damaged or cut short",
                  "get a whole copy of the series, or remove the file if it is no slice");
}

}  // namespace vasamesh
