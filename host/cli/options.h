#pragma once

/// \file
/// The subcommands' options, as CLI11 reads them into the requests.

#include <CLI/CLI.hpp>

#include "cli/commands.h"

namespace vasamesh::cli {

/// Each adds one subcommand; its options land in `request`.
CLI::App* add_convert(CLI::App& app, ConvertRequest& request);
CLI::App* add_check(CLI::App& app, CheckRequest& request);
CLI::App* add_phantom(CLI::App& app, PhantomRequest& request);
CLI::App* add_devices(CLI::App& app);
CLI::App* add_bench(CLI::App& app, BenchRequest& request);
CLI::App* add_tune(CLI::App& app, TuneRequest& request);

}  // namespace vasamesh::cli
