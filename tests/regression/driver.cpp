// SPDX-License-Identifier: Apache-2.0
#include "tests/regression/driver.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <utility>

namespace pbdsurg::testing {
namespace {

SolverOptions options_of(SolverOptions options, const Executor& executor) {
  options.executor = executor;
  options.math = MathMode::strict;
  return options;
}

// Numbers of our own, so that hashes outlive enumerators that come and go.
int number_of(PhaseKind kind) {
  switch (kind) {
    case PhaseKind::distance:
      return 0;
    case PhaseKind::volume:
      return 1;
    case PhaseKind::joint:
      return 2;
    case PhaseKind::neo_hookean:
      return 3;
    case PhaseKind::strain_limit:
      return 4;
    case PhaseKind::vertex:
      return 5;
    case PhaseKind::attachment:
      return 6;
    case PhaseKind::contact:
      return 7;
    case PhaseKind::bending:
      return 8;
    case PhaseKind::stiff_link:
      return 9;
    case PhaseKind::custom:
      return 10;
    case PhaseKind::membrane:
      return 11;
    case PhaseKind::fibre:
      return 12;
    case PhaseKind::body_contact:
      return 13;
    case PhaseKind::grip:
      return 14;
  }
  throw std::logic_error("a phase of a kind without a number");
}

// A value to a step of its unit, so that last bits do not show.
std::int64_t rounded(double value, double step) {
  return std::llround(value / step);
}

}  // namespace

Driver::Driver(const Scene& scene, SolverOptions options, const Executor& executor)
    : solver_(scene, testing::options_of(std::move(options), executor)),
      copies_(solver_.options().copies),
      executor_(executor) {}

void Driver::follow_surface(Index body) {
  surfaces_.emplace_back(solver_.tissue(), body);
  seen_surfaces_.push_back(0);
  maps_.emplace_back();
}

void Driver::follow_pieces() {
  pieces_.emplace(solver_.tissue());
}

void Driver::fill_lumen(Index body) {
  lumen_ = std::make_shared<Lumen>(solver_.tissue(), find_cavities(solver_.tissue(), body).at(0));
  lumen_->set_reservoir(1e-5F, 300);
  solver_.add_constraints(lumen_);
}

void Driver::follow_strands(const ConnectiveTissue& strands) {
  strands_ = strands;
  solver_.tissue().add_follower(*strands_, FollowerRank::surgery);
}

void Driver::follow_heat(std::span<const ThermalBody> bodies) {
  heat_.emplace(solver_.tissue(), bodies, ThermalModel{}, HeatOptions{.executor = executor_});
}

void Driver::switch_on_cautery(std::span<const ThermalBody> bodies, CauteryOptions options) {
  options.heat.executor = options.potential.executor = executor_;
  cautery_.emplace(solver_.tissue(), bodies, options);
}

const HeatField* Driver::heat_field() const {
  return cautery_ ? &cautery_->field() : heat_ ? &*heat_ : nullptr;
}

// --- what happens
// ----------------------------------------------------------------------------------

void Driver::step(float dt) {
  note(solver_.step(dt));
}

void Driver::start_step(float dt) {
  solver_.start_step(dt);
}

void Driver::finish_step() {
  note(solver_.finish_step());
}

void Driver::edit(const TopologyEdit& edit) {
  note(solver_.tissue().apply(edit));
}

void Driver::undo() {
  solver_.tissue().undo();
  front_ = {};
  edits_.mix(-1);
}

void Driver::cut(const CutSurface& surface, CutStyle style) {
  cut(plan_cut(solver_, surface, {.style = style, .front = front_}));
}

void Driver::cut(const CutPlan& plan) {
  edit(plan.edit);
  front_ = plan.front;
}

void Driver::edit_without_crumbs(TopologyEdit change, Index smallest) {
  const Crumbs crumbs = pieces_.value().add_crumbs(solver_.tissue(), change, smallest);
  edits_.mix(crumbs.parts);
  edits_.mix(crumbs.tets);
  edit(change);
}

void Driver::tear(std::span<const BladeSweep> blades) {
  if (const TissueChange* change = strands_.value().separate(solver_, blades)) {
    note(*change);
  }
}

bool Driver::burn(const Electrode& electrode, const std::optional<GeneratorSettings>& generator,
                  double dt) {
  const CauteryReport report = cautery_.value().update(solver_, electrode, generator, dt);
  note(report);
  const TopologyEdit& request = report.edit.edit;
  if (request.remove_tets.empty() && request.remove_links.empty() && request.rest_lengths.empty() &&
      request.rest_volumes.empty()) {
    return false;
  }
  note(report.edit);
  return true;
}

void Driver::heat(double dt, std::span<const HeatSource> sources) {
  const HeatReport report = heat_.value().step(dt, sources);
  burns_.mix(report.active_vertices);
  burns_.mix(report.iterations);
  burns_.mix(report.residual);
  burns_.mix(report.hottest);
}

void Driver::compact() {
  Compaction compaction(solver_);
  compaction.build();
  const Renumbering ids = compaction.finish(solver_);
  front_ = {};
  for (const auto* list : {&ids.vertices, &ids.tets, &ids.edges, &ids.links, &ids.bodies}) {
    edits_.mix_all(*list);
  }
}

// --- what is kept of it
// ----------------------------------------------------------------------------

void Driver::note(const TissueChange& change) {
  front_ = {};
  for (const auto* list : {&change.removed_tets, &change.removed_edges, &change.removed_links,
                           &change.emptied_vertices}) {
    edits_.mix_all(*list);
  }
  edits_.mix_all(std::array{change.first_new_vertex, change.first_new_tet, change.first_new_link,
                            change.first_new_body, change.first_new_edge});
}

void Driver::note(const StepReport& report) {
  reports_.mix_all(std::array{report.inverted_tets, report.non_finite_vertices,
                              report.first_non_finite, report.first_non_finite_copy,
                              report.contacts, report.dropped_contacts.total()});
  reports_.mix(report.distance_residual);
  reports_.mix(report.volume_residual);
}

void Driver::note(const CauteryReport& report) {
  burns_.mix_all(std::array{report.contact_vertices, report.contact_links, report.torn,
                            report.deferred, Index{report.substeps},
                            Index{report.potential_iterations}, Index{report.heat_iterations}});
  burns_.mix_all(std::array{report.contact_area, report.power, report.voltage, report.current,
                            report.resistance, report.energy, report.link_energy,
                            report.electrode_energy, report.body_energy, report.surplus_energy,
                            report.generator_energy, report.hottest, report.removed_volume});
  burns_.mix(report.regime);
  burns_.mix_all(std::array{report.is_arcing, report.is_disk, report.converged});
}

// --- what there is to read
// -------------------------------------------------------------------------

void Driver::look(Record& record, int checkpoint) {
  for (Index copy = 0; copy < copies_; ++copy) {
    if (solver_.last_report(copy).non_finite_vertices > 0) {
      throw std::logic_error(record.program() + ": a vertex is not finite");
    }
    if (follows_contacts_ && solver_.body_contacts(copy).empty()) {
      throw std::logic_error(record.program() + ": no bodies touch");
    }
  }
  record.add(checkpoint, "topology", topology());
  if (!surfaces_.empty()) {
    record.add(checkpoint, "surfaces", surfaces());
  }
  if (pieces_) {
    record.add(checkpoint, "pieces", pieces());
  }
  if (strands_) {
    record.add(checkpoint, "strands", strands());
  }
  if (lumen_) {
    record.add(checkpoint, "lumen", lumen());
  }
  look_at_state(record, checkpoint);
  if (heat_field() != nullptr) {
    look_at_heat(record, checkpoint);
  }
}

// Where heat shrinks tissue, the last bits of its laws are in every position.
void Driver::look_at_state(Record& record, int checkpoint) const {
  const auto add = [&](const std::string& what, std::uint64_t hash) {
    if (cautery_) {
      record.add_of_library(checkpoint, what, hash);
    } else {
      record.add(checkpoint, what, hash);
    }
  };
  for (Index copy = 0; copy < copies_; ++copy) {
    const std::string of = copies_ == 1 ? "" : " of copy " + std::to_string(copy);
    add("state" + of, solver_.state_hash(copy));
    add("tools" + of, tools(copy));
    if (follows_contacts_) {
      add("contacts" + of, contacts(copy));
    }
  }
  add("rest values", rest_values());
  add("plan", plan());
  add("reports", reports_.value());
  add("edits", edits_.value());
}

std::uint64_t Driver::topology() const {
  Digest digest;
  digest.mix(solver_.vertex_count());
  for (Index v = 0; v < solver_.vertex_count(); ++v) {
    digest.mix(solver_.tissue().has_tissue(v));
    digest.mix(solver_.tissue().body_of_vertex(v));
  }
  digest.mix_all(solver_.tissue().tets());
  for (Index t = 0; t < static_cast<Index>(solver_.tissue().tets().size()); ++t) {
    digest.mix(solver_.tissue().is_tet_alive(t));
    digest.mix(solver_.tissue().body_of_tet(t));
    digest.mix_all(solver_.tissue().tet_edges(t));
  }
  digest.mix_all(solver_.tissue().edges());
  for (Index e = 0; e < static_cast<Index>(solver_.tissue().edges().size()); ++e) {
    digest.mix(solver_.tissue().is_edge_alive(e));
  }
  digest.mix(solver_.tissue().links().size());
  for (Index l = 0; l < static_cast<Index>(solver_.tissue().links().size()); ++l) {
    const Link& link = solver_.tissue().links()[l];
    digest.mix_all(std::array{link.first, link.second});
    digest.mix_all(
        std::array{link.rest_length, link.stiffness.fraction, link.stiffness.compliance});
    digest.mix(solver_.tissue().is_link_alive(l));
  }
  digest.mix(solver_.tissue().bodies().size());
  for (Index b = 0; b < static_cast<Index>(solver_.tissue().bodies().size()); ++b) {
    const Body& body = solver_.tissue().body(b);
    digest.mix_all(body.name);
    digest.mix_all(
        std::array{body.first_vertex, body.vertex_count, body.first_tet, body.tet_count});
    digest.mix(solver_.tissue().is_body_alive(b));
  }
  return digest.value();
}

std::uint64_t Driver::rest_values() const {
  Digest digest;
  for (Index e = 0; e < static_cast<Index>(solver_.tissue().edges().size()); ++e) {
    const Material& material =
        solver_.tissue()
            .body(solver_.tissue().body_of_vertex(solver_.tissue().edges()[e][0]))
            .material;
    if (solver_.tissue().is_edge_alive(e) && material.model == ElasticModel::springs) {
      digest.mix(solver_.rest_length(e));
    }
  }
  for (Index t = 0; t < static_cast<Index>(solver_.tissue().tets().size()); ++t) {
    const Material& material = solver_.tissue().body(solver_.tissue().body_of_tet(t)).material;
    if (solver_.tissue().is_tet_alive(t) &&
        (material.model == ElasticModel::neo_hookean || material.has_volume_constraints)) {
      digest.mix(solver_.rest_volume(t));
    }
  }
  return digest.value();
}

std::uint64_t Driver::plan() const {
  Digest digest;
  for (const Phase& phase : solver_.plan().phases) {
    digest.mix(number_of(phase.kind));
    digest.mix_all(std::array{phase.color, phase.level, phase.domain});
    digest.mix(phase.serial);
  }
  return digest.value();
}

// And what else a copy has beside positions and velocities.
std::uint64_t Driver::tools(Index copy) const {
  Digest digest;
  const Snapshot snapshot = solver_.snapshot(copy);
  for (Index tool = 0; tool < static_cast<Index>(snapshot.tool_poses.size()); ++tool) {
    digest.mix_all(solver_.tool_force(ToolId(tool), copy));
    digest.mix_all(snapshot.tool_poses[tool].matrix().reshaped());
  }
  for (const Eigen::Vector3f& rounding : snapshot.roundings) {
    digest.mix_all(rounding);
  }
  digest.mix_all(snapshot.falling);
  digest.mix_all(solver_.watched_positions(copy));
  return digest.value();
}

std::uint64_t Driver::contacts(Index copy) const {
  Digest digest;
  for (const BodyContact& contact : solver_.body_contacts(copy)) {
    digest.mix_all(std::array{contact.first, contact.second, Index{contact.first_count}});
    digest.mix_all(contact.vertices);
    digest.mix_all(contact.weights);
    digest.mix_all(contact.normal);
    digest.mix(contact.distance);
    digest.mix_all(contact.force);
  }
  const auto tool_count = static_cast<Index>(solver_.snapshot(copy).tool_poses.size());
  for (Index i = 0; i < tool_count; ++i) {
    const ToolId tool(i);
    digest.mix_all(solver_.tool_torque(tool, copy));
    digest.mix_all(solver_.tool_displacement(tool, copy));
    for (const ToolContact& contact : solver_.tool_contacts(tool, copy)) {
      digest.mix_all(contact.vertices);
      digest.mix_all(contact.weights);
      digest.mix_all(contact.normal);
      digest.mix_all(contact.force);
    }
    const GripReport grip = solver_.tool_grip(tool, copy);
    digest.mix(grip.state);
    digest.mix(grip.slid);
    digest.mix_all(grip.pull);
    for (const GraspedPoint& point : grip.points) {
      digest.mix_all(point.anchor);
      digest.mix_all(point.force);
    }
  }
  return digest.value();
}

// Triangles by slot, and which slots changed since the last look.
std::uint64_t Driver::surfaces() {
  Digest digest;
  for (std::size_t i = 0; i < surfaces_.size(); ++i) {
    const LiveSurface& surface = surfaces_[i];
    digest.mix_all(surface.triangles());
    for (const TetFace& origin : surface.origins()) {
      digest.mix_all(std::array{origin.tet, origin.face});
    }
    for (Index v = 0; v < solver_.vertex_count(); ++v) {
      digest.mix(surface.is_on_surface(v));
    }
    std::vector<SlotRange> changes;
    surface.collect_changes(seen_surfaces_[i], changes);
    seen_surfaces_[i] = surface.version();
    for (const SlotRange& range : changes) {
      digest.mix_all(std::array{range.first, range.end});
    }
  }
  return digest.value();
}

std::uint64_t Driver::lumen() const {
  Digest digest;
  for (const Triangle& triangle : lumen_->cavity().triangles()) {
    digest.mix_all(triangle);
  }
  digest.mix(lumen_->cavity().hole_count());
  for (Index copy = 0; copy < copies_; ++copy) {
    digest.mix(lumen_->state(copy).amount);
    digest.mix(lumen_->pressure(copy));
  }
  return digest.value();
}

std::uint64_t Driver::pieces() const {
  Digest digest;
  digest.mix(pieces_->count());
  digest.mix(pieces_->first_freed());
  for (Index piece = 0; piece < pieces_->count(); ++piece) {
    digest.mix(pieces_->body(piece));
    digest.mix(pieces_->is_anchored(piece));
    digest.mix_all(pieces_->tets(piece));
  }
  return digest.value();
}

std::uint64_t Driver::strands() const {
  Digest digest;
  for (Index i = 0; i < static_cast<Index>(strands_->strands().size()); ++i) {
    const Strand& strand = strands_->strands()[i];
    digest.mix_all(std::array{strand.first_link, strand.link_count, strand.fibres});
    digest.mix(strand.tear_length);
    digest.mix(strands_->is_whole(i));
  }
  digest.mix(strands_->whole_count());
  for (const StrandEvent& event : strands_->events()) {
    digest.mix_all(std::array{event.strand, event.link});
    digest.mix(event.cause);
  }
  return digest.value();
}

void Driver::look_at_heat(Record& record, int checkpoint) {
  const HeatField& field = *heat_field();
  const ThermalMesh& mesh = field.mesh();
  Digest geometry;
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    const bool conducts = mesh.tissue_of_vertex(v) != kInvalidIndex;
    geometry.mix_all(conducts ? mesh.rest_positions()[v] : Eigen::Vector3d::Zero());
    geometry.mix(mesh.tissue_of_vertex(v));
    geometry.mix_all(std::array{mesh.mass(v), mesh.surface_share(v)});
  }
  for (Index t = 0; t < mesh.tet_count(); ++t) {
    geometry.mix(mesh.is_alive(t));
    geometry.mix(mesh.tissue_of_element(t));
    geometry.mix(mesh.volume(t));
    geometry.mix_all(mesh.edge_coefficients(t));
  }
  geometry.mix(mesh.sliver_count());
  record.add(checkpoint, "heat mesh", geometry.value());

