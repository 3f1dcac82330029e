#include "clients/aprsim/commands/completion.hpp"

#include <algorithm>
#include <ostream>
#include <vector>

#include <fmt/format.h>

#include "clients/aprsim/cli/command_tree.hpp"
#include "clients/wires/endpoints.hpp"
#include "world/api/faults/fault_kinds.hpp"

namespace aprsim::client {
namespace {

/// Candidates for an argument: words, files, or none.
struct Candidates {
  std::vector<std::string> words;
  bool files = false;
};

Candidates candidates(const OptionInfo& option) {
  if (option.value == "FILE") return {{}, true};
  if (option.value == "KIND") {
    Candidates kinds;
    for (const auto& kind : faults::all_kinds()) kinds.words.emplace_back(kind.name);
    return kinds;
  }
  if (option.value != "ROBOT") return {choices(option)};
  Candidates robots;
  for (const auto& [name, port] : Endpoints().crcl) robots.words.push_back(name);
  return robots;
}

/// A command and all its subcommands, with their paths.
void collect(const CommandInfo& command, std::vector<const CommandInfo*>& out) {
  out.push_back(&command);
  for (const auto& sub : command.commands) collect(sub, out);
}

/// Quotes the text as one word of a shell.
std::string shell_word(std::string_view text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

std::string bash_value(const OptionInfo& option) {
  const auto values = candidates(option);
  return values.files ? "files" : fmt::format("words {}", fmt::join(values.words, " "));
}

bool has_option(const CommandInfo& command, const std::string& name) {
  return std::ranges::any_of(command.options, [&](const OptionInfo& option) {
    return std::ranges::find(option.names, name) != option.names.end();
  });
}

/// "x|y) body ;;" for bash's case, in which whole paths stand for commands.
void bash_options(const CommandInfo& command, const std::string& path, std::string& out) {
  for (const auto& option : command.options) {
    if (option.value.empty() || option.positional) continue;
    std::vector<std::string> patterns;
    for (const auto& name : option.names) patterns.push_back(path + shell_word(" " + name));
    out += fmt::format("      {}) value={} ;;\n", fmt::join(patterns, " | "),
                       shell_word(bash_value(option)));
  }
}

/// The names of a command's options without those in `others`.
std::string all_names(const CommandInfo& command, const CommandInfo* others = nullptr) {
  std::string out;
  for (const auto& option : command.options) {
    for (const auto& name : option.names) {
      if (others == nullptr || !has_option(*others, name)) out += (out.empty() ? "" : " ") + name;
    }
  }
  return out;
}

std::string positional_value(const CommandInfo& command) {
  for (const auto& option : command.options) {
    if (option.positional) return bash_value(option);
  }
  std::string names;
  for (const auto& sub : command.commands) names += " " + sub.name;
  return "words" + names;
}

/// Text inside the brackets of zsh's _arguments, or beside its colons.
std::string zsh_text(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '[' || c == ']' || c == ':' || c == '\\') out += '\\';
    out += c;
  }
  return out;
}

std::string zsh_action(const OptionInfo& option) {
  const auto values = candidates(option);
  if (values.files) return "_files";
  if (values.words.empty()) return " ";
  return fmt::format("({})", fmt::join(values.words, " "));
}

/// ":message:action" for each word that the option takes; placeholders are apart by blanks.
std::string zsh_values(const OptionInfo& option) {
  std::string out;
  for (std::size_t begin = 0; begin < option.value.size();) {
    const std::size_t end = std::min(option.value.find(' ', begin), option.value.size());
    out += fmt::format(":{}:{}", zsh_text(option.value.substr(begin, end - begin)),
                       zsh_action(option));
    begin = end + 1;
  }
  return out;
}

/// The specifications of a command's options without those that `others` has as well.
void zsh_specs(const CommandInfo& command, std::string& out, const CommandInfo* others = nullptr) {
  for (const auto& option : command.options) {
    if (option.positional) {
      out +=
          fmt::format(" \\\n    {}",
                      shell_word(fmt::format(":{}:{}", zsh_text(option.help), zsh_action(option))));
    }
    for (const auto& name : option.names) {
      if (others != nullptr && has_option(*others, name)) continue;
      // Offering an option again does no harm.
      out += fmt::format(
          " \\\n    {}",
          shell_word(fmt::format("*{}[{}]{}", name, zsh_text(option.help), zsh_values(option))));
    }
  }
}

std::string zsh_function(const std::string& path) {
  std::string out = "_" + path;
  for (char& c : out) c = c == ' ' ? '_' : c;
  return out;
}

void zsh_command(const CommandInfo& command, const CommandInfo& program, std::string& out) {
  const std::string name = zsh_function(command.path);
  std::string specs;
  zsh_specs(command, specs);
  if (&command != &program) zsh_specs(program, specs, &command);
  if (command.commands.empty()) {
    out += fmt::format("{}() {{\n  _arguments{}\n}}\n\n", name, specs);
    return;
  }
  out += fmt::format("{}_commands() {{\n  local -a commands=(\n", name);
  for (const auto& sub : command.commands) {
    out += fmt::format("    {}\n", shell_word(zsh_text(sub.name) + ":" + zsh_text(sub.help)));
  }
  out += "  )\n  _describe -t commands command commands\n}\n\n";
  out += fmt::format(
      "{0}() {{\n  local context state state_descr line\n  typeset -A opt_args\n"
      "  _arguments -C{1} \\\n    '1: :{0}_commands' \\\n    '*:: :->rest'\n"
      "  [[ $state == rest ]] || return\n  case $line[1] in\n",
      name, specs);
  for (const auto& sub : command.commands) {
    out += fmt::format("    {}) {} ;;\n", sub.name, zsh_function(sub.path));
  }
  out += "  esac\n}\n\n";
  for (const auto& sub : command.commands) zsh_command(sub, program, out);
}

}  // namespace

