#include "server/journal/command_message.hpp"

#include <limits>
#include <optional>
#include <utility>

#include "protocols/messages/codecs.hpp"
#include "world/api/commands/command_fields.hpp"

namespace aprsim::protocols {

/// No factor, as fast as possible, is infinite.
template <>
struct Codec<api::SetSpeed> {
  static constexpr double kFastest = std::numeric_limits<double>::infinity();
  static double number(const api::SetSpeed& speed) { return speed.factor.value_or(kFastest); }
  static api::SetSpeed value(double factor) {
    return {factor == kFastest ? std::nullopt : std::optional(factor)};
  }
};

/// Another scene is recorded as the text that was read, whether it was named or sent.
template <>
struct Codec<api::Reset> {
  static void write(const api::Reset& reset, v1::ResetCommand& message) {
    api::Reset recorded{reset.seed};
    if (reset.next) {
      recorded.scene_name = reset.next->name();
      recorded.scene_text = reset.next->text();
    }
    write_fields(recorded, message);
  }
};

}  // namespace aprsim::protocols

namespace aprsim::server::journal {

void write_message(const api::Command& command, v1::JournalCommand& message) {
  protocols::write_fields(command, message);
}

Result<api::Command> to_command(const v1::JournalCommand& message) {
  api::Command command;
  return protocols::read_fields(message, command).map([&] { return std::move(command); });
}

}  // namespace aprsim::server::journal
