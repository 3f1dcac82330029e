#include "protocols/conveyor/conveyor_device.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

#include "protocols/conveyor/command_exception.hpp"
#include "world/api/commands/stop_command.hpp"

namespace aprsim::conveyor {
namespace {

using modbus::ExceptionCode;

// Bound on writes that the simulation has not confirmed. Its queue is smaller; this bounds the
// memory if the simulation stops confirming.
constexpr std::size_t kMaxPending = 4096;

static_assert(api::kMaxPhotoEyes == modbus::kPhotoEyes);
static_assert(api::kMaxCurtainBeams == modbus::kCurtainBeams);

modbus::FaultCode fault_of(const api::Snapshot& snapshot) {
  if (!snapshot.world_fault.empty()) return modbus::FaultCode::kCellStopped;
  switch (snapshot.conveyor.fault) {
    case api::DriveFault::kNone:
      break;
    case api::DriveFault::kEmergencyStop:
      return modbus::FaultCode::kEmergencyStop;
    case api::DriveFault::kWatchdog:
      return modbus::FaultCode::kWatchdog;
    case api::DriveFault::kLightCurtain:
      return modbus::FaultCode::kLightCurtain;
  }
  return modbus::FaultCode::kNone;
}

std::size_t offset(std::uint16_t address) {
  return static_cast<std::size_t>(address - modbus::kFirstAddress);
}

/// `word` outlives the request.
modbus::Request single_register(std::uint16_t address, const std::array<std::uint8_t, 2>& word) {
  modbus::Request single;
  single.function = modbus::Function::kWriteSingleRegister;
  single.address = address;
  single.quantity = 1;
  single.data = word;
  return single;
}

}  // namespace

modbus::ConveyorReadings readings_of(const api::Snapshot& snapshot) {
  modbus::ConveyorReadings readings;
  readings.fault = fault_of(snapshot);
  readings.time_ms = static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::milliseconds>(snapshot.time).count());
  if (!snapshot.cell) return readings;
  if (const auto& curtain = snapshot.cell->light_curtain) {
    readings.light_curtain = {static_cast<std::uint16_t>(curtain->beams), curtain->range_m,
                              snapshot.light_curtain.broken, snapshot.light_curtain.distance_m};
  }
  if (!snapshot.cell->has_conveyor) return readings;
  const api::ConveyorSnapshot& conveyor = snapshot.conveyor;
  readings.present = true;
  readings.run = conveyor.run;
  readings.forward = conveyor.forward;
  readings.speed_setting_m_s = conveyor.speed_setting_m_s;
  readings.speed_m_s = conveyor.speed_m_s;
  readings.travel_m = conveyor.travel_m;
  readings.max_speed_m_s = snapshot.cell->conveyor.max_speed_m_s;
  readings.emergency_stop = conveyor.emergency_stop;
  readings.motor_current_a = conveyor.motor_current_a;
  readings.load_kg = conveyor.load_kg;
  for (std::size_t i = 0; i < readings.photo_eyes.size(); ++i) {
    readings.photo_eyes[i] = {conveyor.photo_eyes[i].broken, conveyor.photo_eyes[i].count};
  }
  return readings;
}

ConveyorDevice::ConveyorDevice(const modbus::ConveyorScaling& scaling, api::EndpointId endpoint,
                               api::CommandSink& sink, const api::SnapshotSource& source,
                               double watchdog_s)
    : scaling_(scaling),
      endpoint_(endpoint),
      watchdog_s_(watchdog_s),
      sink_(sink),
      source_(source) {
  refresh();
}

void ConveyorDevice::refresh() {
  const api::SnapshotPtr snapshot = source_.latest();
  applied_ = snapshot->applied;
  while (!pending_.empty() && applied(pending_.front().ticket)) {
    commit(pending_.front());
    pending_.pop_front();
  }
  if (epoch_ != snapshot->epoch) {
    image_ = {};
    written_speed_.reset();
    epoch_ = snapshot->epoch;
  }
  const modbus::ConveyorReadings readings = readings_of(*snapshot);
  has_conveyor_ = readings.present;
  encode(readings, scaling_, image_);
  keep_or_forget_speed(readings);
}

void ConveyorDevice::keep_or_forget_speed(const modbus::ConveyorReadings& readings) {
  if (!written_speed_) return;
  // The same arithmetic as decode_write(), so the comparison is exact. The drive may keep the
  // setting as it is or limit it to what the belt can do.
  const double wanted = *written_speed_ * scaling_.m_s_per_count();
  const double setting = readings.speed_setting_m_s;
  if (setting == wanted || setting == std::min(wanted, readings.max_speed_m_s)) {
    image_.holding[offset(modbus::kSpeedRegister)] = *written_speed_;
  } else {
    written_speed_.reset();
  }
}

