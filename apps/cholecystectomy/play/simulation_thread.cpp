// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/play/simulation_thread.h"

#include <algorithm>
#include <cstdint>
#include <exception>
#include <optional>
#include <utility>

#include "apps/cholecystectomy/play/pacer.h"

namespace cholecystectomy {
namespace {

// s, how long a thread without a due step sleeps at most before it looks for orders
constexpr double kNap = 5e-3;

}  // namespace

struct SimulationThread::Load {
  LoadedAnatomy anatomy;
  SurgicalScene scene;
};

SimulationThread::SimulationThread(Options options, const Hands& hands, pbdsurg::Clock& clock,
                                   ContactThread* contacts)
    : options_(std::move(options)),
      hands_(hands),
      clock_(clock),
      contacts_(contacts),
      thread_([this] { run(); }) {}

SimulationThread::~SimulationThread() {
  is_ending_ = true;
  thread_.join();
}

void SimulationThread::run() {
  try {
    Load load;
    load.anatomy = load_anatomy(options_.organs, options_.detail);
    load.scene = make_scene(load.anatomy, options_.is_paper ? pbdsurg::ElasticModel::springs
                                                            : pbdsurg::ElasticModel::neo_hookean);
    show_rest(load);
    if (!is_ending_) {
      play(load, solver_options(options_.executor(), options_.is_paper));
    }
  } catch (const std::exception& error) {
    fail(error.what());
  }
}

// Generation 0 has the organs before there is a solver.
void SimulationThread::show_rest(const Load& load) {
  SceneState& state = states.draft();
  state = {};
  state.whole = rest_surfaces(load.scene, load.anatomy.anatomy.abdominal_wall);
  states.publish();
}

void SimulationThread::fail(const std::string& message) {
  SceneState& state = states.draft();
  state = {};  // an older one lies there
  state.phase = Phase::failed;
  state.message = message;
  states.publish();
}

void SimulationThread::play(const Load& load, const pbdsurg::SolverOptions& solver) {
  std::uint32_t generation = 1;
  std::optional<Session> session;
  EventCounts events{};
  orders.take();
  Orders before = orders.value();
  const auto begin = [&] {
    generation = session ? session->generation() + 1 : 1;
    session.reset();  // its memory first
    session.emplace(load.scene, load.anatomy.anatomy.abdominal_wall, solver, hands_, generation);
    if (options_.on_begin) {
      options_.on_begin(load.scene);
    }
  };
  begin();
  Pacer pacer(Session::kTimeStep, clock_.now());
  std::uint64_t published = 0;
  double published_at = 0;
  std::int64_t steps = 0;
  const auto take_step = [&] {
    const double start = clock_.now();
    session->step(orders.value(), start, events);
    ++steps;
    if (contacts_ != nullptr) {
      session->collect(static_cast<std::uint64_t>(steps), start, contacts_->drafts());
      contacts_->publish();
    }
  };

  while (!is_ending_) {
    orders.take();
    const Orders& now = orders.value();
    if (now.restarts != before.restarts || session->is_lost()) {
      ++events[static_cast<std::size_t>(session->is_lost() ? Event::lost : Event::restarted)];
      begin();
      pacer = Pacer(Session::kTimeStep, clock_.now());
    }
    if (before.undos < now.undos) {
      for (; before.undos < now.undos; ++before.undos) {
        session->undo(events);
      }
      if (options_.on_undo) {
        options_.on_undo();
      }
      pacer = Pacer(Session::kTimeStep, clock_.now());  // what that took is not to be caught up
    }
    if (options_.on_let_go && before.let_gos != now.let_gos) {
      options_.on_let_go();
    }
    pacer.set_speed(now.is_paused ? 0 : now.speed, clock_.now());
    for (; now.is_paused && before.single_steps < now.single_steps; ++before.single_steps) {
      take_step();
    }
    before = now;
    if (pacer.is_due(clock_.now())) {
      take_step();
      pacer.took_step(clock_.now());
    }
    seen.take();
    if (seen.value().sequence >= published || clock_.now() > published_at + kSilence) {
      SceneState& state = states.draft();
      const double start = clock_.now();
      session->fill(state, seen.value());
      state.phase = Phase::playing;
      state.message.clear();
      if (now.is_paused) {
        // no current flows while time stands still; what was spent stays
        GeneratorState& generator = state.generator;
        generator.activation = pbdsurg::Activation::none;
        generator.is_refused = generator.is_arcing = false;
        generator.power = generator.voltage = 0;
      }
      state.events = events;
      state.all_steps = steps;
      state.factor = pacer.factor();
      state.owed = pacer.owed(start);
      state.made = start;
      state.hand_ages = session->hand_ages();
      state.times.publish = 1e3 * (clock_.now() - start);
      published = states.publish();
      published_at = start;
    }
    if (!pacer.is_due(clock_.now())) {
      const double nap = clock_.now() + kNap;
      clock_.wait_until(now.is_paused ? nap : std::min(pacer.next(), nap));
    }
  }
}

}  // namespace cholecystectomy
