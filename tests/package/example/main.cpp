// Reads CRCL commands as they come over a socket, here from standard input, prints each as protobuf
// text, and answers the last of them with a status.

#include <iostream>
#include <iterator>
#include <string>

#include "crcl/framer.hpp"
#include "crcl/messages.hpp"
#include "crcl/units.hpp"

namespace crcl = aprsim::crcl;

int main() {
  crcl::Framer framer = crcl::Framer::for_commands();
  framer.append(std::string(std::istreambuf_iterator<char>(std::cin), {}));

  crcl::v1::Status status;
  for (auto document = framer.next(); document && *document; document = framer.next()) {
    const auto message = crcl::command_message(**document);
    if (!message) {
      std::cerr << message.error().message() << '\n';
      return 1;
    }
    std::cout << message->DebugString();
    if (message->command().has_move_to()) {
      const double x = message->command().move_to().end_position().point().x();
      std::cout << "# x is " << crcl::to_si(x, crcl::LengthUnit::kMillimeter) << " m\n";
    }
    status.mutable_command_status()->set_command_id(message->command().command_id());
  }

  status.mutable_command_status()->set_status_id(1);
  status.mutable_command_status()->set_command_state(crcl::v1::COMMAND_STATE_DONE);
  std::cout << crcl::to_document(status) << '\n';
}
