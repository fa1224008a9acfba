// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/mesh/series.h"

#include <cmath>
#include <utility>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/owned.h"
#include "pbdsurg/base/write_file.h"

#include "lib/mesh/output.h"

namespace pbdsurg {
namespace {

std::string frame_name(const std::filesystem::path& path, std::size_t frame) {
  std::string number = std::to_string(frame);
  number.insert(0, number.size() < 6 ? 6 - number.size() : 0, '0');
  return path.stem().string() + '_' + number + ".vtu";
}

}  // namespace

MeshSeries::MeshSeries(std::filesystem::path path) : path_(std::move(path)) {
  if (path_.extension() != ".pvd") {
    throw InvalidArgument(path_.string() + ": a series is named by its list, NAME.pvd");
  }
  if (path_.stem().string().find_first_of("<>&\"") != std::string::npos) {
    throw InvalidArgument(path_.string() + ": the name of a series must not hold any of <>&\"");
  }
  write_list();
}

void MeshSeries::add_frame(double time, const MeshData& mesh, const MeshFields& fields) {
  if (path_.empty()) {
    throw_moved_from("a mesh series");
  }
  if (!std::isfinite(time) || (!times_.empty() && time < times_.back())) {
    throw InvalidArgument("the time of frame " + std::to_string(times_.size()) + " is " +
                          std::to_string(time) +
                          " s; it must be finite and not before the last frame");
  }
  write_mesh(path_.parent_path() / frame_name(path_, times_.size()), mesh, {}, fields);
  times_.push_back(time);
  write_list();
}

void MeshSeries::write_list() const {
  std::string out =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" "
      "byte_order=\"LittleEndian\">\n<Collection>\n";
  for (std::size_t frame = 0; frame < times_.size(); ++frame) {
    out += "<DataSet timestep=\"";
    append_text(out, times_[frame]);
    out += "\" part=\"0\" file=\"" + frame_name(path_, frame) + "\"/>\n";
  }
  out += "</Collection>\n</VTKFile>\n";
  write_file(path_, out);
}

}  // namespace pbdsurg
