// SPDX-License-Identifier: Apache-2.0
#include "cuda/solver/cuda_backend.h"

#include <algorithm>
#include <array>
#include <bit>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"

#include "cuda/solver/coarse_buffers.h"
#include "cuda/solver/constraint_buffers.h"
#include "cuda/solver/device_step.h"
#include "cuda/solver/filling_buffers.h"
#include "cuda/solver/side_stream.h"
#include "cuda/solver/state_buffers.h"
#include "cuda/solver/step_graph.h"
#include "cuda/solver/step_start.h"
#include "cuda/solver/sweeps.h"
#include "cuda/solver/tool_buffers.h"
#include "cuda/solver/vertex_buffers.h"
#include "cuda/solver/word_kernels.h"
#include "cuda/stream.cuh"
#include "lib/device/stage_plan.h"
#include "lib/device/word_batches.h"
#include "lib/solver/methods/contact_stage.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/state_report.h"

namespace pbdsurg::cuda {
namespace {

// Of an edit: such as a cut through some tetrahedra, where rows of vertices follow.
constexpr std::size_t kUsualWords = 16'384, kUsualWordsOfRows = 131'072;

constexpr Index kMostCopies = 65535;  // as many blocks as a launch may have in its second direction

int current_device() {
  int device = 0;
  PBDSURG_CUDA_CHECK(cudaGetDevice(&device));
  return device;
}

std::string name_of_device(int device) {
  cudaDeviceProp properties{};
  PBDSURG_CUDA_CHECK(cudaGetDeviceProperties(&properties, device));
  return properties.name;
}

const char* name_of(DeviceStrategy strategy) {
  switch (strategy) {
    case DeviceStrategy::stream:
      return "stream";
    case DeviceStrategy::cluster:
      return "cluster";
    case DeviceStrategy::cooperative:
      return "cooperative";
    case DeviceStrategy::graph:
    case DeviceStrategy::automatic:
      break;
  }
  return "graph";
}

// Whether a kernel may be brought to the device while the one before is at work.
bool can_overlap(const StepKernels& kernels) {
  constexpr int kSince = 12030;  // graphs record it
  int runtime = 0;
  int driver = 0;
  PBDSURG_CUDA_CHECK(cudaRuntimeGetVersion(&runtime));
  PBDSURG_CUDA_CHECK(cudaDriverGetVersion(&driver));
  return kernels.code_architecture() >= 90 && runtime >= kSince && driver >= kSince;
}

class CudaBackend final : public Backend {
 public:
  explicit CudaBackend(const SolverData& data)
      : device_(current_device()),
        overlaps_(can_overlap(kernels_of(data.options))),
        takes_fillings_(data.options.mode == ProjectionMode::compliance &&
                        data.options.device_strategy != DeviceStrategy::cluster &&
                        data.options.device_strategy != DeviceStrategy::cooperative),
        state_(data) {
    const bool has_rows_to_come = moves_vertices(data.options) && data.options.spare.vertices > 0;
    shared_words_.reserve(has_rows_to_come ? kUsualWordsOfRows : kUsualWords);
    make_plan(data);
  }

  ~CudaBackend() override {  // what is at work there needs the buffers
    static_cast<void>(cudaStreamSynchronize(stream_.get()));
  }
  CudaBackend(const CudaBackend&) = delete;
  CudaBackend& operator=(const CudaBackend&) = delete;

  [[nodiscard]] const char* name() const noexcept override { return name_.c_str(); }
  [[nodiscard]] bool keeps_state() const noexcept override { return true; }
  [[nodiscard]] bool takes_fillings() const noexcept override { return takes_fillings_; }

  void start_step(SolverData& data) override {
    const CurrentDevice current(device_);
    try {
      take_over(data);
      stiffest_revision_ = data.stable_substep.revision();
      enqueue_part(data);
      while (!data.part.is_last()) {
        stream_.wait();
        if (is_stalled(data.copy_count())) {
          return;
        }
        data.go_on(take_findings(data));
        enqueue_part(data);
      }
    } catch (...) {
      is_planned_ = follows_on_ = false;  // what was taken over may be half there
      forget_recorded();
      stiffest_.reset();
      throw;
    }
  }

