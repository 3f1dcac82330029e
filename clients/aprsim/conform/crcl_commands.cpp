#include <chrono>
#include <limits>
#include <string>

#include <fmt/format.h>

#include "clients/aprsim/conform/crcl_check_groups.hpp"
#include "clients/aprsim/conform/crcl_probe.hpp"
#include "crcl/command_codec.hpp"

namespace aprsim::client::conform::commands {
namespace {

using crcl::CommandState;
using std::chrono::steady_clock;

// A dwell takes time and moves nothing.
std::string dwell(const Target& target) {
  CrclProbe probe(target);
  probe.init();
  const auto began = steady_clock::now();
  crcl::CommandInstance instance;
  const std::int64_t id = instance.command.id = CrclProbe::next_id();
  instance.command.body = crcl::Dwell{0.5};
  probe.send(crcl::encode_command(instance) + get_status_document());
  const SeenStatus first = probe.read();
  expect(first.status.command.command_id == id, in_words(first.status));
  expect_state(first, CommandState::kWorking);
  expect_state(probe.wait_over(id, CrclProbe::kAnswer), CommandState::kDone);
  const std::chrono::duration<double> took = steady_clock::now() - began;
  return fmt::format("CRCL_Working, CRCL_Done after {:.2f} s", took.count());
}

std::string shows_at_once(const Target& target) {
  CrclProbe probe(target);
  probe.init();
  for (int i = 0; i < 5; ++i) {
    crcl::CommandInstance dwell;
    dwell.command.id = CrclProbe::next_id();
    dwell.command.body = crcl::Dwell{0.2};
    probe.send(crcl::encode_command(dwell) + get_status_document());
    const SeenStatus seen = probe.read();
    expect(seen.status.command.command_id == dwell.command.id, in_words(seen.status));
    expect_state(seen, CommandState::kWorking);
    (void)probe.wait_over(dwell.command.id, CrclProbe::kAnswer);
  }
  return "5 times CRCL_Working under the new id";
}

std::string ids(const Target& target) {
  CrclProbe probe(target);
  probe.init();
  const std::int64_t last = CrclProbe::next_id();
  for (const std::int64_t id :
       {last, last, last - 3, std::int64_t{1}, std::numeric_limits<std::int64_t>::max(), last}) {
    probe.send(crcl::Message{"id"}, id);
    const SeenStatus seen = probe.poll();
    expect(seen.status.command.command_id == id,
           fmt::format("{} for {}", in_words(seen.status), id));
    expect_state(seen, CommandState::kDone);
  }
  return "all done";
}

std::string settings_at_once(const Target& target) {
  CrclProbe probe(target);
  probe.init();
  const crcl::CommandBody settings[] = {
      crcl::SetUnits{crcl::LengthUnit::kMillimeter}, crcl::SetUnits{crcl::AngleUnit::kDegree},
      crcl::SetEndPoseTolerance{{1, {}, {}, {}, {}}},
      crcl::ConfigureStatusReport{true, true, false, true, false, false},
      crcl::Message{"settings"}};
  for (const crcl::CommandBody& body : settings) {
    const std::int64_t id = probe.send(body);
    const SeenStatus seen = probe.poll();
    expect(seen.status.command.command_id == id, in_words(seen.status));
    expect_state(seen, CommandState::kDone);
  }
  return fmt::format("{} times CRCL_Done", std::size(settings));
}

std::string any_client(const Target& target) {
  CrclProbe probe(target), other(target);
  probe.init();
  const std::int64_t id = probe.run(crcl::Message{"here"}).status.command.command_id;
  const SeenStatus seen = other.poll();
  expect(seen.status.command.command_id == id, in_words(seen.status));
  return in_words(seen.status);
}

std::string echoed(const Target& target) {
  CrclProbe probe(target);
  probe.init();
  crcl::CommandInstance instance{{}, {}, "kit.xml", 3, 22};
  instance.command.id = CrclProbe::next_id();
  instance.command.body = crcl::Message{"three of 22"};
  probe.send(crcl::encode_command(instance));
  const crcl::CommandStatus status = probe.poll().status.command;
  const std::string seen =
      fmt::format("{} {} {}", status.program_file.value_or("-"), status.program_index.value_or(-1),
                  status.program_length.value_or(-1));
  expect(seen == "kit.xml 3 22", seen);
  return seen;
}

// Ends the program and sends a dwell of zero time: the pendant client initializes only once.
std::string after_end(const Target& target) {
  CrclProbe probe(target);
  probe.init();
  probe.run(crcl::EndCanon{});
  const std::string words = in_words(probe.run(crcl::Dwell{0}).status);
  probe.init();
  return words;
}

// Causes an error with a value outside the range of its element.
Refusal failed_by_value(const Target& target) {
  const std::int64_t id = CrclProbe::next_id();
  return refuse(target, command_document("DwellType", id, "<DwellTime>soon</DwellTime>"), id);
}

std::string held(const Target& target) {
  Refusal failed = failed_by_value(target);
  const std::int64_t id = failed.other.send(crcl::Dwell{0});
  const SeenStatus seen = failed.other.poll();
  const std::string words = in_words(seen.status);
  failed.other.init();
  expect(seen.status.command.state == CommandState::kError, words);
  expect(seen.status.command.command_id == id, words);
  return words;
}

std::string same_id_again(const Target& target) {
  CrclProbe probe(target);
  probe.init();
  const std::int64_t id = CrclProbe::next_id();
  probe.send(command_document("DwellType", id, "<DwellTime>-1</DwellTime>"));
  (void)probe.poll();
  CrclProbe fresh(target);
  fresh.init();
  fresh.send(crcl::Message{"again"}, id);
  const SeenStatus seen = fresh.poll();
  expect(seen.status.command.command_id == id, in_words(seen.status));
  expect_state(seen, CommandState::kDone);
  return in_words(seen.status);
}

std::string stop(const Target& target) {
  CrclProbe probe(target), emergency(target);
  probe.init();
  const std::int64_t dwell = probe.send(crcl::Dwell{20});
  (void)probe.poll();
  const std::int64_t id = emergency.send(crcl::StopMotion{crcl::StopCondition::kNormal}, dwell - 1);
  const SeenStatus seen = probe.wait_over(id, CrclProbe::kAnswer);
  expect_state(seen, CommandState::kDone);
  return in_words(seen.status);
}

std::string replaced(const Target& target) {
  CrclProbe probe(target);
  probe.init();
  probe.send(crcl::Dwell{20});
  const std::int64_t id = probe.send(crcl::Dwell{0.1});
  const SeenStatus seen = probe.wait_over(id, CrclProbe::kAnswer);
  expect_state(seen, CommandState::kDone);
  return in_words(seen.status);
}

std::string reinitialized(const Target& target) {
  CrclProbe probe(target);
  probe.init();
  const std::int64_t id = probe.send(crcl::Dwell{20});
  const std::int64_t init = probe.send(crcl::InitCanon{}, id - 3);
  expect_state(probe.wait_over(init, Milliseconds(35'000)), CommandState::kDone);
  return "CRCL_Done, the dwell is over";
}

}  // namespace

void add(std::vector<Check>& checks) {
  const auto rule = [&checks](const char* clause, const char* source, const char* text,
                              const char* expected, auto run) {
    checks.push_back({clause, source, text, expected, false, run});
  };
  constexpr const char* kClients = "NIST's Java clients";
  constexpr const char* kSchema = "CRCLCommands.xsd";
  rule("C1", kClients, "InitCanon", "CRCL_Done within 30 s", [](const Target& t) {
    CrclProbe probe(t);
    probe.init();
    return in_words(probe.poll().status);
  });
  rule("C2", kClients, "a command shows in the status asked for right behind it",
       "CRCL_Working under its id", shows_at_once);
  rule("C3", kSchema, "Dwell", "CRCL_Working, then CRCL_Done", dwell);
  rule("C4", kClients, "ids that repeat, go down, or are as large as xs:long", "all executed", ids);
  rule("C5", kClients, "settings and messages are done at once", "CRCL_Done", settings_at_once);
  rule("C6", kClients, "a status is of the latest command of any client", "its id", any_client);
  rule("C7", "CRCLStatus.xsd", "ProgramFile, ProgramIndex and ProgramLength are echoed",
       "kit.xml 3 22", echoed);
  rule("C8", kSchema, "EndCanon after EndCanon", "CRCL_Done", [](const Target& t) {
    CrclProbe probe(t);
    probe.init();
    probe.run(crcl::EndCanon{});
    const SeenStatus seen = probe.run(crcl::EndCanon{});
    probe.init();
    return in_words(seen.status);
  });
  rule("C9", kClients, "EndCanon leaves the robot initialized", "CRCL_Done of the next command",
       after_end);
  rule("C10", kClients, "a value that its element cannot have",
       "CRCL_Error with a description, under its id or closed", [](const Target& t) {
         Refusal failed = failed_by_value(t);
         failed.other.init();
         return failed.seen;
       });
  rule("C11", kClients, "InitCanon clears an error", "CRCL_Done", [](const Target& t) {
    Refusal failed = failed_by_value(t);
    failed.other.init();
    return in_words(failed.other.run(crcl::Message{"on"}).status);
  });
  rule("C12", kSchema, "an error is held until InitCanon", "CRCL_Error under the next id", held);
  rule("C13", kClients, "the id of an error is no reason to drop a later command of that id",
       "CRCL_Done", same_id_again);
  rule("C14", kSchema, "StopMotion from another connection, under a lower id",
       "CRCL_Done under its id", stop);
  rule("C15", kClients, "a command replaces the running one", "CRCL_Done of the second", replaced);
  rule("C16", kClients, "InitCanon ends the running command", "CRCL_Done", reinitialized);
}

}  // namespace aprsim::client::conform::commands
