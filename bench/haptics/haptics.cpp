// SPDX-License-Identifier: Apache-2.0
// The servo against its limits: plants, delays and tissues in virtual time, as tests/haptics has
// them, the paper's force law beside ours, and what a tick costs.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "pbdsurg/haptics/servo.h"

#include "bench/support/program.h"
#include "bench/support/table_files.h"
#include "bench/support/timing.h"
#include "tests/haptics/rig.h"
#include "tests/haptics/simulated_tissue.h"

namespace pbdsurg::bench {
namespace {

using testing::Case;
using testing::FakeTissue;
using testing::Rig;

struct Arguments {
  std::filesystem::path out = "out/tables";
  bool quick = false;
};

class Table {
 public:
  void at_most(const std::string& name, const std::string& metric, double value, double limit,
               const std::string& unit) {
    add(name, metric, value, limit, unit, value <= limit);
  }
  void at_least(const std::string& name, const std::string& metric, double value, double limit,
                const std::string& unit) {
    add(name, metric, value, limit, unit, value >= limit);
  }
  // without a limit
  void report(const std::string& name, const std::string& metric, double value,
              const std::string& unit) {
    add(name, metric, value, nullptr, unit, nullptr);
  }
  [[nodiscard]] const Json& rows() const { return rows_; }

 private:
  void add(const std::string& name, const std::string& metric, double value, const Json& limit,
           const std::string& unit, const Json& ok) {
    rows_.push_back({{"case", name},
                     {"metric", metric},
                     {"value", rounded(value, 1e4)},
                     {"limit", limit},
                     {"unit", unit},
                     {"ok", ok}});
  }
  Json rows_ = Json::array();
};

struct Outcome {
  int settled = 0, plants = 0;
  double surplus = 0, computed = 0, commanded = 0;  // J, N/ms, N/ms

