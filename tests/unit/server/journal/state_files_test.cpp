// Files of saved states: signed by this user's key, bounded when they are unpacked, checked against
// the world.

#include "server/journal/state_files.hpp"

#include <cstdlib>
#include <filesystem>
#include <functional>
#include <sys/stat.h>
#include <zstd.h>

#include <gtest/gtest.h>

#include "proto/journal/frames.hpp"
#include "proto/journal/journal_reader.hpp"
#include "server/journal/digest.hpp"
#include "tests/support/temporary_directory.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::server::journal {
namespace {

class SavedStateFiles : public testing::Test {
 protected:
  SavedStateFiles() { setenv("STATE_DIRECTORY", directory_.path().c_str(), 1); }
  ~SavedStateFiles() override { unsetenv("STATE_DIRECTORY"); }

  static std::shared_ptr<const scene::Scene> scene() {
    static const auto kScene = [] {
      auto scene = scene::load_scene("table1", scene::default_data_paths());
      if (!scene) throw std::runtime_error(scene.error().message);
      return std::make_shared<const scene::Scene>(std::move(*scene));
    }();
    return kScene;
  }
  static api::StatePtr state() {
    world::World world(scene(), 1);
    for (int i = 0; i < 30; ++i) world.step();
    return std::make_shared<const world::WorldState>(world.save());
  }
  [[nodiscard]] SceneStateFiles files(bool accepts_foreign = false) const {
    return SceneStateFiles([] { return scene(); }, "0.0", accepts_foreign);
  }
  [[nodiscard]] std::string saved() {
    auto bytes = files().write("there", state());
    if (!bytes) throw std::runtime_error(bytes.error().message);
    return *std::move(bytes);
  }

  test::TemporaryDirectory directory_;
};

/// The file with one change of its checkpoint, which its signature does not cover.
std::string changed(const std::string& bytes,
                    const std::function<void(v1::JournalCheckpoint&)>& change) {
  auto reader = aprsim::journal::JournalReader::of_bytes(bytes);
  aprsim::journal::FrameEncoder encoder;
  v1::JournalRecord record;
  *record.mutable_header() = reader->header();
  encoder.add(record);
  while (reader->next(record)) {
    if (record.has_checkpoint()) change(*record.mutable_checkpoint());
    encoder.add(record);
  }
  return std::string(aprsim::journal::kMagic) + encoder.take();
}

TEST_F(SavedStateFiles, ComeBackWithTheKeyOfThisUser) {
  const std::string bytes = saved();
  const auto read = files().read(bytes);
  ASSERT_TRUE(read.has_value()) << read.error().message;
  EXPECT_EQ(read->name, "there");
  const std::string key = directory_.path() + "/state.key";
  struct stat status {};
  ASSERT_EQ(::stat(key.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0600U);
  EXPECT_EQ(status.st_size, 32);
}

TEST_F(SavedStateFiles, WithoutThatKeyAreRefusedUnlessForeignOnesAreAllowed) {
  const std::string bytes = saved();
  const std::string unsigned_bytes =
      changed(bytes, [](auto& checkpoint) { checkpoint.clear_signature(); });
  const std::string flipped =
      changed(bytes, [](auto& checkpoint) { checkpoint.mutable_signature()->back() ^= 1; });
  const std::string other_scene = changed(
      bytes, [](auto& checkpoint) { checkpoint.mutable_changed_scene()->set_text(scene()->text); });
  for (const std::string& foreign : {unsigned_bytes, flipped, other_scene}) {
    const auto refused = files().read(foreign);
    ASSERT_FALSE(refused.has_value());
    EXPECT_NE(refused.error().message.find("--allow-foreign-states"), std::string::npos)
        << refused.error().message;
  }
  EXPECT_TRUE(files(true).read(unsigned_bytes).has_value());
  // Another user or machine.
  std::filesystem::remove(directory_.path() + "/state.key");
  EXPECT_FALSE(files().read(bytes).has_value());
  EXPECT_TRUE(files(true).read(bytes).has_value());
}

TEST_F(SavedStateFiles, WithoutAUsableFolderHaveAKeyOfTheirDaemon) {
  const std::string key = directory_.write("state.key", "too short");
  SceneStateFiles one = files(), other = files();
  const auto bytes = one.write("there", state());
  ASSERT_TRUE(bytes.has_value()) << bytes.error().message;
  EXPECT_TRUE(one.read(*bytes).has_value());
  EXPECT_FALSE(other.read(*bytes).has_value());
}

/// The hash of bodies and joints is right in all of them.
TEST_F(SavedStateFiles, AreTheStateThatWasSavedAsAWhole) {
  const std::string bytes = saved();
  const auto refuses = [&](const std::function<void(v1::JournalCheckpoint&)>& change,
                           const std::string& why) {
    const auto read = files(true).read(changed(bytes, change));
    ASSERT_FALSE(read.has_value()) << why;
    EXPECT_NE(read.error().message.find(why), std::string::npos) << read.error().message;
  };
  refuses([](auto& checkpoint) { checkpoint.mutable_state()->append("x"); }, "digest");
  refuses([](auto& checkpoint) { checkpoint.clear_state_sha256(); }, "damaged");
  refuses(
      [](auto& checkpoint) {
        checkpoint.mutable_state()->resize(checkpoint.state().size() / 2);
        checkpoint.set_state_sha256(sha256(checkpoint.state()));
      },
      "the saved state cannot be read");
}

TEST_F(SavedStateFiles, NameNoFileOfTheMachine) {
  const std::string secret = directory_.write("secret", "admin: open sesame\n");
  const std::string bytes = saved();
  for (const std::string& text : {"types: " + secret + "\n", "types: secret\n" + scene()->text}) {
    for (const std::string name : {"table1", "../../../etc/x"}) {
      const auto read = files(true).read(changed(bytes, [&](auto& checkpoint) {
        checkpoint.mutable_changed_scene()->set_name(name);
        checkpoint.mutable_changed_scene()->set_text(text);
      }));
      ASSERT_FALSE(read.has_value());
      EXPECT_EQ(read.error().message.find("sesame"), std::string::npos) << read.error().message;
    }
  }
}

TEST_F(SavedStateFiles, AreRefusedBeforeTheyUnpackToTooMuch) {
  const std::string plain(std::size_t{30} << 20, 'x');
  std::string frame(ZSTD_compressBound(plain.size()), '\0');
  frame.resize(ZSTD_compress(frame.data(), frame.size(), plain.data(), plain.size(), 1));
  const auto read = files(true).read(std::string(aprsim::journal::kMagic) + frame);
  ASSERT_FALSE(read.has_value());
  EXPECT_NE(read.error().message.find("would unpack to 31457280 bytes, the limit is 16777216"),
            std::string::npos)
      << read.error().message;
}

}  // namespace
}  // namespace aprsim::server::journal
