#pragma once

#include <string>
#include <vector>

#include "protocols/access/access.hpp"
#include "world/base/result.hpp"

namespace aprsim::server {

/// The file of tokens and of names in client certificates, with their roles (key access.file).
/// `aprsimd token` writes it. It holds hashes instead of tokens.
struct AccessFile {
  static constexpr std::size_t kMaxEntries = 256;  ///< of either kind

  std::vector<protocols::TokenEntry> tokens;
  std::vector<protocols::CertificateEntry> certificates;
};

/// Reads the file; refuses one that other users may read or write. Errors name file, place and the
/// expected value.
[[nodiscard]] Result<AccessFile> read_access_file(const std::string& path);

/// Replaces the file atomically, with access for its owner only.
[[nodiscard]] Result<void> write_access_file(const std::string& path, const AccessFile& file);

/// A new token of 256 random bits.
[[nodiscard]] std::string random_token();
/// The entry of a token, with a random salt.
[[nodiscard]] protocols::TokenEntry entry_of(const std::string& token, std::string name,
                                             protocols::Role role,
                                             std::optional<protocols::WallTime> expires);

/// Parses "2027-01-31T12:00:00Z", or a date, which means its beginning in UTC. Absent = malformed.
[[nodiscard]] std::optional<protocols::WallTime> time_of(const std::string& text);
[[nodiscard]] std::string text_of(protocols::WallTime time);

/// Whether a text may name a token: 1 to 64 letters, digits and any of "._-@".
[[nodiscard]] bool is_token_name(const std::string& text);

}  // namespace aprsim::server