  StepReport finish_step(SolverState& state) override {
    const CurrentDevice current(device_);
    stream_.wait();
    const bool has_stalled = is_stalled(state.copy_count());
    if (has_stalled) {
      give_step_up(state);
    }
    StepReport report;
    const Vec3<float>* watched = watched_.get();
    stiffest_ = take_findings(state);
    if (has_stalled) {
      forget_findings(state);
    }
    for (Index i = 0; i < state.copy_count(); ++i) {
      CopyState& copy = state.copy(i);
      end_tools(copy);
      for (Eigen::Vector3f& position : copy.watched_positions) {
        position = {watched->x, watched->y, watched->z};
        ++watched;
      }
      report_copy(i, to_report(sums_.get()[i]), copy, report);
    }
    fillings_.give_back();
    return report;
  }

  // As the last step has left it, or the host where it has changed anything since.
  float stiffest(SolverData& data) override {
    if (stiffest_ && stiffest_revision_ == data.stable_substep.revision() &&
        !std::ranges::count(data.changes.state, true)) {
      return *stiffest_;
    }
    for (Index i = 0; i < data.copy_count(); ++i) {
      data.fetch_state(i);
    }
    return Backend::stiffest(data);
  }

  void fetch_state(SolverState& state, Index copy) override {
    const CurrentDevice current(device_);
    state_.fetch(state, copy, stream_.get());
  }

  void read_positions(const SolverState& /*state*/, Index copy, std::span<const Index> places,
                      std::span<Eigen::Vector3f> out) override {
    const CurrentDevice current(device_);
    state_.read(copy, places, out, stream_.get());
  }

  void ask_for_motion(std::span<const Index> places) override {
    const CurrentDevice current(device_);
    state_.ask_for_motion(places, stream_.get());
  }

  void collect_motion(Index copy, std::span<VertexMotion> out) override {
    const CurrentDevice current(device_);
    state_.collect_motion(copy, out, stream_.get());
  }

  // Plans lie on the host, and steps that run know nothing of them.
  void follow_edit(SolverData& data) noexcept override {
    Changes& changes = data.changes;
    has_grown_ = has_grown_ || changes.grown;
    try {
      const CurrentDevice current(device_);
      words_.begin();
      is_planned_ = is_planned_ && plan_.follow(data, changes, words_.last()) &&
                    sweeps_->follow(data, plan_.open_stages(), words_.last());
      vertices_.follow(data);
    } catch (...) {
      is_planned_ = false;
    }
    changes.constraints.clear();
    changes.tets.clear();
    changes.blocks.clear();
    changes.shares.clear();
    changes.rows_anew = false;
  }

  [[nodiscard]] Maker maker() const override {
    return [device = device_](const SolverData& data) {
      const CurrentDevice current(device);
      return make_backend(data);
    };
  }

  [[nodiscard]] std::size_t memory_bytes() const noexcept override {
    return state_.memory_bytes() + constraints_.memory_bytes() + tools_.memory_bytes() +
           start_.memory_bytes() + watched_places_.memory_bytes() + vertices_.memory_bytes() +
           free_pieces_.memory_bytes() + coarse_.memory_bytes() + fillings_.memory_bytes() +
           sweeps_->memory_bytes();
  }

 private:
  void make_plan(const SolverData& data) {
    const bool remembers = data.options.mode == ProjectionMode::compliance &&
                           data.options.method == SolverMethod::projection &&
                           data.options.iterations != 1;
    is_planned_ = false;
    forget_recorded();
    StageRecords records;
    plan_ = StagePlan(data, records, has_grown_);
    choose_sweeps(data, records);
    name_ = "cuda, " + name_of_device(device_) + ", " + name_of(strategy_) + ", " +
            (data.options.math == MathMode::strict ? "strict" : "fast");
    constraints_.upload(records, remembers && strategy_ != DeviceStrategy::cluster,
                        data.copy_count(), stream_.get());
    vertices_.upload(data, has_grown_, stream_.get());
    coarse_.upload(data, static_cast<std::size_t>(state_.arrays().capacity), stream_.get());
    have_rows_changed_ = true;
    is_planned_ = true;
  }

