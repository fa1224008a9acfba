// SPDX-License-Identifier: Apache-2.0
#include "bench/table2/report.h"

#include <array>

#include "bench/support/gpu_columns.h"

namespace pbdsurg::bench {
namespace {

// The table as printed: i7-4770 and GTX 980 Ti, ms a step.
struct PaperRow {
  Index colors;
  const char* cpu_ms;
  const char* gpu_ms;
};
constexpr std::array<PaperRow, 5> kPaper{{{40, "16.38-17.41", "14.31-14.42"},
                                          {32, "28.51-29.10", "12.20-12.35"},
                                          {36, "45.79-47.36", "14.49-14.57"},
                                          {40, "54.81-55.65", "16.36-16.47"},
                                          {39, "111.51-116.38", "21.65-22.16"}}};

Json to_json(const Row& row) {
  const Scene& scene = row.subject->scene;
  const std::optional<int> paper_row = row.subject->row;
  Json json{{"row", paper_row ? Json(*paper_row) : Json()},
            {"kind", row.subject->kind},
            {"plan", row.cpu.plan},
            {"vertices", scene.vertex_count()},
            {"links", row.cpu.links},
            {"tets", scene.tets().size()},
            {"colors", row.cpu.colors}};
  add_times(json, "serial", row.cpu.serial);
  add_times(json, "cpu_1thread", row.cpu.one_thread);
  add_times(json, "cpu", row.cpu.all_threads);
  json["threads"] = row.cpu.threads;
  json["backend"] = row.cpu.backend;
  add_gpu_columns(json, row.gpu, row.cpu);
  add_times(json, "plain_loop", row.cpu.plain_loop);
  json["serial_over_cpu_1thread"] = rounded(row.cpu.serial_over_one_thread, 1e3);
  json["serial_over_cpu"] = rounded(row.cpu.serial_over_all_threads, 1e3);
  json["plain_loop_over_cpu"] = rounded(row.cpu.plain_loop_over_all_threads, 1e3);
  json["steps"] = row.cpu.steps;
  json["cpu_steps_per_second"] = rounded(1e3 / row.cpu.all_threads.median_ms, 1e1);
  const PaperRow* paper = paper_row ? &kPaper.at(*paper_row - 1) : nullptr;
  json["paper_colors"] = paper != nullptr ? Json(paper->colors) : Json();
  json["paper_cpu_ms"] = paper != nullptr ? Json(paper->cpu_ms) : Json();
  json["paper_gpu_ms"] = paper != nullptr ? Json(paper->gpu_ms) : Json();
  return json;
}

const std::vector<Column>& columns() {
  static const std::vector<Column> all{{"plan", "plan", 0},
                                       {"vertices", "vertices", 0},
                                       {"links", "links", 0},
                                       {"tets", "tets", 0},
                                       {"colors", "colours", 0},
                                       {"paper_cpu_ms", "paper (i7-4770), ms", 0},
                                       {"plain_loop_ms", "plain loop, ms", 2},
                                       {"plain_loop_p99_ms", "p99", 2},
                                       {"serial_ms", "serial, ms", 2},
                                       {"serial_p99_ms", "p99", 2},
                                       {"cpu_1thread_ms", "1 thread, ms", 2},
                                       {"cpu_1thread_p99_ms", "p99", 2},
                                       {"cpu_ms", "all threads, ms", 2},
                                       {"cpu_p99_ms", "p99", 2},
                                       {"serial_over_cpu_1thread", "serial / 1 thread", 2},
                                       {"serial_over_cpu", "serial / all", 2},
                                       {"plain_loop_over_cpu", "plain loop / all", 2},
                                       {"cpu_steps_per_second", "steps/s", 0},
                                       {"steps", "steps timed", 0}};
  return all;
}

// One line a subject, beside the CPU's fastest plan, which comes last; none without a device.
std::string gpu_table(const Json& rows) {
  std::vector<Column> shown{{"tets", "tets", 0}};
  shown.insert(shown.end(), gpu_columns().begin(), gpu_columns().end());
  std::string lines;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Json& row = rows[i];
    const bool is_last = i + 1 == rows.size() || rows[i + 1]["kind"] != row["kind"] ||
                         rows[i + 1]["row"] != row["row"];
    if (is_last && !row["gpu_ms"].is_null()) {
      const std::string number = row["row"].is_null() ? "" : " " + text_of(row["row"]);
      lines += markdown_line(text_of(row["kind"]) + number, row, shown);
    }
  }
  return lines.empty() ? "" : "\n## gpu\n\n" + markdown_header("mesh", shown) + lines;
}

constexpr const char* kLegend = R"(# Table 2

- one step: 30 sweeps of 0.2 ms from a stretch of 10 %, fractions 0.4 and 1, one rim fixed; medians, and the time that 99 of 100 steps keep
- the first plan of a row is the paper's (random disc, distances, then volumes), the second the fastest of greedy + repair on all threads, separate, joint or nested, balanced or not
- colours: phases in one sweep, of both types; the paper gives one number a row and counts edges alone (see table 1)
- plain loop: all links shuffled, then all tetrahedra, one thread, the same compiler flags: what a backend must beat to be worth its name
- ratios: of the CPU's backends among each other, medians over rounds in which all take turns; against the gpu, of medians
- each step's end state is hashed: runs of one backend agree, fast steps on one thread and on all, and strict ones with the serial backend's
- scene: liver and gallbladder of the largest sizes of the paper's table 3, joined by a membrane; lattice: a liver of a million tetrahedra
)";

}  // namespace

Json to_json(const std::vector<Row>& rows) {
  Json json = Json::array();
  for (const Row& row : rows) {
    json.push_back(to_json(row));
  }
  return json;
}

std::string to_markdown(const Json& rows, const std::vector<std::string>& notes) {
  std::string text = std::string(kLegend) + kGpuLegend;
  for (const std::string& note : notes) {
    text += "- " + note + "\n";
  }
  std::string kind;
  for (const Json& row : rows) {
    if (row["kind"] != kind) {
      kind = row["kind"];
      text += "\n## " + kind + "\n\n" + markdown_header("row", columns());
    }
    text += markdown_line(row["row"].is_null() ? "-" : text_of(row["row"]), row, columns());
  }
  return text + gpu_table(rows);
}

}  // namespace pbdsurg::bench
