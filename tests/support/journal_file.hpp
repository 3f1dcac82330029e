#pragma once

#include <cmath>
#include <cstdint>
#include <fstream>
#include <string>

#include "aprsim/v1/journal.pb.h"
#include "proto/journal/frames.hpp"
#include "proto/journal/journal_reader.hpp"

namespace aprsim::test {

/// A journal of a test's own making: what went over the wires at which simulated time.
class JournalFile {
 public:
  explicit JournalFile(std::string run_id = "run", std::uint32_t part = 1) {
    v1::JournalRecord record;
    v1::JournalHeader& header = *record.mutable_header();
    header.set_format(journal::kFormat);
    header.set_run_id(std::move(run_id));
    header.set_part(part);
    header.set_scene("none");
    encoder_.add(record);
  }

  void received(const std::string& listener, double time_s, const std::string& data,
                std::uint64_t connection = 1) {
    wire(listener, time_s, v1::WIRE_CONTENT_RECEIVED, data, connection);
  }
  void sent(const std::string& listener, double time_s, const std::string& data,
            std::uint64_t connection = 1) {
    wire(listener, time_s, v1::WIRE_CONTENT_SENT, data, connection);
  }
  /// A CRCL command, polls while it runs and a status that says that it is done; when that is.
  double command(const std::string& listener, double time_s, std::int64_t id,
                 const std::string& type, const std::string& fields, double takes_s = 0.1,
                 const std::string& more_status = "", const std::string& state = "CRCL_Done") {
    received(listener, time_s, instance(id, type, fields));
    for (double at = time_s + poll_s; at < time_s + takes_s; at += poll_s) {
      received(listener, at, instance(id, "GetStatusType", ""));
      sent(listener, at, status(id, "CRCL_Working", ""));
    }
    received(listener, time_s + takes_s, instance(id, "GetStatusType", ""));
    sent(listener, time_s + takes_s, status(id, state, more_status));
    return time_s + takes_s;
  }
  void add(const v1::JournalRecord& record) { encoder_.add(record); }

  static std::string instance(std::int64_t id, const std::string& type, const std::string& fields) {
    return "<CRCLCommandInstance><CRCLCommand "
           "xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" xsi:type=\"" +
           type + "\"><CommandID>" + std::to_string(id) + "</CommandID>" + fields +
           "</CRCLCommand></CRCLCommandInstance>";
  }
  static std::string status(std::int64_t id, const std::string& state, const std::string& more) {
    return "<CRCLStatus><CommandStatus><CommandID>" + std::to_string(id) +
           "</CommandID><StatusID>1</StatusID><CommandState>" + state +
           "</CommandState></CommandStatus>" + more + "</CRCLStatus>";
  }
  static std::string pose(const std::string& tag, double x_mm, double y_mm, double z_mm) {
    return "<" + tag + "><Point><X>" + std::to_string(x_mm) + "</X><Y>" + std::to_string(y_mm) +
           "</Y><Z>" + std::to_string(z_mm) +
           "</Z></Point><XAxis><I>1</I><J>0</J><K>0</K></XAxis><ZAxis><I>0</I><J>0</J><K>-1</K>"
           "</ZAxis></" +
           tag + ">";
  }

  void write(const std::string& file, bool ended = true) {
    if (ended) {
      v1::JournalRecord record;
      record.mutable_end();
      encoder_.add(record);
    }
    std::ofstream(file, std::ios::binary) << journal::kMagic << encoder_.take();
  }

  double poll_s = 0.025;

 private:
  void wire(const std::string& listener, double time_s, v1::WireContent content,
            const std::string& data, std::uint64_t connection) {
    v1::JournalRecord record;
    v1::JournalWire& wire = *record.mutable_wire();
    wire.mutable_time()->set_step(static_cast<std::uint64_t>(std::lround(1e3 * time_s)));
    wire.mutable_sim_time()->set_seconds(static_cast<std::int64_t>(time_s));
    wire.mutable_sim_time()->set_nanos(
        static_cast<std::int32_t>(std::lround(1e9 * (time_s - std::floor(time_s)))) %
        1'000'000'000);
    wire.set_kind(listener.starts_with("crcl")     ? v1::WIRE_KIND_CRCL
                  : listener.starts_with("vision") ? v1::WIRE_KIND_VISION
                  : listener == "modbus"           ? v1::WIRE_KIND_MODBUS
                                                   : v1::WIRE_KIND_GRPC);
    wire.set_listener(listener);
    wire.set_connection(connection);
    wire.set_content(content);
    wire.set_data(data);
    encoder_.add(record);
  }

  journal::FrameEncoder encoder_;
};

}  // namespace aprsim::test
