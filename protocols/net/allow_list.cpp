#include "protocols/net/allow_list.hpp"

#include <algorithm>

namespace aprsim::protocols {
namespace {

namespace ip = boost::asio::ip;
using boost::system::error_code;

}  // namespace

Result<AllowList> AllowList::from(const std::vector<std::string>& networks,
                                  const std::string& field) {
  AllowList list;
  for (const std::string& text : networks) {
    const bool one = text.find('/') == std::string::npos;
    error_code v4_error, v6_error;
    const auto v4 = ip::make_network_v4(one ? text + "/32" : text, v4_error);
    const auto v6 = ip::make_network_v6(one ? text + "/128" : text, v6_error);
    if (!v4_error) {
      list.v4_.push_back(v4);
    } else if (!v6_error) {
      list.v6_.push_back(v6);
    } else {
      return fail(ErrorCode::kInvalidArgument, field,
                  "'" + text + "' is neither an address nor a network such as 192.168.1.0/24");
    }
  }
  return list;
}

bool AllowList::allows(const ip::address& address) const {
  if (v4_.empty() && v6_.empty()) return true;
  if (address.is_v6() && !address.to_v6().is_v4_mapped()) {
    const ip::address_v6 v6(address.to_v6().to_bytes());  // without its scope
    return std::any_of(v6_.begin(), v6_.end(), [&](const ip::network_v6& network) {
      return ip::network_v6(v6, network.prefix_length()).network() == network.network();
    });
  }
  const ip::address_v4 v4 =
      address.is_v4() ? address.to_v4() : ip::make_address_v4(ip::v4_mapped, address.to_v6());
  return std::any_of(v4_.begin(), v4_.end(), [&](const ip::network_v4& network) {
    return ip::network_v4(v4, network.prefix_length()).network() == network.network();
  });
}

bool is_network(const std::string& text) { return AllowList::from({text}, "").has_value(); }

}  // namespace aprsim::protocols
