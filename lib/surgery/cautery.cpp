// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/surgery/cautery.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/tissue/renumbering.h"

#include "lib/base/check.h"
#include "lib/surgery/current.h"
#include "lib/surgery/electrode_contact.h"
#include "lib/surgery/heat_changes.h"
#include "lib/tissue/renumber.h"

namespace pbdsurg {
namespace {

constexpr double kLongestSubstep = 2e-3;  // s, while energised
constexpr double kBoilingShare = 0.2;     // of the time to boil
constexpr int kMostSubsteps = 32;
constexpr double kElectrodeRecovery = 20;  // s: steel of 1 cm, by conduction into the shaft

CauteryOptions checked(const Tissue& tissue, std::span<const ThermalBody> bodies,
                       const CauteryOptions& options) {
  check_positive("contact_radius", options.contact_radius, " m");
  check_not_negative("body_resistance", options.body_resistance);
  check_not_negative("electrode_cooling", options.electrode_cooling);
  check_positive("electrode_capacity", options.electrode_capacity, " J/K");
  check_positive("tearing_rate", options.tearing_rate, "/s");
  check_range("tearing_loss", options.tearing_loss, 0, 1);
  check_range("boiled_shrinkage", options.boiled_shrinkage, 0, 0.9);
  check_not_negative("shrink_limit", options.shrink_limit);
  check_positive("link_energy", options.link_energy, " J");
  check_positive("link_conductance", options.link_conductance, " S");
  if (options.model.removal == RemovalRule::water) {
    if (options.boiled_shrinkage != CauteryOptions{}.boiled_shrinkage) {
      throw InvalidArgument("boiled_shrinkage is " + describe(options.boiled_shrinkage) +
                            ", which nothing would read; it needs RemovalRule::boiled_vertices");
    }
    for (const ThermalBody& body : bodies) {
      const ThermalProperties& properties =
          options.model.tissue ? *options.model.tissue : body.properties;
      if (!(properties.water_fraction > 0)) {
        throw InvalidArgument("the tissue of body '" + tissue.body(body.body).name +
                              "' has no water; without it nothing would ever vaporise");
      }
    }
  }
  return options;
}

// Positions are held for one heat().
class PositionsRelease {
 public:
  explicit PositionsRelease(ScenePositions& positions) : positions_(positions) {}
  PositionsRelease(const PositionsRelease&) = delete;
  PositionsRelease& operator=(const PositionsRelease&) = delete;
  ~PositionsRelease() { positions_.release(); }

 private:
  ScenePositions& positions_;
};

bool is_empty(const TopologyEdit& edit) {
  return edit.remove_tets.empty() && edit.remove_triangles.empty() && edit.remove_links.empty() &&
         edit.rest_lengths.empty() && edit.rest_volumes.empty() && edit.rest_areas.empty() &&
         edit.stiffnesses.empty() && edit.triangle_stiffnesses.empty();
}

// Live ones, ascending.
std::vector<Index> elements_at(const ThermalMesh& mesh, std::span<const Index> vertices) {
  std::vector<Index> elements;
  for (const Index v : vertices) {
    check_id("vertex", v, static_cast<std::size_t>(mesh.vertex_count()));
    mesh.for_each_element(v, [&](Index e) { elements.push_back(e); });
  }
  std::ranges::sort(elements);
  elements.erase(std::unique(elements.begin(), elements.end()), elements.end());
  return elements;
}

void check_element(const ThermalMesh& mesh, Index element) {
  if (is_triangle(element)) {
    check_id("triangle", triangle_of_element(element),
             static_cast<std::size_t>(mesh.triangle_count()));
  } else {
    check_id("tet", element, mesh.tets().size());
  }
}

}  // namespace

struct Cautery::Work final : Follower {
  static constexpr const char* kWho = "a cautery";

