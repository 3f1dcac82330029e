#include "server/operations/ports_file.hpp"

#include <csignal>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "tests/support/eventually.hpp"
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

/// A process that has written the file and lives until it is killed.
class OtherDaemon {
 public:
  explicit OtherDaemon(const fs::path& path) : pid_(::fork()) {
    if (pid_ == 0) {
      PortsFile file;
      if (!file.write(path, {{"grpc", 4711}})) ::_exit(1);
      ::pause();
      ::_exit(0);
    }
  }
  ~OtherDaemon() { kill(); }
  OtherDaemon(const OtherDaemon&) = delete;
  OtherDaemon& operator=(const OtherDaemon&) = delete;

  void kill() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
    pid_ = -1;
  }
  [[nodiscard]] pid_t pid() const { return pid_; }

 private:
  pid_t pid_;
};

TEST_F(PortsFileTest, LeavesTheFileOfARunningDaemonAlone) {
  OtherDaemon other(path());
  ASSERT_TRUE(test::eventually([&] { return fs::exists(path()); }));
  EXPECT_NE(refusal().find("process id " + std::to_string(other.pid())), std::string::npos);
  EXPECT_NE(read(path()).find("\"grpc\": 4711"), std::string::npos);
  EXPECT_EQ(files(), 1U) << "nothing is left beside it";
  other.kill();
  EXPECT_EQ(refusal(), "") << "what a killed daemon has left is replaced";
}

/// A process id says nothing in another container, and comes back on this machine.
TEST_F(PortsFileTest, DoesNotGoByTheProcessIdInTheFile) {
  const pid_t other = ::fork();
  if (other == 0) {
    ::pause();
    ::_exit(0);
  }
  occupy("{\"grpc\": 1, \"pid\": " + std::to_string(other) + "}");
  EXPECT_EQ(refusal(), "");
  ::kill(other, SIGKILL);
  ::waitpid(other, nullptr, 0);
  OtherDaemon daemon(path());
  ASSERT_TRUE(test::eventually([&] { return fs::exists(path()); }));
  occupy("{\"pid\": " + std::to_string(::getpid()) + "}");  // as if it had our number
  EXPECT_NE(refusal().find("belongs to the running daemon"), std::string::npos);
}

TEST_F(PortsFileTest, GoesToOneOfManyThatStartAtOnce) {
  for (int round = 0; round < 20; ++round) {
    if (round % 2 == 0) occupy("{}");
    std::vector<pid_t> all;
    for (int i = 0; i < 8; ++i) {
      all.push_back(::fork());
      if (all.back() != 0) continue;
      PortsFile file;
      const bool mine = file.write(path(), {{"grpc", 1}}).has_value();
      if (mine) ::pause();
      ::_exit(7);
    }
    // All but one give up.
    for (int i = 0; i < 7; ++i) {
      int status = 0;
      const pid_t ended = ::wait(&status);
      EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 7);
      std::erase(all, ended);
    }
    ASSERT_EQ(all.size(), 1U);
    EXPECT_NE(read(path()).find(std::to_string(all[0])), std::string::npos);
    ::kill(all[0], SIGKILL);
    ::waitpid(all[0], nullptr, 0);
    fs::remove(path());
  }
}

TEST_F(PortsFileTest, CannotBeHalfThere) {
  // A full disk, as a limit on file sizes.
  const pid_t child = ::fork();
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit none{4, 4};
    ::setrlimit(RLIMIT_FSIZE, &none);
    ::_exit(refusal().empty() ? 1 : 0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(files(), 0U) << "neither the file nor its draft";
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
