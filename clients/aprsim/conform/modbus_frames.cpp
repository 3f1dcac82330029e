#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "clients/aprsim/conform/modbus_check_groups.hpp"
#include "clients/aprsim/conform/modbus_probe.hpp"

namespace aprsim::client::conform::frames {
namespace {

using modbus::conformance::adu;
using modbus::conformance::Bytes;
using modbus::conformance::pdu;
using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kQuiet{300}, kPatience{2000};
constexpr const char* kMessaging = "MODBUS Messaging on TCP/IP V1.0b";

// Expects the reply to the target's read of one value, with that transaction and unit.
void expect_reply(const Target& target, const Bytes& reply, std::uint16_t transaction,
                  std::uint8_t unit = 1) {
  const std::uint8_t function = target.read_one.front();
  const std::uint8_t size = function < 3 ? 1 : 2;
  Bytes body{function, size};
  body.resize(2U + size);
  const Bytes head = adu(body, transaction, unit);
  expect(reply.size() == head.size() && std::equal(head.begin(), head.begin() + 9, reply.begin()),
         in_hex(reply));
}

double ask_ms(const Target& target, ModbusProbe& probe) {
  const auto began = steady_clock::now();
  probe.send(adu(target.read_one, 77));
  expect_reply(target, probe.read(kPatience), 77);
  return std::chrono::duration<double, std::milli>(steady_clock::now() - began).count();
}

std::string served(double ms) { return fmt::format("others served in {:.0f} ms", ms); }

std::string transactions(const Target& target) {
  ModbusProbe probe(target);
  for (const int id : {0, 1, 0x1234, 0x8000, 0xFFFF, 1}) {
    const auto transaction = static_cast<std::uint16_t>(id);
    probe.send(adu(target.read_one, transaction));
    expect_reply(target, probe.read(), transaction);
  }
  return "all come back";
}

// Any unit identifier is served or refused with an exception.
std::string units(const Target& target) {
  ModbusProbe probe(target);
  std::string seen;
  for (const int id : {0, 1, 17, 247, 255}) {
    const auto unit = static_cast<std::uint8_t>(id);
    probe.send(adu(target.read_one, 5, unit));
    const Bytes reply = probe.read();
    expect(reply.size() >= 9 && reply[6] == unit, in_hex(reply));
    const std::uint8_t function = target.read_one.front();
    const bool answered = reply[7] == function;
    const bool no_such_unit =
        reply[7] == (function | 0x80U) && (reply[8] == 0x0A || reply[8] == 0x0B);
    expect(answered || no_such_unit, in_hex(reply));
    seen += fmt::format("{}{} {}", seen.empty() ? "" : ", ", id, answered ? "served" : "refused");
  }
  return seen;
}

std::string foreign_protocol(const Target& target) {
  ModbusProbe probe(target);
  probe.send(adu(target.read_one, 8, 1, 1));
  const auto reply = probe.try_read(kQuiet);
  expect(!reply, "answered: " + in_hex(reply.value_or(Bytes{})));
  ModbusProbe other(target);
  return "no answer, " + served(ask_ms(target, other));
}

// Framing is lost: no request in the following bytes may be executed.
std::string impossible_length(const Target& target) {
  for (const int length : {0, 1, 255, 65535}) {
    ModbusProbe probe(target);
    Bytes bytes = adu(target.read_one, 9);
    bytes[4] = static_cast<std::uint8_t>(length >> 8);
    bytes[5] = static_cast<std::uint8_t>(length & 0xFF);
    probe.send(bytes);
    const auto reply = probe.try_read(kQuiet);
    expect(!reply || reply->at(7) >= 0x80,
           fmt::format("length {} answered: {}", length, in_hex(reply.value_or(Bytes{}))));
  }
  ModbusProbe other(target);
  return "none executed, " + served(ask_ms(target, other));
}

std::string pipelined(const Target& target) {
  constexpr std::uint16_t kMany = 100;
  ModbusProbe probe(target);
  Bytes all;
  for (std::uint16_t i = 0; i < kMany; ++i) {
    const Bytes one = adu(target.read_one, i);
    all.insert(all.end(), one.begin(), one.end());
  }
  probe.send(all);
  for (std::uint16_t i = 0; i < kMany; ++i) expect_reply(target, probe.read(), i);
  return fmt::format("{} replies in order", kMany);
}

// A refused request between two valid ones affects neither.
std::string pipelined_errors(const Target& target) {
  ModbusProbe probe(target);
  Bytes all = adu(target.read_one, 1);
  for (const Bytes& one :
       {adu(pdu(3, {0x8000, 0}), 2), adu(Bytes{0x41}, 3), adu(target.read_one, 4)}) {
    all.insert(all.end(), one.begin(), one.end());
  }
  probe.send(all);
  expect_reply(target, probe.read(), 1);
  expect(probe.read() == adu(Bytes{0x83, 3}, 2), "another answer to the bad quantity");
  expect(probe.read() == adu(Bytes{0xC1, 1}, 3), "another answer to the unknown function");
  expect_reply(target, probe.read(), 4);
  return "4 replies in order";
}

std::string bytewise(const Target& target) {
  ModbusProbe probe(target);
  for (const std::uint8_t byte : adu(target.read_one, 6)) probe.send(Bytes{byte});
  expect_reply(target, probe.read(), 6);
  expect(!probe.try_read(kQuiet), "a second reply");
  return "1 reply";
}

std::string half_requests(const Target& target) {
  std::vector<std::unique_ptr<ModbusProbe>> halves;
  for (const std::size_t size : std::initializer_list<std::size_t>{1, 3, 7, 9}) {
    halves.push_back(std::make_unique<ModbusProbe>(target));
    const Bytes request = adu(target.read_one);
    halves.back()->send(
        Bytes(request.begin(), request.begin() + static_cast<std::ptrdiff_t>(size)));
  }
  ModbusProbe other(target);
  return served(ask_ms(target, other));
}

std::string never_reads(const Target& target) {
  ModbusProbe silent(target), other(target);
  Bytes batch;
  for (std::uint16_t i = 0; i < 100; ++i) {
    const Bytes one = adu(target.read_many, i);
    batch.insert(batch.end(), one.begin(), one.end());
  }
  try {
    for (int i = 0; i < 50; ++i) silent.send(batch);
  } catch (const NotKept&) {
    // The server accepts no more bytes, or has closed.
  }
  return served(ask_ms(target, other));
}

std::string connections(const Target& target) {
  std::vector<std::unique_ptr<ModbusProbe>> probes;
  for (int i = 0; i < 8; ++i) probes.push_back(std::make_unique<ModbusProbe>(target));
  for (const auto& probe : probes) probe->send(adu(target.read_one, 3));
  for (const auto& probe : probes) expect_reply(target, probe->read(), 3);
  return "8 replies";
}

}  // namespace

void add(std::vector<Check>& checks) {
  const auto rule = [&checks](const char* clause, const std::string& section, const char* text,
                              const char* expected, auto run) {
    checks.push_back({clause, std::string(kMessaging) + section, text, expected, false, run});
  };
  rule("T1", ", 3.1.3", "transaction ids", "all come back", transactions);
  rule("T2", ", 3.1.3", "unit ids", "served, or exception 0A or 0B", units);
  rule("T3", ", 3.1.3", "a protocol id that is not 0", "no answer, others served",
       foreign_protocol);
  rule("T4", ", 3.1.3", "lengths of 0, 1, 255 and 65535", "none executed, others served",
       impossible_length);
  rule("T5", ", 4.2", "100 requests in one packet", "100 replies in order", pipelined);
  rule("T6", ", 4.2", "refused requests among others in one packet", "4 replies in order",
       pipelined_errors);
  rule("T7", ", 4.2", "a request in packets of one byte", "1 reply", bytewise);
  rule("T8", ", 4.2", "8 connections", "8 replies", connections);
  rule("T9", ", 4.2", "half a request holds nobody up", "others served within 2 s", half_requests);
  rule("T10", ", 4.2", "a client that reads nothing delays no other client",
       "others served within 2 s", never_reads);
}

}  // namespace aprsim::client::conform::frames
