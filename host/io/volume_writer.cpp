#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>

#include <vector>

#include "io/atomic_file.h"
#include "io/file_ending.h"
#include "io/io_error.h"
#include "io/quiet.h"
#include "io/volume_formats.h"
#include "io/volume_reader.h"

namespace vasamesh {
namespace {

std::string volume_ending(const std::string& path) {
  const std::string ending = file_ending(path, {".nii", ".nii.gz", ".mha", ".nrrd"});
  if (!ending.empty()) return ending;
  throw Error(ErrorCode::usage,
              path + ": unknown ending of a volume; use .nii.gz, .nii, .mha or .nrrd");
}

itk::ImageIOBase::Pointer make_image_io(const std::string& ending) {
  if (ending == ".mha") return itk::MetaImageIO::New().GetPointer();
  if (ending == ".nrrd") return itk::NrrdImageIO::New().GetPointer();
  return itk::NiftiImageIO::New().GetPointer();
}

void describe(const Geometry& geometry, itk::ImageIOBase& io) {
  io.SetNumberOfDimensions(3);
  io.SetNumberOfComponents(1);
  io.SetPixelType(itk::IOPixelEnum::SCALAR);
  io.SetComponentType(itk::IOComponentEnum::UCHAR);
  itk::ImageIORegion region(3);
  for (int axis = 0; axis < 3; ++axis) {
    const auto size = static_cast<itk::SizeValueType>(geometry.size[axis]);
    io.SetDimensions(axis, size);
    io.SetSpacing(axis, geometry.spacing[axis]);
    io.SetOrigin(axis, geometry.origin[axis]);
    io.SetDirection(axis, {geometry.direction[axis], geometry.direction[3 + axis],
                           geometry.direction[6 + axis]});
    region.SetIndex(axis, 0);
    region.SetSize(axis, size);
  }
  io.SetIORegion(region);
}

// The libraries do not notice every failed write, a full disk among them.
void check_written(const std::string& path, const std::string& temporary,
                   const std::string& ending) {
  try {
    const Volume volume = ending == ".mha"    ? open_meta(temporary)
                          : ending == ".nrrd" ? open_nrrd(temporary)
                                              : open_nifti(temporary);
    volume.pixels->visit([](const PixelChunk&) {});
  } catch (const Error&) {
    throw_refused(path, "it could not be written whole", "make room on the disk");
  }
}

}  // namespace

void check_volume_path(const std::string& path) {
  volume_ending(path);
  check_writable(path);
}

void write_segmentation(const std::string& path, const Segmentation& segmentation,
                        const std::atomic<bool>* cancel) {
  const Quiet quiet;
  const std::string ending = volume_ending(path);
  AtomicFile file(path, cancel);
  const itk::ImageIOBase::Pointer io = make_image_io(ending);
  describe(segmentation.geometry, *io);
  io->SetUseCompression(ending != ".nii");
  io->SetCompressionLevel(1);
  try {
    io->SetFileName(file.temporary());
    io->WriteImageInformation();
    io->Write(segmentation.voxels.data());
  } catch (const itk::ExceptionObject&) {
    throw_refused(path, "it could not be written", "make room on the disk");
  }
  check_written(path, file.temporary(), ending);
  file.commit();
}

}  // namespace vasamesh