  void choose_sweeps(const SolverData& data, const StageRecords& records) {
    // once chosen, it stays, unless an edit outgrows a cluster that nobody asked for, or brings
    // what a cooperative kernel does not know
    const DeviceStrategy wanted =
        strategy_ == DeviceStrategy::automatic ? data.options.device_strategy : strategy_;
    const bool is_asked = data.options.device_strategy == DeviceStrategy::cluster;
    const bool projects = data.options.method == SolverMethod::projection;
    if (data.custom.empty() &&
        (wanted == DeviceStrategy::cluster ||
         (wanted == DeviceStrategy::automatic && projects && is_for_cluster(plan_.stages())))) {
      sweeps_ = make_cluster_sweeps(data);
      if (sweeps_->take_over(data, plan_.stages(), records, stream_.get())) {
        strategy_ = DeviceStrategy::cluster;
        return;
      }
      if (is_asked) {
        throw BackendUnavailable(
            "a cluster cannot take this solver: it needs a device of compute capability 9.0 on, a "
            "plan without joint and serial phases, and vertices that fit in the shared memory of "
            "sixteen blocks");
      }
    }
    if (data.custom.empty() && (wanted == DeviceStrategy::cooperative ||
                                (wanted == DeviceStrategy::automatic && !projects))) {
      sweeps_ = make_cooperative_sweeps(data);
      if (sweeps_->take_over(data, plan_.open_stages(), records, stream_.get())) {
        strategy_ = DeviceStrategy::cooperative;
        return;
      }
      if (strategy_ == DeviceStrategy::automatic &&
          data.options.device_strategy == DeviceStrategy::cooperative) {
        throw BackendUnavailable(
            "no cooperative kernel can take this solver: it needs vertex blocks without stiff "
            "links or explicit steps, 32 colours and 254 neighbours of a vertex at most, code "
            "for compute capability 7.0 by toolkit 12.3, and a device with room for a block of "
            "threads of each copy");
      }
    }
    strategy_ = wanted == DeviceStrategy::stream ? wanted : DeviceStrategy::graph;
    sweeps_ = make_launched_sweeps(data);
  }

  [[nodiscard]] bool is_stalled(Index copies) const {
    const std::span<const StepSums> sums(sums_.get(), static_cast<std::size_t>(copies));
    return std::ranges::any_of(sums, [](const StepSums& copy) { return copy.stalled != 0; });
  }

  // All blocks of a kernel were promised to the device at once, and one does not go on. The next
  // step asks for no such promise.
  void give_step_up(const SolverState& state) {
    bring_back_state(state_.arrays(), kept_, static_cast<std::size_t>(state.copy_count()),
                     stream_.get());
    strategy_ = DeviceStrategy::graph;
    is_planned_ = follows_on_ = false;
    const auto watched = static_cast<Index>(state.watched_places.size());
    for (Index copy = 0; copy < state.copy_count(); ++copy) {
      gather_positions(
          state_.particles(copy), watched_places_.get(),
          watched_.get() + static_cast<std::size_t>(copy) * state.watched_places.size(), watched,
          stream_.get());
      sums_.get()[copy] = {};
      sums_.get()[copy].stalled = 1;
    }
    stream_.wait();
  }

  // What happened on the host since the last step.
  void take_over(SolverData& data) {
    const Changes& changes = data.changes;
    state_.make_room(data, stream_.get());
    if (!changes.constraints.empty() || !changes.tets.empty() || !changes.blocks.empty() ||
        changes.rows_anew) {
      follow_edit(data);  // one that was broken off
    }
    if ((strategy_ == DeviceStrategy::cluster || strategy_ == DeviceStrategy::cooperative) &&
        !data.custom.empty()) {  // which no kernel of all sweeps projects
      is_planned_ = false;
    }
    if (!is_planned_) {
      words_.clear();
      make_plan(data);
    }
    vertices_.make_room(data, stream_.get());
    if (sweeps_->make_room(static_cast<std::size_t>(state_.arrays().capacity), stream_.get())) {
      forget_recorded();
    }
    add_vertex_changes(data, changes.vertices);
    coarse_.follow(data, static_cast<std::size_t>(state_.arrays().capacity), words_.last(),
                   stream_.get());
    write_changes(data);
    follows_on_ = follows_on_ && !have_rows_changed_ && changes.moved.empty() &&
                  changes.vertices.empty() && !std::ranges::count(changes.state, true);
    state_.take_over(data, stream_.get());
    free_pieces_.take_over(data, state_.arrays().capacity, stream_.get());
    fillings_.take_over(data, stream_.get());
    coarse_.set_wides(fillings_.wall_count());
    if (changes.tools || state_.arrays().capacity != tools_.vertex_room()) {
      tools_.take_over(data, state_.arrays().capacity, stream_.get());
    } else {
      tools_.follow_surfaces(data, stream_.get());
    }
    if (changes.watched) {
      watched_places_.upload(data.watched_places, stream_.get());
    }
    const auto copies = static_cast<std::size_t>(data.copy_count());
    sums_.reserve(copies);
    wrenches_.reserve(copies * data.tools.size());
    watched_.reserve(copies * data.watched_places.size());
  }

