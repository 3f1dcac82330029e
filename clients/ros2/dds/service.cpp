#include "clients/ros2/dds/service.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

namespace aprsim::ros2 {
namespace {

constexpr std::chrono::seconds kReplyPatience{5};
constexpr std::size_t kMostReplies = 64;
constexpr std::size_t kMostReaders = 1024;

/// The value of a key in user data of the form "key=value;..."; empty = there is none.
std::string entry_of(const dds_builtintopic_endpoint_t& endpoint, const std::string& key) {
  void* bytes = nullptr;
  std::size_t size = 0;
  if (!dds_qget_userdata(endpoint.qos, &bytes, &size) || bytes == nullptr) return {};
  const std::string text(static_cast<const char*>(bytes), size);
  dds_free(bytes);
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find(';', at), text.size());
    if (text.compare(at, key.size() + 1, key + "=") == 0) {
      return text.substr(at + key.size() + 1, end - at - key.size() - 1);
    }
    at = end + 1;
  }
  return {};
}

/// The client whose endpoint it is; takes the endpoint's data.
std::string client_entry(dds_builtintopic_endpoint_t* endpoint) {
  if (endpoint == nullptr) return {};
  std::string id = entry_of(*endpoint, "clientid");
  dds_builtintopic_free_endpoint(endpoint);
  return id;
}

}  // namespace

Service::Service(Node& node, const std::string& name, const TopicType& request,
                 const TopicType& reply)
    : node_(node), ends_(node.create_service(name, request, reply)) {}

Service::~Service() {
  node_.remove(ends_.requests);
  node_.remove(ends_.replies);
}

std::string Service::client_of(dds_instance_handle_t writer) const {
  return client_entry(dds_get_matched_publication_data(ends_.requests, writer));
}

bool Service::is_known(const std::string& client_id) const {
  std::array<dds_instance_handle_t, kMostReaders> readers{};
  const auto count = dds_get_matched_subscriptions(ends_.replies, readers.data(), readers.size());
  const auto found = std::min(static_cast<std::size_t>(std::max(count, 0)), readers.size());
  return std::any_of(readers.begin(), readers.begin() + found, [&](dds_instance_handle_t reader) {
    return client_entry(dds_get_matched_subscription_data(ends_.replies, reader)) == client_id;
  });
}

void Service::take(const std::function<void(const Caller&, const void*)>& serve) {
  void* sample = nullptr;
  dds_sample_info_t info;
  while (dds_take(ends_.requests, &sample, &info, 1, 1) == 1) {
    if (info.valid_data) {
      Caller caller;
      std::memcpy(&caller.header, sample, sizeof caller.header);
      caller.client_id = client_of(info.publication_handle);
      if (!caller.client_id.empty()) serve(caller, sample);
    }
    dds_return_loan(ends_.requests, &sample, 1);
    sample = nullptr;
  }
  send_waiting();
}

void Service::reply(const Caller& caller, WriteReply write) {
  if (waiting_.size() == kMostReplies) waiting_.erase(waiting_.begin());
  waiting_.push_back({caller, std::move(write), std::chrono::steady_clock::now() + kReplyPatience});
  send_waiting();
}

void Service::send_waiting() {
  const auto now = std::chrono::steady_clock::now();
  std::erase_if(waiting_, [&](const Waiting& one) {
    if (!is_known(one.caller.client_id)) return now >= one.until;
    one.write(ends_.replies, one.caller.header);
    return true;
  });
}

}  // namespace aprsim::ros2
