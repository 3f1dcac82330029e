// Runs a kept corpus through its fuzz target, with whatever compiler and sanitizers the build has.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include <gtest/gtest.h>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace aprsim {
namespace {

TEST(FuzzCorpus, RunsClean) {
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(APRSIM_CORPUS)) {
    SCOPED_TRACE(entry.path());
    std::ifstream file(entry.path(), std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
    const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
    EXPECT_EQ(LLVMFuzzerTestOneInput(data, bytes.size()), 0);
    ++files;
  }
  EXPECT_GE(files, 5) << "no corpus in " APRSIM_CORPUS;
}

}  // namespace
}  // namespace aprsim