  void add_vertex_changes(const SolverData& data, std::span<const Index> places) {
    std::vector<WordChange>& words = words_.last();  // which lists none of these
    for (const Index place : places) {
      const auto first = static_cast<std::uint32_t>(place) * 4;  // words
      const float w = data.particles[place].w;
      words.push_back({DeviceArray::particles, first + 3, std::bit_cast<std::uint32_t>(w)});
      for (std::uint32_t axis = 0; axis < 3 && w == 0; ++axis) {
        words.push_back({DeviceArray::velocities, first + axis, 0});
      }
    }
  }

  void write_changes(const SolverData& data) {
    words_.begin();
    const std::span<const WordChange> words = words_.words();
    if (words.empty()) {
      return;
    }
    ArrayStarts arrays{};
    arrays.copy_count = data.copy_count();
    for (int a = 0; a < kDeviceArrayCount; ++a) {
      const auto array = static_cast<DeviceArray>(a);
      for (std::uint32_t* const start : {constraints_.start(array), vertices_.start(array),
                                         sweeps_->start(array), coarse_.start(array)}) {
        arrays.starts[a] = start != nullptr ? start : arrays.starts[a];
      }
      arrays.strides[a] = vertices_.stride(array);
    }
    for (const DeviceArray array : {DeviceArray::particles, DeviceArray::velocities}) {
      arrays.strides[static_cast<int>(array)] =
          4 * static_cast<std::size_t>(state_.arrays().capacity);
    }
    const auto start = [&](DeviceArray array) -> std::uint32_t*& {
      return arrays.starts[static_cast<int>(array)];
    };
    start(DeviceArray::particles) = reinterpret_cast<std::uint32_t*>(state_.arrays().particles);
    start(DeviceArray::velocities) = reinterpret_cast<std::uint32_t*>(state_.arrays().velocities);
    // the device reads them where they are; edits differ in size
    WordChange* const shared = shared_words_.reserve(std::bit_ceil(words.size()));
    std::ranges::copy(words, shared);
    std::size_t first = 0;
    for (const std::size_t end : words_.ends()) {
      write_words(arrays, shared + first, static_cast<Index>(end - first), stream_.get());
      first = end;
    }
    words_.clear();
    have_rows_changed_ = true;
  }

  void enqueue_part(SolverData& data) {
    const bool changes_lengths = tools_.upload(data, sums_.get(), moves_before_, stream_.get());
    enqueue(data, changes_lengths);
  }

  // The forces on tools so far, once the device has done a part of a step.
  // @return  the largest stiffest_vertex() of the copies
  float take_findings(SolverState& state) {
    const Wrench* wrench = wrenches_.get();
    float stiffest = 0;
    if (!is_stalled(state.copy_count())) {
      tools_.take_contacts(state);
    }
    for (Index i = 0; i < state.copy_count(); ++i) {
      for (ToolState& tool : state.copy(i).tools) {
        tool.force = vector_of(wrench->force);
        tool.torque = vector_of(wrench->torque);
        ++wrench;
      }
      stiffest = std::max(stiffest, std::bit_cast<float>(sums_.get()[i].stiffest));
    }
    return stiffest;
  }

  void forget_findings(SolverState& state) {
    for (Index i = 0; i < state.copy_count(); ++i) {
      for (ToolState& tool : state.copy(i).tools) {
        tool.force = tool.torque = Eigen::Vector3f::Zero();
      }
    }
    stiffest_.reset();
  }

