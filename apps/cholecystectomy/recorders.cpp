// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/recorders.h"

#include <cstdio>
#include <utility>

#include <unistd.h>

#include "pbdsurg/base/error.h"

namespace cholecystectomy {

CsvFile::CsvFile(const std::filesystem::path& path, const std::string& header)
    : path_(path), file_(path) {
  file_ << header << '\n';
  if (!file_) {
    throw pbdsurg::FileError(path.string() + ": cannot be opened for writing");
  }
  file_.precision(9);
}

void CsvFile::close() {
  file_.close();
  if (!file_) {
    throw pbdsurg::FileError(path_.string() + ": could not be written to its end");
  }
}

ForceRecorder::ForceRecorder(const std::filesystem::path& path)
    : file_(path, "t_s,tool,fx_n,fy_n,fz_n") {}

void ForceRecorder::step(const Simulation& simulation, double) {
  const Eigen::Vector3f on_grasper = simulation.solver.tool_force(simulation.grasper.tool);
  const Eigen::Vector3f on_hook = simulation.solver.tool_force(simulation.hook.tool);
  const auto write = [&](const char* tool, const Eigen::Vector3f& force) {
    file_.stream() << simulation.time() << ',' << tool << ',' << force.x() << ',' << force.y()
                   << ',' << force.z() << '\n';
  };
  write("grasper", on_grasper);
  write("hook", on_hook);
}

void ForceRecorder::moment(const Simulation&, const std::string&) {}

void ForceRecorder::close() {
  file_.close();
}

CauteryRecorder::CauteryRecorder(const std::filesystem::path& path)
    : file_(path,
            "t_s,set_w,power_w,resistance_ohm,hottest_degc,energy_in_j,tets_deleted,links_cut") {}

void CauteryRecorder::step(const Simulation& simulation, double) {
  file_.stream() << simulation.time() << ',' << simulation.hook_power << ','
                 << simulation.last_burn.power << ',' << simulation.last_burn.resistance << ','
                 << simulation.last_burn.hottest << ',' << simulation.energy_in() << ','
                 << simulation.totals.tets_deleted << ',' << simulation.totals.links_cut << '\n';
}

void CauteryRecorder::moment(const Simulation&, const std::string&) {}

void CauteryRecorder::close() {
  file_.close();
}

void write_recovery(const std::filesystem::path& path, const Recovery& recovery) {
  CsvFile file(path, "t_ms,distance_mm");
  for (std::size_t i = 0; i < recovery.times.size(); ++i) {
    file.stream() << 1e3 * recovery.times[i] << ',' << 1e3 * recovery.distances[i] << '\n';
  }
  file.close();
}

SeriesRecorder::SeriesRecorder(const std::filesystem::path& path) : series_(path) {}

void SeriesRecorder::step(const Simulation&, double) {}

void SeriesRecorder::moment(const Simulation& simulation, const std::string&) {
  const StageTimer timer(simulation.times, "series");
  const pbdsurg::Solver& solver = simulation.solver;
  pbdsurg::MeshData mesh;
  pbdsurg::MeshFields fields;
  pbdsurg::MeshField velocity{"velocity_m_s", 3, {}};
  pbdsurg::MeshField temperature{"temperature_degC", 1, {}};
  pbdsurg::MeshField water{"water_left", 1, {}};
  pbdsurg::MeshField body_of_tet{"body", 1, {}};
  pbdsurg::MeshField state{"heat_state", 1, {}};
  for (const Eigen::Vector3f& x : solver.positions()) {
    mesh.points.push_back(x.cast<double>());
  }
  const pbdsurg::HeatField& heat = simulation.cautery.field();
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    temperature.values.push_back(static_cast<float>(heat.temperatures()[v]));
    water.values.push_back(static_cast<float>(heat.water()[v]));
  }
  for (std::size_t b = 0; b < solver.tissue().bodies().size(); ++b) {
    const pbdsurg::Body& body = solver.tissue().bodies()[b];
    for (pbdsurg::Index t = 0; t < body.tet_count; ++t) {
      if (solver.tissue().is_tet_alive(body.first_tet + t)) {
        mesh.tets.push_back(solver.tissue().tets()[body.first_tet + t]);
        body_of_tet.values.push_back(static_cast<float>(b));
        state.values.push_back(static_cast<float>(simulation.cautery.state(body.first_tet + t)));
      }
    }
  }
  for (const Eigen::Vector3f& v : solver.velocities()) {
    velocity.values.insert(velocity.values.end(), {v.x(), v.y(), v.z()});
  }
  fields.point = {std::move(velocity), std::move(temperature), std::move(water)};
  fields.cell = {std::move(body_of_tet), std::move(state)};
  series_.add_frame(simulation.time(), mesh, fields);
}

ProgressRecorder::ProgressRecorder() : is_terminal_(isatty(STDERR_FILENO) == 1) {}

ProgressRecorder::~ProgressRecorder() {
  if (shown_ >= 0 && shown_ < 100) {
    std::fputc('\n', stderr);
  }
}

void ProgressRecorder::step(const Simulation& simulation, double progress) {
  const int percent = static_cast<int>(100 * progress);
  if (!is_terminal_ || percent == shown_) {
    return;
  }
  shown_ = percent;
  constexpr int kWidth = 40;
  std::string bar(static_cast<std::size_t>(kWidth * progress), '#');
  bar.resize(kWidth, '.');
  std::fprintf(stderr, "\r[%s] %3d %%  %5.2f s simulated", bar.c_str(), percent, simulation.time());
  if (percent == 100) {
    std::fputc('\n', stderr);
  }
  std::fflush(stderr);
}

void ProgressRecorder::moment(const Simulation& simulation, const std::string& name) {
  if (!is_terminal_) {
    std::fprintf(stderr, "%6.2f s  %s\n", simulation.time(), name.c_str());
  }
}

}  // namespace cholecystectomy
