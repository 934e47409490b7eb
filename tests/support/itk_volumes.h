#pragma once

/// \file
/// Volumes written by ITK's own writer, for tests of our reader.

#include <itkImage.h>
#include <itkImageFileWriter.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>

#include <algorithm>
#include <string>
#include <vector>

#include "vasamesh/types.h"

namespace vasamesh {

inline itk::ImageIOBase::Pointer test_image_io(const std::string& path) {
  if (path.ends_with(".mha") || path.ends_with(".mhd")) return itk::MetaImageIO::New().GetPointer();
  if (path.ends_with(".nrrd")) return itk::NrrdImageIO::New().GetPointer();
  return itk::NiftiImageIO::New().GetPointer();
}

template <class T>
typename itk::Image<T, 3>::Pointer make_itk_image(const Geometry& geometry,
                                                  const std::vector<T>& pixels) {
  using Image = itk::Image<T, 3>;
  auto image = Image::New();
  typename Image::SizeType size;
  typename Image::SpacingType spacing;
  typename Image::PointType origin;
  typename Image::DirectionType direction;
  for (int a = 0; a < 3; ++a) {
    size[a] = static_cast<itk::SizeValueType>(geometry.size[a]);
    spacing[a] = geometry.spacing[a];
    origin[a] = geometry.origin[a];
    for (int b = 0; b < 3; ++b) direction[a][b] = geometry.direction[3 * a + b];
  }
  image->SetRegions(size);
  image->SetSpacing(spacing);
  image->SetOrigin(origin);
  image->SetDirection(direction);
  image->Allocate();
  std::copy(pixels.begin(), pixels.end(), image->GetBufferPointer());
  return image;
}

/// Writes `pixels` in the format of the ending.
template <class T>
void write_itk(const std::string& path, const Geometry& geometry, const std::vector<T>& pixels,
               bool compress) {
  auto writer = itk::ImageFileWriter<itk::Image<T, 3>>::New();
  writer->SetImageIO(test_image_io(path));
  writer->SetFileName(path);
  writer->SetInput(make_itk_image(geometry, pixels));
  writer->SetUseCompression(compress);
  writer->Update();
}

}  // namespace vasamesh
