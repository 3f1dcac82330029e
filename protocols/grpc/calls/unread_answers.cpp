#include "protocols/grpc/calls/unread_answers.hpp"

#include <utility>

#include <fmt/format.h>
#include <grpcpp/server_context.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/interceptor.h>

#include "protocols/grpc/calls/call_peer.hpp"

namespace aprsim::grpc_server {
namespace {

using grpc::experimental::InterceptionHookPoints;

/// gRPC offers it on the two kinds of contexts, and not on their base.
void cancel_call(grpc::ServerContextBase& context) {
  if (const auto* callback = dynamic_cast<grpc::CallbackServerContext*>(&context)) {
    callback->TryCancel();
  } else if (const auto* other = dynamic_cast<grpc::ServerContext*>(&context)) {
    other->TryCancel();
  }
}

/// Whether a batch of operations that sent something is done. gRPC reports it without a hook point:
/// kPostSendMessage is left out once the serialized message has been asked for.
bool has_sent(grpc::experimental::InterceptorBatchMethods& methods) {
  for (int i = 0; i < static_cast<int>(InterceptionHookPoints::NUM_INTERCEPTION_HOOKS); ++i) {
    const auto point = static_cast<InterceptionHookPoints>(i);
    if (point != InterceptionHookPoints::POST_SEND_MESSAGE &&
        methods.QueryInterceptionHookPoint(point)) {
      return false;
    }
  }
  return true;
}

/// Counts the messages of one call, of which gRPC sends one at a time.
class Holding final : public grpc::experimental::Interceptor {
 public:
  Holding(UnreadAnswers& answers, grpc::ServerContextBase& context)
      : answers_(answers), context_(context) {}
  ~Holding() override { answers_.remove(number_); }

  void Intercept(grpc::experimental::InterceptorBatchMethods* methods) override {
    const bool sends_message =
        methods->QueryInterceptionHookPoint(InterceptionHookPoints::PRE_SEND_MESSAGE);
    if (sends_message) {
      const grpc::ByteBuffer* message = methods->GetSerializedSendMessage();
      answers_.remove(number_);
      number_ = message == nullptr
                    ? 0
                    : answers_.add([&context = context_] { cancel_call(context); }, context_.peer(),
                                   message->Length() + UnreadAnswers::kCallBytes);
    }
    if (!sends_message &&
        methods->QueryInterceptionHookPoint(InterceptionHookPoints::PRE_SEND_INITIAL_METADATA)) {
      sends_metadata_ = true;
    }
    // Metadata of a batch of their own are sent before the first message.
    if (has_sent(*methods) && !std::exchange(sends_metadata_, false)) {
      answers_.remove(std::exchange(number_, 0));
    }
    methods->Proceed();
  }

 private:
  UnreadAnswers& answers_;
  grpc::ServerContextBase& context_;
  std::uint64_t number_ = 0;
  bool sends_metadata_ = false;  ///< a batch of its own is on its way
};

class HoldingFactory final : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  HoldingFactory(UnreadAnswers& answers, std::function<bool(std::string_view)> counts)
      : answers_(answers), counts_(std::move(counts)) {}
  grpc::experimental::Interceptor* CreateServerInterceptor(
      grpc::experimental::ServerRpcInfo* info) override {
    const std::string_view method(info->method() == nullptr ? "" : info->method());
    // gRPC takes it over; null = none for this call.
    return counts_(method) ? new Holding(answers_, *info->server_context()) : nullptr;
  }

 private:
  UnreadAnswers& answers_;
  const std::function<bool(std::string_view)> counts_;
};

}  // namespace

std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> UnreadAnswers::interceptor(
    std::function<bool(std::string_view method)> counts) {
  return std::make_unique<HoldingFactory>(*this, std::move(counts));
}

std::uint64_t UnreadAnswers::add(std::function<void()> cancel, std::string peer,
                                 std::size_t bytes) {
  const std::lock_guard lock(mutex_);
  bytes_ += bytes;
  // The newest message stays: most clients read it at once.
  for (auto& [number, message] : messages_) {
    if (bytes_ <= max_bytes_) break;
    give_up(message, fmt::format("unread answers exceed {} MB", max_bytes_ >> 20U));
  }
  messages_[++last_number_] = {std::move(cancel), std::move(peer), bytes, Clock::now()};
  return last_number_;
}

void UnreadAnswers::remove(std::uint64_t number) {
  const std::lock_guard lock(mutex_);
  const auto found = messages_.find(number);
  if (found == messages_.end()) return;
  if (!found->second.cancelled) bytes_ -= found->second.bytes;
  messages_.erase(found);
}

void UnreadAnswers::cancel_stuck(Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  for (auto& [number, message] : messages_) {
    if (now - message.since < timeout_) break;
    give_up(message, fmt::format("an answer was not read within {} ms", timeout_.count()));
  }
}

void UnreadAnswers::give_up(Message& message, const std::string& why) {
  if (std::exchange(message.cancelled, true)) return;
  log_.warn(fmt::format("ending a call of {}: {}", call_peer(message.peer).address, why));
  bytes_ -= message.bytes;
  message.cancel();
}

std::size_t UnreadAnswers::bytes() const {
  const std::lock_guard lock(mutex_);
  return bytes_;
}

}  // namespace aprsim::grpc_server
