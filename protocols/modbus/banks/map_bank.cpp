#include "protocols/modbus/banks/map_bank.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "protocols/conveyor/command_exception.hpp"
#include "world/api/commands/stop_command.hpp"

namespace aprsim::modbus_server {
namespace {

using modbus::Area;
using modbus::ExceptionCode;

// Bound on writes that the simulation has not confirmed. Its queue is smaller; this bounds the
// memory if the simulation stops confirming.
constexpr std::size_t kMaxPending = 4096;

/// The value that a client may set the signal to; absent = none. A count that stands for a limit of
/// the signal may be beyond it by its rounding.
std::optional<double> accepted(const BoundRegister& of, double value) {
  constexpr double kFloatRounding = 1e-7, kHalfCount = 0.5;
  const api::BoundSignal& signal = of.signal;
  if (signal.info->flag) return value == 0 || value == 1 ? std::optional(value) : std::nullopt;
  const bool is_float = of.format.encoding == modbus::NumberEncoding::kFloat32;
  const double rounding = is_float ? kFloatRounding * (std::abs(value) + std::abs(of.format.offset))
                                   : kHalfCount * std::abs(of.format.scale);
  if (value < signal.min - rounding || value > signal.max + rounding) return std::nullopt;
  return std::clamp(value, signal.min, signal.max);
}

}  // namespace

MapBank::MapBank(std::string name, api::EndpointId endpoint, api::CommandSink& sink,
                 const api::SnapshotSource& source)
    : endpoint_(endpoint), sink_(sink), source_(source), memory_(std::move(name)) {
  refresh();
}

void MapBank::follow_scene() { memory_.follow(*source_.latest()); }

void MapBank::refresh() {
  const api::SnapshotPtr snapshot = source_.latest();
  memory_.read(*snapshot);
  applied_ = snapshot->applied;
  while (!pending_.empty() && applied(pending_.front().ticket)) pending_.pop_front();
}

modbus::Checked<api::Ticket> MapBank::write(const modbus::Request& request) {
  // The scene may have changed since the request was checked.
  if (!addresses_.has(modbus::area_of(request.function), request.address, request.quantity, true)) {
    return tl::unexpected(ExceptionCode::kIllegalDataAddress);
  }
  Values values = values_of(request);
  const auto commands = commands_of(values);
  if (!commands) return tl::unexpected(commands.error());
  const auto ticket = submit(*commands);
  if (ticket && pending_.size() < kMaxPending) pending_.push_back({*ticket, std::move(values)});
  return ticket;
}

bool MapBank::is_stop(const modbus::Request& request) const {
  if (!request.is_write()) return false;
  if (!addresses_.has(modbus::area_of(request.function), request.address, request.quantity, true)) {
    return false;
  }
  const auto commands = commands_of(values_of(request));
  return commands && api::is_stop(commands->belt);
}

void MapBank::show(api::Ticket ticket) {
  for (const PendingWrite& write : pending_) {
    if (write.ticket <= ticket) store(write.values);
  }
}

MapBank::Values MapBank::values_of(const modbus::Request& request) const {
  Values values{modbus::area_of(request.function), request.address, {}};
  if (request.function == modbus::Function::kMaskWriteRegister) {
    const unsigned now = latest(values.area, request.address);
    const unsigned and_mask = request.word(0), or_mask = request.word(1);
    values.values.push_back(
        static_cast<std::uint16_t>((now & and_mask) | (or_mask & ~and_mask & 0xFFFFU)));
    return values;
  }
  values.values.reserve(request.quantity);
  for (std::uint16_t i = 0; i < request.quantity; ++i) {
    values.values.push_back(request.is_coil_write() ? std::uint16_t{request.bit(i)}
                                                    : request.word(i));
  }
  return values;
}

std::uint16_t MapBank::latest(Area area, std::uint16_t address) const {
  std::uint16_t value = memory_.writable(area, address);
  for (const PendingWrite& write : pending_) {
    const int index = int{address} - int{write.values.address};
    const auto& values = write.values.values;
    if (write.values.area != area || index < 0 || index >= static_cast<int>(values.size())) {
      continue;
    }
    value = values[static_cast<std::size_t>(index)];
  }
  return value;
}

modbus::Checked<api::SignalCommands> MapBank::commands_of(const Values& values) const {
  api::SignalCommands commands;
  const std::size_t count = values.values.size();
  for (const BoundRegister* each : memory_.map().touched(values.area, values.address, count)) {
    modbus::ValueWords words{};
    for (int i = 0; i < each->format.words(); ++i) {
      // A word of the value that is not written keeps what it has.
      const int index = each->address + i - int{values.address};
      const bool written = index >= 0 && index < static_cast<int>(count);
      words[static_cast<std::size_t>(i)] =
          written ? values.values[static_cast<std::size_t>(index)]
                  : latest(values.area, static_cast<std::uint16_t>(each->address + i));
    }
    auto value = modbus::from_words(words, each->format);
    if (value) value = accepted(*each, *value);
    if (!value) return tl::unexpected(ExceptionCode::kIllegalDataValue);
    api::set_signal(each->signal, *value, commands);
  }
  return commands;
}

/// A stop of the belt goes first, since it is always accepted; any other command of the belt goes
/// last, so that nothing runs whose request is refused.
modbus::Checked<api::Ticket> MapBank::submit(const api::SignalCommands& commands) {
  const bool stop = api::is_stop(commands.belt);
  const bool busy = pending_.size() >= kMaxPending && !stop;
  if (busy) return tl::unexpected(ExceptionCode::kServerDeviceBusy);
  std::vector<decltype(api::Command::body)> bodies;
  if (!commands.devices.settings.empty()) bodies.emplace_back(commands.devices);
  if (commands.belt != api::ConveyorCommand{}) {
    bodies.insert(stop ? bodies.begin() : bodies.end(), commands.belt);
  }
  api::Ticket last = 0;
  for (auto& body : bodies) {
    const auto ticket = sink_.submit({endpoint_, std::move(body)});
    if (!ticket) return tl::unexpected(conveyor::exception_for(ticket.error()));
    last = *ticket;
  }
  return last;
}

void MapBank::store(const Values& values) {
  std::size_t address = values.address;
  for (const std::uint16_t value : values.values) memory_.overwrite(values.area, address++, value);
}

}  // namespace aprsim::modbus_server
