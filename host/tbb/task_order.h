#pragma once

/// \file
/// The order that oneTBB keeps between a loop and its tasks, told to ThreadSanitizer: what came
/// before the loop comes before each task, and each task comes before what follows the loop. The
/// library is not built with the sanitizer, which therefore would take every result that one thread
/// leaves to another for a race. Two tasks of a loop stay unordered, so that races between them are
/// found. In builds without the sanitizer there is nothing here.

#if defined(__SANITIZE_THREAD__)
#define VASAMESH_THREAD_SANITIZER
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define VASAMESH_THREAD_SANITIZER
#endif
#endif

#ifdef VASAMESH_THREAD_SANITIZER
#include <sanitizer/tsan_interface.h>

#include <utility>
#endif

namespace vasamesh {

/// The order of one loop or pipeline: made before its tasks begin, on the thread that waits for
/// them, and gone when they have ended, before anything looks at what they have left.
class TaskOrder {
 public:
#ifdef VASAMESH_THREAD_SANITIZER
  TaskOrder() { __tsan_release(&begin_); }
  ~TaskOrder() {
    __tsan_acquire(&begin_);
    __tsan_acquire(&end_);
  }
  TaskOrder(const TaskOrder&) = delete;
  TaskOrder& operator=(const TaskOrder&) = delete;
#endif

  /// The body, which must outlive the result, of tasks that run in any order.
  template <class Body>
  decltype(auto) around(const Body& body) {
    return ordered(body, &begin_, &end_);
  }

  /// The same of tasks that run one after another, and whose results others of this order take.
  template <class Body>
  decltype(auto) in_turn(const Body& body) {
    return ordered(body, &begin_, &begin_);
  }

 private:
#ifdef VASAMESH_THREAD_SANITIZER
  /// A task's place: after what was released at one address, before what acquires the other.
  class Place {
   public:
    Place(char* after, char* before) : before_(before) { __tsan_acquire(after); }
    ~Place() { __tsan_release(before_); }
    Place(const Place&) = delete;
    Place& operator=(const Place&) = delete;

   private:
    char* before_;
  };

  /// oneTBB copies this into its tasks. The sanitizer sees the body, but not what is read from
  /// there before the task has its place.
  template <class Body>
  class Ordered {
   public:
    Ordered(const Body& body, char* after, char* before)
        : body_(&body), after_(after), before_(before) {}

    template <class... Arguments>
    __attribute__((no_sanitize("thread"))) decltype(auto) operator()(
        Arguments&&... arguments) const {
      const Place place(after_, before_);
      return (*body_)(std::forward<Arguments>(arguments)...);
    }

   private:
    const Body* body_;
    char *after_, *before_;
  };

  template <class Body>
  static Ordered<Body> ordered(const Body& body, char* after, char* before) {
    return {body, after, before};
  }
#else
  template <class Body>
  static const Body& ordered(const Body& body, const char*, const char*) {
    return body;
  }
#endif

  char begin_ = 0, end_ = 0;
};

}  // namespace vasamesh
