// SPDX-License-Identifier: Apache-2.0
// Worlds in files. A file is, little-endian: magic, version of the format, bytes of the file, build
// id; sections, each with its name and size; the checksum of all before it.
#include "pbdsurg/world/world_file.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "pbdsurg/base/version.h"
#include "pbdsurg/base/write_file.h"

#include "lib/base/check.h"
#include "lib/base/checksum.h"
#include "lib/tissue/sheet.h"
#include "lib/world/file_records.h"
#include "lib/world/world_bytes.h"

namespace pbdsurg {

Scene scene_of(const SceneRecord& record) {
  Scene scene;
  const auto add = [&](const BodyRecord& body) {
    if (body.particle_mass > 0) {
      return scene.add_particles(body.name, body.positions, body.particle_mass);
    }
    if (body.thickness != 0) {  // whose hinges are among all others
      return scene.append_sheet(body.name, body.positions, body.triangles,
                                {.thickness = body.thickness,
                                 .density = body.material.density,
                                 .youngs_modulus = body.material.youngs_modulus,
                                 .poissons_ratio = body.material.poissons_ratio,
                                 .damping = body.material.damping});
    }
    return scene.add_body(body.name, TetMesh(body.positions, body.tets), body.material);
  };
  for (const BodyRecord& body : record.bodies) {
    const Index id = add(body);
    scene.fix_vertices(id, body.fixed);
    if (!body.stiffnesses.empty()) {
      scene.set_stiffnesses(id, body.stiffnesses);
    }
    if (!body.fibres.empty()) {
      scene.set_fibres(id, body.fibres);
    }
  }
  std::ranges::for_each(record.links, [&](const Link& link) { scene.add_link(link); });
  std::ranges::for_each(record.hinges, [&](const Hinge& hinge) { scene.add_hinge(hinge); });
  scene.set_gravity(record.gravity);
  return scene;
}

SceneRecord record_of(const Scene& scene) {
  SceneRecord record;
  for (const Body& body : scene.bodies()) {
    const auto first = static_cast<std::size_t>(body.first_vertex);
    const auto positions =
        scene.positions().subspan(first, static_cast<std::size_t>(body.vertex_count));
    BodyRecord own;
    own.name = body.name;
    own.material = body.material;
    own.positions.assign(positions.begin(), positions.end());
    for (Index t = body.first_tet; t < body.first_tet + body.tet_count; ++t) {
      Tet tet = scene.tets()[t];
      std::ranges::for_each(tet, [&](Index& v) { v -= body.first_vertex; });
      own.tets.push_back(tet);
    }
    own.thickness = body.thickness;
    for (Triangle triangle : scene.triangles().subspan(body.first_triangle, body.triangle_count)) {
      std::ranges::for_each(triangle, [&](Index& v) { v -= body.first_vertex; });
      own.triangles.push_back(triangle);
    }
    const auto stiffnesses =
        is_sheet(body)
            ? scene.triangle_stiffnesses().subspan(body.first_triangle, body.triangle_count)
            : scene.stiffnesses().subspan(body.first_tet, body.tet_count);
    if (std::ranges::any_of(stiffnesses, [](float factor) { return factor != 1; })) {
      own.stiffnesses.assign(stiffnesses.begin(), stiffnesses.end());
    }
    const auto fibres =
        scene.fibres().subspan(static_cast<std::size_t>(body.first_tet), own.tets.size());
    if (std::ranges::any_of(fibres, [](const Fibre& fibre) { return fibre.stiffness > 0; })) {
      own.fibres.assign(fibres.begin(), fibres.end());
    }
    if (body.tet_count == 0 && !is_sheet(body) && body.vertex_count > 0) {
      own.particle_mass = scene.masses()[first];
    }
    for (Index v = 0; v < body.vertex_count; ++v) {
      if (scene.is_fixed(body.first_vertex + v)) {
        own.fixed.push_back(v);
      }
    }
    record.bodies.push_back(std::move(own));
  }
  record.links.assign(scene.links().begin(), scene.links().end());
  record.hinges.assign(scene.hinges().begin(), scene.hinges().end());
  record.gravity = scene.gravity();
  return record;
}

namespace {

constexpr std::array<char, 8> kMagic{'P', 'B', 'D', 'W', 'O', 'R', 'L', 'D'};
constexpr std::uint32_t kFormatVersion = 12;
constexpr std::size_t kSizeOffset = kMagic.size() + sizeof(kFormatVersion);
constexpr std::size_t kHeadBytes = kSizeOffset + sizeof(std::uint64_t);
constexpr std::size_t kChecksumBytes = sizeof(std::uint64_t);

template <class Record>
void write_section(RecordWriter& writer, const std::string& name, const Record& record) {
  writer(name);
  const std::size_t size_offset = writer.bytes().size();
  writer(std::uint64_t{0}, record);
  writer.write_at(size_offset, writer.bytes().size() - size_offset - sizeof(std::uint64_t));
}

// What a section has is checked where it is used: that refuses it by name.
template <class Record>
Record read_section(RecordReader& reader, const std::string& name) {
  const auto found = reader.next<std::string>();
  if (found != name) {
    reader.fail("has a section '" + found + "'; it must be '" + name + "'");
  }
  RecordReader section = reader.part(reader.next<std::uint64_t>());
  try {
    auto record = section.next<Record>();
    section.expect_end();
    return record;
  } catch (const InvalidArgument& refusal) {
    section.fail("section '" + name + "': " + refusal.what());
  } catch (const InvalidMesh& refusal) {
    section.fail("section '" + name + "': " + refusal.what());
  }
}

// @return  a reader of what follows the build id
RecordReader checked_head(const Source& file) {
  const std::string_view bytes = file.bytes;
  RecordReader whole(file.path, bytes, 0, bytes.size());
  if (!bytes.starts_with(std::string_view(kMagic.data(), kMagic.size()))) {
    whole.fail("does not begin as a world does: PBDWORLD");
  }
  static_cast<void>(whole.next<std::array<char, kMagic.size()>>());
  const auto version = whole.next<std::uint32_t>();
  if (version != kFormatVersion) {
    whole.fail("has version " + std::to_string(version) + " of the format; this library reads " +
               std::to_string(kFormatVersion));
  }
  const auto size = whole.next<std::uint64_t>();
  if (size != bytes.size() || size < kHeadBytes + kChecksumBytes) {
    whole.fail("is to have " + std::to_string(size) + " bytes, and has " +
               std::to_string(bytes.size()) + "; it must be whole");
  }
  const std::size_t end = bytes.size() - kChecksumBytes;
  RecordReader sum(file.path, bytes, end, bytes.size());
  if (sum.next<std::uint64_t>() != checksum(bytes.substr(0, end))) {
    sum.fail("the checksum is not that of the bytes before it: the file was changed");
  }
  RecordReader reader(file.path, bytes, kHeadBytes, end);
  const auto build = reader.next<std::string>();
  if (build != build_id()) {
    reader.fail("was written by pbdsurg " + build + "; this is " + build_id() +
                ", and a world goes on with the same bits only on the build that wrote it");
  }
  return reader;
}

}  // namespace

/// Has access to what a state and a world are made of.
class WorldFile {
 public:
  static std::string bytes_of(const WorldState& state);
  static World read(const Source& file, const Executor& executor);

