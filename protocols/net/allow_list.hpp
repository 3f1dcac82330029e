#pragma once

#include <string>
#include <vector>

#include <boost/asio/ip/address.hpp>
#include <boost/asio/ip/network_v4.hpp>
#include <boost/asio/ip/network_v6.hpp>

#include "world/base/result.hpp"

namespace aprsim::protocols {

/// The networks whose clients are served. Thread: any, once built.
class AllowList {
 public:
  /// Each entry is an IPv4 or IPv6 network, "192.168.1.0/24", or one address. None = everybody.
  /// Errors name the entry and `field`, the key of the entries.
  [[nodiscard]] static Result<AllowList> from(const std::vector<std::string>& networks,
                                              const std::string& field);

  /// An IPv4 address mapped into IPv6 counts as the IPv4 one.
  [[nodiscard]] bool allows(const boost::asio::ip::address& address) const;

 private:
  std::vector<boost::asio::ip::network_v4> v4_;
  std::vector<boost::asio::ip::network_v6> v6_;
};

/// Whether a text is a valid entry.
[[nodiscard]] bool is_network(const std::string& text);

}  // namespace aprsim::protocols
