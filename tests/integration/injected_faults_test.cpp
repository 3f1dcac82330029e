// Injected faults of the real daemon: over gRPC and from the command line, noticed on the wires.

#include <algorithm>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/integration/cli/cli_commands.hpp"
#include "tests/support/cell_client.hpp"
#include "tests/support/crcl_text_client.hpp"
#include "tests/support/daemon_process.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/vision_client.hpp"

namespace aprsim::test {
namespace {

class InjectedFaults : public testing::Test {
 protected:
  grpc::Status inject(const v1::InjectFaultRequest& request, v1::InjectFaultResponse* response) {
    grpc::ClientContext context;
    return client_.control->InjectFault(&context, request, response);
  }
  /// Injects a fault by kind and target; returns its number.
  std::uint64_t inject(const std::string& kind, const std::string& target = "") {
    v1::InjectFaultRequest request;
    request.set_kind(kind);
    request.set_target(target);
    v1::InjectFaultResponse response;
    CellClient::require(inject(request, &response));
    EXPECT_EQ(response.fault().kind(), kind);
    return response.fault().id();
  }
  void end(std::uint64_t id) {
    v1::EndFaultRequest request;
    request.set_id(id);
    v1::EndFaultResponse response;
    grpc::ClientContext context;
    CellClient::require(client_.control->EndFault(&context, request, &response));
  }
  void wait_for_state(std::uint64_t id, v1::InjectedFaultState state) {
    client_.wait_for(
        [&](const v1::Snapshot& now) {
          return std::ranges::any_of(now.injected_faults(), [&](const auto& fault) {
            return fault.id() == id && fault.state() == state;
          });
        },
        "the fault's state");
  }

