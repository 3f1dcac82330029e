// Any bytes as a capture of a network: taken apart, put together, read as the wires' documents.
#include <cstddef>
#include <cstdint>
#include <string>
#include <sys/mman.h>
#include <unistd.h>

#include "clients/aprsim/trace/action.hpp"
#include "clients/aprsim/trace/capture.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace aprsim::trace;
  // Files without a name, since libpcap reads files.
  const int capture = memfd_create("capture", 0), journal = memfd_create("journal", 0);
  const auto place = [](int descriptor) { return "/proc/self/fd/" + std::to_string(descriptor); };
  if (write(capture, data, size) == static_cast<ssize_t>(size)) {
    if (const auto imported = import_capture(place(capture), place(journal), usual_ports())) {
      if (const auto trace = read_trace(place(journal))) static_cast<void>(actions_of(*trace));
    }
  }
  close(capture);
  close(journal);
  return 0;
}