std::string bash_completion() {
  const CommandInfo program = command_tree();
  std::vector<const CommandInfo*> all;
  collect(program, all);
  std::string commands, values, words;
  for (const auto* command : all) {
    if (command != &program) {
      commands += (commands.empty() ? "" : " | ") + shell_word(command->path);
      bash_options(*command, shell_word(command->path), values);
    }
    words += fmt::format("    {}) options={}; value=${{value:-{}}} ;;\n", shell_word(command->path),
                         shell_word(command == &program ? "" : all_names(*command, &program)),
                         positional_value(*command));
  }
  // Options of the program may follow every command, after the command's own.
  bash_options(program, "*", values);
  return fmt::format(R"(# Completion of aprsim for bash, as "aprsim completion bash" prints it.
_aprsim() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} path=aprsim value='' options='' before i
  COMPREPLY=()
  [[ $word != = ]] || word=''
  # Down to the command; an option's value is passed over.
  for ((i = 1; i < COMP_CWORD; i++)); do
    before=${{COMP_WORDS[i]}}
    [[ $before != = ]] || continue
    if [[ $value ]]; then
      value=''
      continue
    fi
    case "$path $before" in
      {}) path+=" $before" ;;
{}    esac
  done
  if [[ $word == -* && ! $value ]]; then value=options; fi
  case $path in
{}  esac
  case $value in
    options) mapfile -t COMPREPLY < <(compgen -W "$options {}" -- "$word") ;;
    files)
      compopt -o filenames 2>/dev/null
      mapfile -t COMPREPLY < <(compgen -f -- "$word")
      ;;
    *) mapfile -t COMPREPLY < <(compgen -W "${{value#words}}" -- "$word") ;;
  esac
}}
complete -F _aprsim aprsim
)",
                     commands, values, words, all_names(program));
}

std::string zsh_completion() {
  const CommandInfo program = command_tree();
  std::string out =
      "#compdef aprsim\n# Completion of aprsim for zsh, as \"aprsim completion zsh\" prints "
      "it.\n\n";
  zsh_command(program, program, out);
  return out +
         "if [[ $funcstack[1] == _aprsim ]]; then\n  _aprsim \"$@\"\nelse\n"
         "  compdef _aprsim aprsim\nfi\n";
}

}  // namespace aprsim::client
