#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "clients/aprsim/conform/crcl_check_groups.hpp"
#include "clients/aprsim/conform/crcl_probe.hpp"

namespace aprsim::client::conform::connections {
namespace {

using std::chrono::steady_clock;

/// Longest reply time for one client, whatever the others do.
constexpr Milliseconds kPatience{2000};

double poll_ms(CrclProbe& probe) {
  const auto began = steady_clock::now();
  (void)probe.poll(kPatience);
  return std::chrono::duration<double, std::milli>(steady_clock::now() - began).count();
}

std::string served(double ms) { return fmt::format("others served in {:.0f} ms", ms); }

// The sockets for commands, stops and polls that NIST's client opens, of two clients.
std::string six(const Target& target) {
  std::vector<std::unique_ptr<CrclProbe>> probes;
  for (int i = 0; i < 6; ++i) probes.push_back(std::make_unique<CrclProbe>(target));
  for (const auto& probe : probes) probe->send(get_status_document());
  for (const auto& probe : probes) (void)probe->read();
  return "6 statuses";
}

std::string half_documents(const Target& target) {
  std::vector<std::unique_ptr<CrclProbe>> halves;
  for (int i = 0; i < 4; ++i) {
    halves.push_back(std::make_unique<CrclProbe>(target));
    halves.back()->send(get_status_document().substr(0, 60));
  }
  CrclProbe other(target);
  return served(poll_ms(other));
}

std::string gone(const Target& target) {
  CrclProbe other(target);
  other.init();
  const std::int64_t id = other.run(crcl::Message{"before"}).status.command.command_id;
  for (int i = 0; i < 4; ++i) {
    CrclProbe leaving(target);
    leaving.send(get_status_document().substr(0, 40));
  }
  const SeenStatus seen = other.poll(kPatience);
  expect(seen.status.command.command_id == id, in_words(seen.status));
  expect(seen.status.command.state == crcl::CommandState::kDone, in_words(seen.status));
  return in_words(seen.status);
}

// Reads while it sends.
std::string flood(const Target& target) {
  constexpr int kBatches = 20, kBatch = 25;
  CrclProbe flooding(target), other(target);
  std::string batch;
  for (int i = 0; i < kBatch; ++i) batch += get_status_document();
  std::int64_t last = -1;
  double worst_ms = 0;
  for (int i = 0; i < kBatches; ++i) {
    flooding.send(batch);
    if (i % 5 == 0) worst_ms = std::max(worst_ms, poll_ms(other));
    for (int k = 0; k < kBatch; ++k) {
      const std::int64_t id = flooding.read().status.command.status_id;
      expect(id > last, "statuses out of order");
      last = id;
    }
  }
  return fmt::format("{} statuses in order, {}", kBatches * kBatch, served(worst_ms));
}

// Never reads; any reaction of the server is allowed.
std::string never_reads(const Target& target) {
  CrclProbe silent(target), other(target);
  try {
    std::string batch;
    for (int i = 0; i < 50; ++i) batch += get_status_document();
    for (int i = 0; i < 40; ++i) silent.send(batch);
  } catch (const NotKept&) {
    // The server accepts no more bytes, or has closed.
  }
  return served(poll_ms(other));
}

std::string endless(const Target& target) {
  CrclProbe endless(target), other(target);
  other.init();
  std::string outcome = "taken";
  try {
    endless.send("<CRCLCommandInstance><CRCLCommand>");
    const std::string filling(1 << 16, ' ');
    for (int i = 0; i < 64; ++i) endless.send(filling);
  } catch (const NotKept&) {
    outcome = "closed";
  }
  const double ms = poll_ms(other);
  other.init();
  return outcome + ", " + served(ms);
}

}  // namespace

void add(std::vector<Check>& checks) {
  const auto rule = [&checks](const char* clause, const char* source, const char* text,
                              const char* expected, auto run) {
    checks.push_back({clause, source, text, expected, false, run});
  };
  constexpr const char* kClients = "NIST's Java clients";
  constexpr const char* kServer = "duty of a server";
  rule("N1", kClients, "two clients of three connections each", "6 statuses", six);
  rule("N2", kServer, "half a document holds nobody up", "others served within 2 s",
       half_documents);
  rule("N3", kClients, "a client that disconnects within a document changes nothing",
       "CRCL_Done as before", gone);
  rule("N4", kServer, "500 GetStatus as fast as they are answered",
       "500 statuses in order, others served within 2 s", flood);
  rule("N5", kServer, "a client that reads nothing delays no other client",
       "others served within 2 s", never_reads);
  rule("N6", kServer, "a document of 4 MB without an end holds nobody up",
       "others served within 2 s", endless);
}

}  // namespace aprsim::client::conform::connections
