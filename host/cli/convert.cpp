/// \file
/// `vasamesh convert`: a volume file in, a surface file and a report out.

#include <chrono>
#include <cstdlib>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "cli/commands.h"
#include "cli/distinct_files.h"
#include "cli/interrupt.h"
#include "cli/progress.h"
#include "cli/summary.h"
#include "cli/volume_errors.h"
#include "io/atomic_file.h"
#include "io/report_json.h"
#include "io/surface_io.h"
#include "io/volume_reader.h"
#include "vasamesh/pipeline.h"

namespace vasamesh::cli {

namespace {

/// Everything that can be refused is, before any work.
void check_request(const ConvertRequest& request) {
  validate(request.parameters);
  check_output_path(request.output);
  if (!request.report.empty()) check_writable(request.report);
  check_distinct({{"IN", request.input}, {"the voxels of IN", voxel_file(request.input)}},
                 {{"--output", request.output}, {"--report", request.report}});
}

/// Keeps what is freed for the blocks that are asked for next, as most are: given back to the
/// system, they would be had page by page, each cleared anew. On a device's driver it has no hold,
/// and its memory would come on top.
void keep_freed_memory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 16 << 20);
  mallopt(M_TRIM_THRESHOLD, 32 << 20);
#endif
}

/// Runs `work`, a stage of the program, and says how long it took.
/// \param on  what it works on.
template <class Work>
StageReport timed(const char* name, const char* on, const Work& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  StageReport stage;
  stage.name = name;
  stage.backend = "host";
  stage.device = on;
  stage.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return stage;
}

/// The last of a context's backends is the host's; those before it are devices.
bool has_device(const Context& context) { return context.backends.size() > 1; }

}  // namespace

void run_convert(const ConvertRequest& request) {
  catch_interrupts(true);
  check_request(request);
  if (request.context.backend != "opencl") keep_freed_memory();
  Progress progress(request.quiet);
  progress.show("device", 0);
  ContextOptions devices = request.context;
  devices.cancel = &interrupted();
  // Lives as long as the program: to close a device means to wait for it, even when interrupted.
  static Context& context = *new Context;
  StageReport device = timed("device", "drivers", [&] { context = make_context(devices); });
  context.progress = [&](std::string_view phase, double fraction) {
    progress.show(phase, fraction);
    return !interrupted();
  };

  PackedSegmentation volume;
  ReadOptions selection = request.read;
  selection.cancel = &interrupted();
  progress.show("read", 0);
  StageReport read = timed("read", "file", [&] { volume = read_packed(request.input, selection); });
  stop_if_interrupted();
  Result result = on_volume_of(request.input,
                               [&] { return convert(volume.view(), request.parameters, context); });
  stop_if_interrupted();
  progress.show("write", 0);
  StageReport write = timed("write", "file", [&] {
    write_surface(request.output, result.mesh, request.parameters.space, &interrupted());
  });
  if (has_device(context)) {
    device.host_reason = "it opens the device, and builds its kernels where none are kept";
    read.host_reason = write.host_reason = "files are read and written by the program";
  }
  std::vector<StageReport>& stages = result.report.stages;
  stages.insert(stages.begin(), {device, read});
  stages.push_back(write);
  if (!request.report.empty())
    write_file(request.report, to_text(to_json(result.report)) + "\n", &interrupted());
  progress.clear();
  if (!request.quiet) print_conversion(request.input, request.output, result.report);
}

}  // namespace vasamesh::cli
