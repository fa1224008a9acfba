// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/play/virtual_play.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <optional>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/version.h"

#include "apps/cholecystectomy/interruption.h"
#include "apps/cholecystectomy/output_folder.h"
#include "apps/cholecystectomy/play/places.h"
#include "apps/cholecystectomy/play/rehearsal.h"
#include "apps/cholecystectomy/play/session.h"
#include "apps/cholecystectomy/recorders.h"
#include "apps/rig/rig.h"
#include "apps/support/executors.h"
#ifdef PBDSURG_HAS_PICTURES
#include "apps/viewer/instruments.h"
#include "apps/viewer/offscreen_renderer.h"
#include "apps/viewer/png.h"
#endif

namespace cholecystectomy {
namespace {

using rig::kSides;
using rig::Side;

constexpr double kPicturePeriod = 0.5;  // s
constexpr int kTicksPerStep = static_cast<int>(Session::kTimeStep / rig::HandServo::kPeriod + 0.5);

// FNV-1a, 64 bits
class Hash {
 public:
  template <class Value>
  void add(const Value& value) {
    for (const auto* byte = reinterpret_cast<const unsigned char*>(&value);
         byte != reinterpret_cast<const unsigned char*>(&value + 1); ++byte) {
      hash_ = (hash_ ^ *byte) * 0x100000001b3ULL;
    }
  }
  void add(const Eigen::Vector3f& vector) {
    for (int axis = 0; axis < 3; ++axis) {
      add(vector[axis]);
    }
  }
  [[nodiscard]] std::string text() const {
    char text[17];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash_));
    return text;
  }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325ULL;
};

// A row a hand and tick.
class HandRecorder {
 public:
  explicit HandRecorder(const std::filesystem::path& path)
      : file_(path,
              "t_s,hand,x_m,y_m,z_m,jaw,cut,coagulation,connected,"
              "simulated_x_n,simulated_y_n,simulated_z_n,computed_x_n,computed_y_n,computed_z_n,"
              "commanded_x_n,commanded_y_n,commanded_z_n,engaged") {}

  void tick(Side side, double time, const pbdsurg::DeviceState& state,
            const pbdsurg::Pedals& pedals, const Eigen::Vector3f& simulated,
            const rig::ServoReport& servo) {
    std::ostream& out = file_.stream();
    const auto write = [&](const Eigen::Vector3f& v) {
      out << ',' << v.x() << ',' << v.y() << ',' << v.z();
    };
    out << time << ',' << rig::name_of(side);
    write(state.pose.translation());
    out << ',' << state.jaw << ',' << pedals.cut << ',' << pedals.coagulation << ','
        << state.is_connected;
    write(simulated);
    write(servo.force.computed);
    write(servo.force.commanded);
    out << ',' << servo.engaged << '\n';
    hash_.add(servo.force.computed);
    hash_.add(servo.force.commanded);
  }

  void close() { file_.close(); }
  [[nodiscard]] std::string hash() const { return hash_.text(); }

 private:
  CsvFile file_;
  Hash hash_;
};

// Forces of one part of the rehearsal, on the hand that it is about.
class PartForces {
 public:
  explicit PartForces(const RehearsedPart& part) : part_(part) {}

  [[nodiscard]] bool has(double time) const { return part_.begin <= time && time < part_.end; }

  void tick(const Eigen::Vector3f& simulated, const pbdsurg::ServoForce& felt) {
    simulated_ = std::max(simulated_, simulated.norm());
    computed_ = std::max(computed_, felt.computed.norm());
    commanded_ = std::max(commanded_, felt.commanded.norm());
    if (last_) {
      steps_.push_back((felt.computed - last_->computed).norm());
      largest_step_ = std::max(largest_step_, (felt.commanded - last_->commanded).norm());
    }
    last_ = felt;
  }

  // Steps are newtons in a tick of a millisecond.
  [[nodiscard]] nlohmann::ordered_json json() {
    std::ranges::sort(steps_);
    const auto rank = static_cast<std::size_t>(0.999 * static_cast<double>(steps_.size()));
    return {{"part", part_.name},
            {"hand", part_.hand == 0 ? "grasper" : "hook"},
            {"begin_s", part_.begin},
            {"end_s", part_.end},
            {"simulated_n", simulated_},
            {"computed_n", computed_},
            {"commanded_n", commanded_},
            {"computed_step_p999_n", steps_.empty() ? 0 : steps_[rank]},
            {"commanded_step_n", largest_step_}};
  }

  [[nodiscard]] std::size_t hand() const { return part_.hand; }
  [[nodiscard]] bool has_begun() const { return last_.has_value(); }

