#include "cli/options.h"

#include <fmt/core.h>

#include <charconv>
#include <limits>
#include <map>
#include <vector>

namespace vasamesh::cli {

namespace {

constexpr const char* kConvertExamples =
    "Examples:\n"
    "  vasamesh convert scan.nii.gz -o vessel.vtp\n"
    "  vasamesh convert labels.nrrd --label 3 -o vessel.stl --report vessel.json\n"
    "  vasamesh convert dicom_folder --threshold 180 --min-component 100 -o vessel.ply\n"
    "  vasamesh convert scan.mha -o vessel.obj --space ras --threads 4";

constexpr const char* kCheckExamples =
    "Ends with code 4 when the surface fails. Examples:\n"
    "  vasamesh check vessel.stl\n"
    "  vasamesh check vessel.stl --against scan.nii.gz\n"
    "  vasamesh check vessel.ply --reference exact.ply --json";

/// The value of `text` in `names`, one of which it is: IsMember has checked that.
template <class Value, class Target>
void add_choice(CLI::App* app, const std::string& name, const std::map<std::string, Value>& names,
                Target& value, const std::string& help, const std::string& standard) {
  std::vector<std::string> keys;
  for (const auto& entry : names) keys.push_back(entry.first);
  app->add_option_function<std::string>(
         name, [names, &value](const std::string& text) { value = names.at(text); }, help)
      ->check(CLI::IsMember(keys))
      ->default_str(standard);
}

void add_connectivity(CLI::App* app, Connectivity& connectivity) {
  add_choice<Connectivity>(
      app, "--connectivity",
      {{"6", Connectivity::face}, {"18", Connectivity::edge}, {"26", Connectivity::vertex}},
      connectivity, "Which contacts join voxels: faces (6), edges too (18), corners too (26)",
      "26");
}

/// \param space  a Space, or an optional one.
template <class Target>
void add_space(CLI::App* app, Target& space, const std::string& help, const std::string& standard) {
  add_choice<Space>(app, "--space",
                    {{"lps", Space::lps}, {"ras", Space::ras}, {"voxel", Space::voxel}}, space,
                    help, standard);
}

void set_label(const std::string& text, ReadOptions& read) {
  if (text == "any") {
    read.any_label = true;
    return;
  }
  std::int64_t label = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), label);
  if (error == std::errc::result_out_of_range)
    throw CLI::ValidationError("--label",
                               fmt::format("give a whole number of {} up to {}, not {}",
                                           std::numeric_limits<std::int64_t>::min(),
                                           std::numeric_limits<std::int64_t>::max(), text));
  if (error != std::errc() || end != text.data() + text.size())
    throw CLI::ValidationError("--label", "give a whole number or 'any', not '" + text + "'");
  read.label = label;
}

void add_selection(CLI::App* app, ReadOptions& read) {
  CLI::Option* label = app->add_option_function<std::string>(
      "--label", [&read](const std::string& text) { set_label(text, read); },
      "The object's value in the volume, or 'any' for all but 0");
  app->add_option("--threshold", read.threshold, "The object is this value and above")
      ->excludes(label);
  label->type_name("N|any");
}

void add_threads(CLI::App* app, int& threads) {
  app->add_option("--threads", threads, "Threads, four for each processor at most; 0: one for each")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str();
}

/// The preset is set first; options given beside it win.
void add_edge_lengths(CLI::App* app, Parameters& p) {
  app->add_option_function<std::string>(
         "--preset", [&p](const std::string& name) { set_preset(name, p); },
         "Edge lengths and stitching of the adaptive surface by a name; options beside it win")
      ->check(CLI::IsMember({"paper", "default", "simulator"}))
      ->trigger_on_parse()
      ->default_str("default");
  EdgeLengths& e = p.edges;
  app->add_option("--rho", e.rho, "Edge length over radius of curvature, up to 2")
      ->capture_default_str();
  auto* around = app->add_option("--edges-around", e.edges_around,
                                 "Edges round a vessel, 4 to 100, in place of --rho");
  auto* chord = app->add_option("--chord-error", e.chord_error,
                                "Height of an edge's arc, voxels, in place of --rho");
  auto* count = app->add_option("--triangles", e.triangles,
                                "How many triangles, within 10 %: all lengths are scaled");
  around->excludes(chord)->excludes(count);
  chord->excludes(count);
  app->add_option("--edge-min", e.edge_min, "Shortest edge length asked for, voxels")
      ->capture_default_str();
  app->add_option("--edge-max", e.edge_max, "Longest edge length asked for, voxels")
      ->capture_default_str();
  app->add_option("--gradation", e.gradation, "Growth of the edge length a length")
      ->capture_default_str();
  add_choice<StitchMode>(app, "--stitch",
                         {{"paper", StitchMode::paper}, {"exact", StitchMode::exact}}, p.stitch,
                         "How gaps are triangulated", "exact");
  add_choice<SurfaceKind>(
      app, "--surface", {{"adaptive", SurfaceKind::adaptive}, {"base", SurfaceKind::base}},
      p.surface, "The fine lattice's triangles, or such as follow the curvature", "adaptive");
}

