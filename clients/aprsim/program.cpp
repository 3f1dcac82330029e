#include "clients/aprsim/program.hpp"

#include <cstddef>
#include <string>
#include <variant>

namespace aprsim::client {
namespace {

constexpr std::size_t kMaxCommands = 1'000'000;

class Expander {
 public:
  explicit Expander(const std::vector<crcl::Command>& commands) : commands_(commands) {}

  Outcome<std::vector<crcl::Command>> expand() {
    if (auto done = expand_block(0, ""); !done) return tl::unexpected(done.error());
    return std::move(out_);
  }

 private:
  /// From `index` to the end of the named loop, or of the program when the name is empty. Gives the
  /// index behind it and leaves the block's own length and count in last_count_.
  Outcome<std::size_t> expand_block(std::size_t index, const std::string& loop) {
    const std::size_t begin = out_.size();
    while (index < commands_.size()) {
      const auto& body = commands_[index].body;
      if (const auto* start = std::get_if<crcl::LoopBlockStart>(&body)) {
        auto next = expand_block(index + 1, start->loop);
        if (!next) return next;
        index = *next;
        continue;
      }
      if (const auto* end = std::get_if<crcl::LoopBlockEnd>(&body)) {
        if (end->loop != loop) {
          return failed(FailureKind::kUsage, "the end of loop '" + end->loop +
                                                 "' stands where that of '" + loop + "' should");
        }
        if (auto done = repeat(begin, end->max_count); !done) return tl::unexpected(done.error());
        return index + 1;
      }
      out_.push_back(commands_[index++]);
    }
    if (!loop.empty()) return failed(FailureKind::kUsage, "loop '" + loop + "' has no end");
    return index;
  }

  /// Makes the commands from `begin` on come `count` times.
  Outcome<void> repeat(std::size_t begin, int count) {
    const std::size_t length = out_.size() - begin;
    const auto times = static_cast<std::size_t>(std::max(count, 0));
    if (times > 0 && length > 0 && times > kMaxCommands / length) {
      return failed(FailureKind::kUsage, "the program's loops make more than a million commands");
    }
    if (times == 0) out_.resize(begin);
    for (std::size_t i = 1; i < times; ++i) {
      for (std::size_t k = 0; k < length; ++k) out_.push_back(out_[begin + k]);
    }
    return {};
  }

  const std::vector<crcl::Command>& commands_;
  std::vector<crcl::Command> out_;
};

}  // namespace

Outcome<std::vector<crcl::Command>> expand_loops(const crcl::Program& program) {
  return Expander(program.commands).expand();
}

}  // namespace aprsim::client
