#include "cli/program.h"

#include <fmt/core.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <optional>
#include <string>

#include "cli/commands.h"
#include "cli/options.h"
#include "vasamesh/errors.h"
#include "vasamesh/version.h"

namespace vasamesh::cli {

namespace {

/// Leaves without taking the program down: a device may still be at work on what was cancelled, and
/// its driver waits for it.
[[noreturn]] void leave(int code) {
  std::fflush(stdout);
  std::fflush(stderr);
  std::_Exit(code);
}

int report(ErrorCode code, std::string message) {
  std::replace(message.begin(), message.end(), '\n', ' ');
  fmt::print(stderr, "vasamesh: {}\n", message);
  return static_cast<int>(code);
}

/// Wrong use; help and version arrive here too, as errors with code 0.
int report_usage(const CLI::App& app, const CLI::ParseError& error) {
  if (error.get_exit_code() == 0) return app.exit(error);
  std::string help = "vasamesh";
  for (const CLI::App* sub : app.get_subcommands()) help += " " + sub->get_name();
  std::string message = error.what();
  if (app.get_subcommands().empty() && !app.remaining().empty())
    message = app.remaining().front() + " is no subcommand";
  return report(ErrorCode::usage, message + "; see " + help + " --help");
}

/// The one place where errors become exit codes.
template <class Work>
int guard(const Work& work) {
  try {
    work();
    if (std::fflush(stdout) != 0 || std::ferror(stdout))
      throw Error(ErrorCode::refused, "standard output cannot be written: is the disk full?");
    return 0;
  } catch (const Error& error) {
    if (error.code() == ErrorCode::cancelled) leave(report(error.code(), error.what()));
    if (error.code() != ErrorCode::internal) return report(error.code(), error.what());
    return report(ErrorCode::internal,
                  std::string(error.what()) + "; this is a fault of vasamesh, please report it");
  } catch (const std::bad_alloc&) {
    return report(ErrorCode::refused,
                  "out of memory: close other programs, or crop the volume to the vessels");
  } catch (const std::exception& error) {
    return report(ErrorCode::internal,
                  std::string(error.what()) + "; this is a fault of vasamesh, please report it");
  }
}

/// Only the program limits threads globally; the library stays within its caller's arena.
std::optional<tbb::global_control> limit_threads(int threads) {
  if (threads <= 0) return std::nullopt;
  return std::optional<tbb::global_control>(std::in_place,
                                            tbb::global_control::max_allowed_parallelism,
                                            static_cast<std::size_t>(threads));
}

}  // namespace

int run(int argc, const char* const* argv) {
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
    return report_usage(app, error);
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
