// SPDX-License-Identifier: Apache-2.0
#include "bench/table1/report.h"

#include <array>

#include "bench/table1/colorings.h"

namespace pbdsurg::bench {
namespace {

// The table as printed. It does not say which type of constraint it counts: 32 colours that hold
// such shares can only be those of distance constraints.
struct PaperRow {
  const char* algorithm;
  Index colors;
  double top10, mid80, last10;
  const char* step_ms;
};
constexpr std::array<PaperRow, 3> kPaper{{{"greedy", 32, .354, .645, .001, "12.65-12.98"},
                                          {"luby", 36, .195, .801, .004, "14.06-14.23"},
                                          {"random_disc", 32, .320, .679, .002, "12.20-12.35"}}};

Json to_json(const Row& row) {
  const ColoringOptions& options = row.coloring;
  const bool is_greedy = options.algorithm == ColoringAlgorithm::greedy;
  const bool is_disc = options.algorithm == ColoringAlgorithm::random_disc;
  const bool has_shrink = is_disc && options.disc.palette == Palette::conflicts;
  const bool is_joint = row.constraints == "joint";
  Json json{{"source", "measured"},
            {"mesh", "table2:" + std::to_string(row.sample->row)},
            {"kind", name_of(row.sample->kind)},
            {"constraints", row.constraints},
            {"constraint_count", row.statistics.constraints},
            {"algorithm", name_of(options.algorithm)},
            {"order", is_greedy ? Json(name_of(options.order)) : Json()},
            {"palette", is_disc ? Json(name_of(options.disc.palette)) : Json()},
            {"shrink", has_shrink ? Json(options.disc.shrink) : Json()},
            {"repair", options.repair},
            {"balance", options.balance},
            {"colors", row.statistics.colors},
            {"clique_bound", row.statistics.clique_bound},
            {"top10", rounded(row.statistics.top10, 1e3)},
            {"mid80", rounded(row.statistics.mid80, 1e3)},
            {"last10", rounded(row.statistics.last10, 1e3)},
            {"rsd", rounded(row.statistics.relative_deviation, 1e3)},
            {"color_ms", rounded(row.color_ms, 1e3)},
            {"color_cuda_ms", rounded(row.color_cuda_ms, 1e3)},
            {"max_owned", is_joint ? Json(row.sample->max_owned) : Json()}};
  for (std::size_t b = 0; b < kStepBackends.size(); ++b) {
    json[kStepBackends[b].key] = rounded(row.step_ms[b], 1e2);
  }
  json["paper_ms"] = Json();
  return json;
}

// The keys of a measured row, in their order.
Json to_json(const PaperRow& row, const Json& measured) {
  Json json;
  for (const auto& [key, value] : measured.items()) {
    json[key] = Json();
  }
  json["source"] = "paper";
  json["mesh"] = "table2:2";
  json["constraints"] = "distance";
  json["algorithm"] = row.algorithm;
  json["colors"] = row.colors;
  json["top10"] = row.top10;
  json["mid80"] = row.mid80;
  json["last10"] = row.last10;
  json["paper_ms"] = row.step_ms;
  return json;
}

std::string label_of(const Json& row) {
  std::string label = row["algorithm"];
  for (const char* detail : {"order", "palette"}) {
    if (!row[detail].is_null()) {
      label += ", " + row[detail].get<std::string>();
    }
  }
  if (!row["shrink"].is_null()) {
    label += " / " + text_of(row["shrink"]);
  }
  for (const char* step : {"repair", "balance"}) {
    label += row[step] == true ? std::string(" + ") + step : "";
  }
  return row["source"] == "paper" ? "*paper: " + label + "*" : label;
}

std::vector<Column> columns() {
  std::vector<Column> result{
      {"colors", "colours", 0},         {"clique_bound", "bound", 0},
      {"top10", "top 10 %", 3},         {"mid80", "middle 80 %", 3},
      {"last10", "last 10 %", 3},       {"rsd", "deviation", 3},
      {"color_ms", "colouring, ms", 3}, {"color_cuda_ms", "colouring on CUDA, ms", 3}};
  for (const StepBackend& backend : kStepBackends) {
    result.push_back({backend.key, backend.title, 2});
  }
  result.push_back({"paper_ms", "step (GTX 980 Ti), ms", 0});
  return result;
}

constexpr const char* kLegend = R"(# Table 1

- bound: the most constraints at one vertex; no colouring has fewer colours
- top, middle, last: shares of the constraints in the largest tenth, the middle and the smallest tenth of the colours
- deviation: standard deviation of the colours' sizes over their mean
- colouring: on one CPU thread; or in the memory of a device, without copies
- step: 30 sweeps of 0.2 ms from a stretch of 10 %, both types coloured in this way; with joint constraints, each tetrahedron projects the edges that it owns, then its volume; on the gpu the state stays there, by the strategy that the backend takes of itself and by one launch a phase, as the paper's
- conflicts / 2.2: palettes of 1 + conflicts / 2.2 colours, as in Vivace; on a mesh whose edges take 31 colours, this gave the paper's shares
- paper: it does not say which type it counts; its shares fit distance constraints alone
)";

// Which table of the Markdown a row belongs to.
std::string heading_of(const Json& row) {
  std::string heading = "\n## " + text_of(row["mesh"]) + ", " + text_of(row["kind"]) + ": " +
                        text_of(row["constraint_count"]) + " " + text_of(row["constraints"]) +
                        " constraints";
  if (!row["max_owned"].is_null()) {
    heading += ", each with up to " + text_of(row["max_owned"]) + " edges of its own";
  }
  return heading + "\n\n";
}

}  // namespace

Json to_json(const std::vector<Row>& rows) {
  Json json = Json::array();
  for (const Row& row : rows) {
    json.push_back(to_json(row));
  }
  const Json first = json.at(0);
  for (const PaperRow& row : kPaper) {
    json.push_back(to_json(row, first));
  }
  return json;
}

Json colors_of(const std::vector<Row>& rows) {
  Json colors = Json::array();
  for (const Row& row : rows) {
    if (row.constraints == "joint") {
      continue;
    }
    Json color = to_json(row);
    for (std::size_t rank = 0; rank < row.color_sizes.size(); ++rank) {
      colors.push_back({{"kind", color["kind"]},
                        {"constraints", color["constraints"]},
                        {"algorithm", color["algorithm"]},
                        {"order", color["order"]},
                        {"palette", color["palette"]},
                        {"repair", color["repair"]},
                        {"balance", color["balance"]},
                        {"rank", rank + 1},
                        {"size", row.color_sizes[rank]}});
    }
  }
  return colors;
}

std::string to_markdown(const Json& rows, const std::vector<std::string>& notes) {
  std::string paper;
  for (const Json& row : rows) {
    paper += row["source"] == "paper" ? markdown_line(label_of(row), row, columns()) : "";
  }
  std::string text = kLegend;
  for (const std::string& note : notes) {
    text += "- " + note + "\n";
  }
  std::string heading;
  for (const Json& row : rows) {
    if (row["source"] == "paper") {
      continue;
    }
    if (heading_of(row) != heading) {
      heading = heading_of(row);
      text += heading + markdown_header("algorithm", columns()) +
              (row["constraints"] == "distance" ? paper : "");
    }
    text += markdown_line(label_of(row), row, columns());
  }
  return text;
}

}  // namespace pbdsurg::bench
