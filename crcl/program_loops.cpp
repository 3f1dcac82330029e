#include "crcl/program_loops.hpp"

#include <algorithm>
#include <string>
#include <utility>
#include <variant>

#include "crcl/command_codec.hpp"
#include "crcl/text.hpp"

namespace aprsim::crcl {
namespace {

struct Block {
  std::string loop;
  std::size_t begin;  // of its commands in the output
};

tl::unexpected<Error> wrong(const Command& command, const std::string& loop, std::string expected) {
  Error error;
  error.kind = ErrorKind::kBadValue;
  error.element = std::string(type_name(command.body)) + "/LoopName";
  error.value = shorten(loop);
  error.expected = std::move(expected);
  error.command_type = type_name(command.body);
  error.command_id = command.id;
  return tl::unexpected<Error>(std::move(error));
}

// Makes the last `length` commands come `times` times; false when that is too many.
bool repeat(std::vector<std::size_t>& out, std::size_t length, std::size_t times, std::size_t max) {
  const std::size_t before = out.size() - length;
  if (times == 0) {
    out.resize(before);
    return true;
  }
  if (length > 0 && times > (max - std::min(max, before)) / length) return false;
  for (std::size_t i = 1; i < times; ++i) {
    for (std::size_t k = 0; k < length; ++k) out.push_back(out[before + k]);
  }
  return true;
}

}  // namespace

Result<std::vector<std::size_t>> expand_loops(const Program& program, std::size_t max_commands) {
  std::vector<std::size_t> out;
  std::vector<Block> open;
  for (std::size_t i = 0; i < program.commands.size(); ++i) {
    const Command& command = program.commands[i];
    if (const auto* start = std::get_if<LoopBlockStart>(&command.body)) {
      open.push_back({start->loop, out.size()});
    } else if (const auto* end = std::get_if<LoopBlockEnd>(&command.body)) {
      if (open.empty()) return wrong(command, end->loop, "expected the start of this loop before");
      if (open.back().loop != end->loop) {
        return wrong(command, end->loop, "expected the end of loop " + open.back().loop);
      }
      const auto times = static_cast<std::size_t>(std::max(end->max_count, 0));
      if (!repeat(out, out.size() - open.back().begin, times, max_commands)) {
        return wrong(command, end->loop,
                     "expected at most " + std::to_string(max_commands) + " commands in all");
      }
      open.pop_back();
    } else {
      out.push_back(i);
    }
  }
  if (!open.empty()) {
    return wrong(program.commands.back(), open.back().loop, "this loop has no end");
  }
  return out;
}

}  // namespace aprsim::crcl
