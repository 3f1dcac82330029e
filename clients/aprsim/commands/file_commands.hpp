#pragma once

#include <functional>
#include <string>
#include <vector>

#include "clients/aprsim/commands/command_group.hpp"
#include "clients/aprsim/files/scene_files.hpp"

/// Commands for scene and scenario files, without a daemon.
namespace aprsim::client {

struct SceneCheckCommand {
  std::vector<std::string> files;  ///< or names
};
struct FileDiffCommand {
  FileKind kind = FileKind::kScene;
  std::string before, after;  ///< files or names
};
struct FileFormatCommand {
  FileKind kind = FileKind::kScene;
  std::vector<std::string> files;  ///< or names
  bool check = false;              ///< report files that are formatted otherwise
  bool write = false;              ///< replace the files
};
struct FileSchemaCommand {
  FileKind kind = FileKind::kScene;
};

[[nodiscard]] Outcome<void> run_command(const SceneCheckCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const FileDiffCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const FileFormatCommand& command, Console& console);
[[nodiscard]] Outcome<void> run_command(const FileSchemaCommand& command, Console& console);

/// Checks files and shows their problems; `show_valid` reports each that has no error, or fails.
[[nodiscard]] Outcome<void> check_files(
    FileKind kind, const std::vector<std::string>& files, Console& console,
    const std::function<Outcome<void>(const CheckedFile&)>& show_valid);

/// Words and options of `scene check`, and of diff, format and schema for a kind of files.
void add_scene_check(CLI::App& group, CommandLine& line);
void add_file_commands(CLI::App& group, CommandLine& line, FileKind kind);

}  // namespace aprsim::client
