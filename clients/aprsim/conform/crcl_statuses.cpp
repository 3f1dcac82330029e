#include <algorithm>
#include <string>

#include <fmt/format.h>

#include "clients/aprsim/conform/crcl_check_groups.hpp"
#include "clients/aprsim/conform/crcl_probe.hpp"
#include "crcl/schema.hpp"

namespace aprsim::client::conform::statuses {
namespace {

constexpr Milliseconds kQuiet{500};

std::string valid(const SeenStatus& seen) {
  if (const auto fault = crcl::schema_fault(seen.document)) throw NotKept{fault->message()};
  return "valid";
}

std::string joints_in_words(const crcl::Status& status) {
  return fmt::format("{} joints", status.joints.size());
}

// Each check configures the reports of its own connection only.
std::string by_default(const Target& target) {
  CrclProbe probe(target);
  const crcl::Status status = probe.poll().status;
  expect(!status.joints.empty(), "no joints");
  for (const crcl::JointStatus& joint : status.joints) {
    expect(joint.position.has_value(), fmt::format("joint {} without position", joint.joint));
  }
  expect(status.pose.has_value(), "no pose");
  expect(status.settings.has_value(), "no settings");
  return joints_in_words(status) + ", pose, settings";
}

std::string configured(const Target& target) {
  CrclProbe probe(target);
  probe.init();
  const auto parts_of = [](const crcl::Status& status) {
    return fmt::format("{}{}{}", status.joints.empty() ? "" : "joints ", status.pose ? "pose " : "",
                       status.settings ? "settings " : "");
  };
  crcl::Status status =
      probe.run(crcl::ConfigureStatusReport{false, true, false, false, false, false}).status;
  expect(parts_of(status) == "pose ", "pose asked for: " + parts_of(status));
  status = probe.run(crcl::ConfigureStatusReport{true, false, false, true, false, false}).status;
  expect(parts_of(status) == "joints settings ",
         "joints and settings asked for: " + parts_of(status));
  CrclProbe other(target);
  status = other.poll().status;
  expect(parts_of(status) == "joints pose settings ", "elsewhere: " + parts_of(status));
  return "as asked, elsewhere all";
}

std::string configured_joints(const Target& target) {
  CrclProbe probe(target);
  probe.init();
  const auto seen = probe.run(crcl::ConfigureJointReports{true, {{2, true, false, true}}});
  const crcl::Status& status = seen.status;
  expect(status.joints.size() == 1 && status.joints[0].joint == 2, joints_in_words(status));
  const crcl::JointStatus& joint = status.joints[0];
  expect(joint.position && joint.velocity, "a value that was asked for is missing");
  expect(!joint.torque, "a torque that was not asked for");
  const auto none = probe.run(crcl::ConfigureJointReports{true, {}});
  expect(none.document.find("JointStatuses") == std::string::npos, "JointStatuses without a joint");
  return "joint 2 with position and velocity; then no joints";
}

std::string unsolicited(const Target& target) {
  CrclProbe probe(target);
  probe.send(crcl::InitCanon{});
  probe.send(crcl::Message{"quiet"});
  expect(probe.silent(kQuiet), "a status that nobody asked for");
  (void)probe.poll();
  expect(probe.silent(kQuiet), "a second status for one GetStatus");
  return "1 status for 1 GetStatus";
}

std::string rises(const Target& target) {
  CrclProbe probe(target), other(target);
  probe.init();
  std::int64_t last = 0;
  for (int i = 0; i < 10; ++i) {
    CrclProbe& asked = i % 2 == 0 ? probe : other;
    const std::int64_t id = asked.poll().status.command.status_id;
    expect(i == 0 || id > last, fmt::format("StatusID {} after {}", id, last));
    last = id;
  }
  return "10 StatusIDs that rise";
}

std::string gripper(const Target& target) {
  CrclProbe probe(target);
  probe.init();
  const auto seen = probe.run(crcl::ConfigureStatusReport{true, true, true, true, true, true});
  expect(seen.status.settings && seen.status.settings->end_effector, "no EndEffectorSetting");
  if (!seen.status.gripper) return "EndEffectorSetting, no gripper";
  expect(seen.status.gripper->holding.has_value(), "GripperStatus without HoldingObject");
  return "EndEffectorSetting, HoldingObject";
}

}  // namespace

void add(std::vector<Check>& checks) {
  const auto rule = [&checks](const char* clause, const char* source, const char* text,
                              const char* expected, auto run) {
    checks.push_back({clause, source, text, expected, false, run});
  };
  constexpr const char* kClients = "NIST's Java clients";
  rule("S1", kClients, "statuses come for GetStatus only, one for each", "1 status for 1 GetStatus",
       unsolicited);
  rule("S2", kClients, "GetStatus is no command: its id never shows", "the id before",
       [](const Target& t) {
         CrclProbe probe(t);
         probe.init();
         const std::int64_t before = probe.run(crcl::Message{"here"}).status.command.command_id;
         probe.send(command_document("GetStatusType", before + 5000));
         const crcl::CommandStatus after = probe.read().status.command;
         expect(after.command_id == before, fmt::format("id {}", after.command_id));
         expect(after.state == crcl::CommandState::kDone, "another state");
         return std::string("the id before");
       });
  rule("S3", "CRCLStatus.xsd", "StatusID rises from status to status", "rises", rises);
  rule("S4", "CRCLStatus.xsd", "a status is valid by the schema", "valid", [](const Target& t) {
    CrclProbe probe(t);
    probe.init();
    return valid(probe.poll());
  });
  rule("S5", "CRCLStatus.xsd", "a status with all its parts is valid", "valid",
       [](const Target& t) {
         CrclProbe probe(t);
         probe.init();
         return valid(probe.run(crcl::ConfigureStatusReport{true, true, true, true, true, true}));
       });
  rule("S6", kClients, "a new connection's statuses", "joint positions, pose, settings",
       by_default);
  rule("S7", "CRCLCommands.xsd", "ConfigureStatusReport, of one connection", "the parts asked for",
       configured);
  rule("S8", "CRCLCommands.xsd", "ConfigureJointReports", "the joints and values asked for",
       configured_joints);
  rule("S9", kClients, "the gripper's status fields", "EndEffectorSetting, HoldingObject", gripper);
}

}  // namespace aprsim::client::conform::statuses