 private:
  static World make(RecordReader& reader, const Executor& executor);
};

std::string WorldFile::bytes_of(const WorldState& written) {
  if (written.data_ == nullptr) {
    throw InvalidArgument("the state is of no world");
  }
  const WorldState::Data& state = *written.data_;
  const World::Origin& origin = *state.origin;
  if (origin.scene == nullptr) {
    throw InvalidArgument(
        "a file has the scene as it was before all edits, and this state does not know it: "
        "record() was first called after an edit, or a compaction has come");
  }
  RecordWriter writer;
  writer(kMagic, kFormatVersion, std::uint64_t{0}, std::string(build_id()));
  write_section(writer, "options", origin.options);
  write_section(writer, "scene", *origin.scene);
  std::vector<TopologyEdit> edits;
  for (const EditJournal::Edits* const some : {&origin.edits_of_scene, &state.edits}) {
    for (const auto& edit : *some) {
      edits.push_back(*edit);
    }
  }
  write_section(writer, "edits", edits);
  const auto strands = state.strands.strands();
  const auto events = state.strands.events();
  write_section(writer, "strands",
                StrandsRecord{{strands.begin(), strands.end()}, {events.begin(), events.end()}});
  const auto bodies = state.bodies.entries();
  write_section(writer, "bodies", std::vector<BodyTable::Entry>(bodies.begin(), bodies.end()));
  write_section(writer, "cauteries", state.burners);
  write_section(writer, "motion", state.motion);
  writer.write_at(kSizeOffset, writer.bytes().size() + kChecksumBytes);
  writer(checksum(writer.bytes()));
  return writer.bytes();
}

World WorldFile::make(RecordReader& reader, const Executor& executor) {
  auto options = read_section<SolverOptions>(reader, "options");
  auto scene = std::make_shared<const Scene>(read_section<Scene>(reader, "scene"));
  const auto edits = read_section<std::vector<TopologyEdit>>(reader, "edits");
  auto strands = read_section<StrandsRecord>(reader, "strands");
  auto bodies = read_section<std::vector<BodyTable::Entry>>(reader, "bodies");
  auto burners = read_section<std::vector<BurnerState>>(reader, "cauteries");
  auto motion = read_section<SolverMotion>(reader, "motion");
  reader.expect_end();

  check_id("replica", std::int64_t{options.copies} - 1, motion.copies.size());
  for (const SolverMotion::OfCopy& copy : motion.copies) {  // before they take memory
    if (copy.snapshot.positions.size() < static_cast<std::size_t>(scene->vertex_count())) {
      throw InvalidArgument("a replica has " + std::to_string(copy.snapshot.positions.size()) +
                            " positions; its scene has " + std::to_string(scene->vertex_count()) +
                            " vertices");
    }
  }
  options.executor = executor;
  if (!executor || executor.kind() != ExecutorKind::device) {
    options.device_strategy = DeviceStrategy::automatic;
  }
  Tissue tissue(*scene);
  const Solver solver(tissue, options);
  auto data = std::make_shared<WorldState::Data>();
  data->origin = World::Origin::of(executor, solver, std::move(scene), {});
  for (const TopologyEdit& edit : edits) {
    data->edits.push_back(std::make_shared<const TopologyEdit>(edit));
  }
  for (const BodyTable::Entry& entry : bodies) {
    check_thermal_properties(entry.record.heat);
  }
  std::size_t before = 0;
  std::set<Index> burnt;
  for (BurnerState& burner : burners) {
    const std::size_t edits_before = burner.setup.since_scene.edits_before;
    if (edits_before < before || edits_before > edits.size()) {
      throw InvalidArgument("a cautery came after " + std::to_string(edits_before) +
                            " edits; it must be in [" + std::to_string(before) + ", " +
                            std::to_string(edits.size()) + "]");
    }
    before = edits_before;
    check_id("tool", burner.setup.tool, motion.copies.front().tools.size());
    if (motion.copies.front().tools[burner.setup.tool].is_removed) {
      throw InvalidArgument("a cautery is at tool " + std::to_string(burner.setup.tool.value) +
                            ", which was removed");
    }
    const Electrode& electrode = burner.setup.electrode;
    if (!electrode.tip.allFinite() || !electrode.heel.allFinite()) {
      throw InvalidArgument("the electrode's ends must be finite");
    }
    for (const BodyId body : burner.setup.bodies) {
      check_id("body", body, bodies.size());
      if (!burnt.insert(static_cast<Index>(body)).second) {
        throw InvalidArgument("body " + std::to_string(static_cast<Index>(body)) +
                              " is burnt by two cauteries");
      }
    }
    for (Executor* const each :
         {&burner.setup.options.heat.executor, &burner.setup.options.potential.executor}) {
      *each = heat_executor(options.math, executor.or_else(solver.options().executor));
    }
    burner.setup.since_record = burner.setup.since_scene;
    if (burner.settings) {
      static_cast<void>(Generator(*burner.settings));
    }
  }
  data->bodies = BodyTable(std::move(bodies));
  data->burners = std::move(burners);
  data->motion = std::move(motion);
  WorldState state;
  state.data_ = std::move(data);
  World world(state);
  World::Data& made = *world.data_;
  for (const BodyTable::Entry& entry : made.bodies.entries()) {
    for (const Index body : {entry.in_tissue, entry.last_in_tissue}) {
      if (body != kInvalidIndex) {
        check_id("body of the tissue", body, made.tissue->bodies().size());
      }
    }
  }
  made.strands =
      ConnectiveTissue(std::move(strands.strands), std::move(strands.events), *made.tissue);
  made.tissue->add_follower(made.strands, FollowerRank::surgery);
  return world;
}

World WorldFile::read(const Source& file, const Executor& executor) {
  RecordReader reader = checked_head(file);
  try {
    return make(reader, executor);
  } catch (const InvalidArgument& refusal) {
    reader.fail(std::string("the world cannot be made: ") + refusal.what());
  } catch (const std::bad_alloc&) {
    reader.fail("the world takes more memory than there is");
  } catch (const std::length_error&) {
    reader.fail("the world takes more memory than there can be");
  }
}

void write_world(const std::filesystem::path& path, const WorldState& state) {
  write_file(path, WorldFile::bytes_of(state));
}

World world_of_bytes(const Source& file, const Executor& executor) {
  return WorldFile::read(file, executor);
}

World read_world(const std::filesystem::path& path, const Executor& executor) {
  return world_of_bytes(read_source(path), executor);
}

}  // namespace pbdsurg
