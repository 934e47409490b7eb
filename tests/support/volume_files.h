#pragma once

/// \file
/// Volume files made by hand, byte by byte, so that a test can spoil each of their fields.

#include <nifti1.h>
#include <zlib.h>

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace vasamesh {

/// A gzip stream of `bytes`.
inline std::string gzip(const std::string& bytes, int level = 6) {
  constexpr int kGzip = 15 + 16;
  z_stream stream{};
  deflateInit2(&stream, level, Z_DEFLATED, kGzip, 8, Z_DEFAULT_STRATEGY);
  std::string out(deflateBound(&stream, bytes.size()) + 64, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

/// The raw bytes of `values`.
template <class T>
std::string bytes_of(const std::vector<T>& values) {
  std::string bytes(values.size() * sizeof(T), '\0');
  if (!values.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

/// A header of a uint8 volume of `size` voxels of 0.5 x 0.5 x 0.75 mm, placed by its sform.
inline nifti_1_header nifti_header(int nx, int ny, int nz) {
  nifti_1_header header{};
  header.sizeof_hdr = sizeof(header);
  const short dim[8] = {
      3, static_cast<short>(nx), static_cast<short>(ny), static_cast<short>(nz), 1, 1, 1, 1};
  const float pixdim[8] = {1, 0.5f, 0.5f, 0.75f, 0, 0, 0, 0};
  std::memcpy(header.dim, dim, sizeof(dim));
  std::memcpy(header.pixdim, pixdim, sizeof(pixdim));
  header.datatype = 2;
  header.bitpix = 8;
  header.vox_offset = 352;
  header.xyzt_units = 2;
  header.sform_code = 1;
  header.srow_x[0] = header.srow_y[1] = 0.5f;
  header.srow_z[2] = 0.75f;
  std::memcpy(header.magic, "n+1", 4);
  return header;
}

/// The file: header, no extension, pixels.
inline std::string nifti_file(const nifti_1_header& header, const std::string& pixels) {
  std::string bytes(352, '\0');
  std::memcpy(bytes.data(), &header, sizeof(header));
  return bytes + pixels;
}

/// A uint8 MetaImage file; `lines` come before ElementDataFile and may repeat a key.
inline std::string meta_file(int nx, int ny, int nz, const std::string& lines,
                             const std::string& pixels) {
  return "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
         "DimSize = " +
         std::to_string(nx) + " " + std::to_string(ny) + " " + std::to_string(nz) +
         "\nElementType = MET_UCHAR\n" + lines + "ElementDataFile = LOCAL\n" + pixels;
}

/// A uint8 NRRD file without space; `lines` come after its sizes.
inline std::string nrrd_file(int nx, int ny, int nz, const std::string& lines,
                             const std::string& pixels) {
  return "NRRD0004\ntype: uint8\ndimension: 3\nsizes: " + std::to_string(nx) + " " +
         std::to_string(ny) + " " + std::to_string(nz) + "\n" + lines + "\n" + pixels;
}

}  // namespace vasamesh
