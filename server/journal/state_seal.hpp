#pragma once

#include <string>

#include "aprsim/v1/journal.pb.h"

namespace aprsim::server::journal {

/// Signs the checkpoints of journals and saved states with the key of this user's state folder, and
/// recognises them. A signature is the HMAC-SHA-256 of the state and the scenes that it belongs to.
/// Thread: any.
class StateSeal {
 public:
  /// Reads the key from `state.key` in `folder`, which is made with a random key where it does not
  /// exist. Where it cannot be used (logged once), the key is a random one of this process.
  explicit StateSeal(const std::string& folder);

  /// $STATE_DIRECTORY (systemd), $XDG_STATE_HOME/aprsim or $HOME/.local/state/aprsim; empty = none
  /// is set.
  [[nodiscard]] static std::string folder();

  /// Sets the signature of a checkpoint in a journal whose header has the scene `header_scene`.
  void sign(const std::string& header_scene, v1::JournalCheckpoint& checkpoint) const;
  /// Whether this key has signed the checkpoint.
  [[nodiscard]] bool has_signed(const std::string& header_scene,
                                const v1::JournalCheckpoint& checkpoint) const;

 private:
  [[nodiscard]] std::string code_of(const std::string& header_scene,
                                    const v1::JournalCheckpoint& checkpoint) const;

  std::string key_;
};

}  // namespace aprsim::server::journal
