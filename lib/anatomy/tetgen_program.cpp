// SPDX-License-Identifier: Apache-2.0
#include "lib/anatomy/tetgen_program.h"

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <system_error>
#include <thread>

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "pbdsurg/base/error.h"

extern char** environ;

namespace pbdsurg {
namespace {

constexpr std::chrono::minutes kTimeLimit{5};

// A folder that only we can read, removed with all its files.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern =
        (std::filesystem::temp_directory_path() / "pbdsurg-tetgen-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) {
      throw FileError(pattern + ": cannot create a temporary folder: " + std::strerror(errno));
    }
    path_ = pattern;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

// Nodes in the file, base 0, one facet a triangle, no holes and no regions.
void write_smesh(const std::filesystem::path& path, const MeshData& surface) {
  std::ofstream file(path);
  file.precision(std::numeric_limits<double>::max_digits10);
  file << surface.points.size() << " 3 0 0\n";
  for (std::size_t v = 0; v < surface.points.size(); ++v) {
    const Eigen::Vector3d& p = surface.points[v];
    file << v << ' ' << p.x() << ' ' << p.y() << ' ' << p.z() << '\n';
  }
  file << surface.triangles.size() << " 0\n";
  for (const auto& [a, b, c] : surface.triangles) {
    file << "3 " << a << ' ' << b << ' ' << c << '\n';
  }
  file << "0\n0\n";
  if (!file.flush()) {
    throw FileError(path.string() + ": cannot be written");
  }
}

void run_program(const std::filesystem::path& input) {
  std::string name = "tetgen";
  std::string switches = "-pYQ";  // fill a surface, split none of its facets, say nothing
  std::string path = input.string();
  std::array<char*, 4> arguments{name.data(), switches.data(), path.data(), nullptr};
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  pid_t process = 0;
  const int error =
      posix_spawnp(&process, name.c_str(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) {
    throw BackendUnavailable(
        "surface-filled meshes are made by the external program tetgen, which cannot be started: " +
        std::string(std::strerror(error)) + "; install it (Debian: tetgen) or put it on PATH");
  }
  const auto end = std::chrono::steady_clock::now() + kTimeLimit;
  int status = 0;
  pid_t done = 0;
  while ((done = waitpid(process, &status, WNOHANG)) == 0 || (done < 0 && errno == EINTR)) {
    if (std::chrono::steady_clock::now() > end) {
      kill(process, SIGKILL);
      waitpid(process, &status, 0);
      throw InvalidMesh("tetgen was stopped: it did not finish within 5 minutes");
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  if (done != process || !WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    throw InvalidMesh("tetgen failed on a surface (wait status " + std::to_string(status) +
                      "); it needs a closed surface that does not cross itself");
  }
}

MeshData read_result(const std::filesystem::path& node_path,
                     const std::filesystem::path& element_path) {
  MeshData mesh;
  std::ifstream nodes(node_path), elements(element_path);
  std::size_t count = 0;
  std::size_t id = 0;
  int ignored = 0;
  nodes >> count >> ignored >> ignored >> ignored;
  for (std::size_t v = 0; nodes && v < count; ++v) {
    Eigen::Vector3d p;
    if (nodes >> id >> p.x() >> p.y() >> p.z()) {
      mesh.points.push_back(p);
    }
  }
  elements >> count >> ignored >> ignored;
  for (std::size_t t = 0; elements && t < count; ++t) {
    Tet tet;
    if (elements >> id >> tet[0] >> tet[1] >> tet[2] >> tet[3]) {
      mesh.tets.push_back(tet);
    }
  }
  if (!nodes || !elements || mesh.tets.empty()) {
    throw InvalidMesh(
        "tetgen wrote no complete mesh; it needs a closed surface that does not "
        "cross itself");
  }
  return mesh;
}

}  // namespace

MeshData fill_with_tetgen(const MeshData& surface) {
  const TemporaryFolder folder;
  // tetgen appends ".1" to the name; a name with a number of its own would be taken for a step of
  // refinement
  write_smesh(folder.path() / "surface.smesh", surface);
  run_program(folder.path() / "surface.smesh");
  return read_result(folder.path() / "surface.1.node", folder.path() / "surface.1.ele");
}

}  // namespace pbdsurg
