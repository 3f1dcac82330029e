#include "server/access/access_file.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <ctime>
#include <fcntl.h>
#include <openssl/rand.h>
#include <set>
#include <stdexcept>
#include <string_view>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "world/base/yaml/yaml_reader.hpp"

namespace aprsim::server {
namespace {

constexpr std::size_t kSaltBytes = 16, kTokenBytes = 32;
constexpr std::string_view kKey = "access.file";
constexpr std::string_view kTokenStart = "aprsim_";

tl::unexpected<Error> wrong(const std::string& message) {
  return fail(ErrorCode::kInvalidArgument, std::string(kKey), fmt::format("{}: {}", kKey, message));
}

std::string random_bytes(std::size_t size) {
  std::string bytes(size, '\0');
  if (RAND_bytes(reinterpret_cast<unsigned char*>(bytes.data()), static_cast<int>(size)) != 1) {
    throw std::runtime_error("OpenSSL gives no random bytes");
  }
  return bytes;
}

template <typename Bytes>
std::string hex_of(const Bytes& bytes) {
  std::string text;
  for (const auto byte : bytes) text += fmt::format("{:02x}", static_cast<unsigned char>(byte));
  return text;
}

/// Decodes hexadecimal digits of a fixed number of bytes; absent = malformed.
std::optional<std::string> bytes_of(std::string_view hex, std::size_t size) {
  if (hex.size() != 2 * size) return std::nullopt;
  std::string bytes;
  for (std::size_t i = 0; i < hex.size(); i += 2) {
    unsigned byte = 0;
    const auto [end, error] = std::from_chars(&hex[i], &hex[i] + 2, byte, 16);
    if (error != std::errc{} || end != &hex[i] + 2) return std::nullopt;
    bytes += static_cast<char>(byte);
  }
  return bytes;
}

protocols::Role role_in(const yaml::Node& node) {
  // In the order of the roles, without the first, none.
  return static_cast<protocols::Role>(node.word({"view", "operate", "inject", "admin"}) + 1);
}

protocols::TokenEntry token_in(const yaml::Node& node) {
  const yaml::Map map = node.map({"name", "role", "salt", "sha256", "expires"});
  protocols::TokenEntry token;
  token.name = map["name"].text();
  if (!is_token_name(token.name)) map["name"].unexpected("1 to 64 letters, digits and . _ - @");
  token.role = role_in(map["role"]);
  if (const auto salt = bytes_of(map["salt"].text(), kSaltBytes)) {
    token.salt = *salt;
  } else {
    map["salt"].unexpected(fmt::format("{} hexadecimal digits", 2 * kSaltBytes));
  }
  if (const auto digest = bytes_of(map["sha256"].text(), token.digest.size())) {
    std::ranges::copy(*digest, token.digest.begin());
  } else {
    map["sha256"].error("another text",
                        fmt::format("{} hexadecimal digits", 2 * token.digest.size()));
  }
  if (const yaml::Node expires = map["expires"]) {
    token.expires = time_of(expires.text());
    if (!token.expires) expires.unexpected("a time such as 2027-01-31T12:00:00Z");
  }
  return token;
}

/// A file that others can read or write would give them access.
Result<void> check_mode(const std::string& path) {
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) {
    return wrong(fmt::format("cannot read {}: {}", path, std::strerror(errno)));
  }
  if (!S_ISREG(status.st_mode)) return wrong(path + ": expected a regular file");
  const auto others = status.st_mode & (S_IRWXG | S_IRWXO);
  if (others == 0) return {};
  return wrong(
      fmt::format("{} has mode {:03o}, so that others reach it; expected 600 (chmod 600 {})", path,
                  status.st_mode & 0777U, path));
}

std::string yaml_of(const AccessFile& file) {
  std::string text =
      "# Who may what: made by aprsimd token. Tokens themselves are not in here.\ntokens:";
  if (file.tokens.empty()) text += " []";
  text += '\n';
  for (const auto& token : file.tokens) {
    text +=
        fmt::format("  - {{name: \"{}\", role: {}, salt: \"{}\", sha256: \"{}\"{}}}\n", token.name,
                    protocols::to_text(token.role), hex_of(token.salt), hex_of(token.digest),
                    token.expires ? fmt::format(", expires: \"{}\"", text_of(*token.expires)) : "");
  }
  text += "certificates:";
  if (file.certificates.empty()) text += " []";
  text += '\n';
  for (const auto& entry : file.certificates) {
    std::string name;
    for (const char c : entry.name)
      name += c == '"' || c == '\\' ? std::string{'\\', c} : std::string(1, c);
    text += fmt::format("  - {{name: \"{}\", role: {}}}\n", name, protocols::to_text(entry.role));
  }
  return text;
}

}  // namespace

