#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "aprsim/v1/control_service.pb.h"
#include "aprsim/v1/journal_service.pb.h"
#include "aprsim/v1/telemetry_service.pb.h"
#include "clients/wires/endpoints.hpp"
#include "clients/wires/outcome.hpp"

namespace aprsim::client {

/// The daemon's gRPC services.
class CellConnection {
 public:
  explicit CellConnection(const Endpoints& endpoints);
  ~CellConnection();
  CellConnection(CellConnection&&) noexcept;

  /// The snapshot, and what keeps the simulation from running as it is told to.
  [[nodiscard]] Outcome<v1::GetSnapshotResponse> status();
  [[nodiscard]] Outcome<v1::Snapshot> snapshot();
  [[nodiscard]] Outcome<v1::CellDescription> cell();
  /// Calls `show` with each sample until it returns false.
  [[nodiscard]] Outcome<void> stream(
      double rate_hz, const std::function<bool(const v1::StreamSnapshotsResponse&)>& show);
  /// Calls `show` with each event until it returns false, or there are no more for a request of
  /// past ones.
  [[nodiscard]] Outcome<void> events(
      const v1::StreamEventsRequest& request,
      const std::function<bool(const v1::StreamEventsResponse&)>& show);

  [[nodiscard]] Outcome<v1::Receipt> pause();
  [[nodiscard]] Outcome<v1::Receipt> resume();
  /// Answered once the steps have been taken; FailureKind::kTimeout when that takes longer.
  [[nodiscard]] Outcome<v1::Receipt> step(
      std::uint64_t steps, std::chrono::milliseconds timeout = std::chrono::hours(1));
  /// The same, with these fields of the cell after them.
  [[nodiscard]] Outcome<v1::Snapshot> step_and_look(std::uint64_t steps,
                                                    std::span<const char* const> fields,
                                                    std::chrono::milliseconds timeout);
  /// The same, as long as `waits` says true, which it is asked every few milliseconds; nothing when
  /// it says false first. What time was asked for may still pass then.
  [[nodiscard]] Outcome<std::optional<v1::Snapshot>> step_and_look(
      std::uint64_t steps, std::span<const char* const> fields, const std::function<bool()>& waits);
  /// Absent = as fast as possible.
  [[nodiscard]] Outcome<v1::Receipt> set_speed(std::optional<double> factor);
  [[nodiscard]] Outcome<v1::Receipt> reset(std::optional<std::uint64_t> seed);
  [[nodiscard]] Outcome<v1::Receipt> reset(const v1::ResetRequest& request);
  /// Answered once the run has ended.
  [[nodiscard]] Outcome<v1::RunUntilResponse> run_until(const v1::RunUntilRequest& request);
  [[nodiscard]] Outcome<v1::GetSceneResponse> scene();
  [[nodiscard]] Outcome<v1::SpawnBodyResponse> spawn_body(const v1::SpawnBodyRequest& request);
  [[nodiscard]] Outcome<v1::MoveBodyResponse> move_body(const v1::MoveBodyRequest& request);
  [[nodiscard]] Outcome<v1::Receipt> remove_body(const std::string& name);
  [[nodiscard]] Outcome<v1::Receipt> set_scene_value(const std::string& path,
                                                     const std::string& value);
  [[nodiscard]] Outcome<v1::Receipt> save_state(const std::string& name);
  [[nodiscard]] Outcome<v1::Receipt> load_state(const std::string& name);
  [[nodiscard]] Outcome<v1::Receipt> delete_state(const std::string& name);
  [[nodiscard]] Outcome<v1::ListStatesResponse> list_states();
  /// A saved state as the bytes of a file.
  [[nodiscard]] Outcome<std::string> export_state(const std::string& name);
  /// Keeps the state of such a file; an empty name = as it was saved.
  [[nodiscard]] Outcome<v1::ImportStateResponse> import_state(const std::string& name,
                                                              const std::string& bytes);
  /// Absent = taken away. The light curtain's state at that step comes with the answer.
  [[nodiscard]] Outcome<v1::SetIntruderResponse> set_intruder(
      const std::optional<v1::Intruder>& intruder);
  /// The fault, with its number, comes with the answer.
  [[nodiscard]] Outcome<v1::InjectFaultResponse> inject_fault(
      const v1::InjectFaultRequest& request);
  [[nodiscard]] Outcome<v1::Receipt> end_fault(std::uint64_t id);
  [[nodiscard]] Outcome<v1::Receipt> report_event(const std::string& event);

  /// The latest of the run as a journal file: calls `take` with each piece until it returns false.
  [[nodiscard]] Outcome<void> incident(
      double last_s, const std::function<bool(const v1::GetIncidentResponse&)>& take);

 private:
  struct Stubs;
  std::string address_;
  std::unique_ptr<Stubs> stubs_;
};

}  // namespace aprsim::client
