// SPDX-License-Identifier: Apache-2.0
#include "bench/edits/report.h"

#include <algorithm>
#include <cstdio>

namespace pbdsurg::bench {
namespace {

constexpr int kRateOfAims = 1000;          // tetrahedra a second
constexpr double kMostShareOfStep = 0.05;  // added at this rate, but for the largest mesh
constexpr Index kLargeMesh = 500'000;      // tetrahedra, from where costs alone are compared

// Of the time of one deletion on the largest mesh, over that on the smallest.
double most_growth(Pattern pattern) {
  return pattern == Pattern::regional ? 4 : 12;
}

double edit_share(const EditTimes& times) {
  return times.edit_ms / times.plain_step_ms;
}

double added_share(const EditTimes& times) {
  return times.added_ms / times.plain_step_ms;
}

// Within a device's step an edit costs what it adds; elsewhere what is added beside it is noise.
double judged_share(const Measured& measured, const EditTimes& times) {
  return measured.run.overlaps ? added_share(times) : edit_share(times);
}

Json to_json(const Measured& measured, const EditTimes& times) {
  return {{"backend", measured.backend},
          {"method", measured.method},
          {"mesh", measured.mesh},
          {"tets", measured.tets},
          {"plan", measured.run.plan},
          {"overlapped", measured.run.overlaps},
          {"pattern", name_of(times.pattern)},
          {"deletions_per_s", times.deletions_per_s},
          {"frames", times.frames},
          {"deleted", times.deleted},
          {"added", 0},
          {"plan_ms_per_step", Json()},
          {"plain_step_ms", rounded(times.plain_step_ms, 1e4)},
          {"step_ms", rounded(times.step_ms, 1e4)},
          {"edit_ms_per_step", rounded(times.edit_ms, 1e4)},
          {"us_per_edit", rounded(times.us_per_deletion, 1e2)},
          {"added_ms_per_step", rounded(times.added_ms, 1e4)},
          {"edit_share", rounded(edit_share(times), 1e4)},
          {"added_share", rounded(added_share(times), 1e4)},
          {"longest_edit_ms", Json()},
          {"longest_step_ms", Json()},
          {"last_step_ms", Json()},
          {"phases", Json()},
          {"compacted_step_ms", Json()},
          {"compacted_phases", Json()}};
}

// With the keys of a row of deletions; an edit of one tetrahedron is a part that came.
Json to_json(const Measured& measured, const CutTimes& times) {
  return {{"backend", measured.backend},
          {"method", measured.method},
          {"mesh", measured.mesh},
          {"tets", measured.tets},
          {"plan", measured.run.plan},
          {"overlapped", false},
          {"pattern", "cut"},
          {"deletions_per_s", kFramesPerSecond * times.divided / times.frames},
          {"frames", times.frames},
          {"deleted", times.divided},
          {"added", times.added},
          {"plan_ms_per_step", rounded(times.plan_ms, 1e4)},
          {"plain_step_ms", rounded(times.plain_step_ms, 1e4)},
          {"step_ms", rounded(times.step_ms, 1e4)},
          {"edit_ms_per_step", rounded(times.edit_ms, 1e4)},
          {"us_per_edit", rounded(times.us_per_added, 1e2)},
          {"added_ms_per_step", rounded(times.added_ms, 1e4)},
          {"edit_share", rounded(times.edit_ms / times.plain_step_ms, 1e4)},
          {"added_share", rounded(times.added_ms / times.plain_step_ms, 1e4)},
          {"longest_edit_ms", rounded(times.longest_edit_ms, 1e4)},
          {"longest_step_ms", rounded(times.longest_step_ms, 1e4)},
          {"last_step_ms", rounded(times.last_step_ms, 1e4)},
          {"phases", times.phases},
          {"compacted_step_ms", rounded(times.compacted_step_ms, 1e4)},
          {"compacted_phases", times.compacted_phases}};
}

const std::vector<Column>& columns() {
  static const std::vector<Column> all{{"tets", "tets", 0},
                                       {"pattern", "pattern", 0},
                                       {"deletions_per_s", "deletions/s", 0},
                                       {"plain_step_ms", "step without edits, ms", 3},
                                       {"step_ms", "step, ms", 3},
                                       {"edit_ms_per_step", "edits a step, ms", 4},
                                       {"us_per_edit", "a deletion, us", 2},
                                       {"edit_share", "edits / step", 4},
                                       {"added_share", "added / step", 4},
                                       {"frames", "frames", 0}};
  return all;
}

const std::vector<Column>& cut_columns() {
  static const std::vector<Column> all{{"tets", "tets", 0},
                                       {"plain_step_ms", "step without edits, ms", 3},
                                       {"plan_ms_per_step", "plan, ms", 3},
                                       {"edit_ms_per_step", "edit, ms", 3},
                                       {"us_per_edit", "a new tetrahedron, us", 1},
                                       {"step_ms", "step, ms", 3},
                                       {"longest_edit_ms", "longest edit, ms", 3},
                                       {"longest_step_ms", "longest step, ms", 3},
                                       {"last_step_ms", "step at the end, ms", 3},
                                       {"compacted_step_ms", "compacted, ms", 3},
                                       {"phases", "phases", 0},
                                       {"compacted_phases", "compacted", 0},
                                       {"deleted", "divided", 0},
                                       {"added", "parts", 0},
                                       {"frames", "frames", 0}};
  return all;
}

const EditTimes* find(const Measured& measured, Pattern pattern) {
  const auto found = std::ranges::find_if(measured.run.times, [&](const EditTimes& times) {
    return times.pattern == pattern && times.deletions_per_s == kRateOfAims;
  });
  return found == measured.run.times.end() ? nullptr : &*found;
}

std::string verdict(const std::string& what, double value, double most) {
  char text[64];
  std::snprintf(text, sizeof text, ": %.3g, at most %.3g is aimed at: %s", value, most,
                value <= most ? "met" : "missed");
  return what + text;
}

constexpr const char* kLegend = R"(# Edits

- tetrahedra deleted while an organ is stepped at 60 frames a second, in one edit a frame: regional, around a point that moves at 5 mm/s, or scattered at random; the cautery with its heat field, a live surface and live pieces take part
- one step: the paper's, 30 sweeps of 0.2 ms, or ten sweeps of vertex blocks; medians over frames. A solver that is not edited takes turns: it gives the step without edits, and added is what edit and step take more. Threads step after the edit; a device steps meanwhile, so there a step is from its start to its report with the edit of the next in it
- a deletion: the time of an edit over its tetrahedra; a rate of zero says how much of `added` is noise. Judged is the edits' share of the step; on a device, what is added
- cut: a blade that crosses some twenty tetrahedra a frame, all in one edit with their neighbours, planned and made before the step, in a solver with spare room; medians over the frames in which tissue parts. The longest step says whether buffers of a device were made anew. Steps at the end, and the phases of their sweeps, are those of the edited solver and of the same after a compaction
)";

}  // namespace

