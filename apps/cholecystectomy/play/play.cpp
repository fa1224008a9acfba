// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/play/play.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <future>
#include <memory>
#include <utility>

#include <epoxy/gl.h>
#include <sys/resource.h>
#include <unistd.h>

#include "pbdsurg/base/error.h"

#include "apps/cholecystectomy/interruption.h"
#include "apps/cholecystectomy/play/controls.h"
#include "apps/cholecystectomy/play/guide.h"
#include "apps/cholecystectomy/play/panel_screen.h"
#include "apps/cholecystectomy/play/panels.h"
#include "apps/cholecystectomy/play/picture_pace.h"
#include "apps/cholecystectomy/play/places.h"
#include "apps/cholecystectomy/play/rehearsal.h"
#include "apps/cholecystectomy/play/rig_watch.h"
#include "apps/cholecystectomy/play/session.h"
#include "apps/cholecystectomy/play/settings.h"
#include "apps/cholecystectomy/play/simulation_thread.h"
#include "apps/cholecystectomy/play/texts.h"
#include "apps/rig/rig.h"
#include "apps/sound/player.h"
#include "apps/support/executors.h"
#include "apps/viewer/instruments.h"
#include "apps/viewer/png.h"
#include "apps/viewer/scene_renderer.h"
#include "apps/viewer/window.h"

namespace cholecystectomy {
namespace {

using rig::Side;

constexpr float kScene = kReach + 0.02F;  // m, about the centre; beyond, hands are withdrawn

// Steps come before pictures: this thread, and those that an OpenGL without a GPU starts from it,
// get a processor when the simulation leaves one.
void yield_to_steps() {
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), 5);
}

RenderQuality quality_of(PictureQuality wanted, const Window& window) {
  const bool is_quick = wanted == PictureQuality::quick ||
                        (wanted == PictureQuality::automatic && window.is_software());
  return is_quick ? RenderQuality::quick() : RenderQuality::full();
}

// All that a lost context takes along.
struct Screen {
  Screen(const WindowOptions& options, PictureQuality quality, const Texts& texts,
         bool& has_understood)
      : window(options),
        renderer(std::max(window.width(), 16), std::max(window.height(), 16),
                 quality_of(quality, window)),
        panels(texts, has_understood),
        panel_screen(window, panels) {}

  Window window;
  SceneRenderer renderer;
  Panels panels;
  PanelScreen panel_screen;
};

class Play {
 public:
  explicit Play(const PlayOptions& options)
      : options_(options),
        settings_path_(options.settings ? *options.settings : default_settings_path()),
        settings_(load_settings(settings_path_, complaint_)),
        sides_(settings_.is_left_handed ? std::array{Side::right, Side::left}
                                        : std::array{Side::left, Side::right}),
        description_(rig::read_rig(options.devices)),
        rig_(description_, places_, false),
        hands_{{{"mouse, grasper", reach_of(Side::left), places_.tips[0], clock()},
                {"mouse, hook", reach_of(Side::right), places_.tips[1], clock()}}},
        scope_(first_scope()),
        controls_(hands_, scope_, assistant_, orders_, settings_.is_left_handed),
        player_(std::async(std::launch::async, make_player)),
        contacts_(feels() ? std::make_unique<ContactThread>(rig_, sides_, clock()) : nullptr),
        simulation_(std::make_unique<SimulationThread>(simulation_options(), devices(), clock(),
                                                       contacts_.get())) {
    for (const char* trace : {"left.trace", "right.trace"}) {
      if (options.is_recorded && std::filesystem::exists(options.out / trace)) {
        throw pbdsurg::FileError((options.out / trace).string() +
                                 " is there already; move it away or choose another folder with "
                                 "--out");
      }
    }
    orders_.cut_power = settings_.cut_power;
    orders_.coagulation_power = settings_.coagulation_power;
    if (settings_.is_left_handed) {
      hands_[0].exchange_places(hands_[1]);
    }
    const auto is_device = [&](Side side) {
      return description_.hand(side).mover != rig::Mover::mouse;
    };
    const std::array has_device{is_device(sides_[0]), is_device(sides_[1])};
    controls_.set_devices(has_device);
    // a mouse leaves a hand free for the scope
    assistant_.switch_on(settings_.follows_tips.value_or(has_device[0] && has_device[1]));
    yield_to_steps();
    open_screen();
    if (!complaint_.empty()) {
      std::fprintf(stderr, "warning: %s\n", complaint_.c_str());
      warn(complaint_);
    }
  }

