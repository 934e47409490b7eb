/// \file
/// The report as JSON: each value under its name, and docs/report.md describes every name.

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "io/report_json.h"
#include "support/scratch.h"

namespace vasamesh {
namespace {

using Json = nlohmann::ordered_json;

/// A report with one entry in every list and everything optional there.
Report full_report() {
  Report report;
  report.geometry = {{3, 4, 5}, {0.5, 0.5, 0.75}, {-1, 2, 3}, {1, 0, 0, 0, 1, 0, 0, 0, -1}};
  report.parameters.normals = NormalMode::gradient;
  report.parameters.space = Space::ras;
  report.input.pieces.push_back(
      {.voxels = 7, .first_voxel = {1, 2, 3}, .cavities = 1, .handles = 2});
  report.input.specks = {.count = 2, .place = {4, 5, 6}};
  report.stages.push_back({"points", "tbb", "cpu", 0.25, 0.125, 1024, 7, 8, 9, "contracts products",
                           "it has no kernels", "sums", "it was lost"});
  report.levels.push_back({3, {8, 8, 8}, 512, 100, 10, 1.0, 0.125});
  report.relabel.stuck_first = 9;
  report.check.passed = true;
  report.check.has_wanted = true;
  report.check.wanted = {1, 2, 3};
  report.check.shell_genus = {2};
  report.quality.least_angle.percentile_5 = 31.5;
  report.quality.dihedral_angle.minimum = 58.5;
  report.quality.sharp_edges = 12;
  report.distance_limit = 0.75;
  report.mesh.far_points = 5;
  return report;
}

TEST(ReportJson, ValuesStandUnderTheirNames) {
  const Json json = to_json(full_report());
  EXPECT_EQ(json["schema_version"], 1);
  EXPECT_EQ(json["geometry"]["size"], (Json{3, 4, 5}));
  EXPECT_EQ(json["geometry"]["direction"][8], -1.0);
  EXPECT_EQ(json["parameters"]["normals"], "gradient");
  EXPECT_EQ(json["parameters"]["connectivity"], 26);
  EXPECT_EQ(json["parameters"]["space"], "ras");
  EXPECT_EQ(json["input"]["pieces"][0]["handles"], 2);
  EXPECT_EQ(json["input"]["specks"]["place"], (Json{4, 5, 6}));
  EXPECT_TRUE(json["input"]["cavities"]["place"].is_null());
  EXPECT_EQ(json["stages"][0]["seconds"], 0.25);
  EXPECT_EQ(json["stages"][0]["other_arithmetic"], "contracts products");
  EXPECT_EQ(json["stages"][0]["host_reason"], "it has no kernels");
  EXPECT_EQ(json["stages"][0]["device_seconds"], 0.125);
  EXPECT_EQ(json["stages"][0]["host_part"], "sums");
  EXPECT_EQ(json["stages"][0]["failure"], "it was lost");
  EXPECT_EQ(json["levels"][0]["residual"], 0.125);
  EXPECT_EQ(json["relabel"]["stuck_first"], 9);
  EXPECT_EQ(json["check"]["wanted"]["cavities"], 3);
  EXPECT_EQ(json["quality"]["least_angle"]["percentile_5"], 31.5);
  EXPECT_EQ(json["quality"]["dihedral_angle"]["minimum"], 58.5);
  EXPECT_EQ(json["quality"]["sharp_edges"], 12);
  EXPECT_EQ(json["distance_limit"], 0.75);
  EXPECT_EQ(json["mesh"]["far_points"], 5);
  EXPECT_TRUE(to_json(Report{})["check"]["wanted"].is_null());
}

TEST(ReportJson, SurvivesText) {
  const Json json = to_json(full_report());
  EXPECT_EQ(Json::parse(json.dump(2)), json);
}

void collect_names(const Json& json, std::set<std::string>& names) {
  for (const auto& item : json.items()) {
    if (json.is_object()) names.insert(item.key());
    if (item.value().is_structured()) collect_names(item.value(), names);
  }
}

TEST(ReportJson, EveryNameIsDescribed) {
  const std::string text = read_text(VASAMESH_SOURCE_DIR "/docs/report.md");
  ASSERT_FALSE(text.empty());
  std::set<std::string> names;
  collect_names(to_json(full_report()), names);
  EXPECT_GT(names.size(), 80u);
  for (const std::string& name : names) {
    EXPECT_NE(text.find("`" + name + "`"), std::string::npos) << name;
  }
}

}  // namespace
}  // namespace vasamesh