bool is_token_name(const std::string& text) {
  constexpr std::size_t kMaxSize = 64;
  constexpr std::string_view kSigns = "._-@";
  const auto ordinary = [&](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           kSigns.find(c) != std::string_view::npos;
  };
  return !text.empty() && text.size() <= kMaxSize && std::ranges::all_of(text, ordinary);
}

std::optional<protocols::WallTime> time_of(const std::string& text) {
  for (const char* form : {"%Y-%m-%dT%H:%M:%SZ", "%Y-%m-%d"}) {
    std::tm time{};
    const char* end = strptime(text.c_str(), form, &time);
    if (end == nullptr || *end != '\0') continue;
    const std::tm asked = time;
    const std::time_t seconds = timegm(&time);
    // timegm() accepts the 31st of February as another day.
    if (time.tm_mday != asked.tm_mday || time.tm_mon != asked.tm_mon) return std::nullopt;
    return std::chrono::system_clock::from_time_t(seconds);
  }
  return std::nullopt;
}

std::string text_of(protocols::WallTime time) {
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}Z",
                     fmt::gmtime(std::chrono::system_clock::to_time_t(time)));
}

Result<AccessFile> read_access_file(const std::string& path) {
  if (auto ok = check_mode(path); !ok) return tl::unexpected(ok.error());
  const auto document = yaml::Document::from_file(path);
  if (!document) return wrong(document.error().message);
  const yaml::Map map = document->root().map({"tokens", "certificates"});
  AccessFile file;
  std::set<std::string> names;
  for (const yaml::Node& node : map["tokens"].items()) {
    const auto& token = file.tokens.emplace_back(token_in(node));
    if (!names.insert(token.name).second) node.error(token.name + " again", "another name");
  }
  for (const yaml::Node& node : map["certificates"].items()) {
    const yaml::Map entry = node.map({"name", "role"});
    file.certificates.push_back({entry["name"].text(), role_in(entry["role"])});
  }
  for (const auto& [key, size] : {std::pair("tokens", file.tokens.size()),
                                  std::pair("certificates", file.certificates.size())}) {
    if (size > AccessFile::kMaxEntries) {
      map[key].error(fmt::format("{} entries", size),
                     fmt::format("{} at most", AccessFile::kMaxEntries));
    }
  }
  if (document->error()) return wrong(document->error()->message);
  return file;
}

Result<void> write_access_file(const std::string& path, const AccessFile& file) {
  std::string name = path + ".XXXXXX";
  const auto failed = [&] {
    const std::string cause = std::strerror(errno);
    (void)::unlink(name.c_str());
    return wrong(fmt::format("cannot write {}: {}", path, cause));
  };
  const int fd = mkostemp(name.data(), O_CLOEXEC);  // of mode 600
  if (fd < 0) return failed();
  // The running daemon keeps reading the old file.
  struct stat before {};
  if (stat(path.c_str(), &before) == 0) (void)!fchown(fd, before.st_uid, before.st_gid);
  const std::string text = yaml_of(file);
  const bool written = ::write(fd, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  const bool kept = written && fsync(fd) == 0;
  if (::close(fd) != 0 || !kept || std::rename(name.c_str(), path.c_str()) != 0) return failed();
  return {};
}

std::string random_token() { return std::string(kTokenStart) + hex_of(random_bytes(kTokenBytes)); }

protocols::TokenEntry entry_of(const std::string& token, std::string name, protocols::Role role,
                               std::optional<protocols::WallTime> expires) {
  std::string salt = random_bytes(kSaltBytes);
  const protocols::Digest digest = protocols::digest_of(salt, token);
  return {std::move(name), role, std::move(salt), digest, expires};
}

}  // namespace aprsim::server