  int run() {
    while (!is_over()) {
      take_inputs();
      if (screen_->window.is_lost() || controls_.wishes.new_window) {
        controls_.wishes.new_window = false;
        open_screen();
      }
      const bool is_hidden = screen_->window.width() == 0 || screen_->window.height() == 0;
      if (is_hidden || pace_.is_due(clock().now())) {  // else nobody asks for a state
        take_state();
        watch_rig();
        make_sounds();
      }
      if (!is_hidden && pace_.is_due(clock().now())) {
        draw();
      }
    }
    remember_settings();
    print_summary();
    if (state().phase == Phase::failed) {
      throw pbdsurg::Error(state().message);
    }
    if (options_.is_recorded) {
      simulation_.reset();  // it asks hands no more
      std::filesystem::create_directories(options_.out);
      for (std::size_t role = 0; role < sides_.size(); ++role) {
        pbdsurg::write_device_trace(
            options_.out / (std::string(rig::name_of(sides_[role])) + ".trace"),
            recording_.traces[role]);
      }
      std::printf("wrote left.trace and right.trace to %s\n", options_.out.c_str());
    }
    return is_interrupted() ? kInterruptedStatus : 0;
  }

 private:
  [[nodiscard]] const SceneState& state() const { return simulation_->states.value(); }
  // A scene that was never there ends the program with a sentence; one that fails later shows it.
  [[nodiscard]] bool is_over() const {
    return screen_->window.is_closing() || controls_.wishes.quit || is_interrupted() ||
           (options_.pictures > 0 && pictures_ >= options_.pictures) ||
           (state().phase == Phase::failed && first_play_ == 0);
  }

  [[nodiscard]] pbdsurg::Clock& clock() { return rig_.clock(); }

  [[nodiscard]] bool feels() const {
    return description_.has(rig::Mover::arm) || description_.has(rig::Mover::trace);
  }

  // Keys and buttons on the screen are pedals of the mouse's hook, whatever holds the real one.
  Hands devices() {
    rig_.set_mouse(sides_[0], hands_[0]);
    rig_.set_mouse(sides_[1], hands_[1]);
    return {&rig_.device(sides_[0]),
            &rig_.device(sides_[1]),
            {&rig_.feet(), &hands_[1]},
            options_.is_recorded ? &recording_ : nullptr};
  }

  void begin(const SurgicalScene& scene) {
    const Rehearsal rehearsal =
        make_rehearsal(scene, {places_.tips[static_cast<std::size_t>(sides_[0])],
                               places_.tips[static_cast<std::size_t>(sides_[1])]});
    std::array<std::vector<pbdsurg::Waypoint>, 2> scripts;
    for (std::size_t role = 0; role < sides_.size(); ++role) {
      scripts[static_cast<std::size_t>(sides_[role])] = rehearsal.hands[role];
    }
    rig_.begin(scripts);
  }

  SimulationThread::Options simulation_options() {
    SimulationThread::Options options;
    options.organs = options_.organs;
    options.detail = options_.detail.value_or(settings_.detail);
    options.is_paper = options_.is_paper;
    options.executor = [name = options_.executor] {
      return pbdsurg::programs::executor_named(name);
    };
    options.on_begin = [this](const SurgicalScene& scene) { begin(scene); };
    options.on_undo = [this] { rig_.disengage(); };
    options.on_let_go = [this] { rig_.let_go(); };
    return options;
  }

  void open_screen() {
    controls_.let_go();  // the new window does not hear keys that the old one heard
    if (screen_ != nullptr) {
      remember_size();
    }
    screen_.reset();
    screen_ =
        std::make_unique<Screen>(WindowOptions{texts_.title, settings_.width, settings_.height},
                                 settings_.quality, texts_, has_understood_);
    drawn_generation_ = kNone;
    if (!rest_.empty()) {  // until a state comes
      screen_->renderer.set_surfaces(rest_);
      drawn_generation_ = 0;
    }
    seen_ = {};
    seen_.generation = kNone;
    publish_seen();
    ++windows_;
  }

  void take_inputs() {
    const double now = clock().now();
    // a hidden window, or one whose picture is not due, sleeps until something happens
    const bool is_hidden = screen_->window.width() == 0;
    screen_->window.poll(is_hidden ? 0.05 : std::clamp(pace_.next() - now, 0.0, 0.05));
    controls_.motion_scale = static_cast<float>(settings_.motion_scale);
    controls_.handle(screen_->panels.unclaimed(screen_->window.take_inputs()),
                     screen_->window.height());
    if (std::exchange(controls_.wishes.fullscreen, false)) {
      screen_->window.toggle_fullscreen();
    }
    for (MouseHand& hand : hands_) {
      hand.refresh();
    }
    simulation_->orders.draft() = orders_;
    simulation_->orders.publish();
  }

