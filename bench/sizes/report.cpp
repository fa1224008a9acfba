// SPDX-License-Identifier: Apache-2.0
#include "bench/sizes/report.h"

#include <cstdio>

namespace pbdsurg::bench {
namespace {

constexpr const char* kLegend = R"(# Sizes

- a liver in a World with default options, its upper 40 % fixed; a hook, a cautery, a surface; steps of 5 ms
- quiet frames: nothing touches the liver. Then frames that burn: the hook gives 60 W where the liver is lowest, and the program removes four tetrahedra at its end
- strict frames of each executor end with the bits of the serial one; for that, heat stays on the host where the executor is a device
)";

constexpr const char* kMemory = R"(
Memory, in 10^6 bytes. Tissue and solver: their `memory_bytes()`, arrays on a device included. Heat and surface: growth of the heap when
they are made. Heap and resident: growth from the mesh to the last frame, with what the allocator adds, without memory of a device;
spare room that nothing has touched yet is not resident.

)";

constexpr const char* kConstruction = R"(
Construction, ms, medians. That of the solver has its colouring and plan.

)";

constexpr const char* kFrames = R"(
A frame, ms, medians: the stages of `Frame::times`, and the whole of `World::step()`, of which their sum misses at most 5 %.

)";

double megabytes(std::int64_t bytes) {
  return 1e-6 * static_cast<double>(bytes);
}

std::string hexadecimal(std::uint64_t value) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
  return text;
}

void add_frames(Json& row, const std::string& name, const FrameTimes& times) {
  row[name + "_heat_ms"] = rounded(times.heat, 1e4);
  row[name + "_edit_ms"] = rounded(times.edit, 1e4);
  row[name + "_step_ms"] = rounded(times.step, 1e4);
  row[name + "_readback_ms"] = rounded(times.readback, 1e4);
  row[name + "_frame_ms"] = rounded(times.frame, 1e4);
  row[name + "_stages_over_frame"] = rounded(times.stages_over_frame, 1e4);
}

std::string table_of(const Json& rows, const std::vector<Column>& columns) {
  std::string text = markdown_header("tets", columns);
  for (const Json& row : rows) {
    text += markdown_line(text_of(row["tets"]), row, columns);
  }
  return text;
}

}  // namespace

Json to_json(const std::string& executor, const SizeTimes& times) {
  Json row{
      {"tets", times.tets},
      {"vertices", times.vertices},
      {"executor", executor},
      {"backend", times.backend},
      {"tissue_mb", rounded(megabytes(times.tissue_bytes), 1e3)},
      {"solver_mb", rounded(megabytes(times.solver_bytes), 1e3)},
      {"heat_mb", rounded(megabytes(times.heat_bytes), 1e3)},
      {"surface_mb", rounded(megabytes(times.surface_bytes), 1e3)},
      {"heap_mb", rounded(megabytes(times.heap_bytes), 1e3)},
      {"resident_mb", rounded(megabytes(times.resident_bytes), 1e3)},
      {"heap_bytes_per_tet", times.heap_bytes / times.tets},
      {"tissue_ms", rounded(times.tissue_ms, 1e3)},
      {"solver_ms", rounded(times.solver_ms, 1e3)},
      {"heat_ms", rounded(times.heat_ms, 1e3)},
  };
  add_frames(row, "quiet", times.quiet);
  add_frames(row, "burn", times.burn);
  row["removed_tets"] = times.removed_tets;
  row["strict_hash"] = hexadecimal(times.strict_hash);
  return row;
}

std::string to_markdown(const Json& rows, const std::vector<std::string>& notes) {
  std::string text = kLegend;
  for (const std::string& note : notes) {
    text += "- " + note + "\n";
  }
  text += kMemory + table_of(rows, {{"vertices", "vertices", 0},
                                    {"executor", "executor", 0},
                                    {"tissue_mb", "tissue", 2},
                                    {"solver_mb", "solver", 2},
                                    {"heat_mb", "heat", 2},
                                    {"surface_mb", "surface", 2},
                                    {"heap_mb", "heap", 2},
                                    {"resident_mb", "resident", 1},
                                    {"heap_bytes_per_tet", "heap, bytes/tet", 0}});
  text += kConstruction + table_of(rows, {{"executor", "executor", 0},
                                          {"tissue_ms", "tissue", 1},
                                          {"solver_ms", "solver", 1},
                                          {"heat_ms", "heat", 1}});
  text += kFrames + table_of(rows, {{"executor", "executor", 0},
                                    {"quiet_heat_ms", "quiet: heat", 3},
                                    {"quiet_edit_ms", "edit", 3},
                                    {"quiet_step_ms", "step", 3},
                                    {"quiet_readback_ms", "readback", 3},
                                    {"quiet_frame_ms", "frame", 3},
                                    {"burn_heat_ms", "burn: heat", 3},
                                    {"burn_edit_ms", "edit", 3},
                                    {"burn_step_ms", "step", 3},
                                    {"burn_readback_ms", "readback", 3},
                                    {"burn_frame_ms", "frame", 3},
                                    {"removed_tets", "removed tets", 0}});
  return text;
}

}  // namespace pbdsurg::bench