modbus::Checked<api::Ticket> ConveyorDevice::write(const modbus::Request& request) {
  if (request.function != modbus::Function::kMaskWriteRegister) return write_values(request);
  const auto word = masked_word(request);
  return write_values(single_register(request.address, word));
}

bool ConveyorDevice::is_stop(const modbus::Request& request) const {
  if (!request.is_write()) return false;
  const bool masked = request.function == modbus::Function::kMaskWriteRegister;
  const auto word = masked ? masked_word(request) : std::array<std::uint8_t, 2>{};
  const auto wanted =
      modbus::decode_write(masked ? single_register(request.address, word) : request, scaling_);
  return wanted && api::is_stop(command_of(*wanted));
}

void ConveyorDevice::show(api::Ticket ticket) {
  for (const PendingWrite& write : pending_) {
    if (write.ticket <= ticket) commit(write);
  }
}

std::array<std::uint8_t, 2> ConveyorDevice::masked_word(const modbus::Request& request) const {
  const unsigned now = latest_word(request.address);
  const unsigned and_mask = request.word(0), or_mask = request.word(1);
  const unsigned value = (now & and_mask) | (or_mask & ~and_mask);
  return {static_cast<std::uint8_t>((value >> 8) & 0xFF), static_cast<std::uint8_t>(value & 0xFF)};
}

std::uint16_t ConveyorDevice::latest_word(std::uint16_t address) const {
  std::uint16_t value = image_.holding[offset(address)];
  for (const PendingWrite& write : pending_) {
    const int index = int{address} - int{write.address};
    if (write.coils || index < 0 || index >= static_cast<int>(write.values.size())) continue;
    value = write.values[static_cast<std::size_t>(index)];
  }
  return value;
}

modbus::Checked<api::Ticket> ConveyorDevice::write_values(const modbus::Request& request) {
  const auto wanted = modbus::decode_write(request, scaling_);
  if (!wanted) return tl::unexpected(wanted.error());
  PendingWrite write{0, request.is_coil_write(), request.address, {}};
  write.values.reserve(request.quantity);
  for (std::uint16_t i = 0; i < request.quantity; ++i) {
    write.values.push_back(write.coils ? std::uint16_t{request.bit(i)} : request.word(i));
  }
  // Every write resets the watchdog, so the drive must receive it.
  const bool sign_of_life = watchdog_s_ > 0 && has_conveyor_;
  if (wanted->empty() && !sign_of_life) {
    commit(write);
    return api::Ticket{0};
  }
  const auto ticket = submit(command_of(*wanted));
  if (!ticket) return ticket;
  if (pending_.size() >= kMaxPending) {
    commit(write);
    return ticket;
  }
  write.ticket = *ticket;
  pending_.push_back(std::move(write));
  return ticket;
}

api::ConveyorCommand ConveyorDevice::command_of(const modbus::ConveyorWrite& wanted) const {
  api::ConveyorCommand command;
  command.run = wanted.run;
  command.forward = wanted.forward;
  command.speed_m_s = wanted.speed_m_s;
  command.emergency_stop = wanted.emergency_stop;
  command.fault_reset = wanted.fault_reset;
  if (watchdog_s_ > 0) command.watchdog_s = watchdog_s_;
  return command;
}

modbus::Checked<api::Ticket> ConveyorDevice::submit(const api::ConveyorCommand& command) {
  if (!has_conveyor_) return tl::unexpected(ExceptionCode::kServerDeviceFailure);
  if (pending_.size() >= kMaxPending && !api::is_stop(command)) {
    return tl::unexpected(ExceptionCode::kServerDeviceBusy);
  }
  const auto ticket = sink_.submit({endpoint_, command});
  if (!ticket) return tl::unexpected(exception_for(ticket.error()));
  return *ticket;
}

void ConveyorDevice::commit(const PendingWrite& write) {
  for (std::size_t i = 0; i < write.values.size(); ++i) {
    const std::size_t at = offset(write.address) + i;
    if (write.coils) {
      image_.coils[at] = static_cast<std::uint8_t>(write.values[i]);
      continue;
    }
    image_.holding[at] = write.values[i];
    if (write.address + i == modbus::kSpeedRegister) written_speed_ = write.values[i];
  }
}

}  // namespace aprsim::conveyor
