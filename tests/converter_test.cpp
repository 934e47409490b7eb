/// The reusable Converter: the same results as convert(), volume after volume.

#include <gtest/gtest.h>

#include "backend/backend.h"
#include "phantom/phantom.h"
#include "tbb/backend.h"
#include "vasamesh/host.h"
#include "vasamesh/pipeline.h"

namespace vasamesh {
namespace {

Context on_tbb() {
  ContextOptions options;
  options.backend = "tbb";
  options.threads = 2;
  return make_context(options);
}

TEST(Converter, GivesWhatConvertGivesForOneVolumeAfterAnother) {
  Converter converter(on_tbb());
  for (const char* name :
       {"torus", "line_space_diagonal", "torus", "single_voxel", "hollow_shell"}) {
    const Phantom phantom = make_phantom(name);
    const Result reused = converter.convert(phantom.view(), {});
    Context context = on_tbb();
    const Result fresh = convert(phantom.view(), {}, context);
    EXPECT_EQ(reused.mesh.vertices, fresh.mesh.vertices) << name;
    EXPECT_EQ(reused.mesh.triangles, fresh.mesh.triangles) << name;
  }
}

TEST(Converter, OfNoBackendSaysSo) {
  const Phantom phantom = make_phantom("sphere");
  for (const std::size_t count : {0u, 1u}) {
    Context context;
    context.backends.resize(count);
    try {
      Converter(context).convert(phantom.view(), {});
      ADD_FAILURE();
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::usage) << error.what();
    }
  }
}

TEST(Converter, WorksAfterAnError) {
  Converter converter(on_tbb());
  const Phantom phantom = make_phantom("sphere");
  Parameters wrong;
  wrong.neighbours = 1;
  EXPECT_THROW(converter.convert(phantom.view(), wrong), Error);
  EXPECT_TRUE(converter.convert(phantom.view(), {}).report.check.passed);
}

TEST(Converter, MayShareABackendWithAnother) {
  const Context shared = on_tbb();
  Converter first(shared);
  {
    Converter second(shared);
    second.convert(make_phantom("torus").view(), {});
  }
  first = Converter(shared);
  EXPECT_TRUE(first.convert(make_phantom("torus").view(), {}).report.check.passed);
}

/// A backend that keeps memory, and what it was asked for.
class KeptMemory : public testing::Test {
 protected:
  void* take(std::size_t bytes) { return backend_->allocate(bytes); }
  void give(void* block, std::size_t bytes) { backend_->release(block, bytes); }

  const std::shared_ptr<Backend> backend_ = make_tbb_backend(1, nullptr);
};

TEST_F(KeptMemory, EndsWithTheLastWhoWantsIt) {
  backend_->keep_memory(true);
  backend_->keep_memory(true);
  backend_->keep_memory(false);
  void* first = take(1'000'000);
  give(first, 1'000'000);
  EXPECT_EQ(take(1'000'000), first);
  give(first, 1'000'000);
  backend_->keep_memory(false);
}

TEST_F(KeptMemory, IsNoneUnderALimit) {
  backend_->keep_memory(true);
  give(take(100'000'000), 100'000'000);
  backend_->set_byte_limit(50'000'000);  // what is kept would be more
  void* first = take(40'000'000);
  EXPECT_EQ(backend_->bytes_held(), 40'000'000u);
  EXPECT_THROW(take(40'000'000), Error);
  give(first, 40'000'000);
  backend_->set_byte_limit(0);
  backend_->keep_memory(false);
}

TEST_F(KeptMemory, ServesTheNextBufferOfThatSizeAndIsNotCountedAsHeld) {
  backend_->keep_memory(true);
  void* first = take(100'000);
  EXPECT_EQ(backend_->bytes_held(), 100'000u);
  give(first, 100'000);
  EXPECT_EQ(backend_->bytes_held(), 0u);
  void* second = take(99'000);  // of the same block size
  EXPECT_EQ(second, first);
  give(second, 99'000);
  backend_->keep_memory(false);
  EXPECT_EQ(backend_->bytes_held(), 0u);
}

}  // namespace
}  // namespace vasamesh