 private:
  RehearsedPart part_;
  float simulated_ = 0, computed_ = 0, commanded_ = 0;  // N, the largest
  float largest_step_ = 0;                              // N, commanded, in a tick
  std::vector<float> steps_;                            // N, computed, in each tick
  std::optional<pbdsurg::ServoForce> last_;
};

#ifdef PBDSURG_HAS_PICTURES
class PictureSeries {
 public:
  explicit PictureSeries(std::filesystem::path folder)
      : folder_(std::move(folder)), renderer_({.width = 640, .height = 480}) {}

  void draw(Session& session, const Scope& scope, double time) {
    SceneState state;
    session.fill(state, {});
    RenderSnapshot snapshot;
    snapshot.surfaces = std::move(state.whole);
    snapshot.sheets = std::move(state.sheets);
    snapshot.tools = {draw_grasper(state.grasper.pose, state.grasper.is_closed),
                      draw_hook(state.hook.pose)};
    snapshot.smoke = std::move(state.smoke);
    snapshot.haze = state.haze;
    snapshot.camera = scope.camera();
    char name[32];
    std::snprintf(name, sizeof name, "hands_%06.0fms.png", 1e3 * time);
    write_png(folder_ / name, renderer_.render(snapshot));
  }

 private:
  std::filesystem::path folder_;
  OffscreenRenderer renderer_;
};
#endif

std::string state_hash(const Simulation& simulation) {
  Hash hash;
  for (const Eigen::Vector3f& x : simulation.solver.positions()) {
    hash.add(x);
  }
  hash.add(simulation.totals.tets_deleted);
  hash.add(simulation.totals.links_cut);
  return hash.text();
}

nlohmann::ordered_json servo_of(const rig::Rig& rig, Side side) {
  const rig::ServoReport& report = rig.last_tick(side);
  nlohmann::ordered_json faults = nlohmann::ordered_json::object();
  for (std::size_t i = 0; i < pbdsurg::kServoFaultCount; ++i) {
    const auto fault = static_cast<pbdsurg::ServoFault>(i);
    if (report.faults.count(fault) > 0) {
      faults[pbdsurg::name_of(fault)] = report.faults.count(fault);
    }
  }
  return {{"ticks", report.tick_count},
          {"missed", report.missed_count},
          {"packet_age_ms",
           {{"median", 1e3 * report.packet_ages.quantile(0.5)},
            {"worst", 1e3 * report.packet_ages.worst()}}},
          {"faults", std::move(faults)}};
}

class VirtualPlay {
 public:
  explicit VirtualPlay(const VirtualPlayOptions& options)
      : options_(options), description_(rig::read_rig(options.devices)) {
    if (!description_.has(rig::Mover::arm) && !description_.has(rig::Mover::trace)) {
      throw pbdsurg::InvalidArgument("--virtual-time with devices " + options.devices +
                                     ": nothing would move; emulator or a device trace would");
    }
    rig_.emplace(description_, places_, true);
    const pbdsurg::SolverOptions solver =
        solver_options(pbdsurg::programs::executor_named(options.executor), options.is_paper);
    folder_.emplace(options.out);
    anatomy_ = load_anatomy(options.organs, options.detail);
    scene_ = make_scene(anatomy_, options.is_paper ? pbdsurg::ElasticModel::springs
                                                   : pbdsurg::ElasticModel::neo_hookean);
    rehearsal_ = make_rehearsal(scene_, places_.tips);
    for (const RehearsedPart& part : rehearsal_.parts) {
      parts_.emplace_back(part);
    }
    session_.emplace(scene_, anatomy_.anatomy.abdominal_wall, solver,
                     Hands{&rig_->device(Side::left),
                           &rig_->device(Side::right),
                           {&rig_->feet()},
                           options.is_recorded ? &recording_ : nullptr},
                     1);
  }

