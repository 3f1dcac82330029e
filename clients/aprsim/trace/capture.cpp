#include "clients/aprsim/trace/capture.hpp"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <pcap/pcap.h>
#include <utility>

#include <fmt/format.h>

#include "clients/aprsim/trace/packet.hpp"
#include "clients/aprsim/trace/stream_framer.hpp"
#include "proto/journal/frames.hpp"
#include "proto/journal/journal_reader.hpp"

namespace aprsim::trace {
namespace {

struct CloseCapture {
  void operator()(pcap_t* capture) const { pcap_close(capture); }
};

v1::WireKind wire_kind(const std::string& listener) {
  if (listener.starts_with("crcl.")) return v1::WIRE_KIND_CRCL;
  return listener == "modbus" ? v1::WIRE_KIND_MODBUS : v1::WIRE_KIND_VISION;
}

/// Writes the records of one journal file.
class JournalWriter {
 public:
  explicit JournalWriter(const std::string& file)
      : file_(file), out_(file, std::ios::binary | std::ios::trunc) {
    out_ << aprsim::journal::kMagic;
  }
  void add(const v1::JournalRecord& record) {
    encoder_.add(record);
    if (encoder_.pending() >= aprsim::journal::kFrameBytes) out_ << encoder_.take();
  }
  Result<void> finish() {
    errno = 0;
    out_ << encoder_.take();
    if (out_.flush()) return {};
    return fail(ErrorCode::kUnavailable, "journal",
                fmt::format("{} cannot be written{}{}", file_, errno != 0 ? ": " : "",
                            errno != 0 ? std::strerror(errno) : ""));
  }

 private:
  std::string file_;
  std::ofstream out_;
  aprsim::journal::FrameEncoder encoder_;
};

/// Turns the packets of one capture into records.
class Importer {
 public:
  Importer(JournalWriter& out, const ListenerPorts& ports)
      : out_(out),
        ports_(ports),
        streams_([this](const TcpEnd& end) { return ports_.contains(end.port); },
                 {.opened = [this](auto number, const auto& client,
                                   const auto& server) { opened(number, client, server); },
                  .bytes = [this](auto number, bool from_client,
                                  auto bytes) { take(number, from_client, bytes); },
                  .hole = [this](auto number, bool from_client) { lose(number, from_client); },
                  .closed = [this](auto number, bool reset) { closed(number, reset); }}) {}

