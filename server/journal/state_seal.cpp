#include "server/journal/state_seal.hpp"

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <optional>
#include <stdexcept>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <spdlog/spdlog.h>

namespace aprsim::server::journal {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kKeyBytes = 32;

std::string random_key() {
  std::string key(kKeyBytes, '\0');
  if (getrandom(key.data(), key.size(), 0) != static_cast<ssize_t>(key.size())) {
    throw std::runtime_error("the system gives no random numbers");
  }
  return key;
}

/// Closes a file when it is left.
class OpenFile {
 public:
  explicit OpenFile(int descriptor) : descriptor_(descriptor) {}
  ~OpenFile() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  [[nodiscard]] int get() const { return descriptor_; }

 private:
  int descriptor_;
};

/// None where there is no file; throws where it is no key of this user alone.
std::optional<std::string> read_key(const fs::path& path) {
  const OpenFile file(open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC));
  if (file.get() < 0) {
    if (errno == ENOENT) return std::nullopt;
    throw std::runtime_error(path.string() + ": " + std::strerror(errno));
  }
  struct stat status {};
  if (fstat(file.get(), &status) != 0 || !S_ISREG(status.st_mode) || status.st_uid != geteuid() ||
      (status.st_mode & 077U) != 0) {
    throw std::runtime_error(path.string() + ": it must be a file of this user alone (mode 600)");
  }
  std::string key(kKeyBytes + 1, '\0');
  const ssize_t size = read(file.get(), key.data(), key.size());
  if (size != static_cast<ssize_t>(kKeyBytes)) {
    throw std::runtime_error(path.string() + ": it does not hold a key of 32 bytes");
  }
  key.resize(kKeyBytes);
  return key;
}

/// Makes the key complete before it has its name: daemons may start at the same time.
void write_key(const fs::path& folder, const fs::path& path) {
  fs::create_directories(folder);
  const std::string key = random_key();
  std::string draft = (folder / ".state.key.XXXXXX").string();
  const OpenFile file(mkostemp(draft.data(), O_CLOEXEC));
  if (file.get() < 0 ||
      ::write(file.get(), key.data(), key.size()) != static_cast<ssize_t>(key.size()) ||
      ::fsync(file.get()) != 0) {
    const int error = errno;
    ::unlink(draft.c_str());
    throw std::runtime_error(folder.string() + ": " + std::strerror(error));
  }
  // A daemon that comes second uses the first one's key.
  const int linked = ::link(draft.c_str(), path.c_str());
  const int error = errno;
  ::unlink(draft.c_str());
  if (linked != 0 && error != EEXIST) {
    throw std::runtime_error(path.string() + ": " + std::strerror(error));
  }
}

}  // namespace

std::string StateSeal::folder() {
  if (const char* state = std::getenv("STATE_DIRECTORY"); state != nullptr && *state != '\0') {
    const std::string_view all(state);
    return std::string(all.substr(0, all.find(':')));
  }
  if (const char* state = std::getenv("XDG_STATE_HOME"); state != nullptr && *state == '/') {
    return (fs::path(state) / "aprsim").string();
  }
  const char* home = std::getenv("HOME");
  if (home == nullptr || *home != '/') return {};
  return (fs::path(home) / ".local" / "state" / "aprsim").string();
}

StateSeal::StateSeal(const std::string& folder) {
  try {
    if (folder.empty()) throw std::runtime_error("neither STATE_DIRECTORY nor HOME is set");
    const fs::path path = fs::path(folder) / "state.key";
    auto key = read_key(path);
    if (!key) {
      write_key(folder, path);
      key = read_key(path);
    }
    if (key) key_ = *std::move(key);
  } catch (const std::exception& failure) {
    spdlog::warn("states: only this daemon accepts the states that it saves, until it stops: {}",
                 failure.what());
  }
  if (key_.empty()) key_ = random_key();
}

/// Each part with its length before it, so that no two checkpoints have the same bytes.
std::string StateSeal::code_of(const std::string& header_scene,
                               const v1::JournalCheckpoint& checkpoint) const {
  std::string signed_bytes;
  for (const std::string& part :
       {header_scene, checkpoint.scene().name(), checkpoint.scene().text(),
        checkpoint.changed_scene().name(), checkpoint.changed_scene().text(), checkpoint.state()}) {
    signed_bytes += std::to_string(part.size()) + ':' + part;
  }
  std::array<unsigned char, EVP_MAX_MD_SIZE> code{};
  unsigned size = 0;
  HMAC(EVP_sha256(), key_.data(), static_cast<int>(key_.size()),
       reinterpret_cast<const unsigned char*>(signed_bytes.data()), signed_bytes.size(),
       code.data(), &size);
  return {reinterpret_cast<const char*>(code.data()), size};
}

void StateSeal::sign(const std::string& header_scene, v1::JournalCheckpoint& checkpoint) const {
  checkpoint.set_signature(code_of(header_scene, checkpoint));
}

bool StateSeal::has_signed(const std::string& header_scene,
                           const v1::JournalCheckpoint& checkpoint) const {
  const std::string code = code_of(header_scene, checkpoint);
  return checkpoint.signature().size() == code.size() &&
         CRYPTO_memcmp(code.data(), checkpoint.signature().data(), code.size()) == 0;
}

}  // namespace aprsim::server::journal
