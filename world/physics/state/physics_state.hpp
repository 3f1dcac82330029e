#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

namespace aprsim::archive {
class Writer;
class Reader;
}  // namespace aprsim::archive

namespace aprsim::physics {

struct PhysicsModel;
class PhysicsStep;

/// State of the physics between two steps, complete for all later ones. An immutable value, cheap
/// to copy.
class PhysicsState {
 public:
  PhysicsState() = default;  ///< of no world; restore() refuses it
  PhysicsState(const PhysicsModel& model, const PhysicsStep& step);

  /// Goes on from there bit for bit in a world that was built of the same scene with the same
  /// initial link poses. Throws std::invalid_argument when the numbers of bodies or robots differ.
  void restore(PhysicsModel& model, PhysicsStep& step) const;

  /// Counts steps that are not taken. Copies the state.
  void advance_clock(std::uint64_t steps);

  /// The tool on a robot's flange; -1 = none.
  [[nodiscard]] int tool_of(int robot) const;
  /// Memory, approximately.
  [[nodiscard]] std::size_t bytes() const;
  /// Serialises to bytes (world/archive/archive.hpp), and back into a state of a world of the same
  /// scene, which determines the numbers of bodies and robots. Throws archive::Damaged.
  void write(archive::Writer& out) const;
  void read(archive::Reader& in);

 private:
  struct Data;
  std::shared_ptr<const Data> data_;
};

}  // namespace aprsim::physics