  void take_state() {
    if (simulation_->states.take() == 0) {
      return;
    }
    const SceneState& now = state();
    if (!now.whole.empty()) {
      screen_->renderer.set_surfaces(now.whole);
      drawn_generation_ = now.generation;
      if (now.generation == 0) {
        rest_ = now.whole;
      }
    } else if (now.generation == drawn_generation_) {
      for (std::size_t i = 0; i < now.changes.size(); ++i) {
        screen_->renderer.update(i, now.changes[i]);
      }
    }
    if (now.generation == drawn_generation_) {
      seen_.generation = now.generation;
      seen_.triangle_versions = now.triangle_versions;
      seen_.burn_versions = now.burn_versions;
      seen_.vertex_counts = now.vertex_counts;
    }
    seen_.sequence = simulation_->states.sequence();
    publish_seen();
    for (std::size_t i = 0; i < now.events.size(); ++i) {
      if (now.events[i] <= events_[i]) {
        continue;
      }
      const Event event = static_cast<Event>(i);
      is_alarmed_ = is_alarmed_ || event == Event::slipped || event == Event::lost;
      if (event == Event::lost) {
        controls_.reset();  // hands that are where the old scene was lost
      }
      if (texts_.events[i][0] != '\0') {
        screen_->panels.warn(texts_.events[i], clock().now());
      }
    }
    if (now.phase == Phase::playing) {
      events_ = now.events;
      solve_ms_ += now.times.solve;
      heat_ms_ += now.times.heat;
      ++states_;
    }
    guide_.update(now, controls_, scope_, clock().now());
  }

  void publish_seen() {
    simulation_->seen.draft() = seen_;
    simulation_->seen.publish();
  }

  void warn(const std::string& text) {
    screen_->panels.warn(text, clock().now());
    is_alarmed_ = true;
  }

  void watch_rig() {
    rig_.poll();
    std::vector<std::string> lines;
    for (const Side side : rig::kSides) {
      const rig::HandStatus& status = rig_.status(side);
      for (const std::string& news : rig_watch_.update(side, status)) {
        warn(news);
        std::fprintf(stderr, "%s\n", news.c_str());
      }
      if (std::string line = rig_watch_.line(side, status); !line.empty()) {
        lines.push_back(std::move(line));
      }
    }
    if (std::exchange(had_pedals_, rig_.are_pedals_connected()) && !had_pedals_) {
      warn(texts_.pedals_lost);
    }
    screen_->panels.set_hands(std::move(lines));
    if (contacts_) {
      contacts_->ages.take();
    }
  }

  void make_sounds() {
    if (sound_ == nullptr) {
      if (player_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
        return;
      }
      sound_ = player_.get();
      std::fprintf(stderr, "%s\n", sound_->status().c_str());
    }
    sound_->set_volume(static_cast<float>(settings_.volume));
    const pbdsurg::Activation activation = state().generator.activation;
    sound_->set_tone(activation == pbdsurg::Activation::cut           ? Tone::cut
                     : activation == pbdsurg::Activation::coagulation ? Tone::coagulation
                                                                      : Tone::none);
    if (state().generator.is_refused && !was_refused_) {
      sound_->play(Chime::refused);
    }
    was_refused_ = state().generator.is_refused;
    if (std::exchange(is_alarmed_, false)) {
      sound_->play(Chime::warning);
    }
  }

  void follow_tips(double now) {
    const double passed = now - std::exchange(followed_, now);
    if (state().phase == Phase::playing) {
      const std::array<Eigen::Vector3f, 2> tips{state().grasper.pose.translation(),
                                                state().hook.pose.translation()};
      assistant_.follow(scope_, tips, passed);
    }
  }

  [[nodiscard]] SceneView view() const {
    SceneView view;
    if (state().phase == Phase::playing) {
      view.tools = {draw_grasper(state().grasper.pose, state().grasper.is_closed),
                    draw_hook(state().hook.pose)};
    }
    view.sheets = state().sheets;
    view.smoke = state().smoke;
    view.haze = state().haze;
    view.camera = scope_.camera();
    return view;
  }

