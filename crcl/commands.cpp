#include "crcl/commands.hpp"

namespace aprsim::crcl {

CommandBody::CommandBody() = default;
CommandBody::CommandBody(const CommandBody& other) = default;
CommandBody::CommandBody(CommandBody&& other) noexcept = default;
CommandBody& CommandBody::operator=(const CommandBody& other) = default;
CommandBody& CommandBody::operator=(CommandBody&& other) noexcept = default;
CommandBody::~CommandBody() = default;

bool CommandBody::operator==(const CommandBody& other) const {
  return static_cast<const AnyCommand&>(*this) == static_cast<const AnyCommand&>(other);
}

}  // namespace aprsim::crcl