  Digest bits, roughly;
  for (const auto& [values, step] : {std::pair(field.temperatures(), 1e-3),
                                     {field.peak_temperatures(), 1e-3},
                                     {field.water(), 1e-6},
                                     {field.survival(), 1e-6},
                                     {field.collagen(), 1e-6},
                                     {field.charred(), 1e-6}}) {
    bits.mix_all(values);
    for (const double value : values) {
      roughly.mix(rounded(value, step));
    }
  }
  bits.mix_all(field.active_vertices());
  const HeatLedger& ledger = field.ledger();
  bits.mix_all(std::array{ledger.in, ledger.sensible, ledger.latent, ledger.removed, ledger.surface,
                          ledger.perfusion});
  bits.mix(burns_.value());
  if (cautery_) {
    for (Index t = 0; t < mesh.tet_count(); ++t) {
      roughly.mix(cautery_->state(t));
    }
    bits.mix_all(std::array{cautery_->link_energy_spent(), cautery_->electrode_energy(),
                            cautery_->removal_energy()});
  }
  const SurfaceFields fields{field.temperatures(), field.survival(), field.water(),
                             field.charred()};
  for (std::size_t i = 0; i < surfaces_.size(); ++i) {
    maps_[i].update(surfaces_[i], fields);
    bits.mix_all(maps_[i].temperatures());
    for (const BurnBytes& marks : maps_[i].marks()) {
      bits.mix_all(std::array{marks.white, marks.brown, marks.charred});
    }
  }
  record.add(checkpoint, "heat roughly", roughly.value());
  record.add_of_library(checkpoint, "heat", bits.value());
}

}  // namespace pbdsurg::testing