/// The base surface has no edge lengths to choose and no gaps: what asks for them is refused.
void refuse_beside_base(CLI::App* app, const Parameters& p) {
  app->callback([app, &p] {
    if (p.surface != SurfaceKind::base) return;
    for (const char* name : {"--preset", "--rho", "--edges-around", "--chord-error", "--triangles",
                             "--edge-min", "--edge-max", "--gradation", "--stitch"})
      if (app->count(name) > 0)
        throw CLI::ValidationError(name,
                                   "the base surface has no edge lengths to choose and no gaps; "
                                   "leave the option or --surface base out");
  });
}

/// Turns bytes with a unit into a number; CLI11's own message lists every unit that it knows.
CLI::Validator bytes_with_unit() {
  const auto convert = [](std::string& text) -> std::string {
    try {
      return CLI::AsSizeValue(false)(text);
    } catch (const CLI::ValidationError&) {
      return "give bytes, as 500M or 2G";
    }
  };
  return {convert, "BYTES"};
}

/// A number of bytes beyond the range arrives as the last one within.
std::int64_t checked_bytes(std::int64_t bytes) {
  if (bytes == std::numeric_limits<std::int64_t>::max())
    throw CLI::ValidationError("--max-memory", "give less than 8 EiB");
  return bytes;
}

void add_parameters(CLI::App* app, Parameters& p, std::int64_t& read_memory) {
  app->add_option("--neighbours", p.neighbours, "Points of a normal's covariance, 3 to 64")
      ->capture_default_str();
  add_choice<NormalMode>(
      app, "--normals",
      {{"covariance", NormalMode::covariance}, {"gradient", NormalMode::gradient}}, p.normals,
      "How normals are estimated", "covariance");
  app->add_option("--depth", p.depth, "Depth of the octree; 0: one cell a voxel")
      ->capture_default_str();
  app->add_option("--kernel-width", p.kernel_width, "Smoothing, in voxels, 0.5 to 4")
      ->capture_default_str();
  add_connectivity(app, p.connectivity);
  app->add_flag("--close-handles", p.close_handles,
                "Fill tunnels and cavities that the smooth field does not have");
  app->add_option("--min-component", p.min_component, "Drop pieces of fewer voxels")
      ->capture_default_str();
  add_space(app, p.space, "Space of the vertices", "lps");
  add_edge_lengths(app, p);
  refuse_beside_base(app, p);
  app->add_option_function<std::int64_t>(
         "--max-memory",
         [&p, &read_memory](std::int64_t bytes) {
           p.max_memory = read_memory = checked_bytes(bytes);
         },
         "Bytes that the work may hold, with K, M or G; 0: no limit")
      ->transform(bytes_with_unit())
      ->type_name("BYTES")
      ->default_str("0");
}

}  // namespace

CLI::App* add_convert(CLI::App& app, ConvertRequest& request) {
  CLI::App* convert = app.add_subcommand("convert", "Turn a segmentation into a closed surface");
  convert->add_option("IN", request.input, ".nii, .nii.gz, .mha, .mhd, .nrrd or a DICOM folder")
      ->required();
  convert->add_option("-o,--output", request.output, "Surface: .vtp, .stl, .ply or .obj")
      ->required();
  convert->add_option("--report", request.report, "Also write a report, JSON");
  add_selection(convert, request.read);
  add_parameters(convert, request.parameters, request.read.max_memory);
  convert->add_option("--backend", request.context.backend, "What it runs on")
      ->check(CLI::IsMember({"auto", "tbb", "opencl"}))
      ->capture_default_str();
  convert->add_option("--device", request.context.device,
                      "A number, type or part of a name from `vasamesh devices`");
  add_threads(convert, request.context.threads);
  convert->add_flag("-q,--quiet", request.quiet, "Print nothing but errors");
  convert->footer(kConvertExamples);
  return convert;
}

