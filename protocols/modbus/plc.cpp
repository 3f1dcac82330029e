#include "protocols/modbus/plc.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

namespace aprsim::protocols {
namespace {

using modbus::ExceptionCode;

// Writes that the simulation has not confirmed. More than its queue can hold never gets here; this
// bounds the memory should the simulation stop confirming.
constexpr std::size_t kMaxPending = 4096;

modbus::ConveyorReadings readings_of(const api::Snapshot& snapshot) {
  modbus::ConveyorReadings readings;
  readings.fault = !snapshot.world_fault.empty();
  if (!snapshot.cell || !snapshot.cell->has_conveyor) return readings;
  const api::ConveyorSnapshot& conveyor = snapshot.conveyor;
  readings.present = true;
  readings.run = conveyor.run;
  readings.forward = conveyor.forward;
  readings.speed_setting_m_s = conveyor.speed_setting_m_s;
  readings.speed_m_s = conveyor.speed_m_s;
  readings.travel_m = conveyor.travel_m;
  readings.max_speed_m_s = snapshot.cell->conveyor.max_speed_m_s;
  readings.time_ms = static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::milliseconds>(snapshot.time).count());
  return readings;
}

ExceptionCode exception_for(const Error& error) {
  switch (error.code) {
    case ErrorCode::kUnavailable:
      return ExceptionCode::kServerDeviceBusy;
    case ErrorCode::kInvalidArgument:
      return ExceptionCode::kIllegalDataValue;
    default:
      return ExceptionCode::kServerDeviceFailure;
  }
}

std::size_t offset(std::uint16_t address) {
  return static_cast<std::size_t>(address - modbus::kFirstAddress);
}

}  // namespace

Plc::Plc(const modbus::ConveyorScaling& scaling, api::EndpointId endpoint, api::CommandSink& sink,
         const api::SnapshotSource& source)
    : scaling_(scaling), endpoint_(endpoint), sink_(sink), source_(source) {
  refresh();
}

void Plc::refresh() {
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

void Plc::keep_or_forget_speed(const modbus::ConveyorReadings& readings) {
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

modbus::Checked<api::Ticket> Plc::write(const modbus::Request& request) {
  if (request.function == modbus::Function::kWriteSingleCoil ||
      request.function == modbus::Function::kWriteMultipleCoils) {
    write_coils(request);
    return api::Ticket{0};
  }
  return write_registers(request);
}

void Plc::write_coils(const modbus::Request& request) {
  for (std::uint16_t i = 0; i < request.quantity; ++i) {
    image_.coils[offset(request.address) + i] = request.bit(i) ? 1 : 0;
  }
}

modbus::Checked<api::Ticket> Plc::write_registers(const modbus::Request& request) {
  const auto wanted = modbus::decode_write(request, scaling_);
  if (!wanted) return tl::unexpected(wanted.error());
  PendingWrite write{0, request.address, {}};
  write.words.reserve(request.quantity);
  for (std::uint16_t i = 0; i < request.quantity; ++i) write.words.push_back(request.word(i));
  if (wanted->empty()) {
    commit(write);
    return api::Ticket{0};
  }
  if (!has_conveyor_) return tl::unexpected(ExceptionCode::kServerDeviceFailure);
  if (pending_.size() >= kMaxPending) return tl::unexpected(ExceptionCode::kServerDeviceBusy);
  const auto ticket = sink_.submit(
      {endpoint_, api::ConveyorCommand{wanted->run, wanted->forward, wanted->speed_m_s}});
  if (!ticket) return tl::unexpected(exception_for(ticket.error()));
  write.ticket = *ticket;
  pending_.push_back(std::move(write));
  return *ticket;
}

void Plc::commit(const PendingWrite& write) {
  for (std::size_t i = 0; i < write.words.size(); ++i) {
    image_.holding[offset(write.address) + i] = write.words[i];
    if (write.address + i == modbus::kSpeedRegister) written_speed_ = write.words[i];
  }
}

}  // namespace aprsim::protocols
