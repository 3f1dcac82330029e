#include "clients/aprsim/trace/listing.hpp"

#include <map>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/trace/action.hpp"
#include "clients/aprsim/trace/crcl_fields.hpp"
#include "crcl/command_codec.hpp"
#include "crcl/status_codec.hpp"
#include "world/base/utf8.hpp"

namespace aprsim::trace {
namespace {

constexpr std::size_t kLongest = 300;  // bytes of a line's text

std::string fields_text(const std::vector<Field>& fields) {
  std::string out;
  for (const Field& field : fields) {
    out += (out.empty() ? ": " : ", ") + field.name + ' ' + text_of(field.value);
  }
  return out;
}

/// The text on one line in UTF-8, without control characters: it goes to terminals and tables.
std::string in_one_line(std::string text) {
  for (char& c : text) c = c == '\n' || c == '\r' || c == '\t' || c == '\0' ? ' ' : c;
  while (text.ends_with(' ')) text.pop_back();
  text = utf8::printable(text);
  if (text.size() > kLongest) text = std::string(utf8::cut(text, kLongest)) + " ...";
  return text;
}

/// Describes messages in words; tracks the units of each CRCL connection.
class Describer {
 public:
  struct Described {
    std::string what;
    bool poll = false;  ///< it only asks, or says nothing new
  };

  Described operator()(const v1::JournalWire& wire) {
    switch (wire.content()) {
      case v1::WIRE_CONTENT_OPENED:
        return {"opened by " + wire.peer()};
      case v1::WIRE_CONTENT_CLOSED:
        return {"closed" + (wire.text().empty() ? "" : ": " + wire.text())};
      case v1::WIRE_CONTENT_RECEIVED:
        break;
      default:
        return answer(wire);
    }
    if (wire.kind() == v1::WIRE_KIND_CRCL) return crcl_request(wire);
    return request(wire);
  }

 private:
  Described crcl_request(const v1::JournalWire& wire) {
    const std::string& data = wire.data();
    crcl::Units& units = units_[wire.connection()];
    if (data.find("<CRCLProgram") != std::string::npos) {
      const auto program = crcl::decode_program(data);
      if (!program) return {"unreadable program: " + program.error().message()};
      return {fmt::format("program of {} commands", program->commands.size())};
    }
    const auto instance = crcl::decode_command(data, crcl::kMaxProgramBytes);
    if (!instance) return {"unreadable command: " + instance.error().message()};
    const crcl::Command& command = instance->command;
    Described out{fmt::format("{} {}{}", command.id, kind_of(command.body),
                              fields_text(fields_of(command, units))),
                  std::holds_alternative<crcl::GetStatus>(command.body)};
    follow_units(command.body, units);
    return out;
  }

  /// Uses the comparison's reader, which names the fields of a request.
  static Described request(const v1::JournalWire& wire) {
    const WireRecord record{0, wire};
    const WireActions one = wire.kind() == v1::WIRE_KIND_MODBUS ? modbus_actions({&record})
                            : wire.kind() == v1::WIRE_KIND_SIMPLE_MESSAGE
                                ? simple_message_actions({&record})
                                : call_actions({&record});
    if (!one.actions.empty()) {
      return {one.actions.front().kind + fields_text(one.actions.front().fields)};
    }
    if (!one.reads.empty()) return {"read " + one.reads.begin()->first, true};
    return {wire.method().empty() ? fmt::format("{} bytes", wire.data().size())
                                  : wire.method().substr(wire.method().rfind('/') + 1),
            true};
  }