  void draw() {
    Screen& screen = *screen_;
    const int width = std::max(screen.window.width(), 16);
    const int height = std::max(screen.window.height(), 16);
    const double start = clock().now();
    screen.renderer.resize(width, height);
    screen.renderer.set_quality(quality_of(settings_.quality, screen.window));
    follow_tips(start);
    if (drawn_generation_ != kNone) {
      screen.renderer.draw(view(), 0);
    } else {
      glBindFramebuffer(GL_FRAMEBUFFER, 0);
      glClearColor(0, 0, 0, 1);
      glClear(GL_COLOR_BUFFER_BIT);
    }
    screen.panel_screen.begin(screen.panels, settings_.text_scale);
    screen.panels.lay_out(state(), controls_, orders_, guide_, settings_, times_, start);
    screen.panel_screen.draw();
    if (std::exchange(controls_.wishes.screenshot, false)) {
      write_screenshot(width, height);
    }
    const double drawn = clock().now();
    screen.window.show();
    if (state().phase == Phase::playing) {
      picture_ages_.add(clock().now() - state().made);
    }
    pictures_ += state().phase == Phase::playing ? 1 : 0;
    if (first_picture_ == 0 && drawn_generation_ != kNone) {
      first_picture_ = clock().now();
    }
    if (first_play_ == 0 && state().phase == Phase::playing) {
      first_play_ = clock().now();
      first_step_ = state().all_steps;
      std::printf("playing\n");
      std::fflush(stdout);
    }
    const double now = clock().now();
    times_.milliseconds += 0.1 * (1e3 * (drawn - start) - times_.milliseconds);
    drawn_s_ += first_play_ > 0 ? drawn - start : 0;
    if (last_picture_ > 0) {
      times_.per_second += 0.1 * (1 / std::max(now - last_picture_, 1e-6) - times_.per_second);
    }
    last_picture_ = now;
    pace_.drew(state().owed, start);
    watch_memory();
  }

  void write_screenshot(int width, int height) {
    Image image;
    image.width = width;
    image.height = height;
    const std::size_t row = 3 * static_cast<std::size_t>(width);
    image.rgb.resize(row * static_cast<std::size_t>(height));
    glBindFramebuffer(GL_READ_FRAMEBUFFER, 0);
    glReadBuffer(GL_BACK);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    for (int y = 0; y < height; ++y) {  // OpenGL counts rows from below
      glReadPixels(0, height - 1 - y, width, 1, GL_RGB, GL_UNSIGNED_BYTE,
                   image.rgb.data() + row * static_cast<std::size_t>(y));
    }
    char name[32];
    do {
      std::snprintf(name, sizeof name, "screenshot_%03d.png", ++screenshots_);
    } while (std::filesystem::exists(options_.out / name));
    try {
      std::filesystem::create_directories(options_.out);
      write_png(options_.out / name, image);
      screen_->panels.warn(name, clock().now());
      std::printf("%s simulated_s %.2f energy_j %.3f\n", name, state().time,
                  state().generator.energy);
      std::fflush(stdout);
    } catch (const std::exception& error) {
      warn(error.what());
    }
  }

  // Of the resident memory, at half of a play of a given length.
  void watch_memory() {
    if (options_.pictures > 0 && pictures_ == options_.pictures / 2) {
      half_memory_ = resident_bytes();
    }
  }

  static double resident_bytes() {
    long pages = 0;
    if (std::FILE* const file = std::fopen("/proc/self/statm", "r")) {
      if (std::fscanf(file, "%*d %ld", &pages) != 1) {
        pages = 0;
      }
      std::fclose(file);
    }
    return static_cast<double>(pages) * static_cast<double>(sysconf(_SC_PAGESIZE));
  }

  void remember_size() {
    const std::array<int, 2> size = screen_->window.windowed_size();
    settings_.width = std::max(size[0], 160);
    settings_.height = std::max(size[1], 120);
  }

  void remember_settings() {
    settings_.is_left_handed = controls_.is_left_handed();
    if (controls_.wants_following) {
      settings_.follows_tips = controls_.wants_following;
    }
    settings_.cut_power = orders_.cut_power;
    settings_.coagulation_power = orders_.coagulation_power;
    remember_size();
    const std::string problem = save_settings(settings_path_, settings_);
    if (!problem.empty()) {
      std::fprintf(stderr, "warning: %s\n", problem.c_str());
    }
  }

