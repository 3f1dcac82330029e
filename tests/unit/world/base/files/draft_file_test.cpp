#include "world/base/files/draft_file.hpp"

#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <sys/stat.h>

#include <gtest/gtest.h>

#include "tests/support/temporary_directory.hpp"

namespace aprsim::files {
namespace {

namespace fs = std::filesystem;

class DraftFileTest : public testing::Test {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const {
    return directory_.path() + '/' + name;
  }
  [[nodiscard]] std::string text_of(const std::string& name) const {
    std::ifstream in(path(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  [[nodiscard]] auto files() const {
    return std::distance(fs::directory_iterator(directory_.path()), {});
  }
  test::TemporaryDirectory directory_;
};

TEST_F(DraftFileTest, ReplacesTheFileWhenCommitted) {
  std::ofstream(path("a")) << "before";
  DraftFile file(path("a"));
  file.out() << "after";
  file.out().flush();
  EXPECT_EQ(text_of("a"), "before");
  ASSERT_TRUE(file.commit());
  EXPECT_EQ(text_of("a"), "after");
  EXPECT_EQ(files(), 1);
}

TEST_F(DraftFileTest, LeavesTheFileWhenNotCommitted) {
  std::ofstream(path("a")) << "before";
  { DraftFile(path("a")).out() << "after"; }
  { DraftFile(path("b")).out() << "after"; }
  EXPECT_EQ(text_of("a"), "before");
  EXPECT_EQ(files(), 1);
}

TEST_F(DraftFileTest, KeepsTheRightsOfTheFileAndItsSymbolicLink) {
  std::ofstream(path("a")) << "before";
  fs::permissions(path("a"), fs::perms::owner_read | fs::perms::owner_write);
  fs::create_symlink("a", path("link"));
  DraftFile file(path("link"));
  file.out() << "after";
  ASSERT_TRUE(file.commit());
  EXPECT_TRUE(fs::is_symlink(path("link")));
  EXPECT_EQ(text_of("a"), "after");
  struct stat status {};
  ASSERT_EQ(::stat(path("a").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0600U);
}

TEST_F(DraftFileTest, WritesADeviceDirectly) {
  DraftFile file("/dev/null");
  file.out() << "text";
  EXPECT_TRUE(file.commit());
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(DraftFileTest, ReportsWhatCannotBeWritten) {
  DraftFile missing(path("none/a"));
  missing.out() << "text";
  const auto refused = missing.commit();
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message,
            path("none/a") + " cannot be written: No such file or directory");
  DraftFile full("/dev/full");
  full.out() << "text";
  const auto failed = full.commit();
  ASSERT_FALSE(failed);
  EXPECT_NE(failed.error().message.find("No space left on device"), std::string::npos)
      << failed.error().message;
}

TEST_F(DraftFileTest, AnOutputIsNoInputByAnyName) {
  std::ofstream(path("in")) << "bytes";
  fs::create_hard_link(path("in"), path("hard"));
  fs::create_symlink(path("in"), path("soft"));
  const std::array inputs{path("in")};
  for (const char* name : {"in", "./in", "hard", "soft"}) {
    const std::array outputs{path("other"), path(name)};
    const auto refused = check_outputs(inputs, outputs);
    ASSERT_FALSE(refused) << name;
    EXPECT_NE(refused.error().message.find("is the same file as the input"), std::string::npos);
  }
  const std::array twice{path("new"), path("./new")};
  EXPECT_FALSE(check_outputs(inputs, twice));
  const std::array apart{path("new"), path("newer"), std::string("/dev/null")};
  EXPECT_TRUE(check_outputs(inputs, apart));
}

}  // namespace
}  // namespace aprsim::files