  void enqueue(const SolverData& data, bool changes_lengths) {
    const bool has_cluster = strategy_ == DeviceStrategy::cluster;  // which has all in its program
    DeviceStep step{
        &kernels_of(data.options),
        {state_.arrays(), constraints_.arrays(), tools_.arrays(), tools_.input(),
         has_cluster ? std::span<const Stage>() : plan_.open_stages(), tools_.has_pushers(),
         tools_.has_attachments(), tools_.has_meeters(), tools_.has_grips(), tools_.has_touches(),
         vertices_.arrays(), data.part.division.sweeps, has_stiff_links(data.plan),
         free_pieces_.arrays(), coarse_.arrays(), has_cluster ? 0 : plan_.revision(),
         fillings_.arrays(), fillings_.revision()},
        {sums_.get(), wrenches_.get(), watched_.get(), watched_places_.get()},
        step_program(data.options, data.part.division),
        changes_lengths};
    if (strategy_ == DeviceStrategy::cooperative && data.part.is_first()) {
      step.start = start_.make_room(step.arrays.state, static_cast<std::size_t>(data.copy_count()));
      kept_ = step.start;
    }
    const Launch apart{stream_.get(), false, data.copy_count()};
    if (have_rows_changed_) {
      sweeps_->follow_rows(vertices_.arrays(), apart);
      coarse_.clear_residuals(stream_.get());
      have_rows_changed_ = false;
    }
    if (sweeps_->takes_whole_step(step.arrays, data.part.division.substeps, changes_lengths)) {
      step.is_whole = true;
      step.changes_lengths = false;  // which its input has, too
      step.program.division = {};    // which its input has, so that a graph serves any
      if (!follows_on_) {
        sweeps_->begin_steps(step.arrays, apart);
      }
      moves_before_ =
          (moves_before_ + data.part.division.substeps * sweeps_->moves_in_substep(step.arrays)) &
          TileArrays::kCountBits;
    }
    follows_on_ = step.is_whole;
    if (strategy_ == DeviceStrategy::stream || step.changes_lengths) {  // the latter is rare
      enqueue_step(step, *sweeps_, apart);
      return;
    }
    Recorded& recorded = recorded_[(data.part.is_first() ? 1 : 0) + (data.part.is_last() ? 2 : 0)];
    if (!recorded.is_valid || !(step == recorded.step)) {
      recorded.is_valid = false;
      recorded.graph.record(stream_.get(), [&] {
        enqueue_step(step, *sweeps_, {stream_.get(), overlaps_, data.copy_count(), &side_});
      });
      recorded.step = step;
      recorded.is_valid = true;
    }
    recorded.graph.launch(stream_.get());
  }

  void forget_recorded() {
    for (Recorded& each : recorded_) {
      each.is_valid = false;
    }
  }

  static StepReport to_report(const StepSums& sums) {
    StepReport report;
    report.inverted_tets = sums.inverted_tets;
    report.non_finite_vertices = sums.non_finite_vertices;
    if (sums.non_finite_vertices > 0) {
      report.first_non_finite = sums.first_non_finite;
    }
    report.contacts = sums.contacts;
    report.dropped_contacts = sums.dropped_contacts;
    report.distance_residual = std::bit_cast<float>(sums.distance_residual);
    report.volume_residual = std::bit_cast<float>(sums.volume_residual);
    report.stalled = sums.stalled != 0;
    return report;
  }

  int device_;
  DeviceStrategy strategy_ = DeviceStrategy::automatic;  // until it is chosen
  bool overlaps_;
  bool takes_fillings_;
  std::string name_;
  Stream stream_;
  SideStream side_;
  std::unique_ptr<Sweeps> sweeps_;
  StagePlan plan_;
  StateBuffers state_;
  StepStart start_;
  KeptState kept_;  // of the last step, if that may stall
  ConstraintBuffers constraints_;
  VertexBuffers vertices_;
  FreePieceBuffers free_pieces_;
  CoarseBuffers coarse_;
  FillingBuffers fillings_;
  ToolBuffers tools_;
  WordBatches words_;
  PinnedBuffer<WordChange> shared_words_;  // those that a step writes first
  DeviceBuffer<Index> watched_places_;
  PinnedBuffer<StepSums> sums_;    // [copy]
  std::optional<float> stiffest_;  // after the last step
  std::uint64_t stiffest_revision_ = 0;
  PinnedBuffer<Wrench> wrenches_;      // [copy][tool]
  PinnedBuffer<Vec3<float>> watched_;  // [copy][watched]
  bool is_planned_ = false;            // stages and records follow the data
  bool have_rows_changed_ = false;     // since the last step
  // Of steps that one kernel takes, see StepInput: it soon starts anew, lest that be a rare event.
  Index moves_before_ = TileArrays::kCountBits - 100;
  bool follows_on_ = false;  // the last step was such a step, and nothing has changed since
  bool has_grown_ = false;   // edits brought constraints before: plans have room for more
  struct Recorded {
    StepGraph graph;
    DeviceStep step;  // in the graph, if it is recorded
    bool is_valid = false;
  };
  std::array<Recorded, 4> recorded_;  // of parts of steps: [is first + 2 * is last]
};

}  // namespace

std::unique_ptr<Backend> make_backend(const SolverData& data) {
  try {
    check_device_code();
    if (data.copy_count() > kMostCopies) {
      throw BackendUnavailable("the CUDA backend takes " + std::to_string(kMostCopies) +
                               " copies at most; there are " + std::to_string(data.copy_count()));
    }
    return std::make_unique<CudaBackend>(data);
  } catch (const DeviceError& error) {
    throw BackendUnavailable(std::string("the CUDA backend cannot take this scene: ") +
                             error.what());
  }
}

}  // namespace pbdsurg::cuda
