#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

/// Devices of a user's own, in the process of the simulation. An extension is a shared library
/// libNAME.so with one class that derives from Device and the line
///
///     APRSIM_EXTENSION(MyDevice)
///
/// A scene names it by NAME and gives its parameters. The simulation steps the device before robots
/// and bodies move. Lengths are in m, angles in rad, forces in N, times in s; poses and vectors are
/// in the world frame W, z up. Bodies, robots and photo-eyes have the indices that Cell lists them
/// by. Thread: that of the simulation; several cells may step at the same time, each its own
/// devices.
namespace aprsim::device {

/// Version of this interface. The simulation refuses libraries of another one.
inline constexpr std::uint32_t kInterfaceVersion = 2;

struct Vector3 {
  double x = 0, y = 0, z = 0;
};

struct Pose {
  Vector3 position;                       ///< of the origin, in W
  double qw = 1, qx = 0, qy = 0, qz = 0;  ///< rotation to W, a unit quaternion
};

/// A tray, gear or part.
struct Body {
  std::string_view name, type;
  double mass_kg = 0;
  Pose pose;
  Vector3 velocity;          ///< of the frame's origin [m/s]
  Vector3 angular_velocity;  ///< [rad/s]
  bool lost = false;         ///< it has fallen out of the cell or was removed
};

struct Robot {
  std::string_view name;
  std::span<const double> joints;  ///< positions from the base [rad], of prismatic joints [m]
  Pose tool;                       ///< frame that CRCL commands and reports
  double separation_m = 0;         ///< of the fingers, pad to pad
  int held_body = -1;              ///< index of the body in the gripper, -1 = none
  bool stopped = false;            ///< by a protective stop
};

/// A light barrier across the belt.
struct PhotoEye {
  std::string_view name;
  bool broken = false;      ///< something is in the beam
  std::uint32_t count = 0;  ///< times the beam has been broken since reset; wraps
};

struct Belt {
  bool run = false;      ///< commanded
  double speed_m_s = 0;  ///< actual, signed: forward is positive
  double travel_m = 0;   ///< signed, since reset
};

/// The cell at the start of a step, which nothing changes during the step.
struct Cell {
  std::uint64_t step = 0;  ///< steps since reset
  double time_s = 0;       ///< since reset
  double step_s = 0;       ///< length of a step
  std::span<const Body> bodies;
  std::span<const Robot> robots;
  std::span<const PhotoEye> photo_eyes;
  const Belt* belt = nullptr;  ///< null = the cell has none
};

/// All state of a device: numbers that the simulation keeps, hashes, saves and restores. They must
/// stay finite and within 1e30.
class State {
 public:
  explicit State(std::span<double> numbers) : numbers_(numbers) {}
  /// `index`: as Setup gave it. Throws std::out_of_range.
  double& operator[](std::size_t index) const {
    if (index >= numbers_.size()) {
      throw std::out_of_range("number " + std::to_string(index) + " of a state with " +
                              std::to_string(numbers_.size()));
    }
    return numbers_[index];
  }

 private:
  std::span<double> numbers_;
};

/// The construction of a device. Each call throws where the scene does not have what it asks for;
/// let the exception pass, and the user reads what is wrong at which place of the scene. All
/// parameters of the scene must be read.
class Setup {
 public:
  virtual std::string_view device() const = 0;  ///< name of the device

  // ---- parameters
  virtual double number(std::string_view parameter, double min, double max) = 0;
  virtual double number_or(std::string_view parameter, double fallback, double min, double max) = 0;
  virtual bool flag_or(std::string_view parameter, bool fallback) = 0;
  virtual std::string text(std::string_view parameter) = 0;
  virtual std::vector<double> numbers(std::string_view parameter, std::size_t min_count,
                                      std::size_t max_count) = 0;
  /// A list [x, y, z].
  Vector3 vector(std::string_view parameter) {
    const std::vector<double> xyz = numbers(parameter, 3, 3);
    return {xyz[0], xyz[1], xyz[2]};
  }
  /// Index of the body, robot or photo-eye that a parameter names.
  virtual std::size_t body(std::string_view parameter) = 0;
  virtual std::size_t robot(std::string_view parameter) = 0;
  virtual std::size_t photo_eye(std::string_view parameter) = 0;

  // ---- state
  /// Adds a number that clients see under this name, such as "mass_kg"; its index in State.
  virtual std::size_t signal(std::string_view name, double start = 0) = 0;
  /// Adds a signal that clients set, too: its index in State. `start` is within min and max; `unit`
  /// is what clients read, such as "m/s". A command sets it between two steps; a step may set it
  /// back, as a push button does.
  virtual std::size_t input(std::string_view name, double start, double min, double max,
                            std::string_view unit = {}) = 0;
  /// Adds a number that clients do not see; its index in State.
  virtual std::size_t memory(double start = 0) = 0;

 protected:
  ~Setup() = default;
};

/// Actions of a device, which take effect in this step, in their order. Each call throws
/// std::invalid_argument where the cell has no such thing or a number is not finite.
class Commands {
 public:
  /// As clients of the belt do: it runs unless a fault holds it, on its own ramp. Negative:
  /// backward.
  virtual void run_belt(double speed_m_s) = 0;
  virtual void stop_belt() = 0;
  virtual void set_gripper(std::size_t robot, double setting) = 0;  ///< 0 closed .. 1 open
  /// Protective stop, which lasts until a client initialises the robot.
  virtual void stop_robot(std::size_t robot) = 0;
  /// Force at the centre of mass, and torque, on a body in this step.
  virtual void push(std::size_t body, const Vector3& force_n, const Vector3& torque_nm = {}) = 0;
  /// Places a body at rest, above the pose by as much as it takes to be clear of all else.
  virtual void place(std::size_t body, const Pose& pose) = 0;
  /// Takes a body out of the cell until a reset.
  virtual void remove(std::size_t body) = 0;

 protected:
  ~Commands() = default;
};

/// A device. It is made anew whenever the cell is: by a reset, a loaded state, a body that is
/// spawned. Members are constants; whatever changes is in the State. A step is a function of its
/// arguments: no clock, no random numbers but from the State, no files, nothing that waits.
class Device {
 public:
  virtual ~Device() = default;
  /// An exception ends the device until a reset, with its text as the fault; the cell goes on.
  virtual void step(const Cell& cell, const State& state, Commands& commands) const = 0;
};

}  // namespace aprsim::device

/// Makes a class that derives from aprsim::device::Device, with a constructor that takes a
/// aprsim::device::Setup&, the extension of this library.
#define APRSIM_EXTENSION(CLASS)                                                                   \
  extern "C" __attribute__((visibility("default"))) std::uint32_t aprsim_device_interface() {     \
    return ::aprsim::device::kInterfaceVersion;                                                   \
  }                                                                                               \
  extern "C" __attribute__((visibility("default"))) ::aprsim::device::Device* aprsim_make_device( \
      ::aprsim::device::Setup& setup) {                                                           \
    return new CLASS(setup);                                                                      \
  }
