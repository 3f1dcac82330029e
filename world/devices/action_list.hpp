#pragma once

#include <span>
#include <vector>

#include "world/devices/action.hpp"
#include "world/devices/cell_names.hpp"
#include "world/devices/interface/device.hpp"

namespace aprsim::devices {

/// The actions of devices in a step. Calls throw std::invalid_argument as device::Commands says,
/// and for more than kMaxActions of one device. Thread: one at a time.
class ActionList final : public device::Commands {
 public:
  static constexpr std::size_t kMaxActions = 256;

  /// `names` must outlive this.
  explicit ActionList(const CellNames& names) : names_(names) {}

  void run_belt(double speed_m_s) override;
  void stop_belt() override;
  void set_gripper(std::size_t robot, double setting) override;
  void stop_robot(std::size_t robot) override;
  void push(std::size_t body, const device::Vector3& force_n,
            const device::Vector3& torque_nm) override;
  void place(std::size_t body, const device::Pose& pose) override;
  void remove(std::size_t body) override;

  void clear() { actions_.clear(); }
  /// The actions that follow are those of another device.
  void begin_device() { begin_ = actions_.size(); }
  /// Drops the actions since then.
  void drop_device() { actions_.resize(begin_); }
  [[nodiscard]] std::span<const Action> all() const { return actions_; }

 private:
  void add(Action action);
  [[nodiscard]] int body_index(std::size_t body) const;
  [[nodiscard]] int robot_index(std::size_t robot) const;
  void require_belt() const;

  const CellNames& names_;
  std::vector<Action> actions_;
  std::size_t begin_ = 0;
};

}  // namespace aprsim::devices
