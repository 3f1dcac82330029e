#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "aprsim/v1/camera_service.pb.h"
#include "aprsim/v1/control_service.pb.h"
#include "aprsim/v1/journal_service.pb.h"
#include "aprsim/v1/telemetry_service.pb.h"
#include "aprsim/v1/trajectory_service.pb.h"
#include "clients/wires/cancellation.hpp"
#include "clients/wires/endpoints.hpp"
#include "clients/wires/outcome.hpp"

namespace aprsim::client {

/// The daemon's gRPC services, each call blocking. A call connects when it is made, without a
/// proxy, and ends within the connection's timeout unless it says otherwise. Values are in SI
/// units, poses in the frames that the messages name.
///
/// Failures: kConnection when the daemon cannot be reached, kUnauthenticated without a valid token,
/// kRefused with the daemon's own words, kTimeout, kUsage for a text that is no UTF-8. Thread: any,
/// also several at a time.
class CellConnection {
 public:
  static constexpr std::chrono::seconds kCallTimeout{10};

  /// Does not connect yet.
  explicit CellConnection(const Endpoints& endpoints,
                          std::chrono::milliseconds timeout = kCallTimeout);
  ~CellConnection();
  CellConnection(CellConnection&&) noexcept;

  /// The snapshot, and what keeps the simulation from running as commanded.
  [[nodiscard]] Outcome<v1::GetSnapshotResponse> status();
  /// The state of everything in the cell.
  [[nodiscard]] Outcome<v1::Snapshot> snapshot();
  /// The parts of the cell that do not move: names, kinds, shapes, limits.
  [[nodiscard]] Outcome<v1::CellDescription> cell();
  /// Calls `show` with each sample until it returns false; has no deadline. `rate_hz`: samples a
  /// second of wall time, at most 1000; 0 = 20.
  [[nodiscard]] Outcome<void> stream(
      double rate_hz, const std::function<bool(const v1::StreamSnapshotsResponse&)>& show);
  /// Calls `show` with each event until it returns false, or there are no more for a request of
  /// past ones; has no deadline.
  [[nodiscard]] Outcome<void> events(
      const v1::StreamEventsRequest& request,
      const std::function<bool(const v1::StreamEventsResponse&)>& show);

  /// Calls `show` with each picture until it returns false; has no deadline.
  [[nodiscard]] Outcome<void> images(
      const v1::StreamImagesRequest& request,
      const std::function<bool(const v1::StreamImagesResponse&)>& show);
  /// Moves a robot along a trajectory: calls `show` with each response until the result, which is
  /// the last one; has no deadline. kInterrupted if cancelled: the daemon then stops the robot.
  [[nodiscard]] Outcome<void> follow(
      const v1::FollowJointTrajectoryRequest& request,
      const std::function<void(const v1::FollowJointTrajectoryResponse&)>& show,
      const Cancelled& cancelled);

  /// Stops taking steps.
  [[nodiscard]] Outcome<v1::Receipt> pause();
  /// Takes steps again.
  [[nodiscard]] Outcome<v1::Receipt> resume();
  /// Takes steps of a paused cell; answered once they have been taken, kTimeout when that takes
  /// longer.
  [[nodiscard]] Outcome<v1::Receipt> step(
      std::uint64_t steps, std::chrono::milliseconds timeout = std::chrono::hours(1));
  /// The same, and reads these fields of the snapshot after them.
  [[nodiscard]] Outcome<v1::Snapshot> step_and_read(std::uint64_t steps,
                                                    std::span<const char* const> fields,
                                                    std::chrono::milliseconds timeout);
  /// The same until cancelled, which gives nothing. The steps may still be taken then.
  [[nodiscard]] Outcome<std::optional<v1::Snapshot>> step_and_read(
      std::uint64_t steps, std::span<const char* const> fields, const Cancelled& cancelled);
  /// Sets the ratio of simulated to wall time; absent = as fast as possible.
  [[nodiscard]] Outcome<v1::Receipt> set_speed(std::optional<double> factor);
  /// Builds the cell anew; absent = with the seed it has.
  [[nodiscard]] Outcome<v1::Receipt> reset(std::optional<std::uint64_t> seed);
  [[nodiscard]] Outcome<v1::Receipt> reset(const v1::ResetRequest& request);
  /// Runs until a condition is met; answered once the run has ended, within an hour. A run that is
  /// cancelled (kInterrupted) or not answered in time leaves the cell paused.
  [[nodiscard]] Outcome<v1::RunUntilResponse> run_until(const v1::RunUntilRequest& request,
                                                        const Cancelled& cancelled = {});

  /// The scene as the daemon holds it.
  [[nodiscard]] Outcome<v1::GetSceneResponse> scene();
  [[nodiscard]] Outcome<v1::SpawnBodyResponse> spawn_body(const v1::SpawnBodyRequest& request);
  [[nodiscard]] Outcome<v1::MoveBodyResponse> move_body(const v1::MoveBodyRequest& request);
  [[nodiscard]] Outcome<v1::Receipt> remove_body(const std::string& name);
  /// Sets a value of the next scene, by its path in the scene file.
  [[nodiscard]] Outcome<v1::Receipt> set_scene_value(const std::string& path,
                                                     const std::string& value);

  [[nodiscard]] Outcome<v1::Receipt> save_state(const std::string& name);
  [[nodiscard]] Outcome<v1::Receipt> load_state(const std::string& name);
  [[nodiscard]] Outcome<v1::Receipt> delete_state(const std::string& name);
  [[nodiscard]] Outcome<v1::ListStatesResponse> list_states();
  /// A saved state as the bytes of a file, within a minute.
  [[nodiscard]] Outcome<std::string> export_state(const std::string& name);
  /// Saves the state of such a file, within a minute; an empty name = the name in the file.
  [[nodiscard]] Outcome<v1::ImportStateResponse> import_state(const std::string& name,
                                                              const std::string& bytes);

  /// Sets an input of a device.
  [[nodiscard]] Outcome<v1::Receipt> set_signal(const std::string& device,
                                                const std::string& signal, double value);
  /// Puts a person before the light curtain; absent = removes it. The light curtain's state at that
  /// step comes with the answer.
  [[nodiscard]] Outcome<v1::SetIntruderResponse> set_intruder(
      const std::optional<v1::Intruder>& intruder);
  /// The fault, with its number, comes with the answer.
  [[nodiscard]] Outcome<v1::InjectFaultResponse> inject_fault(
      const v1::InjectFaultRequest& request);
  [[nodiscard]] Outcome<v1::Receipt> end_fault(std::uint64_t id);
  /// Reports an event to the faults that wait for it.
  [[nodiscard]] Outcome<v1::Receipt> report_event(const std::string& event);

  /// The last `last_s` simulated seconds as a journal file: calls `take` with each piece until it
  /// returns false; has no deadline.
  [[nodiscard]] Outcome<void> incident(
      double last_s, const std::function<bool(const v1::GetIncidentResponse&)>& take);

 private:
  struct Stubs;
  std::string address_;
  std::unique_ptr<Stubs> stubs_;
};

}  // namespace aprsim::client
