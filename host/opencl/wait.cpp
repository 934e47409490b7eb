#include "opencl/wait.h"

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <system_error>
#include <thread>

namespace vasamesh {

namespace {

constexpr std::chrono::milliseconds kRest{10};  // between two checkpoints

/// The end of something, with its status, told by one thread to another.
class Ending {
 public:
  void tell(cl_int status) {
    const std::scoped_lock lock(mutex_);
    status_ = status;
    told_ = true;
    changed_.notify_one();
  }
  cl_int wait(const std::function<void()>& checkpoint) {
    std::unique_lock lock(mutex_);
    while (!changed_.wait_for(lock, kRest, [this] { return told_; })) {
      lock.unlock();
      if (checkpoint) checkpoint();
      lock.lock();
    }
    return status_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool told_ = false;
  cl_int status_ = CL_SUCCESS;
};
using SharedEnding = std::shared_ptr<Ending>;

/// \param user  a SharedEnding of its own.
void CL_CALLBACK on_end(cl_event, cl_int status, void* user) {
  const std::unique_ptr<SharedEnding> ending(static_cast<SharedEnding*>(user));
  (*ending)->tell(status);
}

}  // namespace

void wait_for(const cl::CommandQueue& queue, const std::function<void()>& checkpoint,
              const std::string& device) {
  const std::string what = "waiting for " + device;
  if (!checkpoint) return check(queue.finish(), what);
  checkpoint();  // many short waits in a row are a long time
  cl::Event last;
  check(queue.enqueueMarkerWithWaitList(nullptr, &last), what);
  const auto ending = std::make_shared<Ending>();
  auto for_callback = std::make_unique<SharedEnding>(ending);
  check(last.setCallback(CL_COMPLETE, on_end, for_callback.get()), what);
  for_callback.release();
  check(queue.flush(), what);
  const cl_int status = ending->wait(checkpoint);
  check(status < 0 ? status : CL_SUCCESS, what);
}

cl_int run_beside(std::function<cl_int()> work, const std::function<void()>& checkpoint) {
  if (!checkpoint) return work();
  checkpoint();
  const auto ending = std::make_shared<Ending>();
  try {
    std::thread([ending, work] { ending->tell(work()); }).detach();
  } catch (const std::system_error&) {  // no more threads: without checkpoints, then
    return work();
  }
  return ending->wait(checkpoint);
}

}  // namespace vasamesh
