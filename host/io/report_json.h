#pragma once

/// \file
/// Reports as JSON. docs/report.md describes the schema.

#include <nlohmann/json.hpp>
#include <string>

#include "vasamesh/report.h"

namespace vasamesh {

/// The whole report, with `schema_version`.
nlohmann::ordered_json to_json(const Report& report);

/// What is printed or written: indented, names of files that are not UTF-8 with U+FFFD for each bad
/// byte.
std::string to_text(const nlohmann::ordered_json& json);

/// Parts of it, as they stand in the whole.
nlohmann::ordered_json to_json(const Geometry& geometry);
nlohmann::ordered_json to_json(const Parameters& parameters);
nlohmann::ordered_json to_json(const InputFindings& findings);
nlohmann::ordered_json to_json(const Finding& finding);
nlohmann::ordered_json to_json(const Piece& piece);
nlohmann::ordered_json to_json(const StageReport& stage);
nlohmann::ordered_json to_json(const LevelReport& level);
nlohmann::ordered_json to_json(const RelabelReport& relabel);
nlohmann::ordered_json to_json(const Topology& topology);
nlohmann::ordered_json to_json(const CheckReport& check);
nlohmann::ordered_json to_json(const QualityReport& quality);
nlohmann::ordered_json to_json(const Distribution& distribution);

}  // namespace vasamesh
