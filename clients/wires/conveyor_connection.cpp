#include "clients/wires/conveyor_connection.hpp"

#include <cerrno>
#include <span>
#include <utility>

#include <fmt/format.h>
#include <modbus.h>

namespace aprsim::client {
namespace {

constexpr std::uint32_t kResponseTimeout_s = 3;
// The entries of each area that are read: all before the light curtain's beams.
constexpr int kHoldingRegisters = modbus::kSpeedRegister - modbus::kFirstAddress + 1;
constexpr int kInputRegisters = modbus::kCurtainRangeRegister - modbus::kFirstAddress + 1;
constexpr int kCoils = modbus::kFaultResetCoil - modbus::kFirstAddress + 1;
constexpr int kInputs = modbus::kPhotoEyeInput - modbus::kFirstAddress + modbus::kPhotoEyes;

/// The failure of a request, from errno.
tl::unexpected<Failure> request_failure(const std::string& what) {
  const int error = errno;
  // Exceptions that the server answered with come first among libmodbus' own numbers.
  const bool answered = error > MODBUS_ENOBASE && error < EMBBADCRC;
  return failed(answered             ? FailureKind::kRefused
                : error == ETIMEDOUT ? FailureKind::kTimeout
                                     : FailureKind::kConnection,
                fmt::format("{}: {}", what, modbus_strerror(error)));
}

/// The same outcome, its failure beginning with these words.
Outcome<void> with_words(Outcome<void> outcome, const std::string& what) {
  if (outcome) return outcome;
  return failed(outcome.error().kind, what + ": " + outcome.error().message);
}

constexpr const char* kReading = "cannot read the conveyor's registers";

}  // namespace

void ConveyorConnection::Close::operator()(_modbus* context) const {
  modbus_close(context);
  modbus_free(context);
}

ConveyorConnection::ConveyorConnection(std::unique_ptr<_modbus, Close> context)
    : context_(std::move(context)) {}

ConveyorConnection::ConveyorConnection(SecureModbus secure) : secure_(std::move(secure)) {}

Outcome<ConveyorConnection> ConveyorConnection::connect(const Endpoints& endpoints) {
  std::unique_ptr<_modbus, Close> context(
      modbus_new_tcp_pi(endpoints.host.c_str(), std::to_string(endpoints.modbus).c_str()));
  if (!context || modbus_set_response_timeout(context.get(), kResponseTimeout_s, 0) != 0 ||
      modbus_connect(context.get()) != 0) {
    return failed(
        FailureKind::kConnection,
        fmt::format("cannot reach the conveyor by Modbus at {}: {}",
                    host_and_port(endpoints.host, endpoints.modbus), modbus_strerror(errno)));
  }
  return ConveyorConnection(std::move(context));
}

Outcome<ConveyorConnection> ConveyorConnection::connect_securely(const Endpoints& endpoints) {
  if (!endpoints.encryption || endpoints.encryption->certificate.empty()) {
    return failed(FailureKind::kUsage, "Modbus Security needs a client certificate and its key");
  }
  auto secure = SecureModbus::connect(endpoints.host, endpoints.modbus_tls, *endpoints.encryption);
  if (secure) return ConveyorConnection(*std::move(secure));
  return failed(
      secure.error().kind,
      fmt::format("cannot reach the conveyor by Modbus Security at {}: {}",
                  host_and_port(endpoints.host, endpoints.modbus_tls), secure.error().message));
}

Outcome<void> ConveyorConnection::write(std::uint16_t address, std::uint16_t value) {
  const auto what = [&] {
    return fmt::format("cannot write {} to register 0x{:04X}", value, address);
  };
  if (secure_) return with_words(secure_->write_register(address, value), what());
  if (modbus_write_register(context_.get(), address, value) == 1) return {};
  return request_failure(what());
}

Outcome<modbus::RegisterImage> ConveyorConnection::read() {
  modbus::RegisterImage image;
  const auto done = secure_ ? read_securely(image) : read_plainly(image);
  if (!done) return tl::unexpected(done.error());
  return image;
}

Outcome<void> ConveyorConnection::read_plainly(modbus::RegisterImage& image) {
  constexpr int first = modbus::kFirstAddress;
  _modbus* const context = context_.get();
  if (modbus_read_registers(context, first, kHoldingRegisters, image.holding.data()) < 0 ||
      modbus_read_input_registers(context, first, kInputRegisters, image.input.data()) < 0 ||
      modbus_read_bits(context, first, kCoils, image.coils.data()) < 0 ||
      modbus_read_input_bits(context, first, kInputs, image.discrete.data()) < 0) {
    return request_failure(kReading);
  }
  return {};
}

Outcome<void> ConveyorConnection::read_securely(modbus::RegisterImage& image) {
  constexpr std::uint16_t first = modbus::kFirstAddress;
  auto done = secure_->read_words(MODBUS_FC_READ_HOLDING_REGISTERS, first,
                                  std::span(image.holding).first(kHoldingRegisters));
  if (done) {
    done = secure_->read_words(MODBUS_FC_READ_INPUT_REGISTERS, first,
                               std::span(image.input).first(kInputRegisters));
  }
  if (done) {
    done = secure_->read_bits(MODBUS_FC_READ_COILS, first, std::span(image.coils).first(kCoils));
  }
  if (done) {
    done = secure_->read_bits(MODBUS_FC_READ_DISCRETE_INPUTS, first,
                              std::span(image.discrete).first(kInputs));
  }
  return with_words(std::move(done), kReading);
}

}  // namespace aprsim::client
