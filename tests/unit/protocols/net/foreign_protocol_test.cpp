#include "protocols/net/foreign_protocol.hpp"

#include <string>

#include <gtest/gtest.h>

namespace aprsim::protocols {
namespace {

TEST(ForeignProtocol, KnowsWhatBrowsersSend) {
  for (const std::string request : {"GET / HTTP/1.1", "POST /x HTTP/1.1", "OPTIONS * HTTP/1.1"}) {
    // Whole or in pieces of any size.
    for (std::size_t size = 1; size <= request.size(); ++size) {
      EXPECT_EQ(foreign_protocol(request.substr(0, size)), "HTTP") << size;
    }
  }
  EXPECT_EQ(foreign_protocol("PRI * HTTP/2.0\r\n"), "HTTP");
  EXPECT_EQ(foreign_protocol("\x16\x03\x01"), "TLS");
}

TEST(ForeignProtocol, LeavesControllersAlone) {
  for (const char* text : {"", "<?xml", "<CRCLCommandInstance", " \r\n<?xml", "\xef\xbb\xbf<?xml",
                           "GETTING", "hello"}) {
    EXPECT_EQ(foreign_protocol(text), "") << text;
  }
}

}  // namespace
}  // namespace aprsim::protocols
