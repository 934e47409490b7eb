/// \file
/// The edge lengths of adaptive surfaces: their ranges, what excludes what, and the presets.

#include "vasamesh/parameters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>

#include "vasamesh/errors.h"

namespace vasamesh::test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

void expect_refused(const Parameters& parameters, const std::string& part) {
  SCOPED_TRACE(part);
  try {
    validate(parameters);
    ADD_FAILURE() << "accepted";
  } catch (const Error& error) {
    const std::string message = error.what();
    EXPECT_EQ(error.code(), ErrorCode::usage);
    EXPECT_NE(message.find(part), std::string::npos) << message;
    EXPECT_NE(message.find(": "), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

struct Range {
  const char* name;
  double EdgeLengths::*field;
  std::vector<double> good, bad;
};

class EdgeRange : public ::testing::TestWithParam<Range> {};

TEST_P(EdgeRange, ItsLimitsAreAcceptedAndNothingBeyond) {
  const auto& [name, field, good, bad] = GetParam();
  for (const double value : good) {
    Parameters parameters;
    parameters.edges.edge_min = 0.1;
    parameters.edges.edge_max = 100;
    parameters.edges.*field = value;
    EXPECT_NO_THROW(validate(parameters)) << name << " " << value;
  }
  for (const double value : bad) {
    Parameters parameters;
    parameters.edges.*field = value;
    expect_refused(parameters, name);
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, EdgeRange,
    ::testing::Values(
        Range{"--rho", &EdgeLengths::rho, {0.001, 2}, {0, -1, 2.01, kNaN, kInfinity}},
        Range{"--edges-around", &EdgeLengths::edges_around, {0, 4, 100}, {3.99, 100.1, -6, kNaN}},
        Range{"--chord-error", &EdgeLengths::chord_error, {0, 0.001, 1}, {1.01, -0.1, kNaN}},
        Range{"--edge-min", &EdgeLengths::edge_min, {0.1, 100}, {0, 0.09, -1, 101, kNaN}},
        Range{"--edge-max", &EdgeLengths::edge_max, {0.1, 100}, {0, 0.09, -1, 101, kInfinity}},
        Range{"--gradation", &EdgeLengths::gradation, {0.01, 2}, {0, 2.1, -1, kNaN}}),
    [](const auto& param_info) {
      std::string name = param_info.param.name;
      name.erase(std::remove(name.begin(), name.end(), '-'), name.end());
      return name;
    });

TEST(Parameters, TheirDefaultsAreValid) { EXPECT_NO_THROW(validate(Parameters{})); }

TEST(Parameters, TrianglesAreNotNegative) {
  Parameters parameters;
  parameters.edges.triangles = -1;
  expect_refused(parameters, "--triangles");
}

TEST(Parameters, TrianglesAreNotBeyondAllMeasure) {
  Parameters parameters;
  parameters.edges.triangles = 1'000'000'000;
  EXPECT_NO_THROW(validate(parameters));
  ++parameters.edges.triangles;
  expect_refused(parameters, "--triangles");
}

TEST(Parameters, ChoicesThatAreNoneAreRefused) {
  Parameters normals, surface, stitch, space, connectivity;
  normals.normals = static_cast<NormalMode>(9);
  surface.surface = static_cast<SurfaceKind>(9);
  stitch.stitch = static_cast<StitchMode>(9);
  space.space = static_cast<Space>(9);
  connectivity.connectivity = static_cast<Connectivity>(7);
  expect_refused(normals, "--normals");
  expect_refused(surface, "--surface");
  expect_refused(stitch, "--stitch");
  expect_refused(space, "--space");
  expect_refused(connectivity, "--connectivity");
}

TEST(Parameters, ShortestAboveLongestIsRefused) {
  Parameters parameters;
  parameters.edges.edge_min = parameters.edges.edge_max = 3;
  EXPECT_NO_THROW(validate(parameters));
  parameters.edges.edge_max = 2.9;
  expect_refused(parameters, "--edge-min 3 is above --edge-max 2.9: lower");
  parameters.edges.edge_max = EdgeLengths{}.edge_max;
  expect_refused(parameters, "--edge-min 3 is above --edge-max 1.6 (the default): lower");
}

TEST(Parameters, OneWordForTheEdgeLengthAtMost) {
  for (int given = 0; given < 8; ++given) {
    Parameters parameters;
    if (given & 1) parameters.edges.edges_around = 12;
    if (given & 2) parameters.edges.chord_error = 0.1;
    if (given & 4) parameters.edges.triangles = 5000;
    if ((given & (given - 1)) == 0)
      EXPECT_NO_THROW(validate(parameters)) << given;
    else
      expect_refused(parameters, "give one of them");
  }
}

TEST(Presets, AreValidAndDiffer) {
  Parameters usual, paper, simulator;
  set_preset("default", usual);
  set_preset("paper", paper);
  set_preset("simulator", simulator);
  for (const Parameters& p : {usual, paper, simulator}) EXPECT_NO_THROW(validate(p));
  EXPECT_EQ(usual.edges.rho, EdgeLengths{}.rho);
  EXPECT_EQ(usual.edges.edge_max, EdgeLengths{}.edge_max);
  EXPECT_EQ(paper.edges.edge_min, paper.edges.edge_max);
  EXPECT_EQ(paper.stitch, StitchMode::paper);
  EXPECT_GT(simulator.edges.edge_max, usual.edges.edge_max);
  EXPECT_EQ(simulator.stitch, StitchMode::exact);
}

TEST(Presets, SetAllEdgeLengthsAndNothingElse) {
  Parameters parameters;
  parameters.edges.triangles = 5000;
  parameters.edges.rho = 0.1;
  parameters.stitch = StitchMode::paper;
  parameters.surface = SurfaceKind::adaptive;
  parameters.neighbours = 20;
  set_preset("default", parameters);
  EXPECT_EQ(parameters.edges.triangles, 0);
  EXPECT_EQ(parameters.edges.rho, EdgeLengths{}.rho);
  EXPECT_EQ(parameters.stitch, StitchMode::exact);
  EXPECT_EQ(parameters.surface, SurfaceKind::adaptive);
  EXPECT_EQ(parameters.neighbours, 20);
}

TEST(Presets, UnknownNamesAreRefusedWithTheKnown) {
  Parameters parameters;
  try {
    set_preset("best", parameters);
    ADD_FAILURE() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::usage);
    for (const char* part : {"'best'", "default", "paper", "simulator"})
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace vasamesh::test