  Described answer(const v1::JournalWire& wire) {
    switch (wire.kind()) {
      case v1::WIRE_KIND_CRCL: {
        const auto status = crcl::decode_status(wire.data());
        if (!status) return {"unreadable status: " + status.error().message()};
        const crcl::CommandStatus& command = status->command;
        std::string what = fmt::format("{} {}", command.command_id, crcl::name_of(command.state));
        if (command.description && !command.description->empty()) {
          what += " (" + *command.description + ")";
        }
        std::string& last = last_[wire.connection()];
        const bool again = std::exchange(last, what) == what;
        return {what + fields_text(results_of(*status, units_[wire.connection()])), again};
      }
      case v1::WIRE_KIND_MODBUS: {
        constexpr std::size_t kFunction = 7;  // place in the unit
        const std::string& data = wire.data();
        const auto byte = [&](std::size_t at) { return static_cast<std::uint8_t>(data[at]); };
        if (data.size() <= kFunction) return {"unreadable unit"};
        if ((byte(kFunction) & 0x80U) != 0) {
          return {
              fmt::format("exception {}", data.size() > kFunction + 1 ? byte(kFunction + 1) : 0)};
        }
        std::string hex;
        for (std::size_t at = kFunction; at < data.size() && at < kFunction + 40; ++at) {
          hex += fmt::format(" {:02x}", byte(at));
        }
        return {"answer" + hex, true};
      }
      case v1::WIRE_KIND_VISION:
        return {wire.data(), true};
      default:
        return {fmt::format("reply of {} bytes{}", wire.data().size(),
                            wire.text().empty() ? "" : ": " + wire.text()),
                wire.text().empty()};
    }
  }

  std::map<std::uint64_t, crcl::Units> units_;
  std::map<std::uint64_t, std::string> last_;  ///< of each connection's answers
};

std::string event_text(const v1::CellEvent& event) {
  std::string out = event_word(event.kind());
  for (const std::string& name : event.names()) out += ' ' + name;
  return event.text().empty() ? out : out + ": " + event.text();
}

/// Describes the journal's own records; commands to the cell are on the wires already.
std::optional<std::string> journal_text(const v1::JournalRecord& record) {
  if (record.has_epoch()) {
    return fmt::format("the cell is reset, seed {}{}", record.epoch().seed(),
                       record.epoch().has_loaded_state()
                           ? ", with the state " + record.epoch().loaded_state()
                           : "");
  }
  if (record.has_gap()) {
    return fmt::format("{} records are missing: {}", record.gap().records(), record.gap().reason());
  }
  return std::nullopt;
}

}  // namespace

std::string text_of(const ListedLine& line) {
  const char* arrow = line.direction == "in" ? "->" : (line.direction == "out" ? "<-" : "  ");
  return fmt::format("{:10.3f} s  {:<16} {:>4} {} {}\n", line.time_s, line.wire,
                     line.connection > 0 ? fmt::format("#{}", line.connection) : "", arrow,
                     line.text);
}

nlohmann::ordered_json json_of(const ListedLine& line) {
  return {{"time_s", line.time_s},
          {"wire", line.wire},
          {"connection", line.connection},
          {"direction", line.direction},
          {"text", line.text}};
}

Result<std::vector<std::string>> list_trace(const std::string& place, const ListingChoice& choice,
                                            const std::function<void(const ListedLine&)>& show) {
  TraceClock clock;
  Describer describe;
  double now_s = 0;
  const auto give = [&](ListedLine line) {
    if (!choice.wire.empty() && line.wire != choice.wire) return;
    if (line.time_s < choice.from_s.value_or(line.time_s)) return;
    if (line.time_s > choice.to_s.value_or(line.time_s)) return;
    line.text = in_one_line(std::move(line.text));
    show(line);
  };
  return for_each_record(place, [&](const v1::JournalRecord& record) {
    if (record.has_wire()) {
      const v1::JournalWire& wire = record.wire();
      now_s = clock.at(wire.time().epoch(), seconds_of(wire.sim_time()));
      auto described = describe(wire);
      if (described.poll && !choice.polls) return;
      give({now_s, wire.listener(), wire.connection(),
            wire.content() == v1::WIRE_CONTENT_RECEIVED ? "in"
            : wire.content() == v1::WIRE_CONTENT_SENT   ? "out"
                                                        : "",
            std::move(described.what)});
    } else if (record.has_event()) {
      const v1::CellEvent& event = record.event();
      now_s = clock.at(event.epoch(), seconds_of(event.sim_time()));
      give({now_s, "cell", 0, "", event_text(event)});
    } else if (auto text = journal_text(record)) {
      give({now_s, "cell", 0, "", *std::move(text)});
    }
  });
}

}  // namespace aprsim::trace