Json to_json(const std::vector<Measured>& all) {
  Json json = Json::array();
  for (const Measured& measured : all) {
    for (const EditTimes& times : measured.run.times) {
      json.push_back(to_json(measured, times));
    }
    if (measured.run.cut) {
      json.push_back(to_json(measured, *measured.run.cut));
    }
  }
  return json;
}

std::vector<std::string> verdicts(const std::vector<Measured>& all) {
  std::vector<std::string> lines;
  for (const Measured& measured : all) {
    const std::string where = measured.backend + ", " + measured.method + ", " + measured.mesh;
    for (const Pattern pattern : {Pattern::regional, Pattern::scattered}) {
      const EditTimes* times = find(measured, pattern);
      if (times == nullptr) {
        continue;
      }
      if (measured.tets < kLargeMesh) {
        lines.push_back(verdict(where + ", " + name_of(pattern) + " at " +
                                    std::to_string(kRateOfAims) + "/s: share of the step",
                                judged_share(measured, *times), kMostShareOfStep));
        continue;
      }
      const auto small = std::ranges::find_if(all, [&](const Measured& other) {
        return other.backend == measured.backend && other.method == measured.method;
      });
      lines.push_back(verdict(
          where + ", " + name_of(pattern) + ": time of a deletion, of that on " + small->mesh,
          times->us_per_deletion / find(*small, pattern)->us_per_deletion, most_growth(pattern)));
    }
  }
  return lines;
}

std::string to_markdown(const Json& rows, const std::vector<std::string>& notes) {
  std::string text = kLegend;
  for (const std::string& note : notes) {
    text += "- " + note + "\n";
  }
  std::string backend;
  for (const Json& row : rows) {
    if (row["backend"] != backend) {
      backend = row["backend"];
      text += "\n## " + backend + "\n\n" + markdown_header("method, mesh", columns());
    }
    if (row["pattern"] != "cut") {
      text += markdown_line(text_of(row["method"]) + ", " + text_of(row["mesh"]), row, columns());
    }
  }
  text += "\n## Cuts\n\n" + markdown_header("backend, method, mesh", cut_columns());
  for (const Json& row : rows) {
    if (row["pattern"] == "cut") {
      text += markdown_line(
          text_of(row["backend"]) + ", " + text_of(row["method"]) + ", " + text_of(row["mesh"]),
          row, cut_columns());
    }
  }
  return text;
}

}  // namespace pbdsurg::bench
