/// \file
/// vasamesh_vtk_baseline VOLUME.nii.gz SURFACE.ply: what VTK users do, as a measure of our own
/// time. FlyingEdges3D, WindowedSinc smoothing (20 iterations, pass band 0.1), QuadricDecimation by
/// half. Prints the seconds of each step.

#include <itkImageFileReader.h>
#include <itkNiftiImageIO.h>
#include <vtkCellArray.h>
#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPLYWriter.h>
#include <vtkPointData.h>
#include <vtkQuadricDecimation.h>
#include <vtkUnsignedCharArray.h>
#include <vtkWindowedSincPolyDataFilter.h>

#include <chrono>
#include <cstdio>
#include <exception>

namespace {

using Image = itk::Image<unsigned char, 3>;

/// Seconds since the last call.
double lap() {
  static auto last = std::chrono::steady_clock::now();
  const auto now = std::chrono::steady_clock::now();
  const double seconds = std::chrono::duration<double>(now - last).count();
  last = now;
  return seconds;
}

Image::Pointer read_volume(const char* path) {
  const auto reader = itk::ImageFileReader<Image>::New();
  reader->SetImageIO(itk::NiftiImageIO::New());
  reader->SetFileName(path);
  reader->Update();
  return reader->GetOutput();
}

/// The pixels stay the image's. Directions are left out: they change no time.
void share_pixels(Image& image, vtkImageData* volume) {
  const auto size = image.GetBufferedRegion().GetSize();
  vtkNew<vtkUnsignedCharArray> pixels;
  pixels->SetArray(image.GetBufferPointer(), static_cast<vtkIdType>(size[0] * size[1] * size[2]),
                   1);
  volume->SetDimensions(static_cast<int>(size[0]), static_cast<int>(size[1]),
                        static_cast<int>(size[2]));
  volume->SetSpacing(image.GetSpacing().GetDataPointer());
  volume->SetOrigin(image.GetOrigin().GetDataPointer());
  volume->GetPointData()->SetScalars(pixels);
}

void convert(const char* input, const char* output) {
  lap();
  const Image::Pointer image = read_volume(input);
  vtkNew<vtkImageData> volume;
  share_pixels(*image, volume);
  const double read = lap();

  vtkNew<vtkFlyingEdges3D> cubes;
  cubes->SetInputData(volume);
  cubes->SetValue(0, 0.5);
  cubes->ComputeNormalsOff();
  cubes->Update();
  const double extracted = lap();

  vtkNew<vtkWindowedSincPolyDataFilter> smooth;
  smooth->SetInputConnection(cubes->GetOutputPort());
  smooth->SetNumberOfIterations(20);
  smooth->SetPassBand(0.1);
  smooth->Update();
  const double smoothed = lap();

  vtkNew<vtkQuadricDecimation> decimate;
  decimate->SetInputConnection(smooth->GetOutputPort());
  decimate->SetTargetReduction(0.5);
  decimate->Update();
  const double decimated = lap();

  vtkNew<vtkPLYWriter> writer;
  writer->SetInputConnection(decimate->GetOutputPort());
  writer->SetFileName(output);
  writer->Write();
  std::printf(
      "{\"read\": %.4f, \"flying_edges\": %.4f, \"windowed_sinc\": %.4f, "
      "\"quadric_decimation\": %.4f, \"write\": %.4f, \"triangles_extracted\": %lld, "
      "\"triangles\": %lld}\n",
      read, extracted, smoothed, decimated, lap(),
      static_cast<long long>(cubes->GetOutput()->GetNumberOfCells()),
      static_cast<long long>(decimate->GetOutput()->GetNumberOfCells()));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: vasamesh_vtk_baseline VOLUME.nii.gz SURFACE.ply\n");
    return 2;
  }
  try {
    convert(argv[1], argv[2]);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "vasamesh_vtk_baseline: %s\n", error.what());
    return 3;
  }
}