  void packet(int link, const pcap_pkthdr& header, const u_char* bytes) {
    const std::int64_t now_ns = header.ts.tv_sec * std::int64_t{1'000'000'000} +
                                header.ts.tv_usec;  // nanoseconds, see open
    if (imported_.packets++ == 0) start_ns_ = now_ns;
    // Clocks are set back; the order of the packets stays.
    now_ns_ = std::max(now_ns_, now_ns - start_ns_);
    const Packet packet = read_packet(link, {bytes, header.caplen}, header.len);
    if (packet.kind == PacketKind::kFragment) ++fragments_;
    if (packet.kind != PacketKind::kTcp) return;
    if (packet.segment.cut) ++cut_;
    streams_.take(packet.segment);
  }

  Imported finish() {
    streams_.end();
    const auto note = [this](std::uint64_t count, const char* what) {
      if (count > 0) imported_.notes.push_back(fmt::format("{} {}", count, what));
    };
    note(fragments_, "fragments of IP packets were left out");
    note(cut_, "packets were captured in part only (see tcpdump's -s)");
    note(streams_.holes(), "times bytes of a connection are missing");
    for (const std::string& why : broken_) imported_.notes.push_back(why);
    imported_.connections = streams_.connections();
    imported_.duration_s = 1e-9 * static_cast<double>(now_ns_);
    return std::move(imported_);
  }

 private:
  struct Connection {
    std::string listener, peer;
    StreamFramer from_client, to_client;
  };

  void opened(std::uint64_t number, const TcpEnd& client, const TcpEnd& server) {
    const std::string& listener = ports_.at(server.port);
    const v1::WireKind kind = wire_kind(listener);
    const bool ipv6 = client.address.find(':') != std::string::npos;
    const std::string host = ipv6 ? "[" + client.address + "]" : client.address;
    connections_.emplace(number, Connection{listener, fmt::format("{}:{}", host, client.port),
                                            StreamFramer(kind, true), StreamFramer(kind, false)});
    record(number, v1::WIRE_CONTENT_OPENED, {}, {});
  }

  void take(std::uint64_t number, bool from_client, std::string_view bytes) {
    Connection& connection = connections_.at(number);
    StreamFramer& framer = from_client ? connection.from_client : connection.to_client;
    const bool was_broken = !framer.broken().empty();
    for (const std::string& unit : framer.take(bytes)) {
      record(number, from_client ? v1::WIRE_CONTENT_RECEIVED : v1::WIRE_CONTENT_SENT, unit, {});
      ++imported_.by_listener[connection.listener];
    }
    if (!was_broken && !framer.broken().empty()) {
      broken_.push_back(
          fmt::format("{}, connection {}: the rest {} cannot be read: {}", connection.listener,
                      number, from_client ? "from the client" : "to the client", framer.broken()));
    }
  }

  void lose(std::uint64_t number, bool from_client) {
    Connection& connection = connections_.at(number);
    (from_client ? connection.from_client : connection.to_client).lose();
  }

  void closed(std::uint64_t number, bool reset) {
    record(number, v1::WIRE_CONTENT_CLOSED, {}, reset ? "reset" : "");
    connections_.erase(number);
  }

  void record(std::uint64_t number, v1::WireContent content, const std::string& data,
              const std::string& text) {
    const Connection& connection = connections_.at(number);
    v1::JournalRecord record;
    const std::int64_t wall_ns = start_ns_ + now_ns_;
    record.mutable_wall_time()->set_seconds(wall_ns / 1'000'000'000);
    record.mutable_wall_time()->set_nanos(static_cast<std::int32_t>(wall_ns % 1'000'000'000));
    v1::JournalWire& wire = *record.mutable_wire();
    wire.mutable_time()->set_step(static_cast<std::uint64_t>(now_ns_ / 1'000'000));
    wire.mutable_sim_time()->set_seconds(now_ns_ / 1'000'000'000);
    wire.mutable_sim_time()->set_nanos(static_cast<std::int32_t>(now_ns_ % 1'000'000'000));
    wire.set_kind(wire_kind(connection.listener));
    wire.set_listener(connection.listener);
    wire.set_connection(number);
    wire.set_peer(connection.peer);
    wire.set_content(content);
    wire.set_data(data);
    wire.set_text(text);
    out_.add(record);
    ++imported_.records;
  }

  JournalWriter& out_;
  const ListenerPorts& ports_;
  TcpStreams streams_;
  std::map<std::uint64_t, Connection> connections_;
  std::int64_t start_ns_ = 0, now_ns_ = 0;
  std::uint64_t fragments_ = 0, cut_ = 0;
  std::vector<std::string> broken_;
  Imported imported_;
};

v1::JournalRecord header_record(const std::string& capture, const ListenerPorts& ports) {
  v1::JournalRecord record;
  v1::JournalHeader& header = *record.mutable_header();
  header.set_format(aprsim::journal::kFormat);
  header.set_run_id("capture " + std::filesystem::path(capture).filename().string());
  header.set_part(1);
  std::uint32_t number = 0;
  for (const auto& [port, name] : ports) {
    v1::JournalEndpoint& endpoint = *header.add_endpoints();
    endpoint.set_number(++number);
    endpoint.set_name(name);
  }
  return record;
}

}  // namespace

ListenerPorts usual_ports() {
  return {{64444, "crcl.fanuc"}, {64445, "crcl.motoman"}, {502, "modbus"},
          {1502, "modbus"},      {4000, "vision.fanuc"},  {4001, "vision.motoman"}};
}

bool is_listener_name(const std::string& name) {
  return name == "modbus" || (name.starts_with("crcl.") && name.size() > 5) ||
         (name.starts_with("vision.") && name.size() > 7);
}

Result<Imported> import_capture(const std::string& capture, const std::string& journal,
                                const ListenerPorts& ports) {
  char error[PCAP_ERRBUF_SIZE] = {};
  const std::unique_ptr<pcap_t, CloseCapture> opened(
      pcap_open_offline_with_tstamp_precision(capture.c_str(), PCAP_TSTAMP_PRECISION_NANO, error));
  if (!opened) {
    // libpcap names the file in some of its messages.
    const std::string why = error;
    return fail(ErrorCode::kInvalidArgument, "capture",
                why.find(capture) != std::string::npos ? why : capture + ": " + why);
  }
  const int link = pcap_datalink(opened.get());
  if (!is_known_link(link)) {
    const char* name = pcap_datalink_val_to_name(link);
    return fail(ErrorCode::kInvalidArgument, "capture",
                fmt::format("{}: packets of link {} ({}) cannot be read; expected Ethernet, Linux "
                            "cooked, loopback or raw IP",
                            capture, link, name != nullptr ? name : "unknown"));
  }
  JournalWriter out(journal);
  out.add(header_record(capture, ports));
  Importer importer(out, ports);
  pcap_pkthdr* header = nullptr;
  const u_char* bytes = nullptr;
  int got = 0;
  while ((got = pcap_next_ex(opened.get(), &header, &bytes)) == 1) {
    importer.packet(link, *header, bytes);
  }
  Imported imported = importer.finish();
  if (got == PCAP_ERROR) {
    imported.notes.push_back(fmt::format("{} ends early: {}", capture, pcap_geterr(opened.get())));
  }
  v1::JournalRecord end;
  end.mutable_end()->mutable_time()->set_step(
      static_cast<std::uint64_t>(std::llround(1e3 * imported.duration_s)));
  out.add(end);
  if (auto written = out.finish(); !written) return tl::unexpected(written.error());
  return imported;
}

}  // namespace aprsim::trace