  Work(const Tissue& tissue, std::span<const ThermalBody> bodies, const CauteryOptions& wanted)
      : field(tissue, bodies, wanted.model, wanted.heat),
        options(checked(tissue, bodies, wanted)),
        contact(tissue, bodies, options.contact_radius),
        positions(tissue),
        current(field, options, positions),
        changes(field, options),
        link_doses(tissue.links().size()) {
    tissue.add_follower(*this, FollowerRank::surgery);
  }

  void follow(const Tissue& tissue, const TissueChange& change) noexcept override;
  void undo(const Tissue& tissue, const TissueChange& change) noexcept override;
  void renumber(const Tissue& tissue, const Renumbering& ids) noexcept override;

  void touch(const Solver& solver, const Electrode& electrode, double dt, CauteryReport& report);
  void heat(const Solver& solver, const Generator& generator, double dt, CauteryReport& report);
  HeatState state(Index element) const {
    if (field.mesh().tissue_of_element(element) == kInvalidIndex) {
      return HeatState::normal;
    }
    return field.mesh().is_alive(element) ? heat_state(field, element) : HeatState::vaporised;
  }
  bool is_enough(double dose) const { return !(dose < options.link_energy); }
  bool is_full(Index link) const { return is_enough(link_doses[link]); }
  double conductance_of(const TouchedLink& link) const;
  void sum_links();
  TissueLoad close_circuit(const Solver& solver, const Generator& generator, CauteryReport& report);
  OperatingPoint drive(const Generator& generator, const TissueLoad& load) const;
  int substeps(const Generator& generator, const TissueLoad& load, double dt) const;
  void deliver(const OperatingPoint& point, const TissueLoad& load, double dt,
               CauteryReport& report);
  void step(double dt, CauteryReport& report);
  void collect_links(const Solver& solver, TopologyEdit& edit);
  void undo_links(const TissueChange& change);

