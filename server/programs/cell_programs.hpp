#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/config/config.hpp"
#include "server/operations/ports_file.hpp"
#include "server/programs/programs.hpp"

namespace aprsim::server {

/// The programs that a daemon starts, and the file with the ports for them. There are none where
/// pages may not start programs and no demo is requested. Thread: one; for_pages() any.
class CellPrograms {
 public:
  /// `token`: of the programs; empty = none is needed.
  CellPrograms(const Config& config, bool demo, std::string token = {});
  ~CellPrograms();
  CellPrograms(const CellPrograms&) = delete;
  CellPrograms& operator=(const CellPrograms&) = delete;

  /// Writes the ports and starts a requested demo. Call it once the listeners are open and before
  /// the page is. Errors: the file cannot be written; there is no demo for this scene.
  [[nodiscard]] Result<void> begin(const Ports& ports);
  /// Writes the ports again where they have changed: another scene has other robots. Thread: one.
  void update(const Ports& ports);
  /// The programs for a cell with this scene (name or file); reads files. Thread: any.
  [[nodiscard]] std::vector<Program> programs_of(const std::string& scene) const;
  /// Offers them from now on. Thread: one.
  void offer(std::vector<Program> programs);
  /// Terminates the running program and accepts no more; does not wait.
  void close();
  /// Waits about a second for the end of the running program.
  void end();

  /// Null where there are none; valid until end().
  [[nodiscard]] web::ProgramRunner* for_pages() const { return programs_.get(); }

 private:
  [[nodiscard]] std::string ports_path() const { return directory_ + "/ports.json"; }

  bool demo_;
  std::string directory_;            ///< of the ports file; empty = none
  std::optional<std::string> host_;  ///< of all listeners; none = programs cannot be started
  std::unique_ptr<PortsFile> ports_file_;
  Ports written_;  ///< to it
  std::unique_ptr<Programs> programs_;
};

}  // namespace aprsim::server
