/// The reusable Converter: the same results as convert(), volume after volume.

#include <gtest/gtest.h>

#include "phantom/phantom.h"
#include "tbb/backend.h"
#include "vasamesh/host.h"
#include "vasamesh/pipeline.h"

namespace vasamesh {
namespace {

TEST(Converter, GivesWhatConvertGivesForOneVolumeAfterAnother) {
  Converter converter(make_context({.backend = "tbb", .threads = 2}));
  for (const char* name :
       {"torus", "line_space_diagonal", "torus", "single_voxel", "hollow_shell"}) {
    const Phantom phantom = make_phantom(name);
    const Result reused = converter.convert(phantom.view(), {});
    Context context = make_context({.backend = "tbb", .threads = 2});
    const Result fresh = convert(phantom.view(), {}, context);
    EXPECT_EQ(reused.mesh.vertices, fresh.mesh.vertices) << name;
    EXPECT_EQ(reused.mesh.triangles, fresh.mesh.triangles) << name;
  }
}

TEST(Converter, WorksAfterAnError) {
  Converter converter(make_context({.backend = "tbb"}));
  const Phantom phantom = make_phantom("sphere");
  Parameters wrong;
  wrong.neighbours = 1;
  EXPECT_THROW(converter.convert(phantom.view(), wrong), Error);
  EXPECT_TRUE(converter.convert(phantom.view(), {}).report.check.passed);
}

TEST(KeptMemory, ServesTheNextBufferOfThatSizeAndIsNotCountedAsHeld) {
  const auto backend = make_tbb_backend(1, nullptr);
  backend->keep_memory(true);
  void* first = backend->allocate(100'000);
  EXPECT_EQ(backend->bytes_held(), 100'000u);
  backend->release(first, 100'000);
  EXPECT_EQ(backend->bytes_held(), 0u);
  void* second = backend->allocate(99'000);  // of the same block size
  EXPECT_EQ(second, first);
  backend->release(second, 99'000);
  backend->keep_memory(false);
  EXPECT_EQ(backend->bytes_held(), 0u);
}

}  // namespace
}  // namespace vasamesh
