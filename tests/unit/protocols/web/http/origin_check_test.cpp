#include "protocols/web/http/origin_check.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace aprsim::web {
namespace {

TEST(OriginCheck, KnowsItsOwnHosts) {
  const std::vector<std::string> names = {"cell.example"};
  for (const char* own :
       {"localhost", "LOCALHOST:80", "127.0.0.1:8080", "192.168.1.5", "[::1]:8080", "cell.example",
        "Cell.Example:1", "localhost.", "Cell.Example.:8080"}) {
    EXPECT_TRUE(is_own_host(own, names)) << own;
  }
  for (const char* foreign :
       {"", "evil.example", "localhost.evil.example", "127.0.0.1.evil.example", "localhost:80:90",
        "[::1", "localhost:x", "cell.example@evil", ":80", "localhost..", ".", "localhost /"}) {
    EXPECT_FALSE(is_own_host(foreign, names)) << foreign;
  }
}

TEST(OriginCheck, KnowsItsOwnPage) {
  EXPECT_TRUE(is_same_origin("", "localhost:8080"));
  EXPECT_TRUE(is_same_origin("http://localhost:8080", "localhost:8080"));
  EXPECT_TRUE(is_same_origin("https://localhost:8080", "localhost:8080"));
  for (const char* foreign : {"null", "http://localhost:8081", "http://localhost", "file://",
                              "http://localhost:8080.evil.example", "ftp://localhost:8080"}) {
    EXPECT_FALSE(is_same_origin(foreign, "localhost:8080")) << foreign;
  }
}

}  // namespace
}  // namespace aprsim::web