  void add(const Rig& rig) {
    ++plants;
    settled += testing::settles(rig) ? 1 : 0;
    surplus = std::max(surplus, rig.surplus);
    computed = std::max(computed, testing::steps_of(rig.computed).p999);
    commanded = std::max(commanded, testing::steps_of(rig.commanded).largest);
  }
};

Outcome run_grid(const FakeTissue& tissue, const ServoOptions& options, double least_damping,
                 int period = 10) {
  Outcome outcome;
  for (const Case& one : testing::plant_grid(least_damping)) {
    const Rig rig = testing::pushed(one, tissue, options, period);
    outcome.add(rig);
  }
  return outcome;
}

void add_grid(Table& table, const std::string& name, const Outcome& outcome) {
  table.at_least(name, "plants that settle", outcome.settled, outcome.plants, "");
  table.at_most(name, "energy made", 1e3 * outcome.surplus, 0.1, "mJ");
  table.at_most(name, "step of computed force, p99.9", outcome.computed, 0.1, "N/ms");
  table.at_most(name, "step of commanded force, largest", outcome.commanded, 0.2001, "N/ms");
}

// N/m: of tissue that is a spring, the largest with which all plants settle, to 1 N/m.
double largest_stable(const ServoOptions& options, double least_damping, double most) {
  double stable = 0, unstable = most + 1;
  while (unstable - stable > 1) {
    const auto middle = static_cast<float>((stable + unstable) / 2);
    const Outcome outcome = run_grid(testing::soft_wall(middle, middle), options, least_damping);
    (outcome.settled == outcome.plants ? stable : unstable) = double{middle};
  }
  return std::round(stable);
}

void add_felt(Table& table, float stiffness, const ServoOptions& options, double least_damping) {
  double worst = 0;
  for (const Case& one : testing::plant_grid(least_damping)) {
    const Rig rig = testing::pushed(one, testing::soft_wall(stiffness, stiffness), options);
    worst = std::max(worst, std::abs(testing::felt_stiffness(rig) / double{stiffness} - 1));
  }
  table.at_most("spring of " + std::to_string(std::lround(stiffness)) + " N/m" +
                    (options.is_firm ? ", firm" : ""),
                "felt at rest, off by", 100 * worst, 5, "%");
}

// What takes force away or turns it around.
void add_event(Table& table, const std::string& name, const Rig& rig) {
  table.at_most(name, "step of computed force, p99.9", testing::steps_of(rig.computed).p999, 0.1,
                "N/ms");
  table.at_most(name, "step of commanded force, largest", testing::steps_of(rig.commanded).largest,
                0.2001, "N/ms");
}

// Packets of a simulation that steps with them.
void add_simulated(Table& table) {
  constexpr double kAtRest = 6e-3;  // m/s
  for (const testing::PressedScene& scene : testing::pressed_scenes()) {
    Outcome outcome;
    double off = 0, fastest = 0;
    int at_rest = 0;
    const bool has_statics = scene.scene == testing::spring_block;
    for (const Case& one : testing::simulated_grid()) {
      const auto [rig, depth, felt, simulated] = testing::press(scene, one);
      outcome.add(rig);
      const double wanted = has_statics ? testing::plate_force(depth) : simulated;
      const double late = rig.peak_speed(testing::kEngaged + 10, testing::kEngaged + 12);
      fastest = std::max(fastest, late);
      if (late < kAtRest) {
        ++at_rest;
        off = std::max(off, std::abs(felt / wanted - 1));
      }
    }
    const std::string name = std::string("simulated: ") + scene.name;
    if (at_rest == 0) {
      throw Error("no plant came to rest of " + name);
    }
    add_grid(table, name, outcome);
    table.report(name, "speed in the last two seconds, largest", 1e3 * fastest, "mm/s");
    table.report(name, "plants at rest, slower than 6 mm/s", at_rest, "");
    table.at_most(name,
                  has_statics ? "felt at rest, off a static solution by"
                              : "felt at rest, off the simulation by",
                  100 * off, 5, "%");
  }
  constexpr float kSlips = 0.4F, kTears = 30;  // N, N/m
  Grip slips = testing::slab_grip(), tears = slips;
  slips.friction = 0.5F;
  slips.clamp_force = kSlips / (2 * slips.friction);
  tears.tear_strength = kTears;
  const Rig slipped = testing::pulled_slab(slips), torn = testing::pulled_slab(tears);
  add_event(table, "simulated: jaws that slip", slipped);
  double felt = 0;
  constexpr std::size_t kFrom = 1900, kTo = 2200;  // ticks, while they slip
  for (std::size_t i = kFrom; i < kTo; ++i) {
    felt += double{slipped.commanded[i].norm()} / (kTo - kFrom);
  }
  table.at_most("simulated: jaws that slip", "felt while they slip, off 2 mu N by",
                100 * std::abs(felt / double{kSlips} - 1), 5, "%");
  add_event(table, "simulated: tissue that tears", torn);
  for (const auto& [name, rig] : {std::pair{"simulated: jaws that slip", &slipped},
                                  {"simulated: tissue that tears", &torn}}) {
    table.at_most(name, "force in the end", double{rig->commanded.back().norm()}, 0.01, "N");
  }
}

void add_stale(Table& table) {
  Rig rig = testing::pushed({{.has_hand = true, .position = {0, testing::kAbove, 0}}, 0},
                            testing::hard_wall(), {}, 10, 2);
  rig.publishes = false;
  rig.run(0.15);
  table.at_most("no packets", "force after 150 ms", double{rig.commanded.back().norm()}, 0.01, "N");
}

// Packets with all planes, every tick a new pose, every tenth a new packet.
void add_times(Table& table, int ticks) {
  constexpr int kQuiet = 1500;  // ticks, until force is let in
  ServoState state;
  ContactPacket packet;
  ServoInput input;
  std::vector<double> times;
  float felt = 0;
  for (int i = 0; i < ticks; ++i) {
    if (i % 10 == 0) {
      packet = {};
      packet.sequence = static_cast<std::uint64_t>(i) + 1;
      packet.time = i * 1e-3;
      packet.plane_count = ContactPacket::kLargestPlaneCount;
      packet.force = {0, i < kQuiet ? 0 : 0.5F + 0.4F * std::sin(1e-3F * static_cast<float>(i)), 0};
      fit_to_force(packet, 150);
    }
    input.time = i * 1e-3;
    input.tip.translation().y() = 1e-3F * std::sin(7e-3F * static_cast<float>(i));
    const double before = thread_seconds();
    felt += servo_tick(state, packet, input).commanded.norm();
    times.push_back(thread_seconds() - before);
  }
  if (!(felt > 0)) {
    throw Error("a servo that was to be timed commanded no force");
  }
  table.at_most("tick", "thread's time, p99.9", 1e6 * quantile(times, 0.999), 50, "us");
  table.report("tick", "thread's time, median", 1e6 * median(times), "us");
}

void run(const Arguments& arguments) {
  Table table;
  add_grid(table, "hard wall", run_grid(testing::hard_wall(), {}, 0));
  if (!arguments.quick) {
    add_grid(table, "hard wall, packets at 30 Hz", run_grid(testing::hard_wall(), {}, 0, 33));
    for (const float stiffness : {50.0F, 100.0F, 150.0F}) {
      add_grid(table, "tissue of " + std::to_string(std::lround(stiffness)) + " N/m",
               run_grid(testing::soft_wall(stiffness, stiffness), {}, 0));
      add_felt(table, stiffness, {}, 0);
    }
    add_grid(table, "tissue of 150 N/m, packets say 30",
             run_grid(testing::soft_wall(150, 30), {}, 0));
    add_grid(table, "tissue of 300 N/m, packets say 80",
             run_grid(testing::soft_wall(300, 80), {}, 0));
    add_grid(table, "hard wall, firm, 0.3 N s/m or more",
             run_grid(testing::hard_wall(), {.is_firm = true}, 0.3));
    for (const float stiffness : {200.0F, 300.0F}) {
      add_felt(table, stiffness, {.is_firm = true}, 0.3);
    }
    add_grid(table, "four points", run_grid(testing::four_points(), {}, 0));
    add_event(table, "facets of a ball of 10 mm", testing::over_facets(180));
    const Rig sheet = testing::through_sheet();
    add_event(table, "thin sheet", sheet);
    float pull = 0;
    for (const Eigen::Vector3f& force : sheet.commanded) {
      pull = std::max(pull, -force.y());
    }
    table.at_most("thin sheet", "pull, largest", double{pull}, 1e-6, "N");
    for (const GraspState how : {GraspState::open, GraspState::torn}) {
      const std::string name = how == GraspState::open ? "grasp, opened" : "grasp, torn";
      const Rig rig = testing::grasp_lost(how);
      add_event(table, name, rig);
      table.at_most(name, "force after 0.1 s", double{rig.commanded.back().norm()}, 0.01, "N");
    }
    add_simulated(table);
    add_stale(table);
    const ServoOptions paper{.mode = ServoMode::paper};
    table.report("the paper's force law, 1 N s/m", "largest stable stiffness",
                 largest_stable(paper, 1, 300), "N/m");
    table.report("ours, 0.1 N s/m", "largest stable stiffness, felt", double{kStiffness}, "N/m");
    const Outcome held = run_grid(testing::soft_wall(150, 150), paper, 0);
    table.report("the paper's force law, tissue of 150 N/m", "plants that settle", held.settled,
                 "");
    table.report("the paper's force law, tissue of 150 N/m", "energy made", 1e3 * held.surplus,
                 "mJ");
    table.report("the paper's force law, tissue of 150 N/m", "step of computed force, p99.9",
                 held.computed, "N/ms");
  }
  add_times(table, arguments.quick ? 4000 : 200000);

  const std::vector<Column> columns{{"metric", "metric", 0},
                                    {"value", "value", 4},
                                    {"limit", "limit", 4},
                                    {"unit", "unit", 0},
                                    {"ok", "ok", 0}};
  std::string text =
      "# Haptics\n\n- a servo at 1 kHz in virtual time, packets at 100 Hz where not said "
      "otherwise, 0, 10 and 20 ms late; plants of 30 to 60 g and 0.1 to 1 N s/m behind an encoder "
      "of 0.055 mm, pushed by 0.5 N, or in a hand of 150 N/m and 3 N s/m\n- a plant settles if in "
      "its last two of 12 s it is slower than 3 mm/s, or than 0.7 of what it was 6 s before; "
      "energy made is the work of the force on the plant beyond what the plant's friction has "
      "taken\n- simulated: packets of a solver that steps by 10 ms with them, of all default; "
      "tissue of 5 to 10 kPa, damping of 1 ms; plants without a hand are on a guide\n\n" +
      markdown_header("case", columns);
  for (const Json& row : table.rows()) {
    text += markdown_line(text_of(row["case"]), row, columns);
  }
  std::fputs(text.c_str(), stdout);
  write_table(arguments.out, "haptics", table.rows(), text);
}

}  // namespace
}  // namespace pbdsurg::bench

int main(int argc, char** argv) {
  CLI::App app("The servo against its limits, on plants in virtual time.", "haptics");
  pbdsurg::bench::Arguments arguments;
  app.add_flag("--quick", arguments.quick, "one tissue: to see it work");
  return pbdsurg::bench::run_program(app, argc, argv, arguments.out,
                                     [&] { pbdsurg::bench::run(arguments); });
}
