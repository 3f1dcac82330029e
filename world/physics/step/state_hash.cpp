#include "world/physics/step/state_hash.hpp"

#include <cstring>

namespace aprsim::physics {
namespace {

/// Fowler, Noll & Vo, 64 bits, variant 1a.
class Fnv1a {
 public:
  void add(double value) {
    // The hash is over the bits, so that -0 and 0 differ: any change of rounding shows.
    std::uint64_t bits;
    std::memcpy(&bits, &value, sizeof bits);
    for (int byte = 0; byte < 8; ++byte) {
      hash_ = (hash_ ^ ((bits >> (8 * byte)) & 0xff)) * 0x100000001b3ULL;
    }
  }
  template <typename Derived>
  void add(const Eigen::DenseBase<Derived>& values) {
    for (Eigen::Index c = 0; c < values.cols(); ++c) {
      for (Eigen::Index r = 0; r < values.rows(); ++r) add(values(r, c));
    }
  }
  [[nodiscard]] std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325ULL;
};

}  // namespace

std::uint64_t state_hash(const PhysicsModel& model) {
  Fnv1a hash;
  for (int i = 0; i < static_cast<int>(model.bodies.size()); ++i) {
    hash.add(model.simplification.X_WB(i).matrix());
    hash.add(model.simplification.velocity(i));
    hash.add(model.body(i).omega_W);
  }
  for (const auto& gripper : model.grippers) {
    for (int p = 0; p < GripperParts::kColliding; ++p)
      hash.add(gripper.parts().part(p).X_WS.matrix());
  }
  return hash.value();
}

}  // namespace aprsim::physics
