#pragma once

#include <memory>
#include <string>

#include "server/config/config.hpp"
#include "server/operations/ports_file.hpp"
#include "server/programs/programs.hpp"

namespace aprsim::server {

/// The programs of a daemon's cell, and the file from which they learn its ports. None where pages
/// may start none and the demo is not asked for. Thread: one; pages use for_pages() on theirs.
class CellPrograms {
 public:
  /// `token`: for the programs; empty = they need none.
  CellPrograms(const Config& config, bool demo, std::string token = {});
  ~CellPrograms();
  CellPrograms(const CellPrograms&) = delete;
  CellPrograms& operator=(const CellPrograms&) = delete;

  /// Once everything listens that they need, before pages can ask for one; starts the demo where
  /// that is asked for. Errors: the file cannot be written; no demo for this scene.
  [[nodiscard]] Result<void> begin(const Ports& ports);
  /// Tells what runs to end and takes no more; does not wait.
  void close();
  /// Waits for what runs, for a second or so.
  void end();

  /// Null where there are none; lives until end().
  [[nodiscard]] web::ProgramRunner* for_pages() const { return programs_.get(); }

 private:
  [[nodiscard]] std::string ports_path() const { return directory_ + "/ports.json"; }

  bool demo_;
  std::string directory_;  ///< of the ports file; empty = none
  std::unique_ptr<PortsFile> ports_file_;
  std::unique_ptr<Programs> programs_;
};

}  // namespace aprsim::server
