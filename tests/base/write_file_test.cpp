// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/base/write_file.h"

#include <algorithm>
#include <ostream>

#include <sys/stat.h>

#include "pbdsurg/base/error.h"

#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"

namespace pbdsurg {

using testing::ContainsSubstring;
using testing::read_bytes;
using testing::TemporaryFolder;
namespace fs = std::filesystem;

TEST_CASE("write file: bytes appear under the name, nothing beside them", "[unit]") {
  const TemporaryFolder folder;
  const std::string bytes("a\0\r\n", 4);
  write_file(folder / "a", bytes);
  CHECK(read_bytes(folder / "a") == bytes);
  write_file(folder / "a", "");
  CHECK(read_bytes(folder / "a").empty());
  CHECK(std::distance(fs::directory_iterator(folder / ""), {}) == 1);
}

// Would catch a link that a regular file takes the place of, and a target that keeps old bytes.
TEST_CASE("write file: a symbolic link stays, what it names is replaced", "[unit]") {
  const TemporaryFolder folder;
  fs::create_directories(folder / "far/deep");
  folder.put("far/target", "old");
  fs::create_symlink("far/target", folder / "relative");
  fs::create_symlink(folder / "relative", folder / "chain");
  fs::create_symlink("deep/new", folder / "far/dangling");

  write_file(folder / "relative", "one");
  CHECK(read_bytes(folder / "far/target") == "one");
  write_file(folder / "chain", "two");
  CHECK(read_bytes(folder / "far/target") == "two");
  write_file(folder / "far/dangling", "three");
  CHECK(read_bytes(folder / "far/deep/new") == "three");
  for (const char* link : {"relative", "chain", "far/dangling"}) {
    INFO(link);
    CHECK(fs::is_symlink(folder / link));
  }
}

// Would catch a pipe or device, as /dev/stdout, that a regular file takes the place of.
TEST_CASE("write file: a device is written to and stays one", "[unit]") {
  const TemporaryFolder folder;
  fs::create_symlink("/dev/null", folder / "null");
  write_file(folder / "null", "gone");
  CHECK(fs::is_character_file("/dev/null"));
  CHECK(fs::is_symlink(folder / "null"));
}

// Would catch a user's own file that a part takes the place of, and a file that others may read
// once it is written anew.
TEST_CASE("write file: what lies beside stays, and so do permissions", "[unit]") {
  const TemporaryFolder folder;
  folder.put("a", "old");
  folder.put("a.part", "a user's own");
  fs::permissions(folder / "a", fs::perms::owner_read | fs::perms::owner_write);
  write_file(folder / "a", "new");
  CHECK(read_bytes(folder / "a") == "new");
  CHECK(read_bytes(folder / "a.part") == "a user's own");
  CHECK(fs::status(folder / "a").permissions() == (fs::perms::owner_read | fs::perms::owner_write));
  CHECK(std::distance(fs::directory_iterator(folder / ""), {}) == 2);
}

// Would catch a part that is left behind, or half a file, where what writes gives up.
TEST_CASE("write file: what a writer throws goes through and nothing is changed", "[unit]") {
  const TemporaryFolder folder;
  folder.put("a", "old");
  CHECK_THROWS_WITH(write_file(folder / "a",
                               [](std::ostream& stream) {
                                 stream << "half";
                                 throw InvalidArgument("no more");
                               }),
                    "no more");
  CHECK(read_bytes(folder / "a") == "old");
  CHECK(std::distance(fs::directory_iterator(folder / ""), {}) == 1);
  write_file(folder / "a", [](std::ostream& stream) { stream << "new"; });
  CHECK(read_bytes(folder / "a") == "new");
}

TEST_CASE("write file: what cannot be written is refused and nothing is lost", "[unit]") {
  const TemporaryFolder folder;
  fs::create_directory(folder / "folder");
  fs::create_symlink("loop", folder / "loop");
  CHECK_THROWS_WITH(write_file(folder / "folder", "x"),
                    ContainsSubstring("folder: is a directory"));
  CHECK_THROWS_WITH(write_file(folder / "loop", "x"), ContainsSubstring("symbolic links"));
  CHECK_THROWS_WITH(write_file(folder / "none/a", "x"), ContainsSubstring("none/a: cannot be"));
  CHECK_THROWS_AS(write_file("/dev/full", "x"), FileError);
  CHECK_THROWS_AS(write_file("", "x"), FileError);

  // no name for the new bytes beside the old ones: 255 characters is the most
  const std::string kept(255, 'k');
  folder.put(kept, "old");
  CHECK_THROWS_AS(write_file(folder / kept, "new"), FileError);
  CHECK(read_bytes(folder / kept) == "old");
}

}  // namespace pbdsurg
