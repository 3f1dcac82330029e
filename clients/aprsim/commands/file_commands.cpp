#include "clients/aprsim/commands/file_commands.hpp"

#include <ostream>
#include <utility>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/cli/console.hpp"
#include "clients/aprsim/commands/option_parsing.hpp"
#include "clients/aprsim/files/file_diff.hpp"
#include "clients/aprsim/files/file_format.hpp"
#include "clients/aprsim/files/json_schema.hpp"
#include "world/base/files/draft_file.hpp"

namespace aprsim::client {
namespace {

void show_problem(const Problem& problem, Console& console) {
  const std::string place =
      problem.line > 0 ? fmt::format("{}:{}:{}", problem.file, problem.line, problem.column)
                       : problem.file;
  // Messages without a place name their file themselves.
  const bool named = problem.line == 0 && problem.message.starts_with(problem.file);
  console.show(
      fmt::format("{}{}{}{}\n", named ? "" : place + ": ", problem.is_warning ? "warning: " : "",
                  problem.key.empty() || named ? "" : problem.key + ": ", problem.message),
      {{"file", problem.file},
       {"line", problem.line},
       {"column", problem.column},
       {"severity", problem.is_warning ? "warning" : "error"},
       {"key", problem.key},
       {"message", problem.message}});
}

Outcome<void> show_valid_scene(const CheckedFile& checked, Console& console) {
  if (!checked.scene) {
    console.show(fmt::format("{} is valid: types\n", checked.file), {{"valid", checked.file}});
    return {};
  }
  const scene::Scene& scene = *checked.scene;
  console.show(
      fmt::format("{} is valid: {} robots, {} trays, {} gears, {} parts\n", checked.file,
                  scene.robots.size(), scene.trays.size(), scene.gears.size(), scene.parts.size()),
      {{"valid", checked.file},
       {"robots", scene.robots.size()},
       {"trays", scene.trays.size()},
       {"gears", scene.gears.size()},
       {"parts", scene.parts.size()}});
  return {};
}

const char* word_of(Difference::Kind kind) {
  switch (kind) {
    case Difference::Kind::kAdded:
      return "added";
    case Difference::Kind::kRemoved:
      return "removed";
    case Difference::Kind::kMoved:
      return "moved";
    case Difference::Kind::kChanged:
      break;
  }
  return "changed";
}

nlohmann::ordered_json json_of(const Difference& difference) {
  nlohmann::ordered_json out = {{"change", word_of(difference.kind)},
                                {"key", difference.key},
                                {"before", difference.before},
                                {"after", difference.after},
                                {"unit", difference.unit}};
  if (difference.kind == Difference::Kind::kMoved) out["moved_m"] = difference.moved_m;
  return out;
}

/// A file without errors; they are shown.
Outcome<FoundFile> valid_file(FileKind kind, const std::string& name, Console& console) {
  const auto paths = scene::default_data_paths();
  auto found = find_file(kind, name, paths);
  if (!found) return found;
  const CheckedFile checked = check_file(*found, paths);
  if (checked.errors() == 0) return found;
  for (const Problem& problem : checked.problems) show_problem(problem, console);
  return failed(FailureKind::kUsage, fmt::format("{} has errors", found->path));
}

Outcome<void> replace(const std::string& path, const std::string& text) {
  files::DraftFile draft(path);
  draft.out() << text;
  if (auto done = draft.commit(); !done) return failed(FailureKind::kCheck, done.error().message);
  return {};
}

}  // namespace

Outcome<void> check_files(FileKind kind, const std::vector<std::string>& files, Console& console,
                          const std::function<Outcome<void>(const CheckedFile&)>& show_valid) {
  const auto paths = scene::default_data_paths();
  std::size_t errors = 0, wrong = 0;
  for (const std::string& name : files) {
    const auto found = find_file(kind, name, paths);
    if (!found) return tl::unexpected(found.error());
    const CheckedFile checked = check_file(*found, paths);
    for (const Problem& problem : checked.problems) show_problem(problem, console);
    errors += checked.errors();
    wrong += checked.errors() > 0 ? 1 : 0;
    if (checked.errors() > 0) continue;
    if (auto shown = show_valid(checked); !shown) return shown;
  }
  if (errors == 0) return {};
  return failed(FailureKind::kCheck,
                fmt::format("{} error{} in {} of {} file{}", errors, errors == 1 ? "" : "s", wrong,
                            files.size(), files.size() == 1 ? "" : "s"));
}

Outcome<void> run_command(const SceneCheckCommand& command, Console& console) {
  return check_files(FileKind::kScene, command.files, console, [&](const CheckedFile& checked) {
    return show_valid_scene(checked, console);
  });
}

Outcome<void> run_command(const FileDiffCommand& command, Console& console) {
  const auto before = valid_file(command.kind, command.before, console);
  if (!before) return tl::unexpected(before.error());
  const auto after = valid_file(command.kind, command.after, console);
  if (!after) return tl::unexpected(after.error());
  const auto differences = diff_files(*before, *after, scene::default_data_paths());
  if (!differences) return tl::unexpected(differences.error());
  auto all = nlohmann::ordered_json::array();
  std::string text;
  for (const Difference& difference : *differences) {
    all.push_back(json_of(difference));
    text += text_of(difference) + '\n';
  }
  console.show(text, {{"same", differences->empty()},
                      {"before", before->path},
                      {"after", after->path},
                      {"differences", std::move(all)}});
  if (differences->empty()) return {};
  return failed(FailureKind::kCheck, fmt::format("{} difference{}", differences->size(),
                                                 differences->size() == 1 ? "" : "s"));
}

Outcome<void> run_command(const FileFormatCommand& command, Console& console) {
  std::size_t others = 0;
  for (const std::string& name : command.files) {
    const auto found = find_file(command.kind, name, scene::default_data_paths());
    if (!found) return tl::unexpected(found.error());
    const auto text = format_file(*found);
    if (!text) return tl::unexpected(text.error());
    if (!command.check && !command.write) {
      console.write(*text);
      continue;
    }
    if (*text == found->text) continue;
    ++others;
    console.print(
        fmt::format("{} {}\n", command.write ? "formatted" : "not formatted:", found->path));
    if (!command.write) continue;
    if (auto done = replace(found->path, *text); !done) return done;
  }
  if (others == 0 || command.write) return {};
  return failed(FailureKind::kCheck,
                fmt::format("{} of {} file{} not formatted", others, command.files.size(),
                            command.files.size() == 1 ? "" : "s"));
}

Outcome<void> run_command(const FileSchemaCommand& command, Console& console) {
  console.write(json_schema(command.kind).dump(1) + '\n');
  return {};
}

void add_scene_check(CLI::App& group, CommandLine& line) {
  auto [check, command] = add_command<SceneCheckCommand>(
      group, line, "check", "Check scenes and files of types; needs no daemon");
  check->add_option("FILE", command->files, "Names of shipped scenes, or files")
      ->check(not_empty())
      ->required();
  offer_json(*check, line, "Print one JSON object per problem and per valid file");
}

void add_file_commands(CLI::App& group, CommandLine& line, FileKind kind) {
  const std::string what = kind == FileKind::kScenario ? "scenario" : "scene";
  auto [diff, diff_command] = add_command<FileDiffCommand>(
      group, line, "diff", "Compare what two files describe; needs no daemon");
  diff_command->kind = kind;
  diff->add_option("BEFORE", diff_command->before, "Name of a shipped " + what + ", or a file")
      ->check(not_empty())
      ->required();
  diff->add_option("AFTER", diff_command->after, "The same")->check(not_empty())->required();
  offer_json(*diff, line, "Print the differences as one JSON object");
  auto [format, format_command] = add_command<FileFormatCommand>(
      group, line, "format", "Print files in the common form, with comments; needs no daemon");
  format_command->kind = kind;
  format->add_option("FILE", format_command->files, "Names of shipped " + what + "s, or files")
      ->check(not_empty())
      ->required();
  CLI::Option* check = format->add_flag("--check", format_command->check,
                                        "Name the files that are not formatted, and fail");
  format->add_flag("--write", format_command->write, "Replace the files")->excludes(check);
  auto [schema, schema_command] = add_command<FileSchemaCommand>(
      group, line, "schema", "Print the JSON schema of these files, for editors; needs no daemon");
  schema_command->kind = kind;
  if (kind == FileKind::kScenario) return;
  schema->add_flag_callback(
      "--types", [command = schema_command] { command->kind = FileKind::kTypes; },
      "Print the schema of files of types");
}

}  // namespace aprsim::client