  DaemonProcess daemon_;
  CellClient client_{daemon_.port("grpc")};
};

TEST_F(InjectedFaults, RefusalsNameFieldValueAndLimit) {
  const auto refusal = [&](const v1::InjectFaultRequest& request) {
    v1::InjectFaultResponse response;
    return inject(request, &response);
  };
  v1::InjectFaultRequest request;
  request.set_kind("gremlins");
  EXPECT_EQ(refusal(request).error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_NE(refusal(request).error_message().find("gremlins"), std::string::npos);
  request.set_kind("robot-slow");
  EXPECT_EQ(refusal(request).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  request.set_target("r2d2");
  EXPECT_NE(refusal(request).error_message().find("fanuc, motoman"), std::string::npos);
  request.set_target("fanuc");
  (*request.mutable_parameters())["share"] = -1;
  EXPECT_NE(refusal(request).error_message().find("share is -1, must be within 0 to 1"),
            std::string::npos);
  (*request.mutable_parameters())["share"] = 0.5;
  request.mutable_duration()->set_seconds(-4);
  EXPECT_NE(refusal(request).error_message().find("duration is -4 s"), std::string::npos);
  request.clear_duration();
  request.mutable_at()->set_seconds(-4);
  EXPECT_NE(refusal(request).error_message().find("at is -4 s"), std::string::npos);
  request.mutable_grasped();
  EXPECT_NE(refusal(request).error_message().find("no robot is named"), std::string::npos);
  request.mutable_crossing()->set_quantity("tool-force");
  EXPECT_NE(refusal(request).error_message().find("above and below"), std::string::npos);
  v1::EndFaultRequest unknown;
  unknown.set_id(4711);
  v1::EndFaultResponse ended;
  grpc::ClientContext context;
  const auto status = client_.control->EndFault(&context, unknown, &ended);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_NE(status.error_message().find("4711"), std::string::npos);
  EXPECT_EQ(client_.snapshot().injected_faults_size(), 0) << "nothing has changed";
}

TEST_F(InjectedFaults, TheKindsAreListed) {
  v1::ListFaultKindsResponse response;
  grpc::ClientContext context;
  CellClient::require(client_.control->ListFaultKinds(&context, {}, &response));
  EXPECT_GE(response.kinds_size(), 30);
  const auto slow =
      std::ranges::find(response.kinds(), std::string("robot-slow"), &v1::FaultKind::name);
  ASSERT_NE(slow, response.kinds().end());
  EXPECT_EQ(slow->target(), "ROBOT");
  ASSERT_EQ(slow->parameters_size(), 1);
  EXPECT_EQ(slow->parameters(0).default_(), 0.3);
  EXPECT_GT(response.quantities_size(), 0);
}

TEST_F(InjectedFaults, ABreakdownShowsOnTheRobotsOwnWire) {
  CrclTextClient robot(daemon_.port("crcl.fanuc"));
  robot.run("InitCanonType");
  const auto id = inject("robot-breakdown", "fanuc");
  wait_for_state(id, v1::INJECTED_FAULT_STATE_ACTIVE);
  std::string status;
  EXPECT_TRUE(eventually([&] {
    status = robot.status();
    return CrclTextClient::field(status, "CommandState") == "CRCL_Error";
  }));
  EXPECT_NE(status.find("broken down"), std::string::npos) << status;
  EXPECT_THROW(robot.run("InitCanonType"), std::runtime_error);
  end(id);
  wait_for_state(id, v1::INJECTED_FAULT_STATE_ENDED);
  robot.run("InitCanonType");
}

TEST_F(InjectedFaults, ARebootClosesTheSocketUntilItIsOver) {
  CrclTextClient robot(daemon_.port("crcl.motoman"));
  robot.run("InitCanonType");
  v1::InjectFaultRequest request;
  request.set_kind("controller-reboot");
  request.set_target("motoman");
  request.mutable_duration()->set_seconds(2);
  v1::InjectFaultResponse response;
  CellClient::require(inject(request, &response));
  EXPECT_TRUE(eventually([&] {
    try {
      robot.status();
      return false;
    } catch (const std::exception&) {
      return true;
    }
  }));
  wait_for_state(response.fault().id(), v1::INJECTED_FAULT_STATE_ENDED);
  EXPECT_TRUE(eventually([&] {
    try {
      CrclTextClient again(daemon_.port("crcl.motoman"));
      again.run("InitCanonType");
      return true;
    } catch (const std::exception&) {
      return false;
    }
  }));
}

TEST_F(InjectedFaults, ACameraOutageSilencesItsFeed) {
  const auto id = inject("camera-outage", "fanuc");
  wait_for_state(id, v1::INJECTED_FAULT_STATE_ACTIVE);
  const auto number = [&] { return client_.snapshot().robots(0).vision().number(); };
  client_.wait_for([&, step = client_.snapshot().step()](
                       const v1::Snapshot& now) { return now.step() > step + 300; },
                   "frames on their way");
  const auto last = number();
  client_.wait_for([&, step = client_.snapshot().step()](
                       const v1::Snapshot& now) { return now.step() > step + 500; },
                   "half a second");
  EXPECT_EQ(number(), last);
  end(id);
  EXPECT_TRUE(eventually([&] { return number() > last; }));
}

TEST_F(InjectedFaults, FromTheCommandLine) {
  const auto run = [&](const std::vector<std::string>& arguments) {
    const auto result = run_aprsim(daemon_, arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result.out;
  };
  EXPECT_NE(run({"fault", "list"}).find("no faults"), std::string::npos);
  EXPECT_NE(run({"fault", "inject", "belt-slip", "--share", "0.25", "--for", "600"})
                .find("fault 1 (belt-slip)"),
            std::string::npos);
  run({"fault", "inject", "robot-slow", "fanuc", "--when", "event:order-submitted"});
  run({"fault", "inject", "camera-bias", "motoman", "--x", "-0.01", "--when",
       "joint-position:fanuc:2>1.5"});
  wait_for_state(1, v1::INJECTED_FAULT_STATE_ACTIVE);
  const auto listed = nlohmann::json::parse(run({"fault", "list", "--json"}));
  ASSERT_EQ(listed["faults"].size(), 3U);
  EXPECT_EQ(listed["faults"][0]["parameters"]["share"], 0.25);
  EXPECT_EQ(listed["faults"][1]["state"], "pending");
  EXPECT_EQ(listed["faults"][2]["parameters"]["x"], -0.01);
  EXPECT_EQ(listed["faults"][2]["trigger"], "when joint-position 2 of fanuc > 1.5 rad");
  run({"fault", "event", "order-submitted"});
  wait_for_state(2, v1::INJECTED_FAULT_STATE_ACTIVE);
  run({"fault", "end", "2"});
  wait_for_state(2, v1::INJECTED_FAULT_STATE_ENDED);
  run({"save", "faulty"});
  run({"reset"});
  EXPECT_NE(run({"fault", "list"}).find("no faults"), std::string::npos);
  run({"load", "faulty"});
  EXPECT_NE(run({"fault", "list"}).find("belt-slip"), std::string::npos);
  EXPECT_NE(run({"fault", "kinds"}).find("belt-slip"), std::string::npos);
}

}  // namespace
}  // namespace aprsim::test