CLI::App* add_check(CLI::App& app, CheckRequest& request) {
  CLI::App* check = app.add_subcommand("check", "Check a surface of any program");
  check->add_option("SURFACE", request.surface, ".vtp, .stl, .ply, .obj or .vtk")->required();
  CLI::Option* against = check->add_option(
      "--against", request.volume,
      "The segmentation: compare the topology, and the distance to marching cubes");
  check->add_option("--reference", request.reference, "Measure the distance to this surface");
  add_selection(check, request.read);
  add_connectivity(check, request.connectivity);
  for (const char* name : {"--label", "--threshold", "--connectivity"})
    check->get_option(name)->needs(against);
  add_space(check, request.space, "Space of SURFACE", "what the file says, else lps");
  add_threads(check, request.threads);
  check->add_flag("--json", request.json, "Print JSON");
  check->add_option("--map", request.map, "Write the curvatures and shapes on the surface, .vtp");
  check->footer(kCheckExamples);
  return check;
}

CLI::App* add_phantom(CLI::App& app, PhantomRequest& request) {
  CLI::App* phantom = app.add_subcommand("phantom", "Make one of the project's own inputs");
  phantom->add_option("NAME", request.name, "One of the names below")->required();
  phantom->add_option("-o,--output", request.output, "Volume: .nii, .nii.gz, .mha or .nrrd")
      ->required();
  phantom->add_option("--surface", request.surface, "Also write the exact surface");
  phantom->add_option("--seed", request.options.seed, "Of trees and speckle")
      ->check(CLI::Range(0.0, 1e15))
      ->capture_default_str();
  phantom->add_option("--size", request.options.size, "Voxels along each axis")->type_name("X Y Z");
  phantom->add_option("--spacing", request.options.spacing, "Voxel size along each axis, mm")
      ->type_name("X Y Z");
  phantom->add_option("--radius", request.options.radius, "Of the vessel, in voxels");
  std::string footer = "Names:\n";
  for (const std::string& name : phantom_names())
    footer += fmt::format("  {:<20}{}\n", name, phantom_summary(name));
  footer +=
      "Examples:\n"
      "  vasamesh phantom cerebral -o cerebral.nii.gz\n"
      "  vasamesh phantom torus -o torus.nii.gz --surface torus.ply\n"
      "  vasamesh phantom tree --seed 7 -o tree.nrrd";
  phantom->footer(footer);
  return phantom;
}

CLI::App* add_devices(CLI::App& app) {
  CLI::App* devices = app.add_subcommand("devices", "List what conversions can run on");
  devices->footer("Examples:\n  vasamesh devices");
  return devices;
}

CLI::App* add_tune(CLI::App& app, TuneRequest& request) {
  CLI::App* tune = app.add_subcommand(
      "tune", "Try out OpenCL devices; remember their fastest kernel shapes and stages");
  tune->add_option("--device", request.device, "A number, type or part of a name; all");
  add_threads(tune, request.threads);
  tune->footer("Examples:\n  vasamesh tune\n  vasamesh tune --device gpu");
  return tune;
}

CLI::App* add_bench(CLI::App& app, BenchRequest& request) {
  CLI::App* bench =
      app.add_subcommand("bench", "Measure conversions, stage by stage, on each backend");
  bench->add_option("IN", request.inputs, "Segmentations, as for convert")->required();
  bench->add_option("--backends", request.backends, "tbb, opencl; all that are here")
      ->check(CLI::IsMember({"tbb", "opencl"}))
      ->delimiter(',');
  bench->add_option("--device", request.device,
                    "OpenCL device: its number, type or a part of its name; all");
  bench->add_option("--threads", request.threads, "Of oneTBB, as 1,2; 1, 2, 4 and so on")
      ->check(CLI::Range(1, 4096))
      ->delimiter(',');
  bench->add_option("--repeat", request.repeat, "Conversions measured; one more warms up")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  bench->add_flag("--json", request.json, "Print JSON");
  add_selection(bench, request.read);
  bench->footer(
      "Examples:\n"
      "  vasamesh bench scan.nii.gz\n"
      "  vasamesh bench a.nrrd b.nrrd --backends tbb,opencl --threads 1,2 --repeat 5 --json");
  return bench;
}

}  // namespace vasamesh::cli
