// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/play/session.h"

#include <cmath>
#include <limits>
#include <utility>

namespace cholecystectomy {
namespace {

using pbdsurg::Activation;

// Jaws that close past the first hold, those that open past the second let go: between them nothing
// changes, so that a handle that trembles does not chatter.
constexpr float kClosed = 0.35F, kOpen = 0.65F;

// How many edits an undo goes through, beside those of strokes that are longer: 0.06 ms each.
constexpr std::size_t kMostEdits = 1000;

constexpr float kJawReach = 6e-3F;  // m, from the tip to what jaws take
constexpr float kBite = 5e-3F;      // m, around the tip, of what they hold

void count(EventCounts& events, Event event) {
  ++events[static_cast<std::size_t>(event)];
}

struct Nearest {
  std::optional<Organ> organ;
  float distance;  // m
};

// The organ whose tissue is nearest to a point, by the vertices of its surface.
Nearest nearest_organ(const Simulation& simulation, const Eigen::Vector3f& point) {
  Nearest nearest{std::nullopt, std::numeric_limits<float>::infinity()};
  for (const Organ organ : pbdsurg::kOrgans) {
    const pbdsurg::Surface& surface = simulation.surface(organ);
    for (std::size_t v = 0; v < surface.vertices().size(); ++v) {
      const float distance = (surface.positions()[v] - point).squaredNorm();
      if (distance < nearest.distance &&
          simulation.solver.tissue().has_tissue(surface.vertices()[v])) {
        nearest = {organ, distance};
      }
    }
  }
  nearest.distance = std::sqrt(nearest.distance);
  return nearest;
}

}  // namespace

void HandRecording::add(std::array<pbdsurg::DeviceState, 2> states, const pbdsurg::Pedals& pedals,
                        double now) {
  states[1].pedals = pedals;
  for (std::size_t i = 0; i < traces.size(); ++i) {
    pbdsurg::DeviceTrace& trace = traces[i];
    if (trace.samples.empty()) {
      trace.samples.reserve(kMostSteps);
      trace.begin = now;
    }
    if (trace.samples.size() < kMostSteps) {
      trace.samples.push_back({now, states[i], Eigen::Vector3f::Zero()});
    } else {
      ++trace.lost;
    }
  }
}

Session::Session(const SurgicalScene& scene, const pbdsurg::MeshData& backdrop,
                 const pbdsurg::SolverOptions& options, const Hands& hands,
                 std::uint32_t generation)
    : scene_(scene),
      simulation_(std::make_unique<Simulation>(scene, options, std::nullopt, stages_, kTimeStep)),
      feed_(*simulation_, backdrop, generation),
      smoke_(Smoke::of_scene()),
      hands_(hands) {
  simulation_->grasper.is_aimed = simulation_->hook.is_aimed = false;
  simulation_->world.record();
}

void Session::step(const Orders& orders, double now, EventCounts& events) {
  states_ = {hands_.grasper->state(), hands_.hook->state()};
  const auto& [grasper, hook] = states_;
  const auto follow = [&](Instrument& instrument, const pbdsurg::DeviceState& hand) {
    simulation_->approach(instrument, hand.pose.translation(), kTopSpeed);
    instrument.orientation = Eigen::Quaternionf(hand.pose.rotation());
  };
  follow(simulation_->grasper, grasper);
  follow(simulation_->hook, hook);
  hand_ages_.add(now - grasper.time);
  hand_ages_.add(now - hook.time);
  work_jaws(grasper.jaw, events);

  pedals_ = {};
  const auto press = [&](const pbdsurg::DeviceState& state) {
    if (state.is_connected && now - state.time <= kSilence) {
      pedals_.cut = pedals_.cut || state.pedals.cut;
      pedals_.coagulation = pedals_.coagulation || state.pedals.coagulation;
    }
  };
  press(grasper);
  press(hook);
  for (pbdsurg::Device* device : hands_.feet) {
    press(device->state());
  }
  if (hands_.recording != nullptr) {
    hands_.recording->add(states_, pedals_, now);
  }
  pbdsurg::Pedals pedals = pedals_;
  has_seen_pedals_up_ = has_seen_pedals_up_ || pedals == pbdsurg::Pedals{};
  if (!has_seen_pedals_up_) {
    pedals = {};
  }
  const Activation activation = pbdsurg::activation_of(pedals);
  if (activation_ == Activation::none && activation != Activation::none) {
    begin_stroke();
  }
  activation_ = activation;
  is_refused_ = pedals.cut && pedals.coagulation;
  std::optional<pbdsurg::GeneratorSettings> settings;
  if (activation_ == Activation::cut) {
    settings = pbdsurg::cut_settings(orders.cut_power);
  } else if (activation_ == Activation::coagulation) {
    settings = pbdsurg::coagulate_settings(orders.coagulation_power);
  }

  const StageTimes stages = stages_;
  const Totals totals = simulation_->totals;
  simulation_->advance(settings);
  const auto taken = [&](const char* stage) {
    const auto found = stages.find(stage);
    return stages_[stage] - (found == stages.end() ? 0 : found->second);
  };
  smoke_.advance(kTimeStep, simulation_->pose_of(simulation_->hook).translation(),
                 simulation_->last_burn.energy / kTimeStep, Smoke::kSuction);
  times_ = {taken("cautery"), taken("tearing"), taken("solve"), taken("readback"), 0};
  if (simulation_->totals.tets_deleted > totals.tets_deleted) {
    count(events, Event::tissue_removed);
  }
  if (simulation_->totals.links_cut > totals.links_cut) {
    count(events, Event::strand_parted);
  }
  if (!simulation_->grasper.held.empty() &&
      simulation_->world.force(simulation_->grasper.tool).norm() > kGrip) {
    simulation_->release();
    grasp_ = pbdsurg::GraspState::torn;
    count(events, Event::slipped);
  }
}

void Session::collect(std::uint64_t sequence, double time, const ContactPatches& patches) {
  if (!contacts_) {
    contacts_.emplace(*simulation_);
  }
  contacts_->collect(*simulation_, grasp_, sequence, time, patches);
}

void Session::work_jaws(float jaw, EventCounts& events) {
  Instrument& grasper = simulation_->grasper;
  if (is_closed_ && jaw > kOpen) {
    is_closed_ = false;
    if (!grasper.held.empty()) {
      simulation_->release();
    }
    grasp_ = pbdsurg::GraspState::open;
  } else if (!is_closed_ && jaw < kClosed) {
    is_closed_ = true;
    const Nearest nearest =
        nearest_organ(*simulation_, simulation_->pose_of(grasper).translation());
    const bool is_near = nearest.distance < kJawReach;
    if (is_near) {
      if (activation_ == Activation::none) {
        begin_stroke();
      }
      simulation_->grasp(*nearest.organ, kBite);
      grasp_ = pbdsurg::GraspState::held;
    }
    count(events, is_near ? Event::grasped : Event::missed);
  }
}

void Session::begin_stroke() {
  settle_strokes();
  SimulationState state = simulation_->save();
  if (state.world.edit_count() > kMostEdits) {
    simulation_->world.record();
    state = simulation_->save();
  }
  strokes_.push_back(
      {std::move(state), feed_.skin(), simulation_->energy_in(), smoke_, is_closed_});
}

// Once the last is over: it is none if it changed nothing.
void Session::settle_strokes() {
  if (strokes_.empty()) {
    return;
  }
  const Moment& last = strokes_.back();
  const Totals& before = last.simulation.totals;
  const Totals& now = simulation_->totals;
  if (simulation_->energy_in() == last.energy && now.tets_deleted == before.tets_deleted &&
      now.links_cut == before.links_cut) {
    strokes_.pop_back();
  } else if (strokes_.size() > kMostStrokes) {
    strokes_.pop_front();
  }
}

void Session::undo(EventCounts& events) {
  settle_strokes();
  if (strokes_.empty()) {
    count(events, Event::no_undo);
    return;
  }
  const Moment& moment = strokes_.back();
  auto made = std::make_unique<Simulation>(scene_, moment.simulation, stages_, kTimeStep);
  made.swap(simulation_);
  contacts_.reset();
  feed_.begin_anew(*simulation_, moment.skin);
  smoke_ = moment.smoke;
  is_closed_ = moment.is_closed;
  put_hands(*made);
  has_seen_pedals_up_ = false;
  activation_ = Activation::none;
  is_refused_ = false;
  times_ = {};
  strokes_.pop_back();
  count(events, Event::undone);
}

// Where they were before an undo, but for jaws that still hold.
void Session::put_hands(const Simulation& before) {
  const auto put = [&](Instrument& instrument, const Instrument& now) {
    if (instrument.held.empty()) {
      instrument.tip = now.tip;
      instrument.orientation = now.orientation;
      simulation_->world.move(instrument.tool, instrument.pose());
    }
  };
  const pbdsurg::DeviceState hand = hands_.grasper->state();
  const Instrument& grasper = simulation_->grasper;
  if (!grasper.held.empty() &&
      (hand.jaw > kOpen || (hand.pose.translation() - grasper.tip).norm() > kSameHold)) {
    simulation_->release();
  }
  is_closed_ = hand.jaw < kClosed || (is_closed_ && hand.jaw <= kOpen);
  put(simulation_->grasper, before.grasper);
  put(simulation_->hook, before.hook);
  grasp_ = grasper.held.empty() ? pbdsurg::GraspState::open : pbdsurg::GraspState::held;
}

void Session::fill(SceneState& state, const Seen& seen) {
  feed_.fill(state, seen);
  const auto of = [&](const Instrument& instrument) {
    const pbdsurg::ToolPose pose = simulation_->pose_of(instrument);
    return InstrumentState{pose, false, !instrument.held.empty(),
                           simulation_->world.force(instrument.tool),
                           nearest_organ(*simulation_, pose.translation()).distance};
  };
  state.grasper = of(simulation_->grasper);
  state.grasper.is_closed = is_closed_;
  state.hook = of(simulation_->hook);
  const pbdsurg::CauteryReport& burn = simulation_->last_burn;
  state.generator = {
      activation_,     is_refused_,  burn.contact_vertices > 0 || burn.contact_links > 0,
      burn.is_arcing,  burn.power,   burn.voltage,
      burn.resistance, burn.hottest, simulation_->energy_in()};
  state.smoke.assign(smoke_.puffs().begin(), smoke_.puffs().end());
  state.haze = smoke_.haze();
  state.time = simulation_->time();
  state.step = simulation_->totals.steps;
  state.times = times_;
  state.removed_tets = simulation_->totals.tets_deleted;
  state.parted_strands = simulation_->totals.links_cut;
}

}  // namespace cholecystectomy
