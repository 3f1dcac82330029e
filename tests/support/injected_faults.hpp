#pragma once

#include <memory>
#include <vector>

#include "tests/support/fake_cell.hpp"

namespace aprsim::test {

/// Publishes that these faults last and no others, with the parameters of their kinds unless told
/// otherwise.
class InjectedFaultsOf {
 public:
  explicit InjectedFaultsOf(FakeCell& cell) : cell_(cell) {}

  /// One more lasts, or has just been over at once.
  void begin(faults::Kind kind, int robot = -1, std::vector<double> values = {}) {
    const faults::KindInfo& info = faults::info(kind);
    api::InjectedFault fault;
    fault.id = ++last_id_;
    fault.kind = kind;
    fault.robot = robot;
    fault.begin_step = 1;
    fault.state = info.momentary ? api::FaultState::kEnded : api::FaultState::kActive;
    for (std::size_t i = 0; i < info.parameter_count(); ++i) {
      fault.values[i] = i < values.size() ? values[i] : info.parameters[i].fallback;
    }
    all_.push_back(fault);
    publish();
  }
  /// All are over.
  void end() {
    for (auto& fault : all_) fault.state = api::FaultState::kEnded;
    publish();
  }

 private:
  void publish() {
    auto list = std::make_shared<api::InjectedFaults>();
    list->all = all_;
    cell_.publish([&](api::Snapshot& next) { next.faults = list; });
  }

  FakeCell& cell_;
  std::uint64_t last_id_ = 0;
  std::vector<api::InjectedFault> all_;
};

}  // namespace aprsim::test
