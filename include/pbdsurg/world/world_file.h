// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Worlds in files: a moment of an operation, to start from another day.
///
///     world.record();                               // before the first edit
///     ...
///     world.record();                               // again, so that a burn goes on to the bit
///     write_world("dissected.world", world.save());
///
///     World world = read_world("dissected.world");  // in another run of the same build
///
/// A file is of one build of the library: build_id() is in it, and another refuses it with a
/// sentence. It has the scene, all edits since, and the moment: see World::save(), for what is not
/// in it, too. What follows the tissue on a program's side, surfaces and pieces are asked for anew.

#include <filesystem>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/executor.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/world/world.h"

namespace pbdsurg {

/// Writes a state of a world, at once: see write_file(). A state does not change, so another thread
/// may write while the world steps.
///
/// Size: for a vertex, some 30 bytes of the scene, 40 of each replica, 12 more of one with forces,
/// 24 more where steps are of second order, and 48 of each cautery; for a tetrahedron, 16 bytes;
/// and the edits.
/// @throws InvalidArgument  if the state is of no world; or if World::record() was first called
///                          after an edit, or a compaction has come, for a file has the scene as it
///                          was before all edits
/// @throws FileError        as write_file()
PBDSURG_API void write_world(const std::filesystem::path& path, const WorldState& state);

/// The world of a file, as World(const WorldState&) makes it of a state, with the ids that it had.
/// On a host it goes on with the same bits as the world that was saved; under current, too, if no
/// step came between World::record() and World::save(), else as save() says. On an executor of
/// another kind so in MathMode::strict, as long as a host computes the heat; in MathMode::fast bits
/// are those of one instruction set. It is recorded: save() and write_world() go on from there. No
/// edit before can be taken back.
///
/// Cost: that of making its solver, and of all edits: 56 ms for 1,000 of a cautery, on a core of a
/// Xeon; of hinges their number times the tetrahedra of their bodies, 0.4 s for 3,528 of 16,464.
/// @param executor  does the work of all parts; nobody: as SolverOptions::executor
/// @throws FileError           naming the file, the byte and the rule, if it is of another kind,
///                             version or build, is not whole, or was changed
/// @throws BackendUnavailable  if the executor is a device that cannot step it
/// @throws Error               if a device fails
[[nodiscard]] PBDSURG_API World read_world(const std::filesystem::path& path,
                                           const Executor& executor = {});

}  // namespace pbdsurg
