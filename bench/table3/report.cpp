// SPDX-License-Identifier: Apache-2.0
#include "bench/table3/report.h"

#include "bench/frames/report.h"
#include "bench/support/gpu_columns.h"

namespace pbdsurg::bench {
namespace {

struct Variant {
  const char* key;
  const char* title;
  std::optional<FrameTimes> RowFrames::*times;
};
constexpr std::array<Variant, 4> kVariants{
    {{"frame_cpu_paper", "cpu, paper mode", &RowFrames::cpu_paper},
     {"frame_cpu_default", "cpu, default", &RowFrames::cpu_default},
     {"frame_gpu_paper", "gpu, paper mode", &RowFrames::gpu_paper},
     {"frame_gpu_default", "gpu, default", &RowFrames::gpu_default}}};

void add_frames(Json& json, const RowFrames& frames) {
  const Json best = to_json(frames.best());
  for (const char* key : {"frames_per_s", "p99_ms", "frames", "size", "renderer", "quality",
                          "stages_ms", "realtime_factor"}) {
    json[key] = best.is_null() ? Json() : best[key];
  }
  json["frame_backend"] = best.is_null() ? Json() : best["backend"];
  for (const Variant& variant : kVariants) {
    json[variant.key] = to_json(frames.*variant.times);
  }
}

Json to_json(const Row& row) {
  Json json{{"method", row.line->method},
            {"paper_liver_tets", row.line->liver_tets},
            {"paper_gallbladder_tets", row.line->gallbladder_tets},
            {"paper_fps", row.line->frames_per_second},
            {"liver_tets", row.liver_tets},
            {"gallbladder_tets", row.gallbladder_tets},
            {"membrane_links", row.membrane_links},
            {"plan", row.cpu.plan},
            {"colors", row.cpu.colors}};
  add_times(json, "serial", row.cpu.serial);
  add_times(json, "cpu_1thread", row.cpu.one_thread);
  add_times(json, "cpu", row.cpu.all_threads);
  add_times(json, "vertex_1thread", row.vertex_blocks.one_thread);
  add_times(json, "vertex", row.vertex_blocks.all_threads);
  json["threads"] = row.cpu.threads;
  json["backend"] = row.cpu.backend;
  json["steps"] = row.cpu.steps;
  json["serial_steps_per_second"] = rounded(1e3 / row.cpu.serial.median_ms, 1e1);
  json["cpu_steps_per_second"] = rounded(1e3 / row.cpu.all_threads.median_ms, 1e1);
  add_gpu_columns(json, row.gpu, row.cpu);
  add_frames(json, row.frames);
  return json;
}

const std::vector<Column>& columns() {
  static const std::vector<Column> all{{"liver_tets", "liver, tets", 0},
                                       {"gallbladder_tets", "gallbladder, tets", 0},
                                       {"membrane_links", "membrane, links", 0},
                                       {"serial_ms", "serial, ms", 2},
                                       {"cpu_ms", "all threads, ms", 2},
                                       {"vertex_ms", "vertex blocks, all threads, ms", 2},
                                       {"gpu_ms", "gpu, ms", 3},
                                       {"serial_steps_per_second", "serial, steps/s", 0},
                                       {"cpu_steps_per_second", "all threads, steps/s", 0},
                                       {"gpu_steps_per_second", "gpu, steps/s", 0},
                                       {"paper_fps", "printed, whole frames/s", 2}};
  return all;
}

// Of a variant's object, its stages beside the rest.
Json flat(const Json& frames) {
  Json row = frames;
  row.update(frames["stages_ms"]);
  return row;
}

const std::vector<Column>& frame_columns() {
  static const std::vector<Column> all{{"paper_fps", "printed, whole frames/s", 2},
                                       {"frames_per_s", "frames/s", 1},
                                       {"frame_ms", "ms", 2},
                                       {"p99_ms", "p99", 2},
                                       {"frames", "frames", 0},
                                       {"contacts", "contacts", 1},
                                       {"realtime_factor", "simulated / wall time", 4},
                                       {"heat", "heat, ms", 2},
                                       {"edit", "edit", 2},
                                       {"solver", "solver", 2},
                                       {"contact", "contact", 2},
                                       {"readback", "readback", 2},
                                       {"upload", "upload", 2},
                                       {"picture", "picture", 2}};
  return all;
}

constexpr const char* kFramesLegend = R"(
- from the move of the instruments until the picture is in the memory of whoever draws, without reading it back: one step with a grasper and the hook pressed into the liver, current of 15 W, removal of what it burns, positions to the host, what changed to the renderer, the picture, which a thread of its own sends and draws while the next frame is simulated, and which is done before that one's begins; of more than two threads it has one of the CPU's
- paper mode: one step of 0.2 ms as above, from rest. default: Neo-Hookean tissue, options as they are by default, a step of 10 ms on the CPU, so that a slow picture stands for more time, and 5 ms on a device, as the demo steps
- frames/s: of all frames and their time; p99 of few frames is the longest
- contact: what a step takes more than one by turns without instruments, of organs that do not meet; solver: the rest of it; stages are medians of frames in which one follows another

)";

constexpr const char* kLegend = R"(# Table 3

- liver and gallbladder joined by a membrane; one whole step of the solver: 30 sweeps of 0.2 ms from a stretch of 10 %, fractions 0.4 and 1, the liver's upper part fixed; medians
- vertex blocks: one step of four sweeps, over-relaxed by 1.2, and a coarse correction, with the moduli of the tissue library, from the same start
- the CPU's plan is the fastest of greedy + repair on all threads, separate, joint or nested, balanced or not
- each step's end state is hashed: runs of one backend agree, fast steps on one thread and on all, and strict ones with the serial backend's
- printed: frames a second with all that is beside the step (Pan et al.: GTX 980 Ti; Kim et al., as cited there); the first line's gallbladder is as small as one with a wall can be
)";

std::string label_of(const Json& row) {
  return text_of(row["method"]) + ": " + text_of(row["paper_liver_tets"]) + " + " +
         text_of(row["paper_gallbladder_tets"]);
}

std::string frames_to_markdown(const Json& rows) {
  std::string text;
  for (const Variant& variant : kVariants) {
    std::string lines;
    for (const Json& row : rows) {
      if (!row[variant.key].is_null()) {
        Json frames = flat(row[variant.key]);
        frames["paper_fps"] = row["paper_fps"];
        lines += markdown_line(label_of(row), frames, frame_columns());
      }
    }
    if (!lines.empty()) {
      const Json& first = rows.at(0)[variant.key];
      text += std::string("\n### ") + variant.title + "\n\n" + text_of(first["backend"]) +
              "; pictures of " + text_of(first["size"]) + " by " + text_of(first["renderer"]) +
              ", quality " + text_of(first["quality"]) + "\n\n" +
              markdown_header("printed", frame_columns()) + lines;
    }
  }
  return text.empty() ? text : "\n## Whole frames\n" + std::string(kFramesLegend) + text;
}

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
  text += "\n" + markdown_header("printed", columns());
  std::string gpu;
  for (const Json& row : rows) {
    text += markdown_line(label_of(row), row, columns());
    if (!row["gpu_ms"].is_null()) {
      gpu += markdown_line(label_of(row), row, gpu_columns());
    }
  }
  if (!gpu.empty()) {
    text += "\n## gpu\n\n" + markdown_header("printed", gpu_columns()) + gpu;
  }
  return text + frames_to_markdown(rows);
}

}  // namespace pbdsurg::bench
