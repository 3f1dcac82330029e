#include "clients/aprsim/trace/capture.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
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
#include "world/base/files/draft_file.hpp"
#include "world/base/utf8.hpp"

namespace aprsim::trace {
namespace {

struct CloseCapture {
  void operator()(pcap_t* capture) const { pcap_close(capture); }
};

v1::WireKind wire_kind(const std::string& listener) {
  if (listener.starts_with("crcl.")) return v1::WIRE_KIND_CRCL;
  if (listener == "modbus") return v1::WIRE_KIND_MODBUS;
  return listener.starts_with("vision.") ? v1::WIRE_KIND_VISION : v1::WIRE_KIND_SIMPLE_MESSAGE;
}

/// Writes the records of one journal file, which is in its place once all are written.
class JournalWriter {
 public:
  explicit JournalWriter(const std::string& file) : file_(file) {
    file_.out() << aprsim::journal::kMagic;
  }
  void add(const v1::JournalRecord& record) {
    encoder_.add(record);
    if (encoder_.pending() >= aprsim::journal::kFrameBytes) file_.out() << encoder_.take();
  }
  Result<void> finish() {
    file_.out() << encoder_.take();
    return file_.commit();
  }

 private:
  files::DraftFile file_;
  aprsim::journal::FrameEncoder encoder_;
};

/// Converts the packets of one capture to records.
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
    // A clock that was set back does not change the order of the packets.
    now_ns_ = std::max(now_ns_, now_ns - start_ns_);
    const Packet packet = read_packet(link, {bytes, header.caplen}, header.len);
    if (packet.kind == PacketKind::kFragment) ++fragments_;
    if (packet.kind == PacketKind::kSkipped) ++skipped_[packet.skipped];
    if (packet.kind != PacketKind::kTcp) return;
    if (packet.segment.cut) ++cut_;
    streams_.take(packet.segment);
  }

  Imported finish() {
    streams_.end();
    const auto note = [this](std::uint64_t count, const char* one, const char* many) {
      if (count > 0)
        imported_.notes.push_back(fmt::format("{} {}", count, count == 1 ? one : many));
    };
    for (const auto& [what, count] : skipped_) {
      imported_.skipped += count;
      imported_.notes.push_back(fmt::format("{} of {} {} not read", count_text(count), what,
                                            count == 1 ? "was" : "were"));
    }
    note(fragments_, "fragment of an IP packet was left out",
         "fragments of IP packets were left out");
    note(cut_, "packet was captured in part only (see tcpdump's -s)",
         "packets were captured in part only (see tcpdump's -s)");
    note(streams_.holes(), "gap in the captured bytes of a connection",
         "gaps in the captured bytes of a connection");
    for (const std::string& why : broken_) imported_.notes.push_back(why);
    imported_.connections = streams_.connections();
    imported_.duration_s = 1e-9 * static_cast<double>(now_ns_);
    return std::move(imported_);
  }

 private:
  static std::string count_text(std::uint64_t count) {
    return fmt::format("{} packet{}", count, count == 1 ? "" : "s");
  }

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
  std::map<std::string, std::uint64_t> skipped_;  ///< by kind of encapsulation
  std::vector<std::string> broken_;
  Imported imported_;
};

v1::JournalRecord header_record(const std::string& capture, const ListenerPorts& ports) {
  v1::JournalRecord record;
  v1::JournalHeader& header = *record.mutable_header();
  header.set_format(aprsim::journal::kFormat);
  // File names are bytes, and the field is UTF-8.
  header.set_run_id("capture " + utf8::valid(std::filesystem::path(capture).filename().string()));
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
  return {{64444, "crcl.fanuc"},     {64445, "crcl.motoman"},  {502, "modbus"},
          {1502, "modbus"},          {4000, "vision.fanuc"},   {4001, "vision.motoman"},
          {11000, "motion.fanuc"},   {11002, "state.fanuc"},   {12123, "gripper.fanuc"},
          {50240, "motion.motoman"}, {50241, "state.motoman"}, {50242, "gripper.motoman"}};
}

bool is_listener_name(const std::string& name) {
  const auto allowed = [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '.';
  };
  constexpr std::array<std::string_view, 5> kKinds = {"crcl.", "vision.", "motion.", "state.",
                                                      "gripper."};
  const bool known = std::ranges::any_of(kKinds, [&](std::string_view kind) {
    return name.starts_with(kind) && name.size() > kind.size();
  });
  return name == "modbus" || (known && std::ranges::all_of(name, allowed));
}

namespace {

/// The program that unpacks a file, by its first bytes; empty = it is not packed.
std::string unpacker_of(const std::string& file) {
  std::array<char, 6> begin{};
  std::ifstream(file, std::ios::binary).read(begin.data(), begin.size());
  const std::string_view bytes(begin.data(), begin.size());
  using Packed = std::pair<std::string_view, const char*>;
  constexpr std::array kPacked = {
      Packed("\x1f\x8b", "gunzip"),  Packed("\x28\xb5\x2f\xfd", "unzstd"),
      Packed("\xfd\x37zXZ", "unxz"), Packed("BZh", "bunzip2"),
      Packed("PK\x03\x04", "unzip"), Packed("\x04\x22\x4d\x18", "unlz4")};
  for (const auto& [magic, program] : kPacked) {
    if (bytes.starts_with(magic)) return program;
  }
  return {};
}

Error not_a_capture(const std::string& capture, const std::string& why) {
  // libpcap names the file in some of its messages.
  std::string message = why.find(capture) != std::string::npos ? why : capture + ": " + why;
  if (const auto unpacker = unpacker_of(capture); !unpacker.empty()) {
    message += fmt::format("; the file is compressed: unpack it with {} first", unpacker);
  }
  return {ErrorCode::kInvalidArgument, "capture", message};
}

}  // namespace

Result<Imported> import_capture(const std::string& capture, const std::string& journal,
                                const ListenerPorts& ports) {
  const std::array inputs{capture}, outputs{journal};
  if (auto apart = files::check_outputs(inputs, outputs); !apart) {
    return tl::unexpected(apart.error());
  }
  char error[PCAP_ERRBUF_SIZE] = {};
  const std::unique_ptr<pcap_t, CloseCapture> opened(
      pcap_open_offline_with_tstamp_precision(capture.c_str(), PCAP_TSTAMP_PRECISION_NANO, error));
  if (!opened) return tl::unexpected(not_a_capture(capture, error));
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
