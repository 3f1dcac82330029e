#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

/// The conveyor's Modbus registers as one table, the source of documents, printed map, validation
/// and replies.
namespace aprsim::modbus {

/// The four Modbus data areas.
enum class Area : std::uint8_t { kCoil, kDiscreteInput, kInputRegister, kHoldingRegister };

/// The conveyor's PLC runs TwinCAT, whose Modbus server maps PLC variables to 0x8000-0x80FF of each
/// area (Beckhoff TF6250, default mapping). Other addresses do not exist.
inline constexpr std::uint16_t kFirstAddress = 0x8000;
inline constexpr std::uint16_t kAddressCount = 0x100;

// Holding registers, as in the lab.
inline constexpr std::uint16_t kRunRegister = 0x8000;
inline constexpr std::uint16_t kDirectionRegister = 0x8001;
inline constexpr std::uint16_t kSpeedRegister = 0x8002;

// Input registers; the published lab map has none.
inline constexpr std::uint16_t kActualSpeedRegister = 0x8000;
inline constexpr std::uint16_t kTargetSpeedRegister = 0x8001;
inline constexpr std::uint16_t kDriveStateRegister = 0x8002;
inline constexpr std::uint16_t kFaultCodeRegister = 0x8003;
inline constexpr std::uint16_t kPositionRegister = 0x8004;   // and 0x8005
inline constexpr std::uint16_t kTimeStampRegister = 0x8006;  // and 0x8007
inline constexpr std::uint16_t kMaxSpeedRegister = 0x8008;
inline constexpr std::uint16_t kMotorCurrentRegister = 0x8009;
inline constexpr std::uint16_t kLoadRegister = 0x800A;
inline constexpr std::uint16_t kItemCountRegister = 0x800C;  // of the first photo-eye
inline constexpr std::uint16_t kCurtainBeamsRegister = 0x8010;
inline constexpr std::uint16_t kCurtainRangeRegister = 0x8011;
inline constexpr std::uint16_t kBeamRegister = 0x8040;  // of the light curtain's first beam

// Coils.
inline constexpr std::uint16_t kRunCoil = 0x8000;
inline constexpr std::uint16_t kDirectionCoil = 0x8001;
inline constexpr std::uint16_t kEmergencyStopCoil = 0x8002;
inline constexpr std::uint16_t kFaultResetCoil = 0x8003;

// Discrete inputs.
inline constexpr std::uint16_t kReadyInput = 0x8000;
inline constexpr std::uint16_t kMovingInput = 0x8001;
inline constexpr std::uint16_t kAtSpeedInput = 0x8002;
inline constexpr std::uint16_t kFaultInput = 0x8003;
inline constexpr std::uint16_t kEmergencyStopInput = 0x8004;
inline constexpr std::uint16_t kReverseInput = 0x8005;
inline constexpr std::uint16_t kCurtainInput = 0x8006;
inline constexpr std::uint16_t kPhotoEyeInput = 0x8008;  // of the first photo-eye

/// Photo-eyes in the map.
inline constexpr std::uint16_t kPhotoEyes = 4;

/// Light curtain beams in the map.
inline constexpr std::uint16_t kCurtainBeams = 64;

/// Full scale of the speed registers in counts. Taken as unsigned: it is 0x8000.
inline constexpr std::uint16_t kSpeedFullScaleCounts = 32768;
/// One count of the position register [m].
inline constexpr double kMetresPerPositionCount = 1e-5;

enum class Access : std::uint8_t { kRead, kReadWrite };
/// 32-bit values take two registers, the high word at the lower address.
enum class Encoding : std::uint8_t { kBit, kUint16, kInt16, kUint32, kInt32 };
/// How counts become a physical value.
enum class Scaling : std::uint8_t {
  kNone,
  kSpeed,
  kPosition,
  kMilliseconds,
  kMilliamperes,
  kMillimetres,
  kDecagrams
};

struct RegisterInfo {
  Area area;
  std::uint16_t address;
  Access access;
  Encoding encoding;
  std::string_view name;
  std::string_view unit;  ///< of the scaled value; empty = a plain number
  Scaling scaling;
  std::int64_t min, max;  ///< in counts; a write outside is refused (exception 3)
  std::string_view meaning;
  std::uint16_t count = 1;  ///< such values, one after the other

  /// Addresses of one value.
  [[nodiscard]] constexpr std::uint16_t words() const {
    return encoding == Encoding::kUint32 || encoding == Encoding::kInt32 ? 2 : 1;
  }
  /// Addresses of all of them.
  [[nodiscard]] constexpr std::uint16_t span() const {
    return static_cast<std::uint16_t>(words() * count);
  }
};

/// How an installation scales the registers.
struct ConveyorScaling {
  /// Belt speed at 32768 counts [m/s]. The default makes one count 1e-5 m/s, the calibration the
  /// APRS conveyor panel starts with; the belt's own limit may be lower.
  double full_scale_m_s = 0.32768;
  /// Meaning of 1 in the direction register. APRS' Java panel: forward; its C++ clients: reverse.
  bool one_is_forward = true;

  [[nodiscard]] double m_s_per_count() const { return full_scale_m_s / kSpeedFullScaleCounts; }
};

/// All documented registers, ordered by area (holding registers first) and address.
[[nodiscard]] std::span<const RegisterInfo> register_map();

/// The documented register that covers an address, or null: unused PLC memory or no address at all.
[[nodiscard]] const RegisterInfo* find_register(Area area, std::uint16_t address);

/// Whether all of [address, address + count) is in the mapped range.
[[nodiscard]] constexpr bool is_mapped(std::uint16_t address, std::uint16_t count) {
  return address >= kFirstAddress &&
         std::uint32_t{address} + count <= std::uint32_t{kFirstAddress} + kAddressCount;
}

/// The fault of a scaling in one sentence; empty for a valid one.
[[nodiscard]] std::optional<std::string> check(const ConveyorScaling& scaling);

/// Value of one count in the register's unit; 0 when counts are plain numbers.
[[nodiscard]] double resolution(Scaling scaling, const ConveyorScaling& conveyor);

/// The table as text for a terminal, with the scaling of this installation.
[[nodiscard]] std::string register_map_text(const ConveyorScaling& scaling = {});

}  // namespace aprsim::modbus
