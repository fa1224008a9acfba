// SPDX-License-Identifier: Apache-2.0
// Programs over all that the library does to tissue, each of which must leave the hashes that a
// file of this folder has of it: state_hashes.txt those that follow from IEEE arithmetic, on any
// machine and with any compiler; library_hashes.txt those in which the last bits of exp(), atan()
// and such are, which only the C library that wrote it gives again. A change that means to change
// results writes both anew, and says so:
//
//   build/release/bin/regression_tests "[write]"
#include <algorithm>
#include <array>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include "tests/regression/programs.h"
#include "tests/regression/record.h"
#include "tests/support/catch.h"
#include "tests/support/skip.h"

namespace pbdsurg {
namespace {

using testing::HashFile;
using testing::Program;
using testing::Record;

const std::string kStateHashes = PBDSURG_REGRESSION_FOLDER "/state_hashes.txt";
const std::string kLibraryHashes = PBDSURG_REGRESSION_FOLDER "/library_hashes.txt";

std::vector<Program> all_programs() {
  std::vector<Program> all = testing::mechanics_programs();
  for (std::vector<Program>& more : std::array{
           testing::contact_programs(), testing::edit_programs(), testing::surgery_programs()}) {
    std::ranges::move(more, std::back_inserter(all));
  }
  return all;
}

Record run(const Program& program, const Executor& executor) {
  Record record(program.name);
  program.run(executor, record);
  return record;
}

}  // namespace

// Would catch any bit that a change of structure moves: positions and velocities, ids, rest values,
// the order of work, forces, heat, surfaces, pieces, strands; on one thread or many.
TEST_CASE("regression: every program leaves the hashes of the files", "[long]") {
  const Executor executor =
      GENERATE(executor::serial(), executor::threads(2), executor::threads(3));
  const HashFile state = testing::read_hashes(kStateHashes);
  const HashFile library = testing::read_hashes(kLibraryHashes);
  const bool is_same_library = library.library == testing::math_library_digest();
  for (const Program& program : all_programs()) {
    INFO(executor.name());
    const Record record = run(program, executor);
    CHECK(testing::first_difference(program.name, record.arithmetic(), state.hashes) == "");
    if (is_same_library) {
      CHECK(testing::first_difference(program.name, record.library(), library.hashes) == "");
    }
  }
}

// Says where the test above could not compare all.
TEST_CASE("regression: this C library is that of the hashes", "[library]") {
  const HashFile file = testing::read_hashes(kLibraryHashes);
  if (file.library != testing::math_library_digest()) {
    testing::skip(
        "this C library rounds exp(), atan() and such otherwise than the one that wrote " +
        std::string(kLibraryHashes));
  }
}

// Would catch hashes that no program checks any more.
TEST_CASE("regression: the files name no program that there is not", "[unit]") {
  std::set<std::string> names;
  for (const Program& program : all_programs()) {
    CHECK(names.insert(program.name).second);
  }
  for (const std::string& path : {kStateHashes, kLibraryHashes}) {
    for (const auto& [name, hash] : testing::read_hashes(path).hashes) {
      INFO(path << ": " << name);
      CHECK(names.contains(name.substr(0, name.find('/'))));
    }
  }
}

// Not run unless it is asked for.
TEST_CASE("regression: the files are written anew", "[.][write]") {
  HashFile state, library;
  library.library = testing::math_library_digest();
  for (const Program& program : all_programs()) {
    const Record record = run(program, {});
    state.hashes.insert(record.arithmetic().begin(), record.arithmetic().end());
    library.hashes.insert(record.library().begin(), record.library().end());
  }
  testing::write_hashes(kStateHashes, "strict state hashes: see regression_test.cpp", state);
  testing::write_hashes(kLibraryHashes,
                        "hashes with the last bits of a C library's functions: see "
                        "regression_test.cpp",
                        library);
}

}  // namespace pbdsurg
