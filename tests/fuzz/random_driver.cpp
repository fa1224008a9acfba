// SPDX-License-Identifier: Apache-2.0
// Takes libFuzzer's place where the compiler has none: random inputs, or files.
// Usage: NAME [-seed=N] [-runs=N] [-max_total_time=SECONDS] [FILE...]
//
// Input i is that of seed N + i. The one under trial lies in NAME.input, to be tried again where it
// ended the program.
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

#include "tests/support/edit_trial.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

void run_file(const char* path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    std::fprintf(stderr, "%s: cannot be read\n", path);
    std::exit(2);
  }
  const std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(file), {}};
  LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
}

void run_seeds(std::uint64_t seed, std::uint64_t runs, std::chrono::seconds most,
               const std::string& input) {
  const auto end = std::chrono::steady_clock::now() + most;
  std::uint64_t done = 0;
  for (; done < runs && std::chrono::steady_clock::now() < end; ++done) {
    const std::vector<std::uint8_t> bytes = pbdsurg::testing::bytes_of_trial(seed + done);
    std::ofstream(input, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
  }
  std::remove(input.c_str());
  std::printf("%llu inputs from seed %llu on: nothing wrong\n",
              static_cast<unsigned long long>(done), static_cast<unsigned long long>(seed));
}

}  // namespace

int main(int argc, char** argv) {
  std::uint64_t seed = 0;
  std::uint64_t runs = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t seconds = 365 * 24 * 3600;
  bool has_files = false;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    const auto read = [&](const std::string& name, std::uint64_t& value) {
      const bool is_it = argument.rfind(name, 0) == 0;
      if (is_it) {
        value = std::strtoull(argument.c_str() + name.size(), nullptr, 10);
      }
      return is_it;
    };
    if (!read("-seed=", seed) && !read("-runs=", runs) && !read("-max_total_time=", seconds)) {
      run_file(argv[i]);
      has_files = true;
    }
  }
  if (!has_files) {
    run_seeds(seed, runs, std::chrono::seconds(seconds), std::string(argv[0]) + ".input");
  }
}
