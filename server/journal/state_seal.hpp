#pragma once

#include <string>
#include <string_view>

namespace aprsim::server::journal {

/// Signs the files of saved states with the key of this user's state folder, and recognises them.
/// The signature (HMAC-SHA-256 of all bytes before it) is the last frame of a file; readers of
/// journals skip it. Thread: one at a time.
class StateSeal {
 public:
  /// Reads the key from `state.key` in `folder`, which is made with a random key where it does not
  /// exist. Where it cannot be used (logged once), the key is a random one of this process.
  explicit StateSeal(const std::string& folder);

  /// $STATE_DIRECTORY (systemd), $XDG_STATE_HOME/aprsim or $HOME/.local/state/aprsim; empty = none
  /// is set.
  [[nodiscard]] static std::string folder();

  /// The file with its signature.
  [[nodiscard]] std::string sign(std::string bytes) const;
  /// Whether the file ends with its signature by this key.
  [[nodiscard]] bool has_signed(std::string_view bytes) const;

 private:
  [[nodiscard]] std::string code_of(std::string_view bytes) const;

  std::string key_;
};

}  // namespace aprsim::server::journal
