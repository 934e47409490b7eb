#include "cli/program.h"

#include <fcntl.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>
#include <optional>
#include <string>
#include <string_view>

#include "cli/commands.h"
#include "cli/options.h"
#include "tbb/backend.h"
#include "vasamesh/errors.h"
#include "vasamesh/version.h"

namespace vasamesh::cli {

namespace {

constexpr const char* kNoOutput =
    "standard output cannot be written: is it closed, or the disk full?";

constexpr const char* kNoMemory =
    "out of memory: close other programs, or crop the volume to the vessels";

/// A stream that is closed stays one that cannot be used: no file that is opened takes its number.
void occupy_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (fcntl(stream, F_GETFD) < 0) open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);
}

/// Leaves without taking the program down: a device may still be at work on what was cancelled, and
/// its driver waits for it.
[[noreturn]] void leave(int code) {
  std::fflush(stdout);
  std::fflush(stderr);
  std::_Exit(code);
}

/// One line, of whichever thread is the first.
int report(ErrorCode code, std::string message) {
  static std::atomic_flag told;
  if (told.test_and_set()) return static_cast<int>(code);
  std::replace(message.begin(), message.end(), '\n', ' ');
  std::fprintf(stderr, "vasamesh: %s\n", message.c_str());  // fmt throws where it cannot be written
  return static_cast<int>(code);
}

/// Wrong use, with the help that explains it.
int report_usage(const CLI::App& app, const CLI::ParseError& error) {
  std::string help = "vasamesh";
  for (const CLI::App* sub : app.get_subcommands()) help += " " + sub->get_name();
  std::string message = error.what();
  if (app.get_subcommands().empty() && !app.remaining().empty())
    message = app.remaining().front() + " is no subcommand";
  return report(ErrorCode::usage, message + "; see " + help + " --help");
}

/// oneTBB says so in words alone, where there is no memory for a thread's stack.
bool lacks_threads(const std::exception& error) {
  return std::string_view(error.what()).starts_with("pthread_create");
}

/// A thread of oneTBB's that cannot start the next has nobody to catch what it throws.
[[noreturn]] void end_for_want_of_memory() {
  try {
    if (const std::exception_ptr thrown = std::current_exception()) std::rethrow_exception(thrown);
  } catch (const std::bad_alloc&) {
    leave(report(ErrorCode::refused, kNoMemory));
  } catch (const std::exception& error) {
    if (lacks_threads(error)) leave(report(ErrorCode::refused, kNoMemory));
    std::fprintf(stderr, "vasamesh: %s\n", error.what());
  } catch (...) {
  }
  std::abort();
}

/// The one place where errors become exit codes.
template <class Work>
int guard(const Work& work) {
  try {
    work();
    return std::fflush(stdout) == 0 && !std::ferror(stdout) ? 0
                                                            : report(ErrorCode::refused, kNoOutput);
  } catch (const Error& error) {
    if (error.code() == ErrorCode::cancelled) leave(report(error.code(), error.what()));
    if (error.code() != ErrorCode::internal) return report(error.code(), error.what());
    return report(ErrorCode::internal,
                  std::string(error.what()) + "; this is a fault of vasamesh, please report it");
  } catch (const std::bad_alloc&) {
    return report(ErrorCode::refused, kNoMemory);
  } catch (const std::exception& error) {
    if (std::ferror(stdout)) return report(ErrorCode::refused, kNoOutput);
    if (lacks_threads(error)) return report(ErrorCode::refused, kNoMemory);
    return report(ErrorCode::internal,
                  std::string(error.what()) + "; this is a fault of vasamesh, please report it");
  }
}

/// Only the program limits threads globally; the library stays within its caller's arena.
std::optional<tbb::global_control> limit_threads(int threads) {
  if (threads <= 0) return std::nullopt;
  return std::optional<tbb::global_control>(std::in_place,
                                            tbb::global_control::max_allowed_parallelism,
                                            static_cast<std::size_t>(capped_threads(threads)));
}

}  // namespace

int run(int argc, const char* const* argv) {
  occupy_standard_streams();
  std::set_terminate(end_for_want_of_memory);
  CLI::App app("Segmented blood vessels to closed, smooth triangle surfaces", "vasamesh");
  app.set_version_flag("--version", std::string("vasamesh ") + version());
  app.require_subcommand(1);
  app.footer(
      "Examples:\n"
      "  vasamesh convert scan.nii.gz -o vessel.vtp\n"
      "  vasamesh check vessel.vtp --against scan.nii.gz\n"
      "Each subcommand has its own --help.");
  ConvertRequest convert;
  CheckRequest check;
  PhantomRequest phantom;
  const CLI::App* convert_app = add_convert(app, convert);
  const CLI::App* check_app = add_check(app, check);
  const CLI::App* phantom_app = add_phantom(app, phantom);
  add_devices(app);
  BenchRequest bench;
  TuneRequest tune;
  const CLI::App* bench_app = add_bench(app, bench);
  const CLI::App* tune_app = add_tune(app, tune);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() != 0) return report_usage(app, error);
    return guard([&] { app.exit(error); });  // help and version
  }
  const auto threads = limit_threads(std::max(convert.context.threads, check.threads));
  return guard([&] {
    if (convert_app->parsed()) return run_convert(convert);
    if (check_app->parsed()) return run_check(check);
    if (phantom_app->parsed()) return run_phantom(phantom);
    if (bench_app->parsed()) return run_bench(bench);
    if (tune_app->parsed()) return run_tune(tune);
    run_devices();
  });
}

}  // namespace vasamesh::cli
