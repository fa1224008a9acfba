// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What each record of a world's file holds: visit(member...) writes and reads. All members are
/// named before some are visited, so that a new one does not compile until it is thought of here.

#include <concepts>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "pbdsurg/surgery/cautery.h"
#include "pbdsurg/surgery/connective_tissue.h"
#include "pbdsurg/tissue/topology_edit.h"

#include "lib/solver/solver_copy.h"
#include "lib/world/body_table.h"
#include "lib/world/record_bytes.h"
#include "lib/world/world_state_data.h"

namespace pbdsurg {

/// A body of a scene, with vertices numbered by themselves.
struct BodyRecord {
  std::string name;
  Material material;
  std::vector<Eigen::Vector3d> positions;  ///< [vertex_count] m
  std::vector<Tet> tets;                   ///< of particles none
  std::vector<Triangle> triangles;         ///< of a sheet
  float thickness = 0;                     ///< m, of a sheet; 0: none
  std::vector<float> stiffnesses;          ///< [tet_count or triangle_count], or none: all are 1
  std::vector<Fibre> fibres;               ///< [tet_count], or none where there are none
  double particle_mass = 0;                ///< kg; 0: not of particles
  std::vector<Index> fixed;                ///< vertices
};

/// A scene, as the calls that make it.
struct SceneRecord {
  std::vector<BodyRecord> bodies;
  std::vector<Link> links;
  std::vector<Hinge> hinges;
  Eigen::Vector3f gravity;
};

/// @throws Error  as Scene
[[nodiscard]] Scene scene_of(const SceneRecord& record);
[[nodiscard]] SceneRecord record_of(const Scene& scene);

/// Strands, and what became of them.
struct StrandsRecord {
  std::vector<Strand> strands;
  std::vector<StrandEvent> events;
};

template <>
inline constexpr auto kLast<ContactFeatures> = ContactFeatures::all;
template <>
inline constexpr auto kLast<GripState> = GripState::torn;
template <>
inline constexpr auto kLast<ElasticModel> = ElasticModel::neo_hookean;
template <>
inline constexpr auto kLast<SolverMethod> = SolverMethod::explicit_steps;
template <>
inline constexpr auto kLast<ProjectionMode> = ProjectionMode::compliance;
template <>
inline constexpr auto kLast<CoarseCorrection> = CoarseCorrection::on;
template <>
inline constexpr auto kLast<TimeIntegration> = TimeIntegration::bdf2;
template <>
inline constexpr auto kLast<MathMode> = MathMode::strict;
template <>
inline constexpr auto kLast<DeviceStrategy> = DeviceStrategy::cooperative;
template <>
inline constexpr auto kLast<PlanComposition> = PlanComposition::nested;
template <>
inline constexpr auto kLast<ColoringAlgorithm> = ColoringAlgorithm::random_disc;
template <>
inline constexpr auto kLast<GreedyOrder> = GreedyOrder::saturation;
template <>
inline constexpr auto kLast<Palette> = Palette::conflicts;
template <>
inline constexpr auto kLast<RemovalRule> = RemovalRule::boiled_vertices;
template <>
inline constexpr auto kLast<ColorRule> = ColorRule::temperature;
template <>
inline constexpr auto kLast<GeneratorMode> = GeneratorMode::known_current;
template <>
inline constexpr auto kLast<StrandLoss> = StrandLoss::without_tissue;

/// A record to write or one to read into.
template <class Record, class Type>
concept RecordOf = std::same_as<std::remove_const_t<Record>, Type>;

// options; executors are the reader's

template <RecordOf<RandomDiscOptions> Record, class Visit>
void visit_members(Record& options, Visit& visit) {
  auto& [palette, shrink] = options;
  visit(palette, shrink);
}
template <RecordOf<ColoringOptions> Record, class Visit>
void visit_members(Record& options, Visit& visit) {
  auto& [algorithm, order, disc, repair, balance, max_colors, seed, executor] = options;
  visit(algorithm, order, disc, repair, balance, max_colors, seed);
}
template <RecordOf<SpareRoom> Record, class Visit>
void visit_members(Record& spare, Visit& visit) {
  auto& [vertices, tets, edges, links] = spare;
  visit(vertices, tets, edges, links);
}
template <RecordOf<SolverOptions> Record, class Visit>
void visit_members(Record& options, Visit& visit) {
  auto& [method, mode, substeps, iterations, accuracy, longest_step, damping, over_relaxation,
         coarse_correction, integration, contact_capacity, refuses_dropped_contacts, copies,
         executor, math, device_strategy, coloring, composition, spare, convergence_interval] =
      options;
  visit(method, mode, substeps, iterations, accuracy, longest_step, damping, over_relaxation);
  visit(coarse_correction, integration, contact_capacity, refuses_dropped_contacts, copies);
  visit(math, device_strategy);
  visit(coloring, composition, spare, convergence_interval);
}

// tissue

template <RecordOf<Stiffness> Record, class Visit>
void visit_members(Record& stiffness, Visit& visit) {
  auto& [fraction, compliance] = stiffness;
  visit(fraction, compliance);
}
template <RecordOf<Material> Record, class Visit>
void visit_members(Record& material, Visit& visit) {
  auto& [density, model, stretch, volume, has_volume_constraints, youngs_modulus, poissons_ratio,
         damping, max_stretch] = material;
  visit(density, model, stretch, volume, has_volume_constraints, youngs_modulus, poissons_ratio);
  visit(damping, max_stretch);
}
template <RecordOf<DamageKinetics> Record, class Visit>
void visit_members(Record& kinetics, Visit& visit) {
  auto& [log_frequency, activation_energy] = kinetics;
  visit(log_frequency, activation_energy);
}
template <RecordOf<ThermalProperties> Record, class Visit>
void visit_members(Record& tissue, Visit& visit) {
  auto& [density, specific_heat, conductivity, water_fraction, electrical_conductivity, perfusion,
         collagen_contraction, damage, conductivity_rise, coagulated_stiffness] = tissue;
  visit(density, specific_heat, conductivity, water_fraction, electrical_conductivity, perfusion);
  visit(collagen_contraction, damage, conductivity_rise, coagulated_stiffness);
}
template <RecordOf<TissueLook> Record, class Visit>
void visit_members(Record& look, Visit& visit) {
  auto& [color, mottle, gloss, opacity, detail_size, relief, lobules, vessels] = look;
  visit(color, mottle, gloss, opacity, detail_size, relief, lobules, vessels);
}
template <RecordOf<TissueRecord> Record, class Visit>
void visit_members(Record& tissue, Visit& visit) {
  auto& [name, mechanics, heat, look] = tissue;
  visit(name, mechanics, heat, look);
}
template <RecordOf<BodyTable::Entry> Record, class Visit>
void visit_members(Record& entry, Visit& visit) {
  auto& [name, record, in_tissue, before, last_in_tissue] = entry;
  visit(name, record, in_tissue, before, last_in_tissue);
}

// scenes and edits

template <RecordOf<Fibre> Record, class Visit>
void visit_members(Record& fibre, Visit& visit) {
  auto& [direction, stiffness] = fibre;
  visit(direction, stiffness);
}
template <RecordOf<Link> Record, class Visit>
void visit_members(Record& link, Visit& visit) {
  auto& [first, second, rest_length, stiffness] = link;
  visit(first, second, rest_length, stiffness);
}
template <RecordOf<Hinge> Record, class Visit>
void visit_members(Record& hinge, Visit& visit) {
  auto& [vertices, rigidity] = hinge;
  visit(vertices, rigidity);
}
template <RecordOf<BodyRecord> Record, class Visit>
void visit_members(Record& body, Visit& visit) {
  auto& [name, material, positions, tets, triangles, thickness, stiffnesses, fibres, particle_mass,
         fixed] = body;
  visit(name, material, positions, tets, triangles, thickness, stiffnesses, fibres);
  visit(particle_mass, fixed);
}
template <RecordOf<SceneRecord> Record, class Visit>
void visit_members(Record& scene, Visit& visit) {
  auto& [bodies, links, hinges, gravity] = scene;
  visit(bodies, links, hinges, gravity);
}
template <class Visit>
void visit_members(const Scene& scene, Visit& visit) {
  visit(record_of(scene));
}
template <class Visit>
void visit_members(Scene& scene, Visit& visit) {
  SceneRecord record;
  visit(record);
  scene = scene_of(record);
}
template <RecordOf<RestLengthChange> Record, class Visit>
void visit_members(Record& change, Visit& visit) {
  auto& [edge, rest_length] = change;
  visit(edge, rest_length);
}
template <RecordOf<RestVolumeChange> Record, class Visit>
void visit_members(Record& change, Visit& visit) {
  auto& [tet, rest_volume] = change;
  visit(tet, rest_volume);
}
template <RecordOf<RestAreaChange> Record, class Visit>
void visit_members(Record& change, Visit& visit) {
  auto& [triangle, rest_area] = change;
  visit(triangle, rest_area);
}
template <RecordOf<StiffnessChange> Record, class Visit>
void visit_members(Record& change, Visit& visit) {
  auto& [tet, factor] = change;
  visit(tet, factor);
}
template <RecordOf<TriangleStiffnessChange> Record, class Visit>
void visit_members(Record& change, Visit& visit) {
  auto& [triangle, factor] = change;
  visit(triangle, factor);
}
template <RecordOf<FibreChange> Record, class Visit>
void visit_members(Record& change, Visit& visit) {
  auto& [tet, fibre] = change;
  visit(tet, fibre);
}
template <RecordOf<LinkLengthChange> Record, class Visit>
void visit_members(Record& change, Visit& visit) {
  auto& [link, rest_length] = change;
  visit(link, rest_length);
}
template <RecordOf<NewVertex> Record, class Visit>
void visit_members(Record& vertex, Visit& visit) {
  auto& [first, second, share] = vertex;
  visit(first, second, share);
}
template <RecordOf<CornerMove> Record, class Visit>
void visit_members(Record& move, Visit& visit) {
  auto& [tet, from, to] = move;
  visit(tet, from, to);
}
template <RecordOf<TriangleMove> Record, class Visit>
void visit_members(Record& move, Visit& visit) {
  auto& [triangle, from, to] = move;
  visit(triangle, from, to);
}
template <RecordOf<LinkMove> Record, class Visit>
void visit_members(Record& move, Visit& visit) {
  auto& [link, from, to] = move;
  visit(link, from, to);
}
template <RecordOf<NewTet> Record, class Visit>
void visit_members(Record& tet, Visit& visit) {
  auto& [parent, vertices] = tet;
  visit(parent, vertices);
}
template <RecordOf<TopologyEdit> Record, class Visit>
void visit_members(Record& edit, Visit& visit) {
  auto& [remove_tets, remove_triangles, remove_links, remove_bodies, rest_lengths, rest_volumes,
         rest_areas, stiffnesses, triangle_stiffnesses, fibres, link_lengths, fix_vertices,
         unfix_vertices, new_vertices, corner_moves, triangle_moves, link_moves, new_tets,
         new_links, new_bodies] = edit;
  visit(remove_tets, remove_triangles, remove_links, remove_bodies, rest_lengths, rest_volumes,
        rest_areas, stiffnesses);
  visit(triangle_stiffnesses, fibres, link_lengths);
  visit(fix_vertices, unfix_vertices, new_vertices, corner_moves, triangle_moves, link_moves);
  visit(new_tets, new_links, new_bodies);
}

// strands

template <RecordOf<Strand> Record, class Visit>
void visit_members(Record& strand, Visit& visit) {
  auto& [first_link, link_count, fibres, tear_length] = strand;
  visit(first_link, link_count, fibres, tear_length);
}
template <RecordOf<StrandEvent> Record, class Visit>
void visit_members(Record& event, Visit& visit) {
  auto& [strand, link, cause, version] = event;
  visit(strand, link, cause, version);
}
template <RecordOf<StrandsRecord> Record, class Visit>
void visit_members(Record& record, Visit& visit) {
  auto& [strands, events] = record;
  visit(strands, events);
}

// heat

template <RecordOf<ThermalModel> Record, class Visit>
void visit_members(Record& model, Visit& visit) {
  auto& [has_latent_heat, has_variable_conductivity, has_perfusion, surface_transfer,
         ambient_temperature, removal, dry_water, color, theta, tissue] = model;
  visit(has_latent_heat, has_variable_conductivity, has_perfusion, surface_transfer);
  visit(ambient_temperature, removal, dry_water, color, theta, tissue);
}
template <RecordOf<HeatOptions> Record, class Visit>
void visit_members(Record& options, Visit& visit) {
  auto& [active_rise, tolerance, most_iterations, executor, device_rows] = options;
  visit(active_rise, tolerance, most_iterations, device_rows);
}
template <RecordOf<PotentialOptions> Record, class Visit>
void visit_members(Record& options, Visit& visit) {
  auto& [region_radii, tolerance, most_iterations, conductivity_change, executor, device_rows] =
      options;
  visit(region_radii, tolerance, most_iterations, conductivity_change, device_rows);
}
template <RecordOf<CauteryOptions> Record, class Visit>
void visit_members(Record& options, Visit& visit) {
  auto& [contact_radius, body_resistance, electrode_cooling, electrode_capacity, tearing_rate,
         tearing_loss, boiled_shrinkage, shrink_limit, link_energy, link_conductance, model, heat,
         potential] = options;
  visit(contact_radius, body_resistance, electrode_cooling, electrode_capacity, tearing_rate);
  visit(tearing_loss, boiled_shrinkage, shrink_limit, link_energy, link_conductance, model, heat);
  visit(potential);
}
template <RecordOf<ThermalBody> Record, class Visit>
void visit_members(Record& burnt, Visit& visit) {
  auto& [body, properties] = burnt;
  visit(body, properties);
}
template <RecordOf<Electrode> Record, class Visit>
void visit_members(Record& electrode, Visit& visit) {
  auto& [tip, heel] = electrode;
  visit(tip, heel);
}
template <RecordOf<GeneratorSettings> Record, class Visit>
void visit_members(Record& settings, Visit& visit) {
  auto& [mode, power, current_limit, voltage_limit, duty] = settings;
  visit(mode, power, current_limit, voltage_limit, duty);
}
template <RecordOf<HeatLedger> Record, class Visit>
void visit_members(Record& ledger, Visit& visit) {
  auto& [in, sensible, latent, removed, surface, perfusion] = ledger;
  visit(in, sensible, latent, removed, surface, perfusion);
}
// of the tissue that it is restored to
template <RecordOf<HeatSnapshot> Record, class Visit>
void visit_members(Record& heat, Visit& visit) {
  auto& [temperatures, peak_temperatures, water, survival, collagen, charred, held, active, pending,
         most_warm, ledger, tissue] = heat;
  visit(temperatures, peak_temperatures, water, survival, collagen, charred, held, active);
  visit(pending, most_warm, ledger);
}
template <RecordOf<DueElement> Record, class Visit>
void visit_members(Record& due, Visit& visit) {
  auto& [element, is_torn] = due;
  visit(element, is_torn);
}
template <RecordOf<CauterySnapshot> Record, class Visit>
void visit_members(Record& cautery, Visit& visit) {
  auto& [heat, link_doses, due, removal_energy, link_energy, electrode_energy,
         electrode_temperature] = cautery;
  visit(heat, link_doses, due, removal_energy, link_energy, electrode_energy);
  visit(electrode_temperature);
}
// of a world that is recorded from its scene on
template <RecordOf<BurnerSetup> Record, class Visit>
void visit_members(Record& setup, Visit& visit) {
  auto& [tool, bodies, electrode, options, since_record, since_scene] = setup;
  visit(tool, bodies, electrode, options, since_scene);
}
template <RecordOf<BurnerSetup::Arrival> Record, class Visit>
void visit_members(Record& arrival, Visit& visit) {
  auto& [edits_before, burnt] = arrival;
  visit(edits_before, burnt);
}
template <RecordOf<BurnerState> Record, class Visit>
void visit_members(Record& burner, Visit& visit) {
  auto& [setup, settings, cautery] = burner;
  visit(setup, settings, cautery);
}

// motion

template <RecordOf<SnapshotBodyContact> Record, class Visit>
void visit_members(Record& contact, Visit& visit) {
  auto& [vertex, body, normal, force, friction, edges] = contact;
  visit(vertex, body, normal, force, friction, edges);
}
// of the tissue that it is restored to
template <RecordOf<Snapshot> Record, class Visit>
void visit_members(Record& snapshot, Visit& visit) {
  auto& [positions, velocities, tool_poses, tissue, falling, roundings, past_substep, ways,
         velocities_before, forces, contacts, body_contacts, joint_angles, tool_displacements] =
      snapshot;  // tools have `contacts`, `joint_angles` and `tool_displacements`
  visit(positions, velocities, tool_poses, falling, roundings, past_substep, ways);
  visit(velocities_before, forces, body_contacts);
}
template <RecordOf<Capsule> Record, class Visit>
void visit_members(Record& capsule, Visit& visit) {
  auto& [start, end, radius, across] = capsule;
  visit(start, end, radius, across);
}
template <RecordOf<Attachment> Record, class Visit>
void visit_members(Record& held, Visit& visit) {
  auto& [vertex, anchor, compliance, target, multiplier, color] = held;
  visit(vertex, anchor, compliance, target, multiplier, color);
}
template <RecordOf<HalfSpace> Record, class Visit>
void visit_members(Record& half_space, Visit& visit) {
  auto& [point, normal] = half_space;
  visit(point, normal);
}
template <RecordOf<ToolSurface> Record, class Visit>
void visit_members(Record& surface, Visit& visit) {
  auto& [features, friction] = surface;
  visit(features, friction);
}
template <RecordOf<ContactFeature> Record, class Visit>
void visit_members(Record& feature, Visit& visit) {
  auto& [places] = feature;
  visit(places[0], places[1], places[2]);
}
template <RecordOf<Vec3<float>> Record, class Visit>
void visit_members(Record& vector, Visit& visit) {
  auto& [x, y, z] = vector;
  visit(x, y, z);
}
template <RecordOf<RememberedContact> Record, class Visit>
void visit_members(Record& contact, Visit& visit) {
  auto& [feature, normal, force, friction] = contact;
  visit(feature, normal, force, friction);
}
// without what is of a substep
template <RecordOf<TissuePoint> Record, class Visit>
void visit_members(Record& point, Visit& visit) {
  auto& [vertices, weights] = point;
  visit(vertices, weights);
}
template <RecordOf<JawPad> Record, class Visit>
void visit_members(Record& pad, Visit& visit) {
  auto& [center, normal, along, half_length, half_width] = pad;
  visit(center, normal, along, half_length, half_width);
}
template <RecordOf<Grip> Record, class Visit>
void visit_members(Record& grip, Visit& visit) {
  auto& [pad, clamp_force, friction, tear_strength, compliance] = grip;
  visit(pad, clamp_force, friction, tear_strength, compliance);
}
template <RecordOf<GripPoint> Record, class Visit>
void visit_members(Record& point, Visit& visit) {
  auto& [at, anchor, target, multiplier, force] = point;
  visit(at, anchor, target, multiplier, force);
}
template <RecordOf<GripCorner> Record, class Visit>
void visit_members(Record& corner, Visit& visit) {
  auto& [vertex, share] = corner;
  visit(vertex, share);
}
template <RecordOf<ToolGrip> Record, class Visit>
void visit_members(Record& grip, Visit& visit) {
  auto& [limits, state, jaws, points, corners, normal, slide, slid_before, pull, slid, torn,
         let_go_now] = grip;
  visit(limits, state, jaws, points, corners, normal, slide, pull, slid, torn, let_go_now);
}
template <RecordOf<ToolCoupling> Record, class Visit>
void visit_members(Record& coupling, Visit& visit) {
  auto& [stiffness] = coupling;
  visit(stiffness);
}
template <RecordOf<ToolSpring> Record, class Visit>
void visit_members(Record& spring, Visit& visit) {
  auto& [displacement, shift, yield] = spring;
  visit(displacement);
}
template <RecordOf<ToolJoint> Record, class Visit>
void visit_members(Record& joint, Visit& visit) {
  auto& [point, axis, first_capsule, capsule_count] = joint;
  visit(point, axis, first_capsule, capsule_count);
}
template <RecordOf<JointState> Record, class Visit>
void visit_members(Record& state, Visit& visit) {
  auto& [joint, angle, target] = state;
  visit(joint, angle, target);
}
template <RecordOf<ToolContact> Record, class Visit>
void visit_members(Record& contact, Visit& visit) {
  auto& [vertices, weights, point, normal, force] = contact;
  visit(vertices, weights, point, normal, force);
}
template <RecordOf<BodyContact> Record, class Visit>
void visit_members(Record& contact, Visit& visit) {
  auto& [first, second, vertices, first_count, weights, point, normal, distance, force] = contact;
  visit(first, second, vertices, first_count, weights, point, normal, distance, force);
}
template <RecordOf<ToolState> Record, class Visit>
void visit_members(Record& tool, Visit& visit) {
  auto& [capsules, half_spaces, pose, target, attachments, placed_before, placed, placed_capsules,
         capsules_before, contacts, surface, surface_contacts, remembered, told, force, torque,
         grip, joints, is_removed, coupling, spring] = tool;
  visit(capsules, half_spaces, pose, target, attachments, surface, remembered, told, force, torque);
  visit(grip, joints, is_removed, coupling, spring);
}
template <RecordOf<DroppedContacts> Record, class Visit>
void visit_members(Record& dropped, Visit& visit) {
  auto& [at_vertices, at_surfaces, of_bodies] = dropped;
  visit(at_vertices, at_surfaces, of_bodies);
}
template <RecordOf<StepReport> Record, class Visit>
void visit_members(Record& report, Visit& visit) {
  auto& [inverted_tets, non_finite_vertices, first_non_finite, first_non_finite_copy, contacts,
         dropped_contacts, distance_residual, volume_residual, convergence, substeps, fast_tools,
         stalled] = report;
  visit(inverted_tets, non_finite_vertices, first_non_finite, first_non_finite_copy, contacts);
  visit(dropped_contacts, distance_residual, volume_residual, convergence, substeps);
  visit(fast_tools, stalled);
}
template <RecordOf<CopyFactors> Record, class Visit>
void visit_members(Record& factors, Visit& visit) {
  auto& [stiffness, density, gravity] = factors;
  visit(stiffness, density, gravity);
}
template <RecordOf<SolverMotion::OfCopy> Record, class Visit>
void visit_members(Record& copy, Visit& visit) {
  auto& [snapshot, tools, body_contacts, watched_positions, report, factors] = copy;
  visit(snapshot, tools, body_contacts, watched_positions, report, factors);
}
template <RecordOf<TissueContact> Record, class Visit>
void visit_members(Record& contact, Visit& visit) {
  auto& [thickness, friction] = contact;
  visit(thickness, friction);
}
template <RecordOf<ContactPair> Record, class Visit>
void visit_members(Record& pair, Visit& visit) {
  auto& [first, second, contact] = pair;
  visit(first, second, contact);
}
template <RecordOf<SolverMotion> Record, class Visit>
void visit_members(Record& motion, Visit& visit) {
  auto& [copies, watched_places, steps_since_convergence, gravity, body_gravities, contact_pairs] =
      motion;
  visit(copies, watched_places, steps_since_convergence, contact_pairs, gravity, body_gravities);
}

}  // namespace pbdsurg
