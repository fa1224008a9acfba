// SPDX-License-Identifier: Apache-2.0
// What a world takes in memory and time, by the size of its tissue and by executor.
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "apps/support/executors.h"
#include "bench/sizes/report.h"
#include "bench/support/gpu_times.h"
#include "bench/support/program.h"
#include "bench/support/subject.h"

namespace pbdsurg::bench {
namespace {

struct Arguments {
  std::filesystem::path out = "out/tables";
  std::vector<std::string> executors;
  bool quick = false;
};

std::vector<std::string> executors_here(std::vector<std::string>& notes) {
  std::vector<std::string> names{"serial", "threads"};
  if (const std::optional<std::string> why_not = why_no_gpu()) {
    notes.push_back("no cuda: " + *why_not);
  } else {
    names.push_back("cuda");
  }
  return names;
}

void run(const Arguments& arguments) {
  std::vector<std::string> notes;
  const std::vector<std::string> names =
      arguments.executors.empty() ? executors_here(notes) : arguments.executors;
  // vertices of about 5,000, 20,000, 50,000 and 100,000 tetrahedra
  const std::vector<Index> sizes =
      arguments.quick ? std::vector<Index>{1250} : std::vector<Index>{1250, 4400, 10'300, 19'900};
  const SizeEffort effort = arguments.quick ? SizeEffort{1, 5} : SizeEffort{5, 100};
  Json rows = Json::array();
  for (const Index vertices : sizes) {
    const TetMesh liver = make_liver(vertices);
    for (const std::string& name : names) {
      rows.push_back(to_json(name, measure_size(liver, programs::executor_named(name), effort)));
      std::fprintf(stderr, "%d tetrahedra, %s: done\n", static_cast<int>(liver.tet_count()),
                   name.c_str());
    }
  }
  const std::string text = to_markdown(rows, notes);
  std::fputs(text.c_str(), stdout);
  write_table(arguments.out, "sizes", rows, text);
}

}  // namespace
}  // namespace pbdsurg::bench

int main(int argc, char** argv) {
  CLI::App app("What a world takes in memory and time, by its size.", "sizes");
  pbdsurg::bench::Arguments arguments;
  app.add_option("--executor", arguments.executors,
                 "who works, in place of serial, threads and cuda where there is one: as those, or "
                 "threads:N or cuda:N; may be repeated")
      ->type_name("NAME")
      ->allow_extra_args(false);
  app.add_flag("--quick", arguments.quick, "the smallest mesh, five frames: to see it work");
  return pbdsurg::bench::run_program(app, argc, argv, arguments.out,
                                     [&] { pbdsurg::bench::run(arguments); });
}