  void print_summary() {
    if (first_play_ == 0) {
      return;
    }
    std::printf("renderer %s\npictures_drawn %lld\n", screen_->window.device_name().c_str(),
                static_cast<long long>(pictures_));
    // means of the whole play
    const double played = last_picture_ - first_play_;
    const double pictures = static_cast<double>(std::max<std::int64_t>(pictures_, 1));
    const double simulated =
        Session::kTimeStep * static_cast<double>(state().all_steps - first_step_);
    std::printf("first_picture_s %.2f\nplayable_s %.2f\nsimulated_s %.2f\nrealtime_factor %.3f\n",
                first_picture_, first_play_, simulated, simulated / std::max(played, 1e-3));
    std::printf("pictures_per_s %.1f\npicture_ms %.1f\nsolve_ms %.2f\nheat_ms %.2f\nwindows %d\n",
                pictures / std::max(played, 1e-3), 1e3 * drawn_s_ / pictures,
                solve_ms_ / std::max(states_, 1.0), heat_ms_ / std::max(states_, 1.0), windows_);
    const auto count = [&](Event event) { return events_[static_cast<std::size_t>(event)]; };
    std::printf("grasped %u\nmissed %u\nundone %u\nnot_undone %u\n", count(Event::grasped),
                count(Event::missed), count(Event::undone), count(Event::no_undo));
    std::printf("energy_j %.1f\nremoved_tets %lld\nparted_strands %lld\n", state().generator.energy,
                static_cast<long long>(state().removed_tets),
                static_cast<long long>(state().parted_strands));
    print_ages();
    if (half_memory_ > 0) {
      std::printf("memory_growth_mib %.1f\n", (resident_bytes() - half_memory_) / 1048576);
    }
  }

  // How old values are where threads hand them over, and what servos missed.
  void print_ages() {
    const auto print = [](const std::string& what, const rig::AgeHistogram& ages) {
      if (ages.count() > 0) {
        std::printf("age_ms %s median %.2f p99 %.2f p999 %.2f worst %.2f of %llu\n", what.c_str(),
                    1e3 * ages.quantile(0.5), 1e3 * ages.quantile(0.99), 1e3 * ages.quantile(0.999),
                    1e3 * ages.worst(), static_cast<unsigned long long>(ages.count()));
      }
    };
    print("hand_at_step", state().hand_ages);
    if (contacts_) {
      print("hand_at_packet", contacts_->ages.value());
    }
    for (const Side side : rig::kSides) {
      const rig::HandStatus& status = rig_.status(side);
      if (status.mover != rig::Mover::mouse) {
        const std::string name = rig::name_of(side);
        print("hand_at_servo_" + name, status.servo.packet_ages);
        std::printf("servo_%s ticks %llu missed %llu\n", name.c_str(),
                    static_cast<unsigned long long>(status.servo.tick_count),
                    static_cast<unsigned long long>(status.servo.missed_count));
      }
    }
    print("state_at_picture", picture_ages_);
  }

  static constexpr std::uint32_t kNone = 0xFFFFFFFF;  // a generation that no state has

  const Texts& texts_ = kEnglish;
  PlayOptions options_;
  std::filesystem::path settings_path_;
  std::string complaint_;
  Settings settings_;
  std::array<Side, 2> sides_;  // of the grasper and the hook
  rig::RigPlaces places_ = hand_places();
  rig::RigDescription description_;
  rig::Rig rig_;
  std::array<MouseHand, 2> hands_;  // of the grasper and the hook
  HandRecording recording_;
  RigWatch rig_watch_{texts_};
  Scope scope_;
  CameraAssistant assistant_{kCentre, kScene};
  Orders orders_;
  Controls controls_;
  std::future<std::unique_ptr<SoundPlayer>> player_;  // before the window, which closes first
  std::unique_ptr<SoundPlayer> sound_;
  std::unique_ptr<ContactThread> contacts_;  // null where nobody feels
  std::unique_ptr<SimulationThread> simulation_;
  std::unique_ptr<Screen> screen_;
  Guide guide_;
  PicturePace pace_;
  PictureTimes times_;
  rig::AgeHistogram picture_ages_;  // s, of what they show
  EventCounts events_{};
  Seen seen_;
  std::uint32_t drawn_generation_ = kNone;
  bool had_pedals_ = true;
  bool has_understood_ = false, was_refused_ = false, is_alarmed_ = false;
  std::int64_t pictures_ = 0;
  int screenshots_ = 0;
  int windows_ = 0;
  std::vector<Surface> rest_;                                     // of generation 0
  double last_picture_ = 0, first_picture_ = 0, first_play_ = 0;  // s of the clock
  double followed_ = 0;                                           // s of the clock, so far
  std::int64_t first_step_ = 0;                                   // of all, at first_play_
  double drawn_s_ = 0, solve_ms_ = 0, heat_ms_ = 0, states_ = 0;  // sums
  double half_memory_ = 0;                                        // bytes
};

}  // namespace

int play(const PlayOptions& options) {
  note_interrupt();  // motors must not stay on
  quiet_openal();    // the player would later, when other threads may read the environment
  return Play(options).run();
}

}  // namespace cholecystectomy