  int run() {
    note_interrupt();
    folder_->open();
    HandRecorder recorder(folder_->part() / "hands.csv");
    const char* pictures = "no pictures";
#ifdef PBDSURG_HAS_PICTURES
    std::optional<PictureSeries> series;
    if (options_.has_pictures) {
      try {
        series.emplace(folder_->part());
        pictures = "pictures";
      } catch (const pbdsurg::BackendUnavailable& error) {
        std::fprintf(stderr, "no pictures: %s\n", error.what());
      }
    }
#endif
    rig_->begin(rehearsal_.hands);
    const double scripted = description_.has(rig::Mover::arm) ? rehearsal_.length : 0;
    const double seconds =
        options_.seconds > 0 ? options_.seconds : std::max(scripted, rig_->longest_trace());
    const auto steps = static_cast<std::int64_t>(std::lround(seconds / Session::kTimeStep));
    const double begin = clock().now();
    double next_picture = begin;
    const Scope scope = first_scope();
    EventCounts events{};
    for (std::int64_t step = 0; step < steps && !is_interrupted() && !session_->is_lost(); ++step) {
      const double now = clock().now();
      session_->step({}, now, events);
      session_->collect(static_cast<std::uint64_t>(step) + 1, now, {&patches_[0], &patches_[1]});
      for (int tick = 0; tick < kTicksPerStep; ++tick) {
        rig_->tick();
        record(recorder, begin);
      }
      for (const Side side : kSides) {
        rig_->publish(side, packet_of(patches_[static_cast<std::size_t>(side)]));
      }
#ifdef PBDSURG_HAS_PICTURES
      if (series && now >= next_picture) {
        series->draw(*session_, scope, now - begin);
        next_picture += kPicturePeriod;
      }
#endif
    }
    recorder.close();
    if (options_.is_recorded) {
      for (const Side side : kSides) {
        pbdsurg::write_device_trace(folder_->part() / (std::string(rig::name_of(side)) + ".trace"),
                                    recording_.traces[static_cast<std::size_t>(side)]);
      }
    }
    write_report(recorder, events);
    folder_->publish();
    std::printf("wrote hands.csv, %s and report.json to %s\n", pictures, options_.out.c_str());
    if (session_->is_lost()) {
      std::fprintf(stderr, "the tissue lost its shape at %.2f s\n", session_->simulation().time());
    }
    return is_interrupted() ? kInterruptedStatus : session_->is_lost() ? 1 : 0;
  }

 private:
  [[nodiscard]] pbdsurg::Clock& clock() {
    return rig_->clock();
  }

  void record(HandRecorder& recorder, double begin) {
    const double time = clock().now() - begin;
    for (const Side side : kSides) {
      if (!rig_->has_servo(side)) {
        continue;
      }
      const std::size_t hand = static_cast<std::size_t>(side);
      recorder.tick(side, time, session_->hand(hand), session_->pedals(), patches_[hand].force,
                    rig_->last_tick(side));
      for (PartForces& part : parts_) {
        if (part.hand() == hand && part.has(time)) {
          part.tick(patches_[hand].force, rig_->last_tick(side).force);
        }
      }
    }
  }

  void write_report(const HandRecorder& recorder, const EventCounts& events) {
    const Simulation& simulation = session_->simulation();
    const auto count = [&](Event event) { return events[static_cast<std::size_t>(event)]; };
    nlohmann::ordered_json report{
        {"build_id", pbdsurg::build_id()},
        {"devices", options_.devices},
        {"executor", options_.executor},
        {"is_interrupted", is_interrupted()},
        {"is_lost", session_->is_lost()},
        {"virtual_s", simulation.time()},
        {"forces_hash", recorder.hash()},
        {"state_hash", state_hash(simulation)},
        {"grasped", count(Event::grasped)},
        {"slipped", count(Event::slipped)},
        {"energy_j", simulation.energy_in()},
        {"removed_tets", simulation.totals.tets_deleted},
        {"parted_strands", simulation.totals.links_cut},
    };
    for (const rig::Side side : kSides) {
      if (rig_->has_servo(side)) {
        report["servo"][rig::name_of(side)] = servo_of(*rig_, side);
      }
    }
    report["parts"] = nlohmann::ordered_json::array();
    for (PartForces& part : parts_) {
      if (description_.is_emulated && part.has_begun()) {
        report["parts"].push_back(part.json());
      }
    }
    report["files"] = folder_->files();
    std::ofstream file(folder_->part() / kReportName);
    file << report.dump(2) << '\n';
    file.close();
    if (!file) {
      throw pbdsurg::FileError((folder_->part() / kReportName).string() + ": cannot be written");
    }
  }

  VirtualPlayOptions options_;
  rig::RigDescription description_;
  std::optional<OutputFolder> folder_;
  rig::RigPlaces places_ = hand_places();
  LoadedAnatomy anatomy_;
  SurgicalScene scene_;
  Rehearsal rehearsal_;
  std::vector<PartForces> parts_;  // of it
  std::optional<rig::Rig> rig_;
  HandRecording recording_;
  std::optional<Session> session_;
  std::array<pbdsurg::ContactPatch, 2> patches_;  // of the last step
};

}  // namespace

int play_in_virtual_time(const VirtualPlayOptions& options) {
  return VirtualPlay(options).run();
}

}  // namespace cholecystectomy
