// The table of roles against what can be asked for: every method of every service and every request
// of a page has a row, and nothing else does.

#include "protocols/access/call_roles.hpp"

#include <memory>
#include <set>
#include <string>

#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor_database.h>
#include <grpcpp/generic/generic_stub.h>
#include <gtest/gtest.h>

#include "aprsim/v1/web.pb.h"
#include "tests/support/access_with.hpp"
#include "tests/unit/protocols/grpc/telemetry_fixture.hpp"

namespace aprsim::test {
namespace {

using google::protobuf::DescriptorPool;

std::set<std::string> rows() {
  std::set<std::string> all;
  for (const auto& row : protocols::call_roles()) {
    EXPECT_TRUE(all.emplace(row.call).second) << row.call << " has two rows";
  }
  return all;
}

/// All methods of the package's services, which are linked into this program.
std::set<std::string> methods() {
  std::set<std::string> all;
  for (const char* file :
       {"aprsim/v1/telemetry_service.proto", "aprsim/v1/control_service.proto"}) {
    EXPECT_NE(DescriptorPool::generated_pool()->FindFileByName(file), nullptr) << file;
  }
  // The pool finds a file when it is asked for it.
  std::vector<std::string> names;
  DescriptorPool::internal_generated_database()->FindAllFileNames(&names);
  for (const std::string& name : names) {
    if (!name.starts_with("aprsim/")) continue;
    const auto* file = DescriptorPool::generated_pool()->FindFileByName(name);
    for (int s = 0; s < file->service_count(); ++s) {
      for (int m = 0; m < file->service(s)->method_count(); ++m) {
        all.insert(file->service(s)->full_name() + "/" + file->service(s)->method(m)->name());
      }
    }
  }
  return all;
}

std::set<std::string> requests() {
  std::set<std::string> all;
  const auto* body = v1::ViewerRequest::descriptor()->FindOneofByName("body");
  for (int i = 0; i < body->field_count(); ++i) {
    all.insert("aprsim.v1.ViewerRequest/" + body->field(i)->name());
  }
  return all;
}

TEST(CallRoles, EveryMethodAndRequestHasARow) {
  const auto all = rows();
  for (const auto& calls : {methods(), requests()}) {
    EXPECT_GE(calls.size(), 18U);
    for (const std::string& call : calls) EXPECT_TRUE(all.contains(call)) << call;
  }
}

TEST(CallRoles, EveryRowIsOfSomethingThatThereIs) {
  const auto known = methods(), of_pages = requests();
  for (const std::string& row : rows()) {
    if (!row.starts_with("aprsim.v1.")) continue;
    EXPECT_TRUE(known.contains(row) || of_pages.contains(row)) << row;
  }
}

TEST(CallRoles, CallsWithoutARowAreForAdmins) {
  EXPECT_EQ(protocols::role_needed("aprsim.v1.ControlService/Destroy"), protocols::Role::kAdmin);
  EXPECT_EQ(protocols::role_needed("/aprsim.v1.ControlService/Pause"), protocols::Role::kOperate);
  EXPECT_EQ(protocols::role_needed("/healthz"), protocols::Role::kNone);
}

/// Calls any method with an empty request, by its name.
class AnyCall : public TelemetryFixture {
 protected:
  grpc::Status call(const std::string& method, const std::string& token) {
    grpc::GenericStub stub(new_channel());
    grpc::ClientContext context;
    set_deadline(context, std::chrono::seconds(60));
    if (!token.empty()) context.AddMetadata("authorization", "Bearer " + token);
    grpc::CompletionQueue queue;
    const auto wait = [&queue] {
      void* tag = nullptr;
      bool ok = false;
      return queue.Next(&tag, &ok) && ok;
    };
    const auto stream = stub.PrepareCall(&context, "/" + method, &queue);
    stream->StartCall(this);
    bool open = wait();
    if (open)
      stream->WriteLast(grpc::ByteBuffer(nullptr, 0), grpc::WriteOptions(), this), open = wait();
    grpc::ByteBuffer answer;
    // One answer is enough of a stream.
    stream->Read(&answer, this);
    answered = wait();
    if (answered) context.TryCancel();
    grpc::Status status;
    stream->Finish(&status, this);
    (void)wait();
    queue.Shutdown();
    return answered ? grpc::Status::OK : status;
  }

  bool answered = false;
};

/// A new method without a check of its caller is found here.
TEST_F(AnyCall, IsRefusedWithoutItsRoleAndDoesNothing) {
  for (const auto others : {protocols::Role::kNone, protocols::Role::kView}) {
    auto rules = rules_with_tokens();
    rules.local = others;
    start({.listener = {.access = std::make_shared<protocols::Access>(rules)}});
    for (const std::string& method : methods()) {
      const protocols::Role needed = protocols::role_needed(method);
      if (others >= needed) continue;
      EXPECT_EQ(call(method, "").error_code(), grpc::StatusCode::UNAUTHENTICATED) << method;
      EXPECT_FALSE(answered) << method << " answers who may not ask";
      for (const auto has :
           {protocols::Role::kView, protocols::Role::kOperate, protocols::Role::kInject}) {
        if (has >= needed) continue;
        const std::string name(protocols::to_text(has));
        const auto status = call(method, name + "-token");
        EXPECT_EQ(status.error_code(), grpc::StatusCode::PERMISSION_DENIED)
            << method << ' ' << name;
        EXPECT_NE(status.error_message().find(std::string(protocols::to_text(needed))),
                  std::string::npos);
        EXPECT_FALSE(answered) << method << " answers who may not ask";
      }
    }
    EXPECT_TRUE(cell_->commands().empty());
  }
}

}  // namespace
}  // namespace aprsim::test
