#include "server/ports_file.hpp"

#include <csignal>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "tests/support/temporary_directory.hpp"

namespace aprsim::server {
namespace {

namespace fs = std::filesystem;

std::string read(const fs::path& path) {
  std::ostringstream out;
  out << std::ifstream(path).rdbuf();
  return out.str();
}

class PortsFileTest : public testing::Test {
 protected:
  [[nodiscard]] fs::path path() const { return fs::path(directory.path()) / "ports.json"; }
  [[nodiscard]] std::size_t files() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(directory.path()), fs::directory_iterator()));
  }
  void occupy(const std::string& text) const { std::ofstream(path()) << text; }
  /// Why the file cannot be written; "" = it can.
  [[nodiscard]] std::string refusal() const {
    PortsFile file;
    const auto ok = file.write(path(), {{"grpc", 1}});
    return ok ? "" : ok.error().message;
  }

  test::TemporaryDirectory directory;
};

TEST_F(PortsFileTest, IsThereWholeAndGoesWithItsOwner) {
  {
    PortsFile file;
    ASSERT_TRUE(file.write(path(), {{"grpc", 50051}, {"modbus", 1502}}));
    EXPECT_NE(read(path()).find("\"grpc\": 50051"), std::string::npos);
    EXPECT_NE(read(path()).find("\"pid\": " + std::to_string(::getpid())), std::string::npos);
    EXPECT_EQ(files(), 1U) << "nothing is left beside it";
  }
  EXPECT_EQ(files(), 0U);
}

TEST_F(PortsFileTest, TakesThePlaceOfAFileThatNobodyOwns) {
  for (const std::string text : {"", "no json", "{\"pid\": \"x\"}", "{\"pid\": -1}", "[1]",
                                 "{\"grpc\": 1, \"pid\": 1073741823}"}) {
    occupy(text);
    EXPECT_EQ(refusal(), "") << text;
  }
}

TEST_F(PortsFileTest, LeavesTheFileOfARunningDaemonAlone) {
  const pid_t other = ::fork();
  if (other == 0) {
    ::pause();
    ::_exit(0);
  }
  occupy("{\"grpc\": 1, \"pid\": " + std::to_string(other) + "}");
  EXPECT_NE(refusal().find(std::to_string(other)), std::string::npos);
  EXPECT_NE(read(path()).find("\"grpc\": 1"), std::string::npos);
  ::kill(other, SIGKILL);
  ::waitpid(other, nullptr, 0);
  EXPECT_EQ(refusal(), "");
}

TEST_F(PortsFileTest, DoesNotRemoveWhatAnotherHasWrittenSince) {
  {
    PortsFile file;
    ASSERT_TRUE(file.write(path(), {{"grpc", 1}}));
    occupy("{\"pid\": 1}");
  }
  EXPECT_EQ(read(path()), "{\"pid\": 1}");
}

TEST_F(PortsFileTest, ReplacesOnlyRegularFiles) {
  ASSERT_EQ(::mkfifo(path().c_str(), 0600), 0);
  EXPECT_NE(refusal().find("not a regular file"), std::string::npos);
  EXPECT_TRUE(fs::is_fifo(path()));
  fs::remove(path());
  fs::create_directory(path());
  EXPECT_NE(refusal().find("not a regular file"), std::string::npos);
  fs::remove(path());
  fs::create_symlink("/dev/null", path());
  EXPECT_NE(refusal().find("not a regular file"), std::string::npos);
  EXPECT_TRUE(fs::is_symlink(path()));
}

TEST_F(PortsFileTest, SaysWhatIsWrongWithAFolder) {
  PortsFile file;
  const auto ok = file.write(fs::path(directory.path()) / "none" / "ports.json", {});
  ASSERT_FALSE(ok);
  EXPECT_EQ(ok.error().field, "ports-file");
  EXPECT_NE(ok.error().message.find("No such file"), std::string::npos) << ok.error().message;
}

}  // namespace
}  // namespace aprsim::server