  HeatField field;
  CauteryOptions options;
  ElectrodeContact contact;
  ScenePositions positions;
  Current current;
  HeatChanges changes;
  double unseen = 0;                 // s since the contact was looked for
  std::vector<double> link_doses;    // [link] J
  std::vector<Index> parting_links;  // that have taken their energy and may live
  double link_energy = 0;            // J spent
  double links_conductance = 0;      // S, of those touched that still take energy
  double electrode_energy = 0;       // J
  double electrode_temperature = kBodyTemperature;
  std::vector<double> cooling;  // [vertex_count] W, scratch: zero
  std::vector<HeatSource> sources;
};

Cautery::Cautery(const Tissue& tissue, std::span<const ThermalBody> bodies,
                 const CauteryOptions& options)
    : work_(std::make_unique<Work>(tissue, bodies, options)) {}

Cautery::~Cautery() = default;
Cautery::Cautery(Cautery&&) noexcept = default;
Cautery& Cautery::operator=(Cautery&&) noexcept = default;

const HeatField& Cautery::field() const {
  return work_->field;
}
const PotentialField& Cautery::potential() const {
  return work_->current.potential();
}
double Cautery::link_energy_spent() const {
  return work_->link_energy;
}
double Cautery::electrode_energy() const {
  return work_->electrode_energy;
}
double Cautery::removal_energy() const {
  return work_->changes.spent();
}

CauterySnapshot Cautery::snapshot() const {
  const Work& work = *work_;
  const std::span<const DueElement> due = work.changes.pending();
  return {work.field.snapshot(),     work.link_doses,  {due.begin(), due.end()},
          work.changes.spent(),      work.link_energy, work.electrode_energy,
          work.electrode_temperature};
}

void Cautery::restore(const CauterySnapshot& snapshot) {
  Work& work = *work_;
  if (snapshot.link_doses.size() != work.link_doses.size()) {
    throw InvalidArgument("the snapshot has doses of " +
                          std::to_string(snapshot.link_doses.size()) + " links; the tissue has " +
                          std::to_string(work.link_doses.size()) + " links");
  }
  for (std::size_t l = 0; l < snapshot.link_doses.size(); ++l) {
    check_not_negative(("the dose of link " + std::to_string(l)).c_str(), snapshot.link_doses[l]);
  }
  std::optional<Index> before;
  for (const DueElement& due : snapshot.due) {
    check_element(work.field.mesh(), due.element);
    if (before && due.element <= *before) {
      throw InvalidArgument("element " + std::to_string(due.element) + " follows " +
                            std::to_string(*before) + " in the snapshot; they must ascend");
    }
    before = due.element;
  }
  check_not_negative("removal_energy", snapshot.removal_energy);
  check_not_negative("link_energy", snapshot.link_energy);
  check_not_negative("electrode_energy", snapshot.electrode_energy);
  check(std::isfinite(snapshot.electrode_temperature), "electrode_temperature",
        snapshot.electrode_temperature, "finite");
  std::vector<double> doses = snapshot.link_doses;
  std::vector<Index> full_links;
  for (std::size_t l = 0; l < doses.size(); ++l) {
    if (work.is_enough(doses[l])) {
      full_links.push_back(static_cast<Index>(l));
    }
  }
  std::vector<DueElement> due = snapshot.due;
  std::vector<Index> warm = elements_at(work.field.mesh(), snapshot.heat.active);
  work.field.restore(snapshot.heat);
  // nothing is left to fail
  work.changes.restore(work.field, snapshot.removal_energy, std::move(due));
  work.current.restore(work.field, std::move(warm));
  work.contact.forget();
  work.unseen = 0;
  work.link_doses = std::move(doses);
  work.parting_links = std::move(full_links);  // those that live part in the next update
  work.link_energy = snapshot.link_energy;
  work.electrode_energy = snapshot.electrode_energy;
  work.electrode_temperature = snapshot.electrode_temperature;
}

HeatState Cautery::state(Index tet) const {
  check_id("tet", tet, work_->field.mesh().tets().size());
  return work_->state(tet);
}

HeatState Cautery::state_of_triangle(Index triangle) const {
  check_id("triangle", triangle, static_cast<std::size_t>(work_->field.mesh().triangle_count()));
  return work_->state(element_of_triangle(triangle));
}

CauteryReport Cautery::update(Solver& solver, const Electrode& electrode,
                              const std::optional<GeneratorSettings>& generator, double dt) {
  TopologyEdit edit;
  CauteryReport report = heat(solver, electrode, generator, dt, edit);
  if (!is_empty(edit)) {
    report.edit = solver.tissue().apply(edit);
    commit(report);
  }
  return report;
}

void Cautery::commit(CauteryReport& report) {
  HeatChanges& changes = work_->changes;
  changes.commit();
  report.removed_volume = changes.removed_volume();
  report.torn = changes.torn_count();
}

void Cautery::read_positions(const Solver& solver) {
  solver.tissue().check_follower(*work_, "a cautery");
  work_->positions.hold(solver);
}

CauteryReport Cautery::heat(const Solver& solver, const Electrode& electrode,
                            const std::optional<GeneratorSettings>& generator, double dt,
                            TopologyEdit& edit) {
  Work& work = *work_;
  if (!electrode.tip.allFinite() || !electrode.heel.allFinite()) {
    throw InvalidArgument("the electrode's ends must be finite");
  }
  check_positive("dt", dt, " s");
  std::optional<Generator> driven;
  if (generator) {
    driven.emplace(*generator);
  }
  solver.tissue().check_follower(work, "a cautery");
  work.positions.follow(solver);
  const PositionsRelease release(work.positions);

  CauteryReport report;
  report.resistance = std::numeric_limits<double>::infinity();
  const double in_before = work.field.ledger().in, links_before = work.link_energy;
  work.unseen += dt;
  if (driven) {
    work.touch(solver, electrode, work.unseen, report);
    work.unseen = 0;
    work.heat(solver, *driven, dt, report);
  } else {
    work.sources.clear();
    work.step(dt, report);
  }
  report.energy = work.field.ledger().in - in_before + work.link_energy - links_before;
  report.power = report.energy / dt;

  work.changes.collect(solver, work.field, dt, work.field.ledger().in, edit);
  work.collect_links(solver, edit);
  report.deferred = work.changes.deferred_count();
  return report;
}

void Cautery::Work::touch(const Solver& solver, const Electrode& electrode, double dt,
                          CauteryReport& report) {
  contact.find(solver, electrode, options.contact_radius + Current::kSparkReach, dt, positions);
  current.touch(solver, field, contact);
  report.is_disk = current.is_disk();
  report.contact_vertices = current.vertex_count();
  report.contact_area = report.contact_vertices > 0 ? contact.area() : 0;
  report.contact_links = static_cast<Index>(contact.links().size());
}

// S, 0 once a link has its energy.
double Cautery::Work::conductance_of(const TouchedLink& link) const {
  const double point_area = std::numbers::pi * options.contact_radius * options.contact_radius;
  const double share = point_area / std::max(point_area, contact.area());
  return is_full(link.link) ? 0 : options.link_conductance * link.nearness * share;
}

void Cautery::Work::sum_links() {
  links_conductance = 0;
  for (const TouchedLink& link : contact.links()) {
    links_conductance += conductance_of(link);
  }
}

OperatingPoint Cautery::Work::drive(const Generator& generator, const TissueLoad& load) const {
  return generator.drive(1 / (load.conductance + links_conductance) + options.body_resistance);
}

// Lets sparks take over where contact alone leaves the generator at its voltage limit.
TissueLoad Cautery::Work::close_circuit(const Solver& solver, const Generator& generator,
                                        CauteryReport& report) {
  TissueLoad load = current.find_load(solver, field);
  report.potential_iterations += load.iterations;
  const OperatingPoint point = drive(generator, load);
  const bool is_starved =
      point.regime == GeneratorRegime::voltage || point.regime == GeneratorRegime::open_circuit;
  if (generator.settings().mode == GeneratorMode::cut && point.may_arc && is_starved &&
      current.arc(field, contact)) {
    load = current.find_load(solver, field);
    report.potential_iterations += load.iterations;
    report.is_arcing = load.conductance > 0;
  }
  return load;
}

// So short that tissue at the contact does not boil within one.
int Cautery::Work::substeps(const Generator& generator, const TissueLoad& load, double dt) const {
  const double power = drive(generator, load).power;
  if (!(power > 0) || load.heat.empty()) {
    return 1;
  }
  const ThermalMesh& mesh = field.mesh();
  const ThermalProperties& tissue =
      mesh.tissues()[mesh.tissue_of_vertex(contact.nearest().triangle[0])];
  const double radius = options.contact_radius;
  const double boiling = 2 * std::numbers::pi * radius * radius * radius * tissue.density *
                         tissue.specific_heat * (kBoilingTemperature - kBodyTemperature) / power;
  const double longest = std::min(kLongestSubstep, kBoilingShare * boiling);
  return static_cast<int>(std::clamp(std::ceil(dt / longest), 1.0, double{kMostSubsteps}));
}

void Cautery::Work::heat(const Solver& solver, const Generator& generator, double dt,
                         CauteryReport& report) {
  sum_links();
  TissueLoad load = close_circuit(solver, generator, report);
  const int count = substeps(generator, load, dt);
  for (int i = 0; i < count; ++i) {
    if (i > 0) {
      sum_links();
      load = current.find_load(solver, field);
      report.potential_iterations += load.iterations;
    }
    report.converged = report.converged && load.converged;
    const OperatingPoint point = drive(generator, load);
    report.voltage = point.voltage;
    report.current = point.current;
    report.regime = point.regime;
    report.resistance = 1 / (load.conductance + links_conductance) + options.body_resistance;
    deliver(point, load, dt / count, report);
    step(dt / count, report);
  }
}

// Divides the current by conductance: sources in tissue, doses in links.
void Cautery::Work::deliver(const OperatingPoint& point, const TissueLoad& load, double dt,
                            CauteryReport& report) {
  sources.clear();
  const double conductance = load.conductance + links_conductance;
  if (!(conductance > 0) || !(point.current > 0)) {
    return;
  }
  const double voltage = point.current / conductance;  // across the contact
  report.generator_energy += point.power * dt;
  report.body_energy += point.current * point.current * options.body_resistance * dt;
  cooling.resize(static_cast<std::size_t>(field.mesh().vertex_count()));
  for (const auto& [vertex, area] : current.cooled()) {
    cooling[vertex] = options.electrode_cooling * area *
                      std::max(0.0, field.temperatures()[vertex] - electrode_temperature);
  }
  for (const HeatSource& unit : load.heat) {
    const double power = voltage * voltage * unit.power;
    const double into_metal = std::min(power, cooling[unit.vertex]);
    electrode_energy += into_metal * dt;
    report.electrode_energy += into_metal * dt;
    electrode_temperature += into_metal * dt / options.electrode_capacity;
    if (power > into_metal) {
      sources.push_back({unit.vertex, power - into_metal});
    }
  }
  for (const auto& [vertex, area] : current.cooled()) {
    cooling[vertex] = 0;
  }
  for (const TouchedLink& touched : contact.links()) {
    if (is_full(touched.link)) {
      continue;
    }
    double& dose = link_doses[touched.link];
    // a link takes no more than parts it
    const double offered = voltage * voltage * conductance_of(touched) * dt;
    const double energy = std::min(offered, options.link_energy - dose);
    dose += energy;
    link_energy += energy;
    report.link_energy += energy;
    report.surplus_energy += offered - energy;
    if (is_full(touched.link)) {
      parting_links.push_back(touched.link);
    }
  }
}

void Cautery::Work::step(double dt, CauteryReport& report) {
  const HeatReport stepped = field.step(dt, sources);
  current.update_conductivities(field);
  electrode_temperature = kBodyTemperature + (electrode_temperature - kBodyTemperature) *
                                                 std::exp(-dt / kElectrodeRecovery);
  ++report.substeps;
  report.heat_iterations += stepped.iterations;
  report.converged = report.converged && stepped.converged && stepped.accepted;
  report.hottest = std::max(report.hottest, stepped.hottest);
}

void Cautery::Work::collect_links(const Solver& solver, TopologyEdit& edit) {
  std::erase_if(parting_links, [&](Index l) { return !solver.tissue().is_link_alive(l); });
  std::sort(parting_links.begin(), parting_links.end());
  parting_links.erase(std::unique(parting_links.begin(), parting_links.end()), parting_links.end());
  edit.remove_links.insert(edit.remove_links.end(), parting_links.begin(), parting_links.end());
}

// Those that are back part again.
void Cautery::Work::undo_links(const TissueChange& change) {
  const auto is_gone = [&](Index l) { return l >= static_cast<Index>(link_doses.size()); };
  std::erase_if(parting_links, is_gone);
  std::ranges::copy_if(change.removed_links, std::back_inserter(parting_links),
                       [&](Index l) { return !is_gone(l) && is_full(l); });
}

void Cautery::Work::renumber(const Tissue& tissue, const Renumbering& ids) noexcept {
  contact.renumber(tissue, ids);
  current.renumber(field, ids);
  changes.renumber(field, ids);
  positions.renumber(tissue, ids);
  renumber_values(link_doses, ids.links, tissue.links().size());
  renumber_list(parting_links, ids.links);
  cooling.assign(static_cast<std::size_t>(tissue.vertex_count()), 0.0);
}

void Cautery::Work::follow(const Tissue& tissue, const TissueChange&) noexcept {
  current.follow(field);
  changes.follow(field);
  positions.resize(tissue);
  link_doses.resize(tissue.links().size());
}

void Cautery::Work::undo(const Tissue& tissue, const TissueChange& change) noexcept {
  contact.forget_links();
  current.undo(field);
  changes.undo(field);
  positions.resize(tissue);
  link_doses.resize(tissue.links().size());
  undo_links(change);
}

}  // namespace pbdsurg
