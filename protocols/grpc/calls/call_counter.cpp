#include "protocols/grpc/calls/call_counter.hpp"

#include <chrono>

#include <grpcpp/support/interceptor.h>

namespace aprsim::grpc_server {
namespace {

using grpc::experimental::InterceptionHookPoints;

/// Counts one call.
class Counting final : public grpc::experimental::Interceptor {
 public:
  Counting(CallCounter& counter, bool stream) : counter_(counter), stream_(stream) {
    counter_.begun();
  }

  void Intercept(grpc::experimental::InterceptorBatchMethods* methods) override {
    if (methods->QueryInterceptionHookPoint(InterceptionHookPoints::PRE_SEND_STATUS)) {
      counter_.ended(methods->GetSendStatus().ok(), stream_, Clock::now() - begun_);
    }
    methods->Proceed();
  }

 private:
  using Clock = std::chrono::steady_clock;

  CallCounter& counter_;
  const bool stream_;
  const Clock::time_point begun_ = Clock::now();
};

class Factory final : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  explicit Factory(CallCounter& counter) : counter_(counter) {}
  grpc::experimental::Interceptor* CreateServerInterceptor(
      grpc::experimental::ServerRpcInfo* info) override {
    // gRPC takes it over.
    return new Counting(counter_, info->type() != grpc::experimental::ServerRpcInfo::Type::UNARY);
  }

 private:
  CallCounter& counter_;
};

}  // namespace

std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>>
CallCounter::interceptors() {
  std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>> all;
  all.push_back(std::make_unique<Factory>(*this));
  return all;
}

CallCounts CallCounter::counts() const {
  const std::lock_guard lock(mutex_);
  return {begun_, failed_, times_.counts()};
}

void CallCounter::begun() {
  const std::lock_guard lock(mutex_);
  ++begun_;
}

void CallCounter::ended(bool ok, bool stream, std::chrono::nanoseconds time) {
  const std::lock_guard lock(mutex_);
  if (!ok) ++failed_;
  if (!stream) times_.add(time);
}

}  // namespace aprsim::grpc_server
